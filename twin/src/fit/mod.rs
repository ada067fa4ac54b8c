//! Fitting: the physical parameters of a scene from static or quasi-static recordings.
//!
//! The least squares and its uncertainty are `hysteron-fit`'s, which knows nothing of robots; `quantity`
//! lists what can be fitted of a scene, one line each; `course` chooses the samples that a fit steps through;
//! `material` puts them together. The shape of a robot driven by strokes alone, without friction and
//! gravity, does not depend on its modulus: what the data does not determine is held at its start and reported as held.

mod comparison;
mod hints;
mod material;
mod quantity;
mod sampling;

pub use comparison::{AxisErrors, FitBody, TipFrame};
pub use hints::Hint;
pub use hysteron_fit::{
    Fit, Identifiability, IdentifiedParameter, Options, Parameter, ParameterScale, Prior, TOLERANCE,
    least_squares,
};
pub use material::{FitProgress, MaterialFit, MaterialOptions, fit_material};
pub use quantity::{FitParameter, Of, QUANTITIES, SceneQuantity, Selected, select};
pub use sampling::{FitSamples, Stepping, courses};
