//! The outcome of `study scara`.

use hysteron_report::verdict::{Criterion, Verdict};
use hysteron_workflow::shared::outcome::MetricsFormat;
use hysteron_workflow::shared::verdict::{compared, repeated};
use hysteron_workflow::{COMMIT, Context};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::cells::{ScaraOptions, ScaraStudy};
use crate::arm::estimation::collisions::CollisionCell;

/// The outcome of `study scara`.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct Outcome {
    /// Format of the file.
    pub format: MetricsFormat,
    /// Its version.
    pub version: u32,
    /// Name of the study.
    pub study: String,
    /// Whether external torques can be estimated.
    pub verdict: Verdict,
    /// How much was simulated.
    pub options: ScaraOptions,
    /// Identified friction, joint by joint and method by method.
    pub friction: Vec<FrictionResult>,
    /// External torques while the hand leads the arm, by every model of friction.
    pub teaching: Vec<TeachingResult>,
    /// Deviation of the true external torque of both joints [N m].
    pub truth_deviation_n_m: [f64; 2],
    /// Collisions by every method.
    pub collisions: CollisionCell,
    /// The command that made this.
    pub command: String,
    /// Commit of the program.
    pub commit: String,
}

/// Friction of a joint by one method.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct FrictionResult {
    /// The joint, from 1.
    pub joint: usize,
    /// The method.
    pub method: String,
    /// Parameters of its law.
    pub parameters: Vec<f64>,
    /// Root mean square and largest error of the curve from single trials [N m].
    pub single_error_n_m: [f64; 2],
    /// The same from means of 200 trials [N m].
    pub averaged_error_n_m: [f64; 2],
    /// Training and test error of every fold [N m].
    pub folds_n_m: Vec<[f64; 2]>,
}

/// External torques by one model of friction, both joints.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct TeachingResult {
    /// The method of the model.
    pub method: String,
    /// Root mean square error [N m].
    pub rmse_n_m: [f64; 2],
    /// Largest error [N m].
    pub max_n_m: [f64; 2],
    /// Least error [N m].
    pub min_n_m: [f64; 2],
    /// Mean error [N m].
    pub mean_n_m: [f64; 2],
    /// Share of the variance that is explained (R²) [-].
    pub r2: [f64; 2],
}

impl hysteron_workflow::shared::outcome::Outcome for Outcome {
    fn verdict(&self) -> Option<&Verdict> {
        Some(&self.verdict)
    }
}

impl Outcome {
    pub(super) fn new(study: &ScaraStudy, context: &Context) -> Self {
        let friction = study.friction.iter().flat_map(|joint| {
            joint.rows.iter().map(move |row| FrictionResult {
                joint: joint.joint + 1,
                method: row.method.clone(),
                parameters: row.parameters.clone(),
                single_error_n_m: row.single_error_n_m,
                averaged_error_n_m: row.averaged_error_n_m,
                folds_n_m: row.folds_n_m.clone(),
            })
        });
        let teaching = study.teaching.rows.iter().map(|row| TeachingResult {
            method: row.method.clone(),
            rmse_n_m: row.rmse_n_m,
            max_n_m: row.max_n_m,
            min_n_m: row.min_n_m,
            mean_n_m: row.mean_n_m,
            r2: row.r2,
        });
        Self {
            format: MetricsFormat,
            version: 1,
            study: "scara".to_owned(),
            verdict: assess(study),
            options: study.options,
            friction: friction.collect(),
            teaching: teaching.collect(),
            truth_deviation_n_m: study.teaching.truth_deviation_n_m,
            collisions: study.collisions.clone(),
            command: context.command.clone(),
            commit: COMMIT.to_owned(),
        }
    }
}

/// Whether the best model of friction estimates external torques better than Coulomb's law, and better than nothing.
fn assess(study: &ScaraStudy) -> Verdict {
    let teaching = &study.teaching;
    let mean = |errors: &[f64; 2]| (errors.iter().map(|e| e * e).sum::<f64>() / 2.0).sqrt();
    let errors: Vec<(String, f64)> =
        teaching.rows.iter().map(|row| (row.method.clone(), mean(&row.rmse_n_m))).collect();
    let assessment = Verdict::on("external torques can be estimated with identified friction");
    let assessment =
        compared(assessment, ("error of the external torque", "N m"), &errors, "least-squares-coulomb");
    let least = errors.iter().map(|row| row.1).fold(f64::INFINITY, f64::min);
    let share = least / mean(&teaching.truth_deviation_n_m);
    let statement = format!("the least error is {:.0} % of the deviation of the true torques", 100.0 * share);
    repeated(assessment.because(Criterion::ErrorOverSpread, share, statement), study.options.trials, "trial")
        .verdict()
}
