//! One search: Levenberg–Marquardt on a smooth parametrisation, with finite differences in parallel.
//!
//! A parameter p within its bounds is the angle u of p̃ = (1 + sin u)/2, where p̃ ∈ [0, 1] is its place between the
//! bounds, on a logarithmic scale where asked. Only this module knows `levenberg-marquardt`.
//!
//! # Reference
//! Moré (1978), the Levenberg–Marquardt algorithm, as in MINPACK; James and Roos (1975) for the sine.

use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use hysteron_base::{BadInput, parallel};
use levenberg_marquardt::{LeastSquaresProblem, LevenbergMarquardt, TerminationReason};
use nalgebra::{DMatrix, DVector, Dyn, Owned};

use crate::Failure;
use crate::evaluation_error::{Erased, EvaluationError, aside};
use crate::outcome::{Fit, Options};
use crate::parameter::Parameter;
use crate::uncertainty::{self, Identifiability, ResidualVariance};

/// Difference of places for derivatives [-]: the solver's tolerance and the curvature of the residuals both stay
/// below a hundredth of what such a step moves.
const DIFFERENCE: f64 = 1e-3;
/// A start on a bound is moved off it by this, for the sine is flat there [-].
const OFF_BOUND: f64 = 1e-2;
/// Nearness to a bound from which on it is tried whether the minimum lies on it [-]: a search along a sine comes to a
/// bound ever more slowly, and one that starts on it begins at `OFF_BOUND`.
const NEAR_BOUND: f64 = 2.0 * OFF_BOUND;
/// Move to a bound after which the other parameters are searched again [-].
const WORTH_A_SEARCH: f64 = 1e-4;
/// Evaluations allowed per parameter.
const PATIENCE: usize = 20;
/// The same for a search that only distinguishes one valley from another.
const QUICK_TOLERANCE: f64 = 1e-2;
const QUICK_JACOBIANS: usize = 2;
/// Parts of a correction that are tried.
const PARTS: [f64; 3] = [1.0, 0.5, 0.25];
/// Iterations of the estimate of the residuals' spread, which weighs the priors, and the part of it that is
/// worth another search [-].
const MAX_ROUNDS: usize = 3;
const SAME_SPREAD: f64 = 0.7;

/// Residuals that belong together, each next to its neighbours.
pub type ResidualSeries = Vec<Vec<f64>>;

/// Residuals of parameters, and their priors.
pub struct FitProblem<'a, E> {
    parameters: &'a [Parameter],
    options: &'a Options<'a>,
    residuals: &'a (dyn Fn(&[f64]) -> Result<ResidualSeries, E> + Sync),
    n_residuals: usize,
    /// Standard deviation of an independent residual, which one of a prior counts as.
    pub noise: f64,
    effort: SearchLimits,
    /// Value of every residual where they cannot be computed.
    failed: f64,
    evaluations: AtomicUsize,
    /// Least root mean square so far.
    best: Mutex<f64>,
}

/// When a search ends.
struct SearchLimits {
    tolerance: f64,
    jacobians: usize,
}

/// Where a search ended.
pub struct SearchResult {
    /// All parameters, also those that were not free.
    pub places: Vec<f64>,
    /// Jacobians computed.
    pub iterations: usize,
    /// Why the search ended.
    pub ended: String,
    /// True if it ended at a minimum.
    pub is_converged: bool,
}

impl<'a, E: Failure> FitProblem<'a, E> {
    /// With the residuals at the start, which are given back; nothing is known of their spread yet.
    ///
    /// # Errors
    /// A start out of its bounds; fewer residuals than parameters; those of `residuals`.
    pub fn new(
        parameters: &'a [Parameter],
        options: &'a Options<'a>,
        residuals: &'a (dyn Fn(&[f64]) -> Result<ResidualSeries, E> + Sync),
    ) -> Result<(Self, ResidualSeries), E> {
        parameters.iter().try_for_each(Parameter::check)?;
        let first = residuals(&parameters.iter().map(|p| p.start).collect::<Vec<_>>())?;
        let n_residuals = first.iter().map(Vec::len).sum::<usize>();
        if n_residuals <= parameters.len() + options.n_nuisance {
            let expected = format!("more than the {} parameters", parameters.len() + options.n_nuisance);
            return Err(BadInput::new("residuals", expected, n_residuals.to_string()).into());
        }
        let problem = Self {
            parameters,
            options,
            residuals,
            n_residuals,
            noise: 0.0,
            effort: SearchLimits { tolerance: options.tolerance, jacobians: usize::MAX },
            failed: 10.0 * rms(&first).max(f64::MIN_POSITIVE),
            evaluations: AtomicUsize::new(1),
            best: Mutex::new(rms(&first)),
        };
        Ok((problem, first))
    }

    /// Evaluations so far.
    pub fn n_evaluations(&self) -> usize {
        self.evaluations.load(Ordering::Relaxed)
    }

    /// Searches until the spread by which priors are weighed is that of the residuals found: from a large one on, with
    /// which priors weigh more.
    pub fn settle(
        &mut self,
        start: &[f64],
        free: &[usize],
        spread: impl Fn(&[Vec<f64>], usize) -> ResidualVariance,
    ) -> Result<SearchResult, E> {
        let mut found = self.search(start, free)?;
        for _ in 1..MAX_ROUNDS {
            if free.iter().all(|&k| self.parameters[k].prior.is_none()) {
                break;
            }
            let Some(series) = self.evaluate(&found.places)? else { break };
            let noise = spread(&series, free.len()).variance.sqrt();
            if noise > SAME_SPREAD * self.noise {
                break;
            }
            self.noise = noise;
            let iterations = found.iterations;
            found = self.search(&found.places, free)?;
            found.iterations += iterations;
        }
        Ok(found)
    }

    /// Those of `free` with a prior: position, how far off its middle they are, and what that counts per place.
    fn prior_terms(&self, places: &[f64], free: &[usize]) -> impl Iterator<Item = (usize, f64, f64)> {
        let of = |(at, &k): (usize, &usize)| {
            let parameter = &self.parameters[k];
            let off = places[k] - parameter.place(parameter.home());
            Some((at, off, self.noise / parameter.prior_width()?))
        };
        free.iter().enumerate().filter_map(of).collect::<Vec<_>>().into_iter()
    }

    /// The cost at `places`; with the residuals `otherwise` where they have no value.
    pub fn cost_at(&self, places: &[f64], otherwise: &[Vec<f64>]) -> Result<f64, E> {
        let series = self.evaluate(places)?;
        let series = series.as_deref().unwrap_or(otherwise);
        Ok(cost(self.parameters, places, series, self.noise))
    }

    /// The residuals with all parameters at `places`, bent by Huber's rule; none where they have no value.
    pub fn evaluate(&self, places: &[f64]) -> Result<Option<ResidualSeries>, E> {
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
            Err(error) if error.is_local() => Ok(None),
            Err(error) => Err(error),
        }
    }

    /// Derivatives of the residuals by the places of the parameters `free`, one column each, by differences
    /// from `series`, the residuals at `places`; zero where a neighbour has none.
    pub fn columns(&self, places: &[f64], free: &[usize], series: &[Vec<f64>]) -> Result<Vec<Vec<f64>>, E> {
        let column = |&k: &usize| {
            let step = if places[k] > 0.5 { -DIFFERENCE } else { DIFFERENCE };
            let mut moved = places.to_vec();
            moved[k] += step;
            let Some(other) = self.evaluate(&moved)? else { return Ok(vec![0.0; self.n_residuals]) };
            let pairs = other.iter().flatten().zip(series.iter().flatten());
            Ok(pairs.map(|(other, here)| (other - here) / step).collect())
        };
        parallel::try_map(free, column)
    }

    /// `found` with those of `free` on their bounds whose minimum lies there: near a bound the cost falls towards it, up to the
    /// bound itself. The others are then searched again.
    pub fn pinned(&self, mut found: SearchResult, free: &[usize]) -> Result<SearchResult, E> {
        let distance = |place: f64| (place - place.round()).abs();
        let near: Vec<usize> =
            free.iter().copied().filter(|&k| distance(found.places[k]) <= NEAR_BOUND).collect();
        if near.is_empty() {
            return Ok(found);
        }
        let Some(series) = self.evaluate(&found.places)? else { return Ok(found) };
        let mut least = cost(self.parameters, &found.places, &series, self.noise);
        let (mut rest, mut has_moved) = (free.to_vec(), false);
        for k in near {
            let (bound, distance) = (found.places[k].round(), distance(found.places[k]));
            let mut moved = found.places.clone();
            moved[k] = bound;
            let Some(series) = self.evaluate(&moved)? else { continue };
            let price = cost(self.parameters, &moved, &series, self.noise);
            if price <= least {
                (found.places, least) = (moved, price);
                has_moved |= distance > WORTH_A_SEARCH;
                rest.retain(|&other| other != k);
            }
        }
        if has_moved && !rest.is_empty() {
            let again = self.search(&found.places, &rest)?;
            return Ok(SearchResult { iterations: found.iterations + again.iterations, ..again });
        }
        Ok(found)
    }

    /// The search from `start` with the parameters `free`.
    pub fn search(&self, start: &[f64], free: &[usize]) -> Result<SearchResult, E> {
        let angle = |&k: &usize| (2.0 * start[k].clamp(OFF_BOUND, 1.0 - OFF_BOUND) - 1.0).asin();
        let search = TransformedProblem {
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
            return Ok(SearchResult { places: start.to_vec(), iterations: 0, ended, is_converged: true });
        }
        let method = LevenbergMarquardt::new().with_tol(self.effort.tolerance).with_patience(PATIENCE);
        let (search, report) = method.minimize(search);
        let iterations = search.iterations.load(Ordering::Relaxed);
        let places = search.places();
        if let Some(failure) = search.failure.into_inner().unwrap_or_default() {
            return Err(failure);
        }
        let is_converged = report.termination.was_successful();
        let ended = match report.termination {
            TerminationReason::ResidualsZero => "converged: no error is left".to_owned(),
            TerminationReason::Orthogonal => "converged: the gradient is zero".to_owned(),
            TerminationReason::Converged { ftol: true, .. } => {
                "converged: the error falls no further".to_owned()
            }
            TerminationReason::Converged { .. } => "converged: the parameters change no further".to_owned(),
            TerminationReason::LostPatience => {
                format!("not converged after {} evaluations", report.number_of_evaluations)
            }
            TerminationReason::NoImprovementPossible(_) => {
                "not converged: no step lowers the error".to_owned()
            }
            TerminationReason::Numerical(_) => "not converged: a number is not finite".to_owned(),
            _ => "not converged: the search was given up".to_owned(),
        };
        Ok(SearchResult { places, iterations, ended, is_converged })
    }
}

/// Parameters, and the residuals there by recording.
type EvaluatedPoint = (Vec<f64>, ResidualSeries);

/// The problem in the form of `levenberg-marquardt`: in angles, for the free parameters alone.
struct TransformedProblem<'a, E> {
    problem: &'a FitProblem<'a, E>,
    start: &'a [f64],
    free: &'a [usize],
    angles: DVector<f64>,
    iterations: AtomicUsize,
    /// Places and residuals of the last evaluation: a Jacobian is computed at the same places.
    last: Mutex<Option<EvaluatedPoint>>,
    failure: Mutex<Option<E>>,
}

impl<E: Failure> TransformedProblem<'_, E> {
    fn places(&self) -> Vec<f64> {
        let mut places = self.start.to_vec();
        for (&k, angle) in self.free.iter().zip(self.angles.iter()) {
            places[k] = 0.5 * (1.0 + angle.sin());
        }
        places
    }

    /// The value, or nothing and the error kept for later.
    fn keep<T>(&self, result: Result<T, E>) -> Option<T> {
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

    /// Reports progress to the callback; false if the search is to end.
    fn continues(&self, rms: f64) -> bool {
        let Ok(mut best) = self.problem.best.lock() else { return false };
        *best = best.min(rms);
        (self.problem.options.watch)(self.problem.evaluations.load(Ordering::Relaxed), *best)
    }
}

impl<E: Failure> LeastSquaresProblem<f64, Dyn, Dyn> for TransformedProblem<'_, E> {
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
        let mut flat = series.as_ref().map_or_else(|| vec![self.problem.failed; n], |series| series.concat());
        let prior_terms = self.problem.prior_terms(&places, self.free).collect::<Vec<_>>();
        *self.last.lock().ok()? = series.map(|series| (places, series));
        let rms = (flat.iter().map(|r| r * r).sum::<f64>() / n as f64).sqrt();
        flat.extend(prior_terms.iter().map(|(_, off, weight)| weight * off));
        self.continues(rms).then(|| DVector::from_vec(flat))
    }

    fn jacobian(&self) -> Option<DMatrix<f64>> {
        if self.iterations.fetch_add(1, Ordering::Relaxed) >= self.problem.effort.jacobians {
            return None;
        }
        let places = self.places();
        let last = self.last.lock().ok()?.take().filter(|(at, _)| *at == places);
        let series = match last {
            Some((_, series)) => series,
            None => self.keep(self.problem.evaluate(&places))??,
        };
        let mut columns = self.keep(self.problem.columns(&places, self.free, &series))?;
        for (at, _, weight) in self.problem.prior_terms(&places, self.free) {
            for (other, column) in columns.iter_mut().enumerate() {
                column.push(if other == at { weight } else { 0.0 });
            }
        }
        for (column, angle) in columns.iter_mut().zip(self.angles.iter()) {
            column.iter_mut().for_each(|value| *value *= 0.5 * angle.cos());
        }
        Some(DMatrix::from_vec(columns[0].len(), columns.len(), columns.concat()))
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

/// The minimum near the starts of `parameters`, roughly: their values, and the cost there.
///
/// # Errors
/// Those of [`FitProblem::new`] and of `residuals`.
pub fn minimum<F, E>(parameters: &[Parameter], options: &Options, residuals: F) -> Result<(Vec<f64>, f64), E>
where
    F: Fn(&[f64]) -> Result<Vec<Vec<f64>>, E> + Sync,
    E: Failure,
{
    aside(residuals, |residuals| roughly(parameters, options, residuals))
}

fn roughly(
    parameters: &[Parameter],
    options: &Options,
    residuals: Erased<ResidualSeries>,
) -> Result<(Vec<f64>, f64), EvaluationError> {
    let (mut problem, first) = FitProblem::new(parameters, options, residuals)?;
    problem.effort = SearchLimits { tolerance: QUICK_TOLERANCE, jacobians: QUICK_JACOBIANS };
    problem.noise = rms(&first);
    let start: Vec<f64> = parameters.iter().map(|p| p.place(p.start)).collect();
    let all: Vec<usize> = (0..parameters.len()).collect();
    let places = problem.search(&start, &all)?.places;
    let series = problem.evaluate(&places)?.unwrap_or(first);
    let values = parameters.iter().zip(&places).map(|(p, place)| p.value(*place)).collect();
    Ok((values, series.iter().flatten().map(|r| r * r).sum()))
}

/// Corrects `fit`, from whose values the `parameters` start, by one step of Gauss and Newton, or a part of it, of those that
/// are determined; with other residuals than it was found with.
///
/// # Errors
/// Those of [`FitProblem::new`] and of `residuals`.
pub fn polished<F, E>(
    parameters: &[Parameter],
    options: &Options,
    residuals: F,
    fit: &mut Fit,
) -> Result<(), E>
where
    F: Fn(&[f64]) -> Result<Vec<Vec<f64>>, E> + Sync,
    E: Failure,
{
    aside(residuals, |residuals| corrected(parameters, options, residuals, fit))
}

fn corrected(
    parameters: &[Parameter],
    options: &Options,
    residuals: Erased<ResidualSeries>,
    fit: &mut Fit,
) -> Result<(), EvaluationError> {
    let (mut problem, first) = FitProblem::new(parameters, options, residuals)?;
    let places: Vec<f64> = parameters.iter().map(|p| p.place(p.start)).collect();
    let is_free = |k: &usize| {
        matches!(fit.estimates[*k].identifiability, Identifiability::Fitted | Identifiability::Vague)
    };
    let free = uncertainty::inside(&(0..parameters.len()).filter(is_free).collect::<Vec<_>>(), &places);
    let spread = ResidualVariance::new(&first, free.len() + options.n_nuisance);
    problem.noise = spread.variance.sqrt();
    let columns = problem.columns(&places, &free, &first)?;
    let rows = prior_rows(parameters, &free, &columns, problem.noise);
    let mut flat = first.concat();
    flat.extend(problem.prior_terms(&places, &free).map(|(_, off, weight)| weight * off));
    let mut best = (places.clone(), first, f64::INFINITY);
    best.2 = cost(parameters, &best.0, &best.1, problem.noise);
    if let Some(changes) = within_bounds(&places, &free, &rows, flat) {
        for part in PARTS {
            let mut moved = places.clone();
            for (&k, change) in free.iter().zip(&changes) {
                moved[k] = (places[k] + part * change).clamp(0.0, 1.0);
            }
            let Some(series) = problem.evaluate(&moved)? else { continue };
            let price = cost(parameters, &moved, &series, problem.noise);
            if price < best.2 {
                best = (moved, series, price);
                break;
            }
        }
    }
    // A parameter on its bound has no standard error, and takes no part in those of the others.
    let inside = uncertainty::inside(&free, &best.0);
    let of_inside = |k: &usize| free.iter().position(|f| f == k).map(|at| columns[at].clone());
    let columns: Vec<Vec<f64>> = inside.iter().filter_map(of_inside).collect();
    let rows = prior_rows(parameters, &inside, &columns, problem.noise);
    let spread = ResidualVariance::new(&best.1, inside.len() + options.n_nuisance);
    let covariance = uncertainty::covariance(&rows, spread.variance);
    fit.correct(parameters, &best.0, (&inside, covariance.as_ref()));
    fit.condition = uncertainty::condition(&columns);
    fit.rms[1] = rms(&best.1);
    fit.evaluations += problem.n_evaluations();
    fit.iterations += 1;
    (fit.n_residuals, fit.n_effective) = (problem.n_residuals, spread.n_effective);
    Ok(())
}

/// Changes of the places `free` that make residuals with these columns least, each at most up to its bound: what would
/// leave its bounds ends on one, and the others are corrected with it there. `None` where a direction is not
/// determined.
fn within_bounds(
    places: &[f64],
    free: &[usize],
    columns: &[Vec<f64>],
    mut residuals: Vec<f64>,
) -> Option<Vec<f64>> {
    let mut changes = vec![0.0; free.len()];
    let mut open: Vec<usize> = (0..free.len()).collect();
    while !open.is_empty() {
        let of_open: Vec<Vec<f64>> = open.iter().map(|&at| columns[at].clone()).collect();
        let correction = uncertainty::correction(&of_open, &residuals)?;
        let beyond = |(at, change): (&usize, &f64)| {
            let aim = places[free[*at]] + change;
            (aim != aim.clamp(0.0, 1.0)).then(|| (*at, aim.clamp(0.0, 1.0) - places[free[*at]]))
        };
        let leaving: Vec<(usize, f64)> = open.iter().zip(&correction).filter_map(beyond).collect();
        if leaving.is_empty() {
            open.iter().zip(&correction).for_each(|(&at, change)| changes[at] = *change);
            break;
        }
        for (at, change) in leaving {
            changes[at] = change;
            residuals.iter_mut().zip(&columns[at]).for_each(|(r, column)| *r += change * column);
            open.retain(|&other| other != at);
        }
    }
    Some(changes)
}

/// Sum of squares of the residuals at `places` and of the priors, each of which counts `noise`.
pub fn cost(parameters: &[Parameter], places: &[f64], series: &[Vec<f64>], noise: f64) -> f64 {
    let off = |(parameter, place): (&Parameter, &f64)| {
        let off = place - parameter.place(parameter.home());
        Some((noise * off / parameter.prior_width()?).powi(2))
    };
    let prior_terms: f64 = parameters.iter().zip(places).filter_map(off).sum();
    series.iter().flatten().map(|r| r * r).sum::<f64>() + prior_terms
}

/// The columns of the parameters `free` with one row more for each prior.
pub fn prior_rows(
    parameters: &[Parameter],
    free: &[usize],
    columns: &[Vec<f64>],
    noise: f64,
) -> Vec<Vec<f64>> {
    let mut columns = columns.to_vec();
    for (at, &k) in free.iter().enumerate() {
        let Some(width) = parameters[k].prior_width() else { continue };
        for (other, column) in columns.iter_mut().enumerate() {
            column.push(if other == at { noise / width } else { 0.0 });
        }
    }
    columns
}

/// Root mean square of all residuals.
pub fn rms(series: &[Vec<f64>]) -> f64 {
    let n: usize = series.iter().map(Vec::len).sum();
    (series.iter().flatten().map(|r| r * r).sum::<f64>() / n as f64).sqrt()
}
