//! Forward dynamics by articulated bodies: a factor of the mass matrix in O(n), and solutions with it.
//!
//! Written as bias torque, factor and solve, so that the same factor serves the adjoint, implicit damping and friction.
//!
//! # Reference
//! Featherstone (2008), Rigid Body Dynamics Algorithms, chapter 7, in the axes of the base.

use crate::data::BodyState;
use crate::external::ExternalForce;
use crate::rnea::bias_torque;
use crate::spatial::{Articulated, SpatialMotion, Wrench};
use crate::{Data, Model, Scalar};

/// Accelerations q̈ = M⁻¹ (τ − C q̇ − g + Jᵀ f) [rad/s²] or [m/s²].
///
/// `data` keeps the factor of M for [`solve_mass`], and velocities and accelerations of the bodies.
#[inline(always)]
pub fn forward_dynamics<T: Scalar>(
    model: &Model,
    data: &mut Data<T>,
    [q, dq, tau]: [&[T]; 3],
    external: &[ExternalForce<T>],
    ddq: &mut [T],
) {
    bias_torque(model, data, [q, dq], external, ddq);
    factor_mass(model, data);
    for (ddq, tau) in ddq.iter_mut().zip(tau) {
        *ddq = *tau - *ddq;
    }
    solve_mass(model, data, ddq);
    for body in &mut data.bodies {
        body.acceleration = body.acceleration.plus(&body.motion);
    }
}

/// Factor of M + armature from inertias that are placed, for [`solve_mass`].
#[inline(always)]
pub(crate) fn factor_mass<T: Scalar>(model: &Model, data: &mut Data<T>) {
    data.apart(
        #[inline(always)]
        |data| {
            for body in &mut data.bodies {
                body.articulated = Articulated::rigid(&body.inertia);
            }
            for i in (0..model.n_joints()).rev() {
                let body = &mut data.bodies[i];
                body.reaction = body.articulated.mul(&body.axis);
                body.inverse = (body.axis.dot(&body.reaction) + data.armature[i]).recip();
                if let Some(p) = model.joints[i].parent {
                    let BodyState { articulated, inverse, reaction, .. } = data.bodies[i];
                    data.bodies[p].articulated =
                        data.bodies[p].articulated.plus_reduced(&articulated, inverse, &reaction);
                }
            }
        },
    )
}

/// Solves M x = b with the factor of the last [`forward_dynamics`] or `factor_mass`; `x` holds b, then x.
#[inline(always)]
pub fn solve_mass<T: Scalar>(model: &Model, data: &mut Data<T>, x: &mut [T]) {
    data.apart(
        #[inline(always)]
        |data| {
            let like = data.like();
            for body in &mut data.bodies {
                body.load = Wrench::zero(like);
            }
            for i in (0..model.n_joints()).rev() {
                let BodyState { axis, load, reaction, inverse, .. } = data.bodies[i];
                // What the joint is left with, in units of its acceleration.
                x[i] = (x[i] - axis.dot(&load)) * inverse;
                if let Some(p) = model.joints[i].parent {
                    data.bodies[p].load = data.bodies[p].load.plus(&load).plus_scaled(x[i], &reaction);
                }
            }
            for (i, joint) in model.joints.iter().enumerate() {
                let carried = joint.parent.map_or(SpatialMotion::zero(like), |p| data.bodies[p].motion);
                let body = &mut data.bodies[i];
                x[i] = x[i] - carried.dot(&body.reaction) * body.inverse;
                body.motion = carried.plus_scaled(x[i], &body.axis);
            }
        },
    )
}
