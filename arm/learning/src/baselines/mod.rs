//! Simple models of inverse dynamics that a learned one has to beat: an identified rigid body with friction and springs,
//! ridge regression on Fourier features, a Gaussian process, and these on what the first leaves.

mod fourier;
mod gaussian_process;
mod rigid_body;
mod selection;
mod states;

pub use fourier::FourierFeatures;
pub use gaussian_process::{GaussianFit, GaussianProcess, MAX_POINTS, fit_gaussian_process};
pub use hysteron_learn::ridge::{NormalEquations, predict};
pub use rigid_body::RigidFeatures;
pub use selection::{Choice, FourierFit, GoesOn, choose_penalty, fit_fourier, fit_rigid_body};
