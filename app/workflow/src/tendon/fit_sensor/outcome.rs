//! The outcome of `fit-sensor`: the file of the sensor.

use hysteron_base::checks::Warning;
use hysteron_report::verdict::{Criterion, Verdict};
use hysteron_twin::sense::ForceSensor;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::shared::inputs::Input;
use crate::shared::recording_checks::Findings;
use crate::tendon::sense::file::{FORMAT, SensedRobot, VERSION};
use crate::{COMMIT, Context};

/// The outcome of `fit-sensor`, which is the file of the sensor.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct Outcome {
    /// Format of the file: `hysteron-force-sensor`.
    pub format: String,
    /// Its version.
    pub version: u32,
    /// The sensor.
    pub sensor: ForceSensor,
    /// Hash of the scene and its mesh.
    pub scene_sha256: String,
    /// Hash of the residual network, where the twin has one.
    pub residual_sha256: Option<String>,
    /// Names and SHA-256 of the recordings.
    pub recordings: Vec<(String, String)>,
    /// Whether forces can be estimated with this sensor.
    pub verdict: Verdict,
    /// Warnings about the recordings.
    #[serde(default)]
    pub recording_warnings: Vec<Warning>,
    /// The command that made this.
    pub command: String,
    /// Commit of the program.
    pub commit: String,
}

impl crate::shared::outcome::Outcome for Outcome {
    fn verdict(&self) -> Option<&Verdict> {
        Some(&self.verdict)
    }
}

impl Outcome {
    /// Of a sensor that was fitted to `recordings`, `n_known` of them with a known force.
    pub(super) fn new(
        sensor: ForceSensor,
        robot: &SensedRobot,
        (recordings, n_known): (&[Input], usize),
        findings: &Findings,
        context: &Context,
    ) -> Self {
        Self {
            format: FORMAT.to_owned(),
            version: VERSION,
            verdict: assess(&sensor, n_known),
            sensor,
            scene_sha256: robot.scene.to_owned(),
            residual_sha256: robot.network.map(str::to_owned),
            recordings: recordings.iter().map(|input| (input.name.clone(), input.hash.clone())).collect(),
            recording_warnings: findings.warnings().to_vec(),
            command: context.command.clone(),
            commit: COMMIT.to_owned(),
        }
    }
}

/// Whether forces can be estimated with this sensor.
fn assess(sensor: &ForceSensor, n_known: usize) -> Verdict {
    let response = sensor.tip.response;
    let claim = format!("forces on the tip are known to {:.0} % of their size", 100.0 * response);
    let (missing, statement) = match sensor.servo {
        Some(_) => (0.0, "tensions rest on loads of the servos and on the twin"),
        None => (0.5, "1 of 2 sources of tensions is missing: not every recording has ticks and loads"),
    };
    let how = match n_known {
        0 => "without a recording of a known force".to_owned(),
        n => format!("from {n} recordings of known forces"),
    };
    Verdict::on(claim)
        .because(
            Criterion::RelativeStandardError,
            response,
            format!("the stiffness of the tip is known to {:.0} %, {how}", 100.0 * response),
        )
        .because(Criterion::Missing, missing, statement)
        .verdict()
}
