//! The outcome of `study neural` and `study neural-networks`.

use hysteron_arm_learning::neural::METHODS;
use hysteron_report::verdict::Verdict;
use hysteron_workflow::shared::outcome::MetricsFormat;
use hysteron_workflow::shared::verdict::{compared, repeated};
use hysteron_workflow::{COMMIT, Context};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::study::NeuralStudy;

/// The outcome of `study neural`.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct Outcome {
    /// Format of the file.
    pub format: MetricsFormat,
    /// Its version.
    pub version: u32,
    /// Name of the study.
    pub study: String,
    /// Whether an actuator that is learned from telemetry simulates the arm.
    pub verdict: Verdict,
    /// The arm that was recorded, and the size of the networks.
    pub about: String,
    /// Every comparison, without what is only drawn.
    pub cells: NeuralStudy,
    /// The command that made this.
    pub command: String,
    /// Commit of the program.
    pub commit: String,
}

impl hysteron_workflow::shared::outcome::Outcome for Outcome {
    fn verdict(&self) -> Option<&Verdict> {
        Some(&self.verdict)
    }
}

impl Outcome {
    pub(super) fn new(study: &NeuralStudy, about: String, context: &Context) -> Self {
        Self {
            format: MetricsFormat,
            version: 1,
            study: "neural".to_owned(),
            verdict: assess(study),
            about,
            cells: without_traces(study),
            command: context.command.clone(),
            commit: COMMIT.to_owned(),
        }
    }
}

/// The study without what is only drawn.
fn without_traces(study: &NeuralStudy) -> NeuralStudy {
    let mut all = study.clone();
    all.published.iter_mut().for_each(|cell| cell.traces = None);
    all
}

/// Half of the interval that holds the mean with 95 %, by seeds (Student's t): of 2 to 10.
const STUDENT: [f64; 9] = [12.71, 4.30, 3.18, 2.78, 2.57, 2.45, 2.36, 2.31, 2.26];

/// Mean of the finite values over seeds, and half of its 95 % interval for more than one.
pub(super) fn over_seeds<C>(cells: &[C], of: &dyn Fn(&C) -> Option<f64>) -> Option<(f64, Option<f64>)> {
    let values: Vec<f64> = cells.iter().filter_map(of).filter(|value| value.is_finite()).collect();
    let n = values.len();
    let mean = values.iter().sum::<f64>() / n as f64;
    let squares: f64 = values.iter().map(|x| (x - mean) * (x - mean)).sum();
    let t = STUDENT.get(n.wrapping_sub(2)).copied().unwrap_or(1.96);
    let half = (n > 1).then(|| t * (squares / (n as f64 - 1.0) / n as f64).sqrt());
    (n > 0).then_some((mean, half))
}

/// Whether the network in pure simulation does better than goals that are copied with a fitted lag and droop.
fn assess(study: &NeuralStudy) -> Verdict {
    let error =
        |method: usize| over_seeds(&study.published, &|cell| cell.mean_deg.values()[method].steps_500);
    let errors: Vec<(String, f64)> = [1, 3]
        .into_iter()
        .filter_map(|method| Some((METHODS[method].to_owned(), error(method)?.0)))
        .collect();
    let assessment = Verdict::on("an actuator learned from telemetry simulates the arm");
    let assessment = compared(assessment, ("error of the joints, 500 steps", "deg"), &errors, METHODS[3]);
    repeated(assessment, study.published.len(), "seed").verdict()
}
