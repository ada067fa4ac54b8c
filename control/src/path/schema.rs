//! A target exactly as typed: one field per key, units still in the names. Only `convert.rs` reads these.

use crate::plan::Direction;
use hysteron_base::schema::FixedArray;
use serde::Deserialize;

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct TargetFile {
    pub format: String,
    pub version: i64,
    pub name: String,
    pub rate_hz: f64,
    pub speed_mm_s: f64,
    pub ramp_s: f64,
    pub rest_s: f64,
    pub lead_in_s: f64,
    pub laps: Option<u32>,
    pub centre_mm: Option<Vec<f64>>,
    pub rotation_deg: Option<f64>,
    pub direction: Option<Direction>,
    pub curve: CurveTable,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct CurveTable {
    pub family: CurveFamily,
    pub size_mm: Option<f64>,
    pub width_mm: Option<f64>,
    pub cycles: Option<FixedArray<u32, 2>>,
    pub phase_deg: Option<f64>,
    pub turns: Option<f64>,
    pub aspect: Option<f64>,
    pub k: Option<u32>,
    pub points_mm: Option<Vec<Vec<f64>>>,
    pub file: Option<String>,
    pub closed: Option<bool>,
    pub may_cross: Option<bool>,
}

#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum CurveFamily {
    Circle,
    Diamond,
    Square,
    Lissajous,
    FigureEight,
    Ellipse,
    Rose,
    Spiral,
    Polyline,
    Outline,
}
