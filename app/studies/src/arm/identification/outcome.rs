//! The outcome of `study identification`.

use hysteron_report::verdict::Verdict;
use hysteron_workflow::shared::outcome::MetricsFormat;
use hysteron_workflow::shared::verdict::{compared, repeated};
use hysteron_workflow::{COMMIT, Context};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::cells::{IdentificationOptions, IdentificationStudy};
use super::franka::FrankaRow;
use super::sweep::SweepCell;
use crate::arm::estimation::scara_friction::{FrictionCell, FrictionRow};

/// The outcome of `study identification`.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct Outcome {
    /// Format of the file.
    pub format: MetricsFormat,
    /// Its version.
    pub version: u32,
    /// Name of the study.
    pub study: String,
    /// Whether friction can be identified from single trials.
    pub verdict: Verdict,
    /// How much was simulated.
    pub options: IdentificationOptions,
    /// Recorded friction of a Franka arm; null without data.
    pub franka: Option<FrankaResult>,
    /// Friction of the SCARA: method by method for each joint, over the seeds.
    pub scara: Vec<ScaraMethod>,
    /// Bodies of the wrist, seed by seed.
    pub wrist: Vec<SweepCell>,
    /// The command that made this.
    pub command: String,
    /// Commit of the program.
    pub commit: String,
}

/// Recorded friction of a joint of a Franka arm: two speeds are fitted, the third is predicted.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct FrankaResult {
    /// One for each model.
    pub rows: Vec<FrankaRow>,
    /// Ridge of the map's fit, for each speed that is predicted.
    pub ridge: [f64; 3],
}

/// One method on one joint of the SCARA; errors are means over the seeds.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct ScaraMethod {
    /// The joint, from 1.
    pub joint: usize,
    /// Name of the method.
    pub method: String,
    /// Parameters of its law, of the first seed.
    pub parameters: Vec<f64>,
    /// Root mean square error of the curve from single trials [N m].
    pub single_rms_n_m: f64,
    /// Largest error of that curve [N m].
    pub single_max_n_m: f64,
    /// Root mean square error of the curve from means of 200 trials [N m].
    pub averaged_rms_n_m: f64,
    /// Largest error of that curve [N m].
    pub averaged_max_n_m: f64,
    /// Training and test error of the five folds, means over folds and seeds [N m].
    pub folds_training_test_n_m: [f64; 2],
}

impl hysteron_workflow::shared::outcome::Outcome for Outcome {
    fn verdict(&self) -> Option<&Verdict> {
        Some(&self.verdict)
    }
}

impl Outcome {
    pub(super) fn new(study: &IdentificationStudy, context: &Context) -> Self {
        let scara: Vec<ScaraMethod> = (0..2).flat_map(|joint| methods(study, joint)).collect();
        let franka = study.franka.as_ref();
        Self {
            format: MetricsFormat,
            version: 1,
            study: "identification".to_owned(),
            verdict: assess(&scara, study.options.seeds as usize),
            options: study.options,
            franka: franka.map(|cell| FrankaResult { rows: cell.rows.clone(), ridge: cell.ridge }),
            scara,
            wrist: study.wrist.clone(),
            command: context.command.clone(),
            commit: COMMIT.to_owned(),
        }
    }
}

/// Every method on one joint of the SCARA.
fn methods(study: &IdentificationStudy, joint: usize) -> Vec<ScaraMethod> {
    let cells: Vec<&FrictionCell> = study.scara.iter().filter(|cell| cell.joint == joint).collect();
    let rows = cells.first().map_or(&[][..], |cell| &cell.rows);
    rows.iter().enumerate().map(|(m, first)| ScaraMethod::of(joint, first, &cells, m)).collect()
}

impl ScaraMethod {
    /// Method `m` of the cells, whose first row is `first`.
    fn of(joint: usize, first: &FrictionRow, cells: &[&FrictionCell], m: usize) -> Self {
        let n = cells.len() as f64;
        let (mut errors, mut folds) = ([0.0; 4], [0.0; 2]);
        for row in cells.iter().map(|cell| &cell.rows[m]) {
            let own = [row.single_error_n_m, row.averaged_error_n_m].concat();
            errors.iter_mut().zip(own).for_each(|(sum, e)| *sum += e / n);
            for fold in &row.folds_n_m {
                folds.iter_mut().zip(fold).for_each(|(sum, e)| *sum += e / n / row.folds_n_m.len() as f64);
            }
        }
        let [single_rms_n_m, single_max_n_m, averaged_rms_n_m, averaged_max_n_m] = errors;
        Self {
            joint: joint + 1,
            method: first.method.clone(),
            parameters: first.parameters.clone(),
            single_rms_n_m,
            single_max_n_m,
            averaged_rms_n_m,
            averaged_max_n_m,
            folds_training_test_n_m: folds,
        }
    }
}

/// Whether the best method finds the curve of friction better than Coulomb's law by least squares.
fn assess(methods: &[ScaraMethod], seeds: usize) -> Verdict {
    let of = |joint: usize| -> Vec<(String, f64)> {
        let of_joint = methods.iter().filter(|method| method.joint == joint);
        of_joint.map(|method| (method.method.clone(), method.single_rms_n_m)).collect()
    };
    let assessment =
        (1..=2).fold(Verdict::on("friction can be identified from single trials"), |assessment, joint| {
            let what = format!("joint {joint}, error of the curve");
            compared(assessment, (&what, "N m"), &of(joint), "least-squares-coulomb")
        });
    repeated(assessment, seeds, "seed").verdict()
}
