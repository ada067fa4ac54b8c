//! Penalties and lengths chosen by leaving out whole trajectories of the training data.

use hysteron_base::BadInput;
use hysteron_fit::folds;

use super::{FourierFeatures, NormalEquations, RigidFeatures};
use crate::lagrangian::{ArmSamples, TorqueScores};

/// Parts of the trajectories that are left out in turn.
pub(super) const FOLDS: usize = 4;
/// Penalties that are tried.
const PENALTIES: [f64; 9] = [1e-8, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 1e-1, 1.0, 10.0];

/// Ridge penalty selected by validation, and its validation error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Choice {
    /// λ of the ridge.
    pub penalty: f64,
    /// Mean nMSE of a joint over the validation trajectories [-].
    pub validation: f64,
}

fn total(parts: &[NormalEquations], which: impl IntoIterator<Item = usize>) -> NormalEquations {
    let mut which = which.into_iter();
    let mut sum = which.next().map(|t| parts[t].clone()).unwrap_or_else(|| NormalEquations::new(0, 0));
    which.for_each(|t| sum.add_scaled(&parts[t], 1.0));
    sum
}

/// Asked between parts of a choice; false ends it, without one.
pub type GoesOn<'a> = &'a mut dyn FnMut() -> bool;

/// The penalty whose weights err least on validation trajectories. `errors(weights, test)` gives the normalised
/// error on the trajectories of those numbers.
///
/// # Errors
/// `BadInput` for fewer than two trajectories.
pub fn choose_penalty(
    parts: &[NormalEquations],
    errors: &dyn Fn(&[f64], &[usize]) -> f64,
    continues: GoesOn<'_>,
) -> Result<Option<Choice>, BadInput> {
    let folds = folds(parts.len(), FOLDS.min(parts.len()))?;
    let mut best = Choice { penalty: PENALTIES[0], validation: f64::INFINITY };
    let sums: Vec<NormalEquations> =
        folds.iter().map(|fold| total(parts, fold.training.iter().copied())).collect();
    for penalty in PENALTIES {
        if !continues() {
            return Ok(None);
        }
        let errors = folds.iter().zip(&sums).map(|(fold, sum)| errors(&sum.solve(penalty), &fold.test));
        let validation = errors.sum::<f64>() / folds.len() as f64;
        if validation < best.validation {
            best = Choice { penalty, validation };
        }
    }
    Ok(Some(best))
}

/// A rigid body's parameters from all training trajectories, with the penalty chosen on those left out; the sums too, from
/// which feasible bodies can be found.
///
/// # Errors
/// As [`choose_penalty`].
pub fn fit_rigid_body(
    features: &RigidFeatures<'_>,
    training: &ArmSamples,
    stride: usize,
    continues: GoesOn<'_>,
) -> Result<Option<(Vec<f64>, Choice, NormalEquations)>, BadInput> {
    let parts = features.normal_equations(training, stride);
    let errors = |weights: &[f64], test: &[usize]| {
        let part = training.select(test.iter().copied());
        1.0 - TorqueScores::of(part.n_joints, &part.tau, &features.predict(weights, &part)).mean_r2()
    };
    let Some(choice) = choose_penalty(&parts, &errors, continues)? else { return Ok(None) };
    let sums = total(&parts, 0..parts.len());
    Ok(Some((sums.solve(choice.penalty), choice, sums)))
}

/// Fourier features with their weights.
#[derive(Debug, Clone)]
pub struct FourierFit {
    /// The features of the chosen length.
    pub features: FourierFeatures,
    /// [feature][joint].
    pub weights: Vec<f64>,
    /// The penalty chosen.
    pub choice: Choice,
    /// The length chosen, in spreads of the states.
    pub length: f64,
}

/// Ridge regression on Fourier features of what `offset` (torques that another model predicts, [sample][joint]) leaves;
/// length and penalty are chosen on validation trajectories.
///
/// # Errors
/// As [`choose_penalty`].
pub fn fit_fourier(
    training: &ArmSamples,
    offset: &[f64],
    lengths: &[f64],
    (n_features, stride, seed): (usize, usize, u64),
    continues: GoesOn<'_>,
) -> Result<Option<FourierFit>, BadInput> {
    let n = training.n_joints;
    let targets: Vec<f64> = training.tau.iter().zip(offset).map(|(t, o)| t - o).collect();
    let mut best: Option<FourierFit> = None;
    for length in lengths {
        let features = FourierFeatures::new(training, n_features, *length, seed);
        let parts = features.normal_equations(training, &targets, stride);
        let errors = |weights: &[f64], test: &[usize]| {
            let part = training.select(test.iter().copied());
            let offset = test.iter().flat_map(|t| {
                let range = &training.trajectories[*t];
                offset[n * range.start..n * range.end].iter()
            });
            let found = features.predict(weights, &part);
            let sum: Vec<f64> = found.iter().zip(offset).map(|(f, o)| f + o).collect();
            1.0 - TorqueScores::of(n, &part.tau, &sum).mean_r2()
        };
        let Some(choice) = choose_penalty(&parts, &errors, continues)? else { return Ok(None) };
        if best.as_ref().is_none_or(|best| choice.validation < best.choice.validation) {
            let weights = total(&parts, 0..parts.len()).solve(choice.penalty);
            best = Some(FourierFit { features, weights, choice, length: *length });
        }
    }
    best.map(Some).ok_or_else(|| BadInput::new("lengths", "one or more", "none"))
}
