//! The outcome of the studies of learned inverse dynamics.

use hysteron_arm_learning::datasets::RealSet;
use hysteron_arm_learning::lagrangian::Variant;
use hysteron_report::verdict::{Criterion, Verdict};
use hysteron_workflow::shared::outcome::{MetricsFormat, by_key};
use hysteron_workflow::shared::verdict::{compared, repeated};
use hysteron_workflow::{COMMIT, Context};
use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, Serialize};

use super::published::{PublishedRow, published};
use super::real::{RealOptions, RealRow};
use super::simulated::{Parts, SimulatedRow, SimulatedStudy};

/// The outcome of a study of learned inverse dynamics.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct Outcome {
    /// Format of the file.
    pub format: MetricsFormat,
    /// Its version.
    pub version: u32,
    /// Models and their errors.
    pub study: Study,
    /// Means over the seeds, of simulated arms.
    pub means: Vec<Means>,
    /// Whether the best model does better than the simplest.
    pub verdict: Verdict,
    /// The command that made this.
    pub command: String,
    /// Commit of the program.
    pub commit: String,
}

/// Models of a simulated arm, or of recorded ones.
#[derive(Debug, Clone, Serialize, JsonSchema)]
#[serde(untagged)]
pub enum Study {
    /// Of a simulated arm, where all parts of the torques are known.
    Simulated(Simulated),
    /// Of recorded arms.
    Recorded(Recorded),
}

impl<'de> Deserialize<'de> for Study {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        by_key(deserializer, "tables", Self::Recorded, Self::Simulated)
    }
}

/// Models of a simulated arm.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct Simulated {
    /// Models, seeds and data that were compared.
    pub study: SimulatedStudy,
    /// One for each training.
    pub rows: Vec<SimulatedRow>,
}

/// Models of recorded arms.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct Recorded {
    /// How models were found.
    pub options: RealOptions,
    /// One for each set.
    pub tables: Vec<RecordedTable>,
    /// Sets that were not there.
    pub left_out: Vec<String>,
}

/// Models of one recorded arm.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct RecordedTable {
    /// Its name.
    pub set: String,
    /// Samples and trajectories that models were chosen by.
    pub training: [usize; 2],
    /// Samples that errors are of.
    pub test_samples: usize,
    /// Cut-off of the low-pass filter [Hz].
    pub cutoff_hz: f64,
    /// One for each model.
    pub rows: Vec<RealRow>,
    /// The same models as published, where they are.
    pub published: Vec<PublishedRow>,
}

impl RecordedTable {
    /// Of these rows.
    pub(super) fn new(set: &RealSet, rows: Vec<RealRow>) -> Self {
        Self {
            set: set.name.clone(),
            training: [set.training.len(), set.training.trajectories.len()],
            test_samples: set.test.len(),
            cutoff_hz: set.cutoff,
            rows,
            published: published(&set.name).to_vec(),
        }
    }
}

impl hysteron_workflow::shared::outcome::Outcome for Outcome {
    fn verdict(&self) -> Option<&Verdict> {
        Some(&self.verdict)
    }
}

impl Outcome {
    pub(super) fn new(study: Study, context: &Context) -> Self {
        let means: Vec<Means> = match &study {
            Study::Simulated(Simulated { study, rows }) => {
                Variant::ALL.iter().filter_map(|v| Means::of(study, rows, *v)).collect()
            }
            Study::Recorded(_) => Vec::new(),
        };
        Self {
            format: MetricsFormat,
            version: 1,
            verdict: assess(&study, &means),
            study,
            means,
            command: context.command.clone(),
            commit: COMMIT.to_owned(),
        }
    }
}

/// Mean and spread over the seeds of one variant, learning from the most trajectories.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct Means {
    /// The model.
    pub variant: Variant,
    /// Normalised errors of torque, inertial, Coriolis and gravity torque at every speed [-].
    pub nmse: Vec<[f64; 4]>,
    /// Their standard deviations over the seeds, at the first speed.
    pub spread: [f64; 4],
    /// Mean squared errors of the same at the first speed [N² m²].
    pub mse: [f64; 4],
    /// Torque of every joint, at the first speed.
    pub joints: Vec<f64>,
    /// Mean squared error of the power [W²].
    pub power_mse: f64,
    /// Parameters of the model.
    pub parameters: usize,
    /// Time of a training [s].
    pub seconds: f64,
}

fn array(parts: &Parts) -> [f64; 4] {
    [parts.torque, parts.inertial, parts.coriolis, parts.gravity]
}

impl Means {
    fn of(study: &SimulatedStudy, rows: &[SimulatedRow], variant: Variant) -> Option<Self> {
        let most = study.trajectories.iter().copied().max();
        let rows: Vec<&SimulatedRow> = rows
            .iter()
            .filter(|r| {
                r.variant == variant && most.is_none_or(|n| r.trajectories == n || r.parts.len() == 1)
            })
            .collect();
        let n = rows.len() as f64;
        let mean = |of: &dyn Fn(&SimulatedRow) -> f64| rows.iter().map(|r| of(r)).sum::<f64>() / n;
        let [speeds, joints] = [rows.first()?.parts.len(), rows[0].joints.len()];
        let nmse: Vec<[f64; 4]> =
            (0..speeds).map(|s| std::array::from_fn(|k| mean(&|r| array(&r.parts[s])[k]))).collect();
        let spread = std::array::from_fn(|k| mean(&|r| (array(&r.parts[0])[k] - nmse[0][k]).powi(2)).sqrt());
        Some(Self {
            variant,
            spread,
            nmse,
            mse: std::array::from_fn(|k| mean(&|r| array(&r.mse)[k])),
            joints: (0..joints).map(|j| mean(&|r| r.joints[j])).collect(),
            power_mse: mean(&|r| r.power_mse),
            parameters: rows[0].parameters,
            seconds: mean(&|r| r.seconds),
        })
    }
}

/// Whether the best model does better than the simplest: a feed-forward network of simulated arms, the first row of recorded ones.
fn assess(study: &Study, means: &[Means]) -> Verdict {
    match study {
        Study::Simulated(Simulated { study, .. }) => {
            let errors: Vec<(String, f64)> =
                means.iter().map(|mean| (mean.variant.label().to_owned(), mean.mse[0].sqrt())).collect();
            let simplest = Variant::FeedForward.label();
            let assessment =
                Verdict::on("a model of the DeLaN family gives torques better than a feed-forward network");
            let assessment = compared(assessment, ("error of the torques", "N m"), &errors, simplest);
            repeated(assessment, study.seeds as usize, "seed").verdict()
        }
        Study::Recorded(Recorded { tables, left_out, .. }) => {
            let claim =
                "the best model gives the torques of recorded arms better than the rigid body as identified";
            let assessment = tables.iter().fold(Verdict::on(claim), |assessment, table| {
                let errors: Vec<(String, f64)> =
                    table.rows.iter().map(|row| (row.name.clone(), row.sum_mse.sqrt())).collect();
                let simplest = errors.first().map_or("", |row| &row.0[..]);
                compared(
                    assessment,
                    (&format!("{}, error of the torques", table.set), "N m"),
                    &errors,
                    simplest,
                )
            });
            let n = tables.len() + left_out.len();
            let missing = left_out.len() as f64 / n.max(1) as f64;
            let statement = format!("{} of {n} sets of recordings are not there", left_out.len());
            assessment.because(Criterion::Missing, missing, statement).verdict()
        }
    }
}
