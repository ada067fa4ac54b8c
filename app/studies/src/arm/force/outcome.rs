//! The outcome of `study force`.

use hysteron_report::verdict::Verdict;
use hysteron_workflow::shared::outcome::MetricsFormat;
use hysteron_workflow::shared::verdict::{compared, repeated};
use hysteron_workflow::{COMMIT, Context};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::cells::{ForceCell, ForceStudy};
use super::methods::{METHODS, TASKS};
use super::score::{FreeRow, LoadedRow};

/// The outcome of `study force`.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct Outcome {
    /// Format of the file.
    pub format: MetricsFormat,
    /// Its version.
    pub version: u32,
    /// Name of the study.
    pub study: String,
    /// Whether forces at the tip can be estimated.
    pub verdict: Verdict,
    /// Arms that were recorded.
    pub about: String,
    /// Names of the tasks.
    pub tasks: Vec<String>,
    /// Number of arms.
    pub arms: usize,
    /// Samples for identification, of tests with objects and of tests without, arm by arm.
    pub samples: Vec<[usize; 3]>,
    /// One for each method.
    pub methods: Vec<ForceMethod>,
    /// The command that made this.
    pub command: String,
    /// Commit of the program.
    pub commit: String,
}

/// The forces that one method estimates.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct ForceMethod {
    /// Name of the method.
    pub name: String,
    /// Errors with objects.
    pub loaded: LoadedMeans,
    /// Forces without contact, arm by arm.
    pub free: Vec<FreeRow>,
}

/// Errors over the arms: one value for each task, then their mean; null where there is no trajectory of a task.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct LoadedMeans {
    /// Mean of three axes over all rows, rows without a label as 0 N [N].
    pub mean_n: Vec<Option<f64>>,
    /// Mean of three axes over rows with a label [N].
    pub labelled_n: Vec<Option<f64>>,
    /// Along z over rows with a label [N].
    pub z_n: Vec<Option<f64>>,
    /// Norm of the error over rows with a label [N].
    pub norm_n: Vec<Option<f64>>,
}

impl hysteron_workflow::shared::outcome::Outcome for Outcome {
    fn verdict(&self) -> Option<&Verdict> {
        Some(&self.verdict)
    }
}

impl Outcome {
    pub(super) fn new(study: &ForceStudy, about: String, context: &Context) -> Self {
        let method = |(k, name): (usize, &&str)| ForceMethod {
            name: (*name).to_owned(),
            loaded: LoadedMeans::of(study, k),
            free: study.cells.iter().map(|cell| cell.free[k].clone()).collect(),
        };
        Self {
            format: MetricsFormat,
            version: 1,
            study: "force".to_owned(),
            verdict: assess(study),
            about,
            tasks: TASKS.map(str::to_owned).to_vec(),
            arms: study.cells.len(),
            samples: study.cells.iter().map(|cell| cell.samples).collect(),
            methods: METHODS.iter().enumerate().map(method).collect(),
            command: context.command.clone(),
            commit: COMMIT.to_owned(),
        }
    }
}

impl LoadedMeans {
    fn of(study: &ForceStudy, method: usize) -> Self {
        let means = |shown: Shown| {
            row(study, method, shown).into_iter().map(|found| found.map(|[mean, _]| mean)).collect()
        };
        Self {
            mean_n: means(|row| row.mean_n),
            labelled_n: means(|row| row.labelled_n),
            z_n: means(|row| row.z_n),
            norm_n: means(|row| row.norm_n),
        }
    }
}

/// Value of a row that a table shows.
pub(super) type Shown = fn(&LoadedRow) -> f64;

/// Mean and standard deviation over arms.
pub(super) fn over_arms(cells: &[ForceCell], of: &dyn Fn(&ForceCell) -> Option<f64>) -> Option<[f64; 2]> {
    let values: Vec<f64> = cells.iter().filter_map(of).collect();
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let squares: f64 = values.iter().map(|x| (x - mean) * (x - mean)).sum();
    (!values.is_empty()).then(|| [mean, (squares / (n - 1.0).max(1.0)).sqrt()])
}

/// A method's error in each task, and their mean.
pub(super) fn row(study: &ForceStudy, method: usize, shown: Shown) -> Vec<Option<[f64; 2]>> {
    let of = |cell: &ForceCell, task: usize| cell.loaded[method][task].as_ref().map(shown);
    let mean = |cell: &ForceCell| {
        let all: Vec<f64> = (0..TASKS.len()).filter_map(|task| of(cell, task)).collect();
        (!all.is_empty()).then(|| all.iter().sum::<f64>() / all.len() as f64)
    };
    let tasks = (0..TASKS.len()).map(|task| over_arms(&study.cells, &|cell| of(cell, task)));
    tasks.chain([over_arms(&study.cells, &mean)]).collect()
}

/// Verdict on the best estimator, compared with the estimate zero.
fn assess(study: &ForceStudy) -> Verdict {
    let mean = |method: usize| row(study, method, |row| row.norm_n).last().copied().flatten();
    let errors: Vec<(String, f64)> = METHODS
        .iter()
        .enumerate()
        .filter_map(|(method, name)| Some(((*name).to_owned(), mean(method)?[0])))
        .collect();
    let assessment = Verdict::on("forces at the tip can be estimated without a sensor");
    let assessment = compared(assessment, ("error where a force acts", "N"), &errors, METHODS[0]);
    repeated(assessment, study.cells.len(), "arm").verdict()
}
