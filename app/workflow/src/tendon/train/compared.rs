//! The controllers of a training next to each other, on recordings that none of them learned from.

use std::path::{Path, PathBuf};

use hysteron_control::inverse::{Candidate, DataOrigin, Dataset, FittedController};
use hysteron_learn::simplest_within;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::judge::Judge;
use super::options::Options;
use crate::Context;

/// Part by which errors differ by chance: another seed of a network changes as much [-].
pub(super) const SAME: f64 = 0.05;

/// A controller that was fitted, and its error at the tip.
pub(super) struct ComparedController {
    pub candidate: Candidate,
    pub fitted: FittedController,
    /// By [`Judge::tip_error_mm`]; none where nothing judged it, or the twin could not follow [mm].
    pub tip_mm: Option<f64>,
}

/// Errors of a controller in validation.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct CandidateErrors {
    /// Which controller.
    pub candidate: Candidate,
    /// Root mean square error of its strokes [mm].
    pub stroke_rmse_mm: f64,
    /// Root mean square distance of the tips that its strokes and the recorded ones bring the twin to [mm]; none where the twin
    /// cannot follow.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tip_rmse_mm: Option<f64>,
    /// Whether it is the one in the checkpoint.
    pub is_chosen: bool,
}

/// The controllers to compare: where a twin judges, all that the data allow; else the network of all data alone.
pub(super) fn candidates(options: &Options, data: &Dataset, recorded: Option<&Dataset>) -> Vec<Candidate> {
    if options.scene.is_none() {
        return vec![Candidate::Network];
    }
    let is_hybrid = data.count(DataOrigin::Synthetic) > 0 && recorded.is_some();
    let recorded = is_hybrid.then_some(Candidate::RecordedNetwork);
    [Some(Candidate::StaticRegression), recorded, Some(Candidate::Network)].into_iter().flatten().collect()
}

/// The file that the training of a candidate resumes from.
pub(super) fn training_file(out: &Path, candidate: Candidate) -> Option<PathBuf> {
    match candidate {
        Candidate::StaticRegression => None,
        Candidate::RecordedNetwork => Some(out.with_extension("recorded.training")),
        Candidate::Network => Some(out.with_extension("training")),
    }
}

impl ComparedController {
    /// Lets the twin judge, if there is one.
    ///
    /// # Errors
    /// Those of [`Judge::tip_error_mm`].
    pub(super) fn new(
        candidate: Candidate,
        mut fitted: FittedController,
        judge: Option<&Judge>,
        data: &Dataset,
        context: &Context,
    ) -> anyhow::Result<Self> {
        let tip = judge.map(|judge| judge.tip_error_mm(&fitted.model, &data.validation, context));
        if tip.is_some() {
            fitted.model.training.candidate = Some(candidate);
        }
        Ok(Self { candidate, fitted, tip_mm: tip.transpose()?.flatten() })
    }

    /// Which of some to use: the simplest whose error at the tip is no more than [`SAME`] above the least; the last where none has
    /// an error there.
    pub(super) fn best(all: &[Self]) -> usize {
        simplest_of_the_best(&all.iter().map(|one| one.tip_mm).collect::<Vec<_>>())
    }

    /// Their errors, where there was a choice.
    pub(super) fn errors(all: &[Self], chosen: usize) -> Vec<CandidateErrors> {
        let errors = |(k, one): (usize, &Self)| CandidateErrors {
            candidate: one.candidate,
            stroke_rmse_mm: one.fitted.report.together().last().copied().unwrap_or(f64::NAN),
            tip_rmse_mm: one.tip_mm,
            is_chosen: k == chosen,
        };
        if all.len() > 1 { all.iter().enumerate().map(errors).collect() } else { Vec::new() }
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
