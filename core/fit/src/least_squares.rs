//! Bounded least squares: estimates of all parameters with their identifiability, by searches of `search`.
//!
//! A parameter may come with a prior, a normal distribution. It counts as one residual more, weighed against
//! the spread of the residuals found, which neighbours share where they err alike. A parameter that is not
//! observable is fixed at once; a vague one is brought back to where it came from, and fixed there unless that
//! fits worse than noise allows.

use crate::Failure;
use crate::evaluation_error::{Erased, EvaluationError, aside};
use crate::outcome::{Fit, Options};
use crate::parameter::Parameter;
use crate::search::{FitProblem, ResidualSeries, cost, prior_rows, rms};
use crate::uncertainty::{self, ResidualVariance};

/// Tolerance of a search whose end is the end [-].
pub const TOLERANCE: f64 = 1e-5;
/// Squared number of standard deviations that a return to the start may cost: 95 % of all noise stays below.
const NOISE: f64 = 4.0;

/// Fits `parameters` so that the sum of squared residuals is least.
///
/// `residuals` gives series of residuals that belong together, neighbours next to each other (as one
/// coordinate over one recording), from which the fit estimates how independent they are. Where they fail
/// locally ([`Failure::is_local`]), the search turns back.
///
/// # Errors
/// A start out of its bounds; fewer residuals than parameters; any other error of `residuals`.
pub fn least_squares<F, E>(parameters: &[Parameter], options: &Options, residuals: F) -> Result<Fit, E>
where
    F: Fn(&[f64]) -> Result<Vec<Vec<f64>>, E> + Sync,
    E: Failure,
{
    aside(residuals, |residuals| fitted(parameters, options, residuals))
}

fn fitted(
    parameters: &[Parameter],
    options: &Options,
    residuals: Erased<ResidualSeries>,
) -> Result<Fit, EvaluationError> {
    let (mut problem, first) = FitProblem::new(parameters, options, residuals)?;
    let start: Vec<f64> = parameters.iter().map(|p| p.place(p.start)).collect();
    let home: Vec<f64> = parameters.iter().map(|p| p.place(p.home())).collect();
    let spread_of = |series: &[Vec<f64>], n: usize| ResidualVariance::new(series, n + options.n_nuisance);
    problem.noise = spread_of(&first, parameters.len()).variance.sqrt();

    // Parameters that are not observable are fixed, one at a time, until the rest is determined.
    let mut free: Vec<usize> = (0..parameters.len()).collect();
    let (mut fixed, mut retained) = (Vec::new(), Vec::new());
    let mut places = start.clone();
    let mut columns = problem.columns(&start, &free, &first)?;
    while let Some((at, with)) = uncertainty::unidentifiable(&free, &columns, options.smallest_effect) {
        let k = free.remove(at);
        places[k] = home[k];
        fixed.push((k, with));
        columns.remove(at);
    }
    let mut found = problem.settle(&places, &free, spread_of)?;
    found = problem.pinned(found, &free)?;
    let mut iterations = 1 + found.iterations;
    loop {
        let series = problem.evaluate(&found.places)?.unwrap_or_else(|| first.clone());
        let inside = uncertainty::inside(&free, &found.places);
        let columns = problem.columns(&found.places, &inside, &series)?;
        let spread = spread_of(&series, inside.len());
        let unidentifiable = uncertainty::unidentifiable(&inside, &columns, options.smallest_effect);
        let rows = prior_rows(parameters, &inside, &columns, problem.noise);
        let covariance = uncertainty::covariance(&rows, spread.variance);
        let vague = || uncertainty::vague(parameters, &inside, covariance.as_ref()?, &retained);
        let Some((at, with)) = unidentifiable.clone().or_else(vague) else {
            let (estimates, correlation) = uncertainty::estimates(
                parameters,
                &found.places,
                (&inside, covariance.as_ref()),
                &retained,
                &fixed,
            );
            return Ok(Fit {
                estimates,
                correlation,
                condition: uncertainty::condition(&columns),
                rms: [rms(&first), rms(&series)],
                iterations,
                evaluations: problem.n_evaluations(),
                n_residuals: first.iter().map(Vec::len).sum(),
                n_effective: spread.n_effective,
                ended: found.ended,
                is_converged: found.is_converged,
            });
        };
        let k = inside[at];
        let rest: Vec<usize> = free.iter().copied().filter(|&other| other != k).collect();
        let mut returned = found.places.clone();
        returned[k] = home[k];
        let without = problem.search(&returned, &rest)?;
        let without = problem.pinned(without, &rest)?;
        iterations += without.iterations;
        let price = problem.cost_at(&without.places, &first)?
            - cost(parameters, &found.places, &series, problem.noise);
        if unidentifiable.is_none() && price > NOISE * spread.variance {
            retained.push(k);
        } else {
            fixed.push((k, with));
            free = rest;
            found = without;
        }
    }
}
