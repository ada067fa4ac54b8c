//! The outcome of `fit-material`.

use hysteron_base::checks::Warning;
use hysteron_report::verdict::Verdict;
use hysteron_twin::fit::{Identifiability, IdentifiedParameter, Selected};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::verdict::FinishedFit;
use crate::shared::outcome::MetricsFormat;
use crate::{COMMIT, Context};

/// The outcome of `fit-material`; everything in SI.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct Outcome {
    /// Format of the file.
    pub format: MetricsFormat,
    /// Its version.
    pub version: u32,
    /// Whether the fitted scene can be used.
    pub verdict: Verdict,
    /// Name of the robot.
    pub robot: String,
    /// Hash of the scene and its mesh.
    pub scene_sha256: String,
    /// Parameters of the fit.
    pub parameters: Vec<FittedParameter>,
    /// Correlation, rows and columns in the order of the parameters; zero where one was not fitted [-].
    pub correlation: Vec<Vec<f64>>,
    /// Errors of the scene as given.
    pub errors_before: FittedTipErrors,
    /// Errors of the fitted scene.
    pub errors_after: FittedTipErrors,
    /// Gravity of the fitted scene [m/s²].
    pub gravity_m_s2: [f64; 3],
    /// Largest tension of every tendon with the fitted scene [N].
    pub largest_tensions_n: Vec<f64>,
    /// Warnings about the result, and other explanations of the errors that are left.
    #[serde(rename = "doubts")]
    pub warnings: Vec<String>,
    /// Warnings about the recordings.
    #[serde(default)]
    pub recording_warnings: Vec<Warning>,
    /// Recordings that were compared.
    pub recordings: usize,
    /// Recordings that were skipped for their role.
    pub recordings_of_another_role: usize,
    /// Measured tips that were compared.
    pub rows: usize,
    /// Steps of the twin in an evaluation.
    pub steps: usize,
    /// Condition number of the Jacobian, columns normalised [-].
    pub condition: f64,
    /// Coordinates of the tip that never change and were skipped.
    pub constant_channels: usize,
    /// Residuals.
    pub residuals: usize,
    /// Effective number of independent residuals [-].
    pub effective_residuals: f64,
    /// Iterations of the search.
    pub iterations: usize,
    /// Evaluations of the search.
    pub evaluations: usize,
    /// Why the search ended.
    pub ended: String,
    /// Whether it converged.
    pub converged: bool,
    /// The command that made this.
    pub command: String,
    /// Commit of the program.
    pub commit: String,
}

/// A parameter of the fit, in SI.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct FittedParameter {
    /// Name.
    pub name: String,
    /// Value of the scene.
    pub start: f64,
    /// Fitted value.
    pub value: f64,
    /// Standard error, where the data determine it.
    pub standard_error: Option<f64>,
    /// Lower bound.
    pub lower_bound: f64,
    /// Upper bound.
    pub upper_bound: f64,
    /// Standard deviation of the prior; a factor on a logarithmic scale.
    pub prior_width: Option<f64>,
    /// Whether the fit ended at a bound.
    pub is_at_bound: bool,
    /// Identifiability, in words.
    #[serde(rename = "standing")]
    pub identifiability: String,
}

/// Errors of the twin's tip.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct FittedTipErrors {
    /// Root mean square along x, y and z [m].
    pub rmse_axes_m: [f64; 3],
    /// Root mean square of the distance [m].
    pub rmse_distance_m: f64,
}

impl crate::shared::outcome::Outcome for Outcome {
    fn verdict(&self) -> Option<&Verdict> {
        Some(&self.verdict)
    }
}

impl FittedParameter {
    fn new(selected: &Selected, estimate: &IdentifiedParameter) -> Self {
        Self {
            name: estimate.name.clone(),
            start: estimate.start,
            value: estimate.value,
            standard_error: estimate.standard_error,
            lower_bound: selected.parameter.bounds.min,
            upper_bound: selected.parameter.bounds.max,
            prior_width: selected.parameter.prior.map(|prior| prior.width),
            is_at_bound: estimate.identifiability == Identifiability::AtBound,
            identifiability: identifiability(&estimate.identifiability),
        }
    }
}

impl Outcome {
    pub(super) fn new(finished: &FinishedFit, context: &Context) -> Self {
        let FinishedFit { scene, motions, selected, found, .. } = *finished;
        let fit = &found.fit;
        let errors = |k: usize| FittedTipErrors {
            rmse_axes_m: found.errors[k].axes,
            rmse_distance_m: found.errors[k].distance,
        };
        let parameters = selected.iter().zip(&fit.estimates);
        Self {
            format: MetricsFormat,
            version: 1,
            verdict: finished.verdict(),
            robot: scene.name.clone(),
            scene_sha256: scene.hash.clone(),
            parameters: parameters.map(|(selected, one)| FittedParameter::new(selected, one)).collect(),
            correlation: fit.correlation.clone(),
            errors_before: errors(0),
            errors_after: errors(1),
            gravity_m_s2: found.scene.gravity,
            largest_tensions_n: found.tensions.clone(),
            warnings: finished.warnings(),
            recording_warnings: finished.findings.warnings().to_vec(),
            recordings: motions.len(),
            recordings_of_another_role: finished.n_other_role,
            rows: found.courses.iter().flat_map(|course| &course.tips).flatten().count(),
            steps: found.courses.iter().map(|course| course.samples.len()).sum(),
            condition: fit.condition,
            constant_channels: motions
                .iter()
                .flat_map(|motion| motion.axes)
                .filter(|is_used| !is_used)
                .count(),
            residuals: fit.n_residuals,
            effective_residuals: fit.n_effective,
            iterations: fit.iterations,
            evaluations: fit.evaluations,
            ended: fit.ended.clone(),
            converged: fit.is_converged,
            command: context.command.clone(),
            commit: COMMIT.to_owned(),
        }
    }
}

/// Significant digits of a parameter on the console and on the page.
pub(super) const N_DIGITS: i32 = 4;

/// Identifiability of a parameter, in words.
pub(super) fn identifiability(identifiability: &Identifiability) -> String {
    match identifiability {
        Identifiability::Fitted => "fitted".into(),
        Identifiability::AtBound => "at a bound".into(),
        Identifiability::Vague => "vague, but the scene's value fits worse".into(),
        Identifiability::Undetermined(with) if with.is_empty() => "not determined by the data, fixed".into(),
        Identifiability::Undetermined(with) => {
            format!("determined only together with {}, fixed", with.join(", "))
        }
    }
}
