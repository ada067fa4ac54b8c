//! The run of `study ftdcr`.

use anyhow::Result;
use hysteron_workflow::{Context, WorkflowError};
use rayon::prelude::*;

use super::fold::{Fold, N_FOLDS, folds};
use super::outcome::{FoldResult, FtdcrMetrics, METHODS, MethodError, ParameterValue};
use super::recording::{Pattern, read_patterns};
use super::robot::Robot;
use crate::tendon::numbers::rms;
use crate::tendon::{DataOptions, Outcome, session};

/// The reduced model is fitted to every third row, in a quick study to every twelfth.
const FIT_EVERY: [usize; 2] = [3, 12];
/// Runs the study, a quick one with the first fold, fewer rows to fit and without the finite-element twin.
///
/// # Errors
/// The files are missing or cannot be read, or a fit fails.
pub fn run(options: &DataOptions, context: &Context) -> Result<Outcome<FtdcrMetrics>, WorkflowError> {
    session::run("ftdcr", &options.shared.out, context, || {
        let folds = measure(options)?;
        Ok(FtdcrMetrics {
            folds: folds.iter().map(FoldResult::of).collect(),
            pooled: errors(folds[0].errors.len(), |method| pooled(&folds, method)),
        })
    })
}

fn measure(options: &DataOptions) -> Result<Vec<Fold>> {
    let quick = options.shared.quick;
    let patterns = read_patterns(&options.require("ftdcr-v4/train.csv")?)?;
    let fold_of = folds(patterns.len());
    let (n_folds, fit_every) = if quick { (1, FIT_EVERY[1]) } else { (N_FOLDS, FIT_EVERY[0]) };
    let robot = if quick { None } else { Some(Robot::read(&options.shared.repository)?) };
    let one = |fold: usize| {
        let (held, training): (Vec<_>, Vec<_>) =
            patterns.iter().zip(&fold_of).partition(|(_, of)| **of == fold);
        let only =
            |pairs: Vec<(&Pattern, &usize)>| pairs.into_iter().map(|(p, _)| p.clone()).collect::<Vec<_>>();
        Fold::new(robot.as_ref(), fit_every, &only(training), &only(held))
    };
    (0..n_folds).into_par_iter().map(one).collect()
}

impl FoldResult {
    fn of(fold: &Fold) -> Self {
        let parameters = fold.fitted.names.iter().zip(&fold.fitted.values);
        Self {
            patterns: fold.patterns.clone(),
            rows: fold.errors[0].len(),
            rows_without_equilibrium: fold.rows_without_equilibrium,
            parameters: parameters
                .map(|(name, value)| ParameterValue { name: name.to_string(), value: *value })
                .collect(),
            fit_ended: fold.fitted.ended.to_string(),
            twin_parameters: fold.twin.as_ref().map(|own| own.values.to_vec()),
            rmse_mm: errors(fold.errors.len(), |method| rms(fold.errors[method].iter().copied())),
        }
    }
}

/// Errors of the first `n` methods.
fn errors(n: usize, rmse_mm: impl Fn(usize) -> f64) -> Vec<MethodError> {
    let one = |(m, name): (usize, &&str)| MethodError { method: (*name).to_owned(), rmse_mm: rmse_mm(m) };
    METHODS.iter().take(n).enumerate().map(one).collect()
}

fn pooled(folds: &[Fold], method: usize) -> f64 {
    rms(folds.iter().flat_map(|fold| &fold.errors[method]).copied())
}
