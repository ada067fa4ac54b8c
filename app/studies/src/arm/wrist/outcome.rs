//! The outcome of `study wrist`.

use hysteron_report::verdict::Verdict;
use hysteron_workflow::shared::outcome::MetricsFormat;
use hysteron_workflow::shared::verdict::{compared, repeated};
use hysteron_workflow::{COMMIT, Context};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::cells::WristStudy;
use crate::arm::estimation::wrist::{Load, METHODS, WristCell};

/// The outcome of `study wrist`.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct Outcome {
    /// Format of the file.
    pub format: MetricsFormat,
    /// Its version.
    pub version: u32,
    /// Name of the study.
    pub study: String,
    /// Whether interaction torques can be estimated from the motors.
    pub verdict: Verdict,
    /// Trials: by drift of friction, load and seed.
    pub cells: Vec<WristResult>,
    /// The paper's simulations: root mean square errors.
    pub simulated_rms: SimulatedErrors,
    /// Residuals of both joints in the swept sine, model by model [N m].
    pub sweep_rms_n_m: Vec<[f64; 2]>,
    /// The command that made this.
    pub command: String,
    /// Commit of the program.
    pub commit: String,
}

/// Every method under one load, one drift of friction and one seed.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct WristResult {
    /// Load of the wrist.
    pub load: Load,
    /// Relative change of friction after identification [-].
    pub drift: f64,
    /// Seed of the noise.
    pub seed: u64,
    /// Mean size of the true torque of both joints [N m].
    pub mean_truth_n_m: [f64; 2],
    /// Residual of the identification, both joints [N m].
    pub identified_rms_n_m: [f64; 2],
    /// One for each method.
    pub methods: Vec<MethodErrors>,
}

/// Errors of one method, both joints.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct MethodErrors {
    /// Name of the method.
    pub name: String,
    /// Mean error [N m].
    pub error_n_m: [f64; 2],
    /// The same over the mean torque [%].
    pub error_percent: [f64; 2],
}

/// Errors of inverse dynamics and of the disturbance observer, joint by joint, in the paper's simulations.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct SimulatedErrors {
    /// Noise on the encoders [N m].
    pub noise: [Vec<f64>; 2],
    /// A wrong model [N m].
    pub model_error: [Vec<f64>; 2],
    /// Sensitivity to the mass of the second link [m²/s²].
    pub sensitivity: [Vec<f64>; 2],
}

impl hysteron_workflow::shared::outcome::Outcome for Outcome {
    fn verdict(&self) -> Option<&Verdict> {
        Some(&self.verdict)
    }
}

impl Outcome {
    pub(super) fn new(study: &WristStudy, context: &Context) -> Self {
        let [noise, wrong, sensitivity] = &study.simulated;
        Self {
            format: MetricsFormat,
            version: 1,
            study: "wrist".to_owned(),
            verdict: assess(study),
            cells: study.cells.iter().map(WristResult::of).collect(),
            simulated_rms: SimulatedErrors {
                noise: noise.rms.clone(),
                model_error: wrong.rms.clone(),
                sensitivity: sensitivity.rms.clone(),
            },
            sweep_rms_n_m: study.sweep.rms_n_m.clone(),
            command: context.command.clone(),
            commit: COMMIT.to_owned(),
        }
    }
}

impl WristResult {
    fn of(cell: &WristCell) -> Self {
        let method = |method: &crate::arm::estimation::wrist::WristMethod| MethodErrors {
            name: method.name.clone(),
            error_n_m: method.error_n_m,
            error_percent: method.error_percent,
        };
        Self {
            load: cell.load,
            drift: cell.drift,
            seed: cell.seed,
            mean_truth_n_m: cell.mean_truth_n_m,
            identified_rms_n_m: cell.identified_rms_n_m,
            methods: cell.methods.iter().map(method).collect(),
        }
    }
}

/// Whether the best observer does better than the motors' torque taken as it is.
fn assess(study: &WristStudy) -> Verdict {
    let cells: Vec<&WristCell> = study.cells.iter().filter(|cell| cell.drift == 0.0).collect();
    let mean = |method: usize| means(&cells, method)[0].iter().sum::<f64>() / 2.0;
    let errors: Vec<(String, f64)> =
        METHODS.iter().enumerate().map(|(k, name)| ((*name).to_owned(), mean(k))).collect();
    let assessment = Verdict::on("interaction torques can be estimated from the motors");
    let assessment =
        compared(assessment, ("mean error without drift of friction", "N m"), &errors, METHODS[0]);
    let seeds: std::collections::BTreeSet<u64> = cells.iter().map(|cell| cell.seed).collect();
    repeated(assessment, seeds.len(), "seed").verdict()
}

/// Means over the seeds, joints 1 and 2: error [N m], percent.
pub(super) fn means(cells: &[&WristCell], method: usize) -> [[f64; 2]; 2] {
    let n = cells.len() as f64;
    let mean = |of: &dyn Fn(&WristCell) -> f64| cells.iter().map(|cell| of(cell)).sum::<f64>() / n;
    [
        [0, 1].map(|j| mean(&|cell| cell.methods[method].error_n_m[j])),
        [0, 1].map(|j| mean(&|cell| cell.methods[method].error_percent[j])),
    ]
}
