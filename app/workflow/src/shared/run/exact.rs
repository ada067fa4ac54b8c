//! Samples of a run with a chain that the finite elements make too.

use std::num::NonZeroUsize;
use std::time::{Duration, Instant};

use hysteron_base::BadInput;
use hysteron_base::statistics::nearest_quantile;
use hysteron_twin::command::{ChainError, CommandStep, ExactSteps};
use hysteron_twin::{Twin, TwinState};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Every N-th sample, made again by the finite elements.
pub struct ExactSamples {
    steps: ExactSteps,
    every: usize,
    /// Equilibrium before the sample that is compared next.
    before: Option<TwinState>,
    errors: Vec<ChainError>,
    n_unsolved: usize,
    /// Time that the finite elements took.
    pub spent: Duration,
}

/// How far the chain of a run was off.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct ExactSummary {
    /// Samples that were made by the finite elements too.
    pub samples: usize,
    /// Others for which they found no equilibrium.
    pub unsolved: usize,
    /// Half of the tips of the chain were closer than this to those of the finite elements [m].
    pub tip_median_m: f64,
    /// Largest distance of the two tips [m].
    pub tip_largest_m: f64,
    /// Half of the largest errors of a tension were less [N].
    pub tension_median_n: f64,
    /// Largest error of a tension [N].
    pub tension_largest_n: f64,
}

impl ExactSamples {
    /// # Errors
    /// `BadInput` where no chain moves the twin.
    pub fn new(twin: &Twin, every: Option<NonZeroUsize>) -> Result<Option<Self>, BadInput> {
        let Some(every) = every else { return Ok(None) };
        if twin.chain.is_none() {
            return Err(BadInput::new("--exact-every", "a robot that a chain moves", "finite elements")
                .hint("leave it out: every step is one of the finite elements"));
        }
        let steps = ExactSteps::new(twin);
        let every = every.get();
        Ok(Some(Self { steps, every, before: None, errors: vec![], n_unsolved: 0, spent: Duration::ZERO }))
    }

    /// Notes the equilibrium before sample `row`, if it is to be compared.
    pub fn begin(&mut self, row: usize, state: &TwinState) {
        self.before = row.is_multiple_of(self.every).then(|| state.clone());
    }

    /// Compares the sample that has begun.
    ///
    /// # Errors
    /// Those of [`ExactSteps::error_of`].
    pub fn compare(
        &mut self,
        twin: &Twin,
        after: &TwinState,
        step: &CommandStep,
    ) -> hysteron_twin::Result<()> {
        if let Some(before) = self.before.take() {
            let start = Instant::now();
            match self.steps.error_of(twin, (&before, after), &step.strokes)? {
                Some(error) => self.errors.push(error),
                None => self.n_unsolved += 1,
            }
            self.spent += start.elapsed();
        }
        Ok(())
    }

    /// Errors over all comparisons; `None` without any.
    pub fn summary(&self) -> Option<ExactSummary> {
        let quantiles = |of: fn(&ChainError) -> f64| {
            let mut values: Vec<f64> = self.errors.iter().map(of).collect();
            [0.5, 1.0].map(|part| nearest_quantile(&mut values, part).unwrap_or_default())
        };
        let ([tip_median_m, tip_largest_m], [tension_median_n, tension_largest_n]) =
            (quantiles(|error| error.tip), quantiles(|error| error.tension));
        let samples = self.errors.len();
        (samples + self.n_unsolved > 0).then_some(ExactSummary {
            samples,
            unsolved: self.n_unsolved,
            tip_median_m,
            tip_largest_m,
            tension_median_n,
            tension_largest_n,
        })
    }
}

impl ExactSummary {
    /// The comparison in words.
    pub fn line(&self) -> String {
        format!(
            "{} samples made by the finite elements too: the tip of the chain is off by {:.4} mm (median), {:.4} mm at most, a \
             tension by {:.4} N, {:.4} N at most; {} without an equilibrium",
            self.samples,
            1e3 * self.tip_median_m,
            1e3 * self.tip_largest_m,
            self.tension_median_n,
            self.tension_largest_n,
            self.unsolved
        )
    }
}
