//! The controllers of a training next to each other, on recordings that none of them learned from.

use std::path::{Path, PathBuf};

use hysteron_control::inverse::{Candidate, DataOrigin, Demonstration, FittedController};
use hysteron_learn::{FitReport, simplest_within};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::judge::{Judge, SquaredDistances};
use super::options::Options;
use crate::Context;
use crate::shared::paper_design::DesignName;

/// Part by which errors differ by chance: another seed of a network changes as much [-].
pub const SAME: f64 = 0.05;
/// Part by which a network must be behind the best after the first fold to be given up [-].
const BEHIND: f64 = 0.25;

/// A controller that was fitted once for each fold, and its errors on what that left out.
pub(super) struct ComparedController {
    pub candidate: Candidate,
    /// Of each fold.
    reports: Vec<FitReport>,
    /// Of the last fold.
    pub last: FittedController,
    /// At the tip, by recording; none where nothing judges it, or the twin could not follow.
    tips: Vec<Option<SquaredDistances>>,
}

/// Errors of a controller in validation.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct CandidateErrors {
    /// Which controller.
    pub candidate: Candidate,
    /// Root mean square error of its strokes [mm].
    pub stroke_rmse_mm: f64,
    /// Root mean square distance of the tips that its strokes and the recorded ones bring the twin to [mm]; none where no twin
    /// was named, or it cannot follow.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tip_rmse_mm: Option<f64>,
    /// Standard error of that, from the differences between recordings [mm].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tip_standard_error_mm: Option<f64>,
    /// Folds that it was fitted for: fewer than the others where it was far behind after the first.
    pub folds: usize,
    /// Whether it is the one in the checkpoint.
    pub is_chosen: bool,
}

/// The controllers to compare: those of the options, or all that the data allow. Without a twin that judges, controllers of real and of
/// synthetic data cannot be compared, since their strokes alone do not say how far the tip is off.
pub(super) fn candidates(options: &Options, all: &[Demonstration]) -> Vec<Candidate> {
    let has = |origin| all.iter().any(|one| one.origin == origin);
    let is_hybrid = has(DataOrigin::Real) && has(DataOrigin::Synthetic);
    if !options.candidates.is_empty() {
        return options.candidates.iter().map(|name| name.candidate()).collect();
    }
    if options.design == DesignName::Paper || is_hybrid && options.scene.is_none() {
        return vec![Candidate::Network];
    }
    let recorded = is_hybrid.then_some(Candidate::RecordedNetwork);
    let all = [Candidate::StaticRegression, Candidate::KernelRegression];
    all.into_iter().chain(recorded).chain([Candidate::Network]).collect()
}

/// The file that the training of a candidate resumes from: for a fold, or for all data.
pub(super) fn training_file(out: &Path, candidate: Candidate, fold: Option<usize>) -> Option<PathBuf> {
    let which = match candidate {
        Candidate::StaticRegression | Candidate::KernelRegression => return None,
        Candidate::RecordedNetwork => "recorded.training",
        Candidate::Network => "training",
    };
    Some(out.with_extension(match fold {
        Some(number) => format!("fold-{}.{which}", number + 1),
        None => which.to_owned(),
    }))
}

impl ComparedController {
    pub(super) fn new(
        candidate: Candidate,
        fitted: FittedController,
        tips: Vec<Option<SquaredDistances>>,
    ) -> Self {
        Self { candidate, reports: vec![fitted.report.clone()], last: fitted, tips }
    }

    /// Adds what it does in another fold.
    pub(super) fn add(&mut self, fitted: FittedController, tips: Vec<Option<SquaredDistances>>) {
        self.reports.push(fitted.report.clone());
        self.last = fitted;
        self.tips.extend(tips);
    }

    /// Root mean square error at the tip, and its standard error [mm].
    fn tip(&self) -> Option<(f64, Option<f64>)> {
        let squares = self.tips.iter().copied().collect::<Option<Vec<_>>>()?;
        (!squares.is_empty()).then(|| SquaredDistances::root_mean_mm(&squares))
    }

    fn stroke_mm(&self) -> f64 {
        FitReport::pooled(&self.reports).together().last().copied().unwrap_or(f64::NAN)
    }

    /// Its error where one compares it: at the tip where a twin judges, else of the strokes [mm].
    fn error_mm(&self, is_judged: bool) -> Option<f64> {
        if is_judged { self.tip().map(|(error, _)| error) } else { Some(self.stroke_mm()) }
    }

    /// Learning curve and errors, all folds together.
    pub(super) fn report(&self) -> FitReport {
        FitReport::pooled(&self.reports)
    }
}

/// All controllers of a training.
pub(super) struct ControllerComparison {
    pub controllers: Vec<ComparedController>,
    is_judged: bool,
    n_folds: usize,
}

impl ControllerComparison {
    pub(super) fn new(is_judged: bool, n_folds: usize) -> Self {
        Self { controllers: Vec::new(), is_judged, n_folds }
    }

    /// Adds a fit and lets the twin judge, if there is one.
    ///
    /// # Errors
    /// Those of [`Judge::tip_errors`].
    pub(super) fn add(
        &mut self,
        candidate: Candidate,
        fitted: FittedController,
        judge: Option<&Judge>,
        validation: &[Demonstration],
        context: &Context,
    ) -> anyhow::Result<()> {
        let tips = judge.map(|judge| judge.tip_errors(&fitted.model, validation, context)).transpose()?;
        let tips = tips.unwrap_or_default();
        match self.controllers.iter_mut().find(|one| one.candidate == candidate) {
            Some(known) => known.add(fitted, tips),
            None => self.controllers.push(ComparedController::new(candidate, fitted, tips)),
        }
        Ok(())
    }

    /// Whether a network is so far behind after the first fold that it is given up.
    pub(super) fn is_given_up(&self, candidate: Candidate) -> bool {
        let errors = self.controllers.iter().map(|one| one.error_mm(self.is_judged).unwrap_or(f64::INFINITY));
        let least = errors.fold(f64::INFINITY, f64::min);
        let own = self.controllers.iter().find(|one| one.candidate == candidate);
        let own = own.and_then(|one| one.error_mm(self.is_judged));
        candidate.is_network() && own.is_some_and(|own| least.is_finite() && own > (1.0 + BEHIND) * least)
    }

    /// The one to use: the simplest whose error is no more than [`SAME`] above the least, of those that no fold is missing of;
    /// the last where none has an error.
    pub(super) fn best(&self) -> usize {
        let most = self.controllers.iter().map(|one| one.reports.len()).max().unwrap_or(0);
        let errors = self
            .controllers
            .iter()
            .map(|one| one.error_mm(self.is_judged).filter(|_| one.reports.len() == most));
        simplest_of_the_best(&errors.collect::<Vec<_>>())
    }

    /// Their errors, where there was a choice or there were folds.
    pub(super) fn errors(&self, chosen: usize) -> Vec<CandidateErrors> {
        let errors = |(k, one): (usize, &ComparedController)| {
            let tip = one.tip();
            CandidateErrors {
                candidate: one.candidate,
                stroke_rmse_mm: one.stroke_mm(),
                tip_rmse_mm: tip.map(|(error, _)| error),
                tip_standard_error_mm: tip.and_then(|(_, standard)| standard),
                folds: one.reports.len(),
                is_chosen: k == chosen,
            }
        };
        let is_compared = self.controllers.len() > 1 || self.n_folds > 1;
        if is_compared { self.controllers.iter().enumerate().map(errors).collect() } else { Vec::new() }
    }
}

fn simplest_of_the_best(errors: &[Option<f64>]) -> usize {
    let errors: Vec<f64> = errors.iter().map(|error| error.unwrap_or(f64::NAN)).collect();
    simplest_within(SAME, &errors).unwrap_or(errors.len().saturating_sub(1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_equals_the_simplest_is_used_and_one_that_the_twin_cannot_follow_never() {
        let cases = [
            (vec![Some(1.0), Some(0.5), Some(0.4)], 2),
            (vec![Some(1.04), Some(1.2), Some(1.0)], 0),
            (vec![Some(1.06), Some(1.04), Some(1.0)], 1),
            (vec![None, Some(2.0), None], 1),
            (vec![None], 0),
            (vec![None, None, None], 2),
        ];
        for (errors, expected) in cases {
            assert_eq!(simplest_of_the_best(&errors), expected, "{errors:?}");
        }
    }
}
