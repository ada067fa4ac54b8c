//! Optimisation with bounds: parameters fitted to measurements by any function of residuals, and quadratic programs.
//!
//! [`least_squares`] finds the minimum near a start and gives the uncertainty of each parameter; [`search_globally`] finds where
//! to start; [`FuzzyNetwork`] is a curve of five rules; [`folds`] are for cross-validation. Nothing here knows a robot.

mod evaluation_error;
mod folds;
mod fuzzy;
mod global;
mod least_squares;
mod outcome;
mod parameter;
pub mod qp;
mod search;
mod uncertainty;

use hysteron_base::BadInput;

pub use folds::{Fold, folds};
pub use fuzzy::{Consequents, FuzzyNetwork};
pub use global::{GlobalMethod, GlobalOptions, GlobalSearch, search_globally};
pub use least_squares::{TOLERANCE, least_squares};
pub use outcome::{Fit, Options};
pub use parameter::{Parameter, ParameterScale, Prior};
pub use search::{FitProblem, SearchResult, cost, minimum, polished, prior_rows};
pub use uncertainty::{
    Identifiability, IdentifiedParameter, ResidualVariance, condition, correction, covariance, unidentifiable,
};

/// Error type of the residuals of a fit.
pub trait Failure: From<BadInput> + Send + std::fmt::Debug {
    /// True where the residuals have no value at these parameters alone, so that a search turns back; false ends it.
    fn is_local(&self) -> bool;
}

impl Failure for BadInput {
    fn is_local(&self) -> bool {
        false
    }
}
