//! The outcome of `rig calibrate`.

use std::path::PathBuf;

use hysteron_rig::calibration::RigCalibration;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The outcome of `rig calibrate`.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct Outcome {
    /// The calibration file.
    pub calibration: PathBuf,
    /// One entry per tendon.
    pub channels: Vec<ChannelCalibration>,
}

impl crate::shared::outcome::Outcome for Outcome {}

/// Zero and slack of a tendon.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct ChannelCalibration {
    /// Id of its servo.
    pub servo: u8,
    /// Position of the servo at stroke zero [ticks].
    pub zero_ticks: i32,
    /// Stroke at which the slack ends [mm].
    pub slack_end_mm: f64,
}

impl Outcome {
    pub(super) fn new(file: PathBuf, calibration: &RigCalibration) -> Self {
        let channels = calibration.channels.iter().map(|channel| ChannelCalibration {
            servo: channel.servo_id,
            zero_ticks: channel.zero,
            slack_end_mm: 1e3 * channel.slack_end,
        });
        Self { channels: channels.collect(), calibration: file }
    }
}
