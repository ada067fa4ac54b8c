//! The algorithms in double precision, built here once: a crate that is built for size calls them at this one's speed.

use crate::{Data, ExternalForce, Model};

/// [`crate::inverse_dynamics`] in double precision.
#[inline(never)]
pub fn inverse_dynamics(
    model: &Model,
    data: &mut Data<f64>,
    state: [&[f64]; 3],
    external: &[ExternalForce<f64>],
    tau: &mut [f64],
) {
    crate::inverse_dynamics(model, data, state, external, tau);
}

/// [`crate::forward_dynamics`] in double precision.
#[inline(never)]
pub fn forward_dynamics(
    model: &Model,
    data: &mut Data<f64>,
    state: [&[f64]; 3],
    external: &[ExternalForce<f64>],
    ddq: &mut [f64],
) {
    crate::forward_dynamics(model, data, state, external, ddq);
}

/// [`crate::mass_matrix`] in double precision.
#[inline(never)]
pub fn mass_matrix(model: &Model, data: &mut Data<f64>, q: &[f64], mass: &mut [f64]) {
    crate::mass_matrix(model, data, q, mass);
}
