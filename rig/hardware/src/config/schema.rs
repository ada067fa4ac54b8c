//! A rig file exactly as typed: one field per key, units still in the names. Only `config/mod.rs` reads these.

use super::{AtEnd, ServoMode, WindingDirection};
use hysteron_base::schema::FixedArray;
use serde::Deserialize;

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RigFile {
    pub format: String,
    pub version: i64,
    pub name: String,
    pub servos: RigServosTable,
    pub tendon: Vec<RigTendonTable>,
    pub tracker: Option<RigTrackerTable>,
    pub limits: SafetyLimitsTable,
    pub motion: RigMotionTable,
    pub calibration: CalibrationTable,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RigServosTable {
    pub port: String,
    pub baud: i64,
    pub operating_mode: ServoMode,
    pub position_p_gain: i64,
    pub position_i_gain: i64,
    pub position_d_gain: i64,
    pub bus_watchdog_ms: f64,
    pub reply_timeout_ms: f64,
    pub retries: i64,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RigTendonTable {
    pub servo_id: i64,
    pub winds: WindingDirection,
    pub pulley_radius_mm: f64,
    pub angle_deg: f64,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RigTrackerTable {
    pub address: String,
    pub device: String,
    pub rate_hz: f64,
    pub latency_ms: f64,
    pub stale_ms: f64,
    pub speed_max_mm_s: f64,
    pub tip_rest_mm: FixedArray<f64, 3>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SafetyLimitsTable {
    pub stroke_min_mm: f64,
    pub stroke_max_mm: f64,
    pub stroke_rate_max_mm_s: f64,
    pub lag_max_mm: f64,
    pub load_max_percent: f64,
    #[serde(alias = "load_hold_percent")]
    pub load_limit_percent: Option<f64>,
    pub temperature_max_degc: f64,
    pub voltage_min_v: f64,
    pub voltage_max_v: f64,
    pub tip_min_mm: FixedArray<f64, 3>,
    pub tip_max_mm: FixedArray<f64, 3>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RigMotionTable {
    pub slew_mm_s: f64,
    pub at_end: AtEnd,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct CalibrationTable {
    pub file: String,
    pub slack_load_percent: f64,
    pub pretension_load_percent: f64,
    pub search_max_mm: f64,
    pub probe_mm: f64,
}
