//! Simple models of inverse dynamics that a learned one has to beat: an identified rigid body with friction and springs,
//! ridge regression on Fourier features, and the second on what the first leaves.

mod fourier;
mod ridge;
mod rigid_body;
mod selection;

pub use fourier::FourierFeatures;
pub use ridge::{NormalEquations, predict};
pub use rigid_body::RigidFeatures;
pub use selection::{Choice, FourierFit, choose_penalty, fit_fourier, fit_rigid_body};
