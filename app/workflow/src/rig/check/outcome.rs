//! The outcome of `rig check`.

use std::collections::BTreeMap;
use std::path::PathBuf;

use hysteron_rig::bus::ServoReport;
use hysteron_rig::tracker::TrackerSurvey;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The outcome of `rig check`.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct Outcome {
    /// Serial ports of this machine.
    pub ports: Vec<Port>,
    /// Servos of a rig.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub servos: Option<Vec<ServoSummary>>,
    /// Tracker of a rig that has one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tracker: Option<TrackerSurvey>,
    /// Joints of two arms.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub joints: Option<usize>,
}

impl crate::shared::outcome::Outcome for Outcome {}

impl Outcome {
    pub(super) fn of_ports(ports: Vec<Port>) -> Self {
        Self { ports, servos: None, tracker: None, joints: None }
    }
}

/// A serial port.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct Port {
    /// Its device file.
    pub port: PathBuf,
    /// Its description by the system.
    pub description: String,
}

/// A servo as it answered.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct ServoSummary {
    /// Id on the bus.
    pub id: u8,
    /// Model number.
    pub model: u16,
    /// Supply voltage [V].
    pub supply_v: f64,
    /// Temperature [°C].
    pub temperature_c: f64,
    /// Whether its torque is on.
    pub is_torque_on: bool,
    /// Position [ticks].
    pub position_ticks: i32,
    /// Registers that a calibration stores, by name; empty for servos that have none.
    pub registers: BTreeMap<String, i64>,
}

impl ServoSummary {
    pub(super) fn new(servo: &ServoReport) -> Self {
        Self {
            id: servo.id,
            model: servo.model,
            supply_v: servo.voltage_v,
            temperature_c: servo.temperature_degc,
            is_torque_on: servo.torque_on,
            position_ticks: servo.position,
            registers: servo.registers.to_keys(),
        }
    }
}
