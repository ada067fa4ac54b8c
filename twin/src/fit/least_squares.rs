//! Bounded least squares: Levenberg–Marquardt on a smooth parametrisation, with finite differences in parallel.
//!
//! A parameter p within its bounds is the angle u of p̃ = (1 + sin u)/2, where p̃ ∈ [0, 1] is its place between the
//! bounds, on a logarithmic scale where asked. Only this module knows `levenberg-marquardt` and the `nalgebra` that it
//! takes.
//!
//! # Reference
//! Moré (1978), the Levenberg–Marquardt algorithm, as in MINPACK; James and Roos (1975) for the sine.

use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use hysteron_base::{BadInput, Bounds};
use levenberg_marquardt::{LeastSquaresProblem, LevenbergMarquardt};
use nalgebra_of_lm::{DMatrix, DVector, Dyn, Owned};
use rayon::prelude::*;

use super::uncertainty::{self, Estimate};
use crate::{Error, Result};

/// How a parameter is spread between its bounds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scale {
    /// Evenly.
    Linear,
    /// Evenly in its logarithm; both bounds are positive.
    Logarithmic,
}

/// A number to fit.
#[derive(Debug, Clone, PartialEq)]
pub struct Parameter {
    /// Name in reports.
    pub name: String,
    /// Where the search begins, within the bounds [SI].
    pub start: f64,
    /// Where it may go [SI].
    pub bounds: Bounds,
    /// How it is spread between them.
    pub scale: Scale,
}

/// What a fit minimises, and who watches it.
pub struct Options<'a> {
    /// Residual from which on a residual counts linearly rather than squared (Huber, 1964), if any [their unit].
    pub huber: Option<f64>,
    /// Root mean square by which a parameter must move the residuals, on its way between its bounds, to count as
    /// seen by the data [unit of the residuals].
    pub smallest_effect: f64,
    /// Parameters that the residuals themselves have been cleared of, a rigid frame for example.
    pub n_nuisance: usize,
    /// Told the number of evaluations and the root mean square of the best; false ends the fit.
    pub watch: &'a (dyn Fn(usize, f64) -> bool + Sync),
}

/// The outcome of a fit.
#[derive(Debug, Clone, PartialEq)]
pub struct Fit {
    /// One per parameter, in their order.
    pub estimates: Vec<Estimate>,
    /// Correlation of the estimates, for those with a standard error; n × n, zero elsewhere [-].
    pub correlation: Vec<Vec<f64>>,
    /// Condition number of the Jacobian of the fitted ones, its columns of length one: from 30 on some can hardly be
    /// told apart (Belsley, Kuh, Welsch, 1980) [-].
    pub condition: f64,
    /// Root mean square of the residuals at the start and at the end.
    pub rms: [f64; 2],
    /// Jacobians computed.
    pub iterations: usize,
    /// Evaluations of the residuals, those for Jacobians included.
    pub evaluations: usize,
    /// Number of residuals.
    pub n_residuals: usize,
    /// How many independent ones they are worth: neighbouring samples of a recording err alike.
    pub n_effective: f64,
    /// Why the search ended.
    pub ended: String,
    /// True if it ended at a minimum.
    pub is_converged: bool,
}

impl Fit {
    /// Values of the parameters, in their order.
    pub fn values(&self) -> Vec<f64> {
        self.estimates.iter().map(|estimate| estimate.value).collect()
    }
}

impl Parameter {
    /// Checks that the start lies within the bounds and that the scale can be taken.
    pub(super) fn check(&self) -> Result<()> {
        let Bounds { min, max } = self.bounds;
        let is_interval = min.is_finite() && max.is_finite() && min < max;
        if !is_interval || (self.scale == Scale::Logarithmic && min <= 0.0) {
            let expected = match self.scale {
                Scale::Linear => "two finite numbers, the first smaller",
                Scale::Logarithmic => "two finite positive numbers, the first smaller",
            };
            let place = format!("bounds of {}", self.name);
            return Err(BadInput::new(place, expected, format!("{min} to {max}")).into());
        }
        if !self.bounds.contains(self.start) {
            let place = format!("start of {}", self.name);
            return Err(BadInput::new(place, format!("{min} to {max}"), self.start.to_string())
                .hint("widen the bounds, or change the scene")
                .into());
        }
        Ok(())
    }

    /// Place between the bounds, 0 to 1.
    pub(super) fn place(&self, value: f64) -> f64 {
        let along = |value: f64| match self.scale {
            Scale::Linear => value,
            Scale::Logarithmic => value.ln(),
        };
        let (low, high) = (along(self.bounds.min), along(self.bounds.max));
        (along(value) - low) / (high - low)
    }

    /// The inverse of [`Self::place`].
    pub(super) fn value(&self, place: f64) -> f64 {
        let Bounds { min, max } = self.bounds;
        let value = match self.scale {
            Scale::Linear => min + place * (max - min),
            Scale::Logarithmic => (min.ln() + place * (max / min).ln()).exp(),
        };
        self.bounds.clamp(value)
    }

    /// Change of the value with its place.
    pub(super) fn slope(&self, value: f64) -> f64 {
        match self.scale {
            Scale::Linear => self.bounds.max - self.bounds.min,
            Scale::Logarithmic => value * (self.bounds.max / self.bounds.min).ln(),
        }
    }
}

/// Difference of places for derivatives [-]: the solver's tolerance and the curvature of the residuals both stay
/// below a hundredth of what such a step moves.
const DIFFERENCE: f64 = 1e-3;
/// A start on a bound is moved off it by this, for the sine is flat there [-].
const OFF_BOUND: f64 = 1e-2;
/// Relative change of the sum of squares, or of the angles, below which the search ends [-].
const TOLERANCE: f64 = 1e-5;
/// Evaluations allowed per parameter.
const PATIENCE: usize = 20;

/// Fits `parameters` so that the sum of squared residuals is least.
///
/// `residuals` gives series of residuals that belong together, neighbours beside each other (as one coordinate over
/// one recording), so that the fit can tell how independent they are. Where it fails with
/// [`Error::NoEquilibrium`], the search turns back.
///
/// # Errors
/// A start out of its bounds; fewer residuals than parameters; any other error of `residuals`.
pub fn least_squares<F>(parameters: &[Parameter], options: &Options, residuals: F) -> Result<Fit>
where
    F: Fn(&[f64]) -> Result<Vec<Vec<f64>>> + Sync,
{
    parameters.iter().try_for_each(Parameter::check)?;
    let start: Vec<f64> = parameters.iter().map(|p| p.place(p.start)).collect();
    let mut places = start.clone();
    let first = residuals(&parameters.iter().map(|p| p.start).collect::<Vec<_>>())?;
    let n_residuals = first.iter().map(Vec::len).sum::<usize>();
    if n_residuals <= parameters.len() + options.n_nuisance {
        let expected = format!("more than the {} parameters", parameters.len() + options.n_nuisance);
        return Err(BadInput::new("residuals", expected, n_residuals.to_string()).into());
    }
    let problem = Problem {
        parameters,
        options,
        residuals: &residuals,
        n_residuals,
        failed: 10.0 * rms(&first).max(f64::MIN_POSITIVE),
        evaluations: AtomicUsize::new(1),
        best: Mutex::new(rms(&first)),
    };
    let seen =
        |free: &[usize], columns: &[Vec<f64>]| uncertainty::unseen(free, columns, options.smallest_effect);

    // What the data does not see is held, one parameter at a time, until the rest is determined.
    let mut free: Vec<usize> = (0..parameters.len()).collect();
    let mut held = Vec::new();
    let mut columns = problem.columns(&start, &free, &first)?;
    while let Some((at, with)) = seen(&free, &columns) {
        held.push((free.remove(at), with));
        columns.remove(at);
    }
    let mut iterations = 1;
    loop {
        let found = problem.search(&places, &free)?;
        iterations += found.iterations;
        let series = problem.evaluate(&found.places)?.unwrap_or_else(|| first.clone());
        let inside = uncertainty::inside(&free, &found.places);
        let columns = problem.columns(&found.places, &inside, &series)?;
        let spread = uncertainty::Spread::new(&series, inside.len() + options.n_nuisance);
        let vague = seen(&inside, &columns).or_else(|| uncertainty::vague(&inside, &columns, &spread));
        let Some((at, with)) = vague else {
            let (estimates, correlation) =
                uncertainty::estimates(parameters, &found.places, (&inside, &columns), &held, &spread);
            return Ok(Fit {
                estimates,
                correlation,
                condition: uncertainty::condition(&columns),
                rms: [rms(&first), rms(&series)],
                iterations,
                evaluations: problem.evaluations.load(Ordering::Relaxed),
                n_residuals,
                n_effective: spread.n_effective,
                ended: found.ended,
                is_converged: found.is_converged,
            });
        };
        free.retain(|&k| k != inside[at]);
        places = found.places;
        places[inside[at]] = start[inside[at]];
        held.push((inside[at], with));
    }
}

struct Problem<'a, F> {
    parameters: &'a [Parameter],
    options: &'a Options<'a>,
    residuals: &'a F,
    n_residuals: usize,
    /// What every residual counts as where there is no equilibrium.
    failed: f64,
    evaluations: AtomicUsize,
    /// Least root mean square so far.
    best: Mutex<f64>,
}

/// Where a search ended.
struct Found {
    places: Vec<f64>,
    iterations: usize,
    ended: String,
    is_converged: bool,
}

impl<F: Fn(&[f64]) -> Result<Vec<Vec<f64>>> + Sync> Problem<'_, F> {
    /// The residuals with all parameters at `places`, bent by Huber's rule; none without equilibrium.
    fn evaluate(&self, places: &[f64]) -> Result<Option<Vec<Vec<f64>>>> {
        let values: Vec<f64> = self.parameters.iter().zip(places).map(|(p, place)| p.value(*place)).collect();
        self.evaluations.fetch_add(1, Ordering::Relaxed);
        match (self.residuals)(&values) {
            Ok(mut series) => {
                if let Some(threshold) = self.options.huber {
                    series.iter_mut().flatten().for_each(|r| *r = bent(*r, threshold));
                }
                let n: usize = series.iter().map(Vec::len).sum();
                assert_eq!(n, self.n_residuals, "the number of residuals must not change");
                Ok(Some(series))
            }
            Err(Error::NoEquilibrium { .. }) => Ok(None),
            Err(other) => Err(other),
        }
    }

    /// Derivatives of the residuals by the places of the parameters `free`, one column each, by differences
    /// from `series`, the residuals at `places`; zero where a neighbour has no equilibrium.
    fn columns(&self, places: &[f64], free: &[usize], series: &[Vec<f64>]) -> Result<Vec<Vec<f64>>> {
        let column = |&k: &usize| {
            let step = if places[k] > 0.5 { -DIFFERENCE } else { DIFFERENCE };
            let mut moved = places.to_vec();
            moved[k] += step;
            let Some(other) = self.evaluate(&moved)? else { return Ok(vec![0.0; self.n_residuals]) };
            let pairs = other.iter().flatten().zip(series.iter().flatten());
            Ok(pairs.map(|(other, here)| (other - here) / step).collect())
        };
        free.par_iter().map(column).collect()
    }

    /// The search from `start` with the parameters `free`.
    fn search(&self, start: &[f64], free: &[usize]) -> Result<Found> {
        let angle = |&k: &usize| (2.0 * start[k].clamp(OFF_BOUND, 1.0 - OFF_BOUND) - 1.0).asin();
        let search = Search {
            problem: self,
            start,
            free,
            angles: DVector::from_iterator(free.len(), free.iter().map(angle)),
            iterations: AtomicUsize::new(0),
            last: Mutex::new(None),
            failure: Mutex::new(None),
        };
        if free.is_empty() {
            let ended = "nothing to fit is determined by the data".to_owned();
            return Ok(Found { places: start.to_vec(), iterations: 0, ended, is_converged: true });
        }
        let method = LevenbergMarquardt::new().with_tol(TOLERANCE).with_patience(PATIENCE);
        let (search, report) = method.minimize(search);
        let iterations = search.iterations.load(Ordering::Relaxed);
        let places = search.places();
        if let Some(failure) = search.failure.into_inner().unwrap_or_default() {
            return Err(failure);
        }
        let is_converged = report.termination.was_successful();
        let ended = match report.termination {
            levenberg_marquardt::TerminationReason::LostPatience => {
                format!("not converged after {} evaluations", report.number_of_evaluations)
            }
            other => format!("{other:?}"),
        };
        Ok(Found { places, iterations, ended, is_converged })
    }
}

/// Parameters, and the residuals there by recording.
type Evaluated = (Vec<f64>, Vec<Vec<f64>>);

/// The problem as `levenberg-marquardt` sees it: in angles, for the free parameters alone.
struct Search<'a, F> {
    problem: &'a Problem<'a, F>,
    start: &'a [f64],
    free: &'a [usize],
    angles: DVector<f64>,
    iterations: AtomicUsize,
    /// Places and residuals that were asked for last: a Jacobian is wanted where the residuals were.
    last: Mutex<Option<Evaluated>>,
    failure: Mutex<Option<Error>>,
}

impl<F: Fn(&[f64]) -> Result<Vec<Vec<f64>>> + Sync> Search<'_, F> {
    fn places(&self) -> Vec<f64> {
        let mut places = self.start.to_vec();
        for (&k, angle) in self.free.iter().zip(self.angles.iter()) {
            places[k] = 0.5 * (1.0 + angle.sin());
        }
        places
    }

    /// The value, or nothing and the error kept for later.
    fn keep<T>(&self, result: Result<T>) -> Option<T> {
        match result {
            Ok(value) => Some(value),
            Err(error) => {
                if let Ok(mut failure) = self.failure.lock() {
                    *failure = Some(error);
                }
                None
            }
        }
    }

    /// Tells who watches; false if the search is to end.
    fn goes_on(&self, rms: f64) -> bool {
        let Ok(mut best) = self.problem.best.lock() else { return false };
        *best = best.min(rms);
        (self.problem.options.watch)(self.problem.evaluations.load(Ordering::Relaxed), *best)
    }
}

impl<F: Fn(&[f64]) -> Result<Vec<Vec<f64>>> + Sync> LeastSquaresProblem<f64, Dyn, Dyn> for Search<'_, F> {
    type ResidualStorage = Owned<f64, Dyn>;
    type JacobianStorage = Owned<f64, Dyn, Dyn>;
    type ParameterStorage = Owned<f64, Dyn>;

    fn set_params(&mut self, angles: &DVector<f64>) {
        self.angles.clone_from(angles);
    }

    fn params(&self) -> DVector<f64> {
        self.angles.clone()
    }

    fn residuals(&self) -> Option<DVector<f64>> {
        let places = self.places();
        let series = self.keep(self.problem.evaluate(&places))?;
        let n = self.problem.n_residuals;
        let flat = series.as_ref().map_or_else(|| vec![self.problem.failed; n], |series| series.concat());
        *self.last.lock().ok()? = series.map(|series| (places, series));
        let residuals = DVector::from_vec(flat);
        self.goes_on(residuals.norm() / (n as f64).sqrt()).then_some(residuals)
    }

    fn jacobian(&self) -> Option<DMatrix<f64>> {
        self.iterations.fetch_add(1, Ordering::Relaxed);
        let places = self.places();
        let last = self.last.lock().ok()?.take().filter(|(at, _)| *at == places);
        let series = match last {
            Some((_, series)) => series,
            None => self.keep(self.problem.evaluate(&places))??,
        };
        let mut columns = self.keep(self.problem.columns(&places, self.free, &series))?;
        for (column, angle) in columns.iter_mut().zip(self.angles.iter()) {
            column.iter_mut().for_each(|value| *value *= 0.5 * angle.cos());
        }
        Some(DMatrix::from_vec(self.problem.n_residuals, columns.len(), columns.concat()))
    }
}

/// The residual whose square is Huber's loss.
fn bent(residual: f64, threshold: f64) -> f64 {
    let size = residual.abs();
    if size <= threshold {
        return residual;
    }
    residual.signum() * (threshold * (2.0 * size - threshold)).sqrt()
}

fn rms(series: &[Vec<f64>]) -> f64 {
    let n: usize = series.iter().map(Vec::len).sum();
    (series.iter().flatten().map(|r| r * r).sum::<f64>() / n as f64).sqrt()
}
