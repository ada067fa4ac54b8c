//! A file of two arms exactly as typed: one field per key, units still in the names. Only `config.rs` reads these.

use crate::config::{ServoMode, WindingDirection};
use serde::Deserialize;
use std::collections::BTreeMap;

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ArmsFile {
    pub format: String,
    pub version: i64,
    pub name: String,
    pub rate_hz: f64,
    pub leader: LeaderTable,
    pub follower: FollowerTable,
    pub joint: Vec<JointTable>,
    pub gripper: Option<TeleoperationGripperTable>,
    pub limits: ArmLimitsTable,
    pub motion: ArmMotionTable,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct LeaderTable {
    pub port: String,
    pub baud: i64,
    pub reply_timeout_ms: f64,
    pub retries: i64,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct FollowerTable {
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
pub(super) struct JointTable {
    pub name: String,
    pub leader: TeleoperationServoTable,
    pub follower: TeleoperationServoTable,
    pub min_deg: f64,
    pub max_deg: f64,
    pub rest_deg: f64,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct TeleoperationServoTable {
    pub id: i64,
    pub model: String,
    pub zero_ticks: i64,
    pub turns: WindingDirection,
    /// Registers whose value intentionally differs from the factory's.
    #[serde(default)]
    pub registers: BTreeMap<String, i64>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct TeleoperationGripperTable {
    pub aperture_mm_per_rad: f64,
    pub closed_deg: f64,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ArmLimitsTable {
    pub speed_max_deg_s: f64,
    pub lag_max_deg: f64,
    pub current_max_a: f64,
    pub temperature_max_degc: f64,
    pub voltage_min_v: f64,
    pub voltage_max_v: f64,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ArmMotionTable {
    pub approach_deg_s: f64,
}
