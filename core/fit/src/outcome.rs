//! Options of a fit, and its result.

use crate::parameter::Parameter;
use crate::uncertainty::{self, Identifiability, IdentifiedParameter};

/// Options of a least-squares fit: loss, thresholds, tolerance and a progress callback.
pub struct Options<'a> {
    /// Residual from which on a residual counts linearly rather than squared (Huber, 1964), if any [their unit].
    pub huber: Option<f64>,
    /// Root mean square by which a parameter must move the residuals, from bound to bound, to count as
    /// observable in the data [unit of the residuals].
    pub smallest_effect: f64,
    /// Parameters that the residuals themselves have been cleared of, a rigid frame for example.
    pub n_nuisance: usize,
    /// Relative change of the sum of squares, or of the places, below which a search ends [-].
    pub tolerance: f64,
    /// Called with the number of evaluations and the root mean square of the best; false ends the fit.
    pub watch: &'a (dyn Fn(usize, f64) -> bool + Sync),
}

/// The outcome of a fit.
#[derive(Debug, Clone, PartialEq)]
pub struct Fit {
    /// One per parameter, in their order.
    pub estimates: Vec<IdentifiedParameter>,
    /// Correlation of the estimates, for those with a standard error; n × n, zero elsewhere [-].
    pub correlation: Vec<Vec<f64>>,
    /// Condition number of the Jacobian of the fitted ones, its columns of length one: from 30 on some can
    /// hardly be identified separately (Belsley, Kuh, Welsch, 1980) [-].
    pub condition: f64,
    /// Root mean square of the residuals at the start and at the end.
    pub rms: [f64; 2],
    /// Jacobians computed.
    pub iterations: usize,
    /// Evaluations of the residuals, those for Jacobians included.
    pub evaluations: usize,
    /// Number of residuals.
    pub n_residuals: usize,
    /// Effective number of independent ones: neighbouring samples of a recording have correlated errors.
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

    /// Moves the parameters to these places; `fitted` are those off their bounds, with the covariance of their places.
    pub(crate) fn correct(
        &mut self,
        parameters: &[Parameter],
        places: &[f64],
        (fitted, covariance): (&[usize], Option<&nalgebra::DMatrix<f64>>),
    ) {
        let identifiabilities: Vec<_> =
            self.estimates.iter().map(|estimate| estimate.identifiability.clone()).collect();
        let (estimates, correlation) =
            uncertainty::estimates(parameters, places, (fitted, covariance), &[], &[]);
        for ((old, new), identifiability) in self.estimates.iter_mut().zip(estimates).zip(identifiabilities) {
            let is_still_inside = new.identifiability != Identifiability::AtBound;
            if matches!(identifiability, Identifiability::Fitted | Identifiability::Vague) {
                *old = IdentifiedParameter {
                    start: old.start,
                    identifiability: if is_still_inside {
                        identifiability
                    } else {
                        new.identifiability.clone()
                    },
                    ..new
                };
            }
        }
        self.correlation = correlation;
    }
}
