//! The outcome of `target`.

use hysteron_control::TargetPath;
use hysteron_twin::Reach;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::shared::outcome::MetricsFormat;
use crate::{COMMIT, Context};

/// The outcome of `target`.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct Outcome {
    /// Format of the file.
    pub format: MetricsFormat,
    /// Its version.
    pub version: u32,
    /// Name of the target.
    pub name: String,
    /// Family of its curve.
    pub family: String,
    /// SHA-256 of what it was made from.
    pub target_sha256: String,
    /// Rate [Hz].
    pub rate_hz: f64,
    /// Number of samples.
    pub samples: usize,
    /// Time from the first to the last sample [s].
    pub duration_s: f64,
    /// Length of a lap [m].
    pub length_m: f64,
    /// Laps.
    pub laps: usize,
    /// Times at which the curve begins and ends [s].
    pub curve_s: [f64; 2],
    /// Whether a robot reaches it, where a scene was given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reach: Option<Reach>,
    /// The command that made this.
    pub command: String,
    /// Commit of the program.
    pub commit: String,
}

impl crate::shared::outcome::Outcome for Outcome {}

impl Outcome {
    pub(super) fn new(target: &TargetPath, reach: Option<Reach>, context: &Context) -> Self {
        let n = target.points().len();
        Self {
            format: MetricsFormat,
            version: 1,
            name: target.name.clone(),
            family: target.family.clone(),
            target_sha256: target.hash.clone(),
            rate_hz: target.rate_hz,
            samples: n,
            duration_s: target.time(n - 1),
            length_m: target.outline.length(),
            laps: target.laps().count(),
            curve_s: [target.time(*target.curve().start()), target.time(*target.curve().end())],
            reach,
            command: context.command.clone(),
            commit: COMMIT.to_owned(),
        }
    }
}
