//! The numbers of `study sensing`.

use hysteron_report::verdict::{Criterion, Verdict};
use hysteron_twin::sense::{ForceSensor, SensingScores};
use hysteron_workflow::shared::verdict::{compared, digits, repeated};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The numbers of `study sensing`.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct SensingMetrics {
    /// One for each robot.
    pub robots: Vec<SensedRobot>,
}

/// The sensor of one robot.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct SensedRobot {
    /// The robot.
    pub robot: String,
    /// Scores of tensions and pushes, as `sense` gives them.
    pub scores: SensingScores,
    /// The sensor, as `sense` gives it.
    pub sensor: ForceSensor,
    /// False alarms in recordings without contact.
    pub without_contact: WithoutContact,
}

/// False alarms in recordings without contact.
#[derive(Debug, Clone, Copy, Serialize, Deserialize, JsonSchema)]
pub struct WithoutContact {
    /// Number of alarms.
    pub alarms: f64,
    /// Time without contact [s].
    pub seconds: f64,
}

/// Whether tensions and pushes are estimated without force sensors.
pub(super) fn assess(metrics: &SensingMetrics) -> Verdict {
    let builder = Verdict::on("tensions and pushes are estimated without force sensors");
    let builder = metrics.robots.iter().fold(builder, |mut builder, one| {
        let SensingScores { tensions, forces, contacts } = &one.scores;
        // The first method is the sensor's own.
        if let Some(own) = tensions.first() {
            let statement =
                format!("{}: tensions are off by {} % of their size", one.robot, digits(100.0 * own.all));
            builder = builder.because(Criterion::ErrorOverSpread, own.all, statement);
        }
        for samples in forces.chunk_by(|a, b| a.method == b.method).next().into_iter().flatten() {
            let same = forces.iter().filter(|score| score.samples == samples.samples);
            let methods: Vec<(String, f64)> =
                same.map(|score| (score.method.clone().into_owned(), score.rms_n)).collect();
            let what = format!("{}, error of a push, {}", one.robot, samples.samples);
            builder = compared(builder, (&what, "N"), &methods, NO_FORCE);
        }
        if let Some(contacts) = contacts {
            let missed = 1.0 - contacts.strong_found_at_once;
            let statement = format!(
                "{}: {:.0} % of the contacts above 0.15 N were not found within 100 ms",
                one.robot,
                100.0 * missed
            );
            builder = builder.because(Criterion::Missing, missed, statement);
        }
        builder
    });
    repeated(builder, metrics.robots.len(), "robot").verdict()
}

/// Name of the simplest estimate of a push, as `sense` gives it.
const NO_FORCE: &str = "no force";
