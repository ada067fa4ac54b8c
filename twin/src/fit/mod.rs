//! Fitting: the physical parameters of a scene from static or quasi-static recordings.
//!
//! `least_squares` knows residuals and bounded parameters, nothing of robots; `uncertainty` says what its outcome is
//! worth; `quantity` lists what can be fitted of a scene, one line each; `course` chooses the samples that a fit
//! steps through; `material` puts them together. The shape of a robot driven by strokes alone, without friction and
//! gravity, does not depend on its modulus: what the data does not determine is held at its start and said to be.

mod comparison;
mod course;
mod hints;
mod least_squares;
mod material;
mod quantity;
mod search;
mod uncertainty;

pub use course::{Course, Stepping, courses};
pub use hints::Hint;
pub use least_squares::{Fit, Options, Parameter, Prior, Scale, TOLERANCE, least_squares};
pub use material::{AxisErrors, Frame, MaterialFit, MaterialOptions, Progress, fit_material};
pub use quantity::{Of, QUANTITIES, Quantity, Selected, Wanted, select};
pub use uncertainty::{Estimate, Standing};
