//! The outcome of `arm estimate`: along a recording, live on a bus, or with learned dynamics.

use std::path::PathBuf;

use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, Serialize};

use crate::shared::outcome;

/// The outcome of `arm estimate`: with learned dynamics, or from the telemetry of servos.
#[derive(Debug, Clone, Serialize, JsonSchema)]
#[serde(untagged)]
pub enum Outcome {
    /// External torques with learned dynamics.
    External(ExternalTorques),
    /// Torques, force, contact and condition.
    Telemetry(TelemetryEstimates),
}

impl outcome::Outcome for Outcome {}

impl<'de> Deserialize<'de> for Outcome {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        outcome::by_key(deserializer, "rms_n_m", Self::External, Self::Telemetry)
    }
}

/// External torques along a recording.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct ExternalTorques {
    /// Number of samples.
    pub rows: usize,
    /// Root mean square of the external torque, joint by joint [N m or N].
    pub rms_n_m: Vec<f64>,
    /// The recording of the estimates.
    pub out: PathBuf,
}

/// Estimates from the telemetry of servos: along a recording, or live.
#[derive(Debug, Clone, Serialize, JsonSchema)]
#[serde(untagged)]
pub enum TelemetryEstimates {
    /// While a follower followed its leader.
    Live(Box<LiveEstimates>),
    /// Along a recording.
    Along(RecordingEstimates),
}

impl<'de> Deserialize<'de> for TelemetryEstimates {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        outcome::by_key(deserializer, "recording", |live| Self::Live(Box::new(live)), Self::Along)
    }
}

/// Estimates along a recording.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct RecordingEstimates {
    /// Number of samples.
    pub rows: usize,
    /// Part of the samples in contact [-].
    pub contact: f64,
    /// Probability that the watched motor is healthy at the last sample [-].
    pub healthy_at_end: f64,
    /// The recording of the estimates.
    pub out: PathBuf,
    /// Joints that `--fix-base` holds at zero.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub held_joints: Vec<String>,
}

/// Estimates while a follower followed its leader.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct LiveEstimates {
    /// The recording.
    pub recording: PathBuf,
    /// Number of samples.
    pub rows: usize,
    /// Samples that were not measured and are filled in.
    pub filled_in: usize,
    /// Cycles that came late.
    pub late_cycles: usize,
    /// Rate of the bus [Hz].
    pub rate_hz: f64,
    /// Part of the estimated samples in contact [-].
    pub contact: f64,
    /// Contacts that began.
    pub contacts: u64,
    /// Probability that the watched motor is healthy at the last sample [-]; none without an estimate.
    pub healthy_at_end: Option<f64>,
    /// Time that a step of the estimator takes.
    pub step_ms: TimePercentiles,
    /// Time from reading the servos to the estimate.
    pub age_ms: TimePercentiles,
    /// Joints that `--fix-base` holds at zero.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub held_joints: Vec<String>,
}

/// Percentiles of times [ms].
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct TimePercentiles {
    /// Half of the times are shorter.
    pub median: f64,
    /// 95 % are shorter.
    pub p95: f64,
    /// 99 % are shorter.
    pub p99: f64,
    /// The longest.
    pub max: f64,
}
