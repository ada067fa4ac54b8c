//! The outcome of `study cloning`.

use hysteron_report::verdict::Verdict;
use hysteron_workflow::shared::outcome::MetricsFormat;
use hysteron_workflow::shared::verdict::{compared, repeated};
use hysteron_workflow::{COMMIT, Context};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::score::{Row, Task};

/// Printed successes of NeuralActuator, table IX, of [`PUBLISHED_TRIALS`] each: without and with force.
const PUBLISHED: [(Task, [usize; 2]); 2] = [(Task::Place, [32, 37]), (Task::Stay, [34, 38])];
/// Trials of a printed row.
const PUBLISHED_TRIALS: usize = 40;

/// The outcome of `study cloning`.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct Outcome {
    /// Format of the file.
    pub format: MetricsFormat,
    /// Its version.
    pub version: u32,
    /// Setting of the study.
    pub study: Setting,
    /// Rows of the table.
    pub rows: Vec<Row>,
    /// Printed rows.
    pub published: Vec<PublishedSuccess>,
    /// Whether policies that observe a force do better.
    pub verdict: Verdict,
    /// The command that made this.
    pub command: String,
    /// Commit of the program.
    pub commit: String,
}

/// Setting of the study.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct Setting {
    /// The virtual arm.
    pub arm: String,
    /// Demonstrations of a policy, and of its validation.
    pub demonstrations: [usize; 2],
    /// Trials of a row.
    pub trials: usize,
    /// Policies of a row.
    pub policies: usize,
    /// Distance from the goal that counts as a success [mm].
    pub near_mm: f64,
    /// How long before the end the tip must be that near [s].
    pub stays_s: f64,
    /// Heaviest object [kg].
    pub heaviest_kg: f64,
    /// Units of the hidden layers.
    pub hidden: [usize; 2],
    /// Epochs of the training.
    pub epochs: usize,
}

/// A printed row.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct PublishedSuccess {
    /// The task.
    pub task: Task,
    /// Its trials.
    pub trials: usize,
    /// Successes of the policy without a force.
    pub without_force: usize,
    /// Successes of the policy with a force.
    pub with_force: usize,
}

impl hysteron_workflow::shared::outcome::Outcome for Outcome {
    fn verdict(&self) -> Option<&Verdict> {
        Some(&self.verdict)
    }
}

impl Outcome {
    pub(super) fn new(rows: Vec<Row>, study: Setting, context: &Context) -> Self {
        let published = PUBLISHED.map(|(task, [without_force, with_force])| PublishedSuccess {
            task,
            trials: PUBLISHED_TRIALS,
            without_force,
            with_force,
        });
        Self {
            format: MetricsFormat,
            version: 1,
            verdict: assess(&rows, study.policies),
            study,
            rows,
            published: published.to_vec(),
            command: context.command.clone(),
            commit: COMMIT.to_owned(),
        }
    }
}

/// Policy that observes least.
const BASELINE: &str = "plan and positions";

/// Whether observing more than plan and positions fails less often; experts and goals as planned are no policies.
fn assess(rows: &[Row], n_policies: usize) -> Verdict {
    let failures = |row: &Row| (row.method.clone(), 1.0 - row.rate);
    let of = |task: Task| -> Vec<(String, f64)> {
        let is_policy = |row: &&Row| row.method == BASELINE || row.method.contains("with the");
        let policies = rows.iter().filter(|row| row.task == task).filter(is_policy);
        policies.map(failures).collect()
    };
    let claim = "policies that observe a force handle objects of unknown mass better than those that see plan and positions alone";
    let assessment =
        compared(Verdict::on(claim), ("share of failures, place", ""), &of(Task::Place), BASELINE);
    let assessment = compared(assessment, ("share of failures, stay", ""), &of(Task::Stay), BASELINE);
    repeated(assessment, n_policies, "seed").verdict()
}
