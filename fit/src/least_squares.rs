//! Bounded least squares: what the data says of each parameter, by searches of `search`.
//!
//! A parameter may come with a prior: where it is believed to be, and how well. It counts as one residual more, weighed
//! against the spread of the residuals found, which neighbours share where they err alike. What the data does not see is
//! held at once; what it sees badly is brought back to where it came from, and held there unless that fits worse than
//! noise allows.

use hysteron_base::{BadInput, Bounds};

use crate::Failure;
use crate::search::{Problem, cost, prior_rows, rms};
use crate::uncertainty::{self, Estimate, Spread, Standing};

/// How a parameter is spread between its bounds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scale {
    /// Evenly.
    Linear,
    /// Evenly in its logarithm; both bounds are positive.
    Logarithmic,
}

/// What is believed of a parameter before the data is seen: a normal distribution on the parameter's scale.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Prior {
    /// Its middle [SI].
    pub center: f64,
    /// Its standard deviation, above 0 [SI]; on a logarithmic scale a factor above 1.
    pub width: f64,
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
    /// What is believed of it before, if anything.
    pub prior: Option<Prior>,
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
    /// Relative change of the sum of squares, or of the places, below which a search ends [-].
    pub tolerance: f64,
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

    /// Moves the parameters `fitted` to these places, with the covariance of their places.
    pub(crate) fn correct(
        &mut self,
        parameters: &[Parameter],
        places: &[f64],
        (fitted, covariance): (&[usize], Option<&nalgebra::DMatrix<f64>>),
    ) {
        let standings: Vec<_> = self.estimates.iter().map(|estimate| estimate.standing.clone()).collect();
        let (estimates, correlation) =
            uncertainty::estimates(parameters, places, (fitted, covariance), &[], &[]);
        for ((old, new), standing) in self.estimates.iter_mut().zip(estimates).zip(standings) {
            let is_still_inside = new.standing != Standing::AtBound;
            if matches!(standing, Standing::Fitted | Standing::Vague) {
                *old = Estimate {
                    standing: if is_still_inside { standing } else { new.standing.clone() },
                    ..new
                };
            }
        }
        self.correlation = correlation;
    }
}

impl Parameter {
    /// Checks that the start lies within the bounds and that the scale can be taken.
    ///
    /// # Errors
    /// `BadInput` naming the parameter.
    pub fn check(&self) -> Result<(), BadInput> {
        let Bounds { min, max } = self.bounds;
        let is_interval = min.is_finite() && max.is_finite() && min < max;
        if !is_interval || (self.scale == Scale::Logarithmic && min <= 0.0) {
            let expected = match self.scale {
                Scale::Linear => "two finite numbers, the first smaller",
                Scale::Logarithmic => "two finite positive numbers, the first smaller",
            };
            let place = format!("bounds of {}", self.name);
            return Err(BadInput::new(place, expected, format!("{min} to {max}")));
        }
        if !self.bounds.contains(self.start) {
            let place = format!("start of {}", self.name);
            return Err(BadInput::new(place, format!("{min} to {max}"), self.start.to_string())
                .hint("widen the bounds, or start elsewhere"));
        }
        Ok(())
    }

    /// Where it goes back to if the data says nothing.
    pub fn home(&self) -> f64 {
        self.prior.map_or(self.start, |prior| prior.center)
    }

    /// Place between the bounds, 0 to 1.
    pub fn place(&self, value: f64) -> f64 {
        let (low, high) = (self.along(self.bounds.min), self.along(self.bounds.max));
        (self.along(value) - low) / (high - low)
    }

    /// Standard deviation of the prior, in places.
    pub fn prior_width(&self) -> Option<f64> {
        let range = self.along(self.bounds.max) - self.along(self.bounds.min);
        self.prior.map(|prior| self.along(prior.width) / range)
    }

    fn along(&self, value: f64) -> f64 {
        match self.scale {
            Scale::Linear => value,
            Scale::Logarithmic => value.ln(),
        }
    }

    /// The inverse of [`Self::place`].
    pub fn value(&self, place: f64) -> f64 {
        let Bounds { min, max } = self.bounds;
        let value = match self.scale {
            Scale::Linear => min + place * (max - min),
            Scale::Logarithmic => (min.ln() + place * (max / min).ln()).exp(),
        };
        self.bounds.clamp(value)
    }

    /// Change of the value with its place.
    pub(crate) fn slope(&self, value: f64) -> f64 {
        match self.scale {
            Scale::Linear => self.bounds.max - self.bounds.min,
            Scale::Logarithmic => value * (self.bounds.max / self.bounds.min).ln(),
        }
    }
}

/// Tolerance of a search whose end is the end [-].
pub const TOLERANCE: f64 = 1e-5;
/// Squared number of standard deviations that a return to the start may cost: 95 % of all noise stays below.
const NOISE: f64 = 4.0;

/// Fits `parameters` so that the sum of squared residuals is least.
///
/// `residuals` gives series of residuals that belong together, neighbours beside each other (as one coordinate over
/// one recording), so that the fit can tell how independent they are. Where they fail
/// locally ([`Failure::is_local`]), the search turns back.
///
/// # Errors
/// A start out of its bounds; fewer residuals than parameters; any other error of `residuals`.
pub fn least_squares<F, E>(parameters: &[Parameter], options: &Options, residuals: F) -> Result<Fit, E>
where
    F: Fn(&[f64]) -> Result<Vec<Vec<f64>>, E> + Sync,
    E: Failure,
{
    let (mut problem, first) = Problem::new(parameters, options, &residuals)?;
    let start: Vec<f64> = parameters.iter().map(|p| p.place(p.start)).collect();
    let home: Vec<f64> = parameters.iter().map(|p| p.place(p.home())).collect();
    let spread_of = |series: &[Vec<f64>], n: usize| Spread::new(series, n + options.n_nuisance);
    problem.noise = spread_of(&first, parameters.len()).variance.sqrt();

    // What the data does not see is held, one parameter at a time, until the rest is determined.
    let mut free: Vec<usize> = (0..parameters.len()).collect();
    let (mut held, mut kept) = (Vec::new(), Vec::new());
    let mut places = start.clone();
    let mut columns = problem.columns(&start, &free, &first)?;
    while let Some((at, with)) = uncertainty::unseen(&free, &columns, options.smallest_effect) {
        let k = free.remove(at);
        places[k] = home[k];
        held.push((k, with));
        columns.remove(at);
    }
    let mut found = problem.settle(&places, &free, spread_of)?;
    let mut iterations = 1 + found.iterations;
    loop {
        let series = problem.evaluate(&found.places)?.unwrap_or_else(|| first.clone());
        let inside = uncertainty::inside(&free, &found.places);
        let columns = problem.columns(&found.places, &inside, &series)?;
        let spread = spread_of(&series, inside.len());
        let unseen = uncertainty::unseen(&inside, &columns, options.smallest_effect);
        let rows = prior_rows(parameters, &inside, &columns, problem.noise);
        let covariance = uncertainty::covariance(&rows, spread.variance);
        let vague = || uncertainty::vague(parameters, &inside, covariance.as_ref()?, &kept);
        let Some((at, with)) = unseen.clone().or_else(vague) else {
            let (estimates, correlation) = uncertainty::estimates(
                parameters,
                &found.places,
                (&inside, covariance.as_ref()),
                &kept,
                &held,
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
        iterations += without.iterations;
        let price = problem.cost_at(&without.places, &first)?
            - cost(parameters, &found.places, &series, problem.noise);
        if unseen.is_none() && price > NOISE * spread.variance {
            kept.push(k);
        } else {
            held.push((k, with));
            free = rest;
            found = without;
        }
    }
}
