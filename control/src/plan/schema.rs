//! A plan exactly as typed: one field per key, units still in the names. Only `convert.rs` reads these.

use super::{Direction, Space, TrajectoryRole};
use hysteron_base::schema::FixedArray;
use serde::Deserialize;

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PlanFile {
    pub format: String,
    pub version: i64,
    pub name: String,
    pub seed: u64,
    pub rate_hz: f64,
    #[serde(default)]
    pub space: Space,
    pub scale: Option<f64>,
    pub vary: Option<f64>,
    pub tendon_angles_deg: Vec<f64>,
    pub release: f64,
    pub co_contraction_mm: Option<f64>,
    pub rest_before_s: f64,
    pub rest_after_s: f64,
    pub stroke_max_mm: f64,
    pub stroke_rate_max_mm_s: f64,
    #[serde(default)]
    pub trajectory: Vec<TrajectoryTable>,
    #[serde(default)]
    pub draw: Vec<Draw>,
}

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct TrajectoryTable {
    pub name: String,
    pub role: TrajectoryRole,
    pub family: FamilyName,
    pub amplitude_mm: f64,
    pub frequency_hz: Option<f64>,
    pub period_s: Option<f64>,
    pub phase_deg: Option<f64>,
    pub orientation_deg: Option<f64>,
    pub aspect: Option<f64>,
    pub swings: Option<f64>,
    pub direction: Option<Direction>,
    pub attack_s: f64,
    pub sustain_s: f64,
    pub decay_s: f64,
}

#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum FamilyName {
    Sinusoid,
    Circle,
    Square,
    Ellipse,
    Rose,
}

/// Trajectories drawn from ranges, each `[smallest, largest]`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Draw {
    pub name: String,
    pub role: TrajectoryRole,
    pub family: FamilyName,
    pub count: i64,
    pub amplitude_mm: FixedArray<f64, 2>,
    pub period_s: FixedArray<f64, 2>,
    pub orientation_deg: Option<FixedArray<f64, 2>>,
    pub aspect: Option<FixedArray<f64, 2>>,
    pub swings: Option<FixedArray<f64, 2>>,
    pub attack_s: f64,
    pub sustain_s: f64,
    pub decay_s: f64,
}
