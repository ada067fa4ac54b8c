//! Inverse dynamics by the recursive Newton-Euler algorithm.
//!
//! # Reference
//! Featherstone (2008), Rigid Body Dynamics Algorithms, table 5.1, in the axes of the base.

use crate::external::{ExternalForce, subtract};
use crate::kinematics::{accelerate_bodies, move_bodies};
use crate::spatial::SpatialMotion;
use crate::{Data, Model, Scalar};

/// Torques τ [N m] that give the accelerations: τ = M q̈ + C q̇ + g − Jᵀ f, with the torques of springs in g.
///
/// `q`, `dq`, `ddq`, `tau` have one number for each joint [rad, rad/s, rad/s²] or [m, m/s, m/s²].
#[inline(always)]
pub fn inverse_dynamics<T: Scalar>(
    model: &Model,
    data: &mut Data<T>,
    [q, dq, ddq]: [&[T]; 3],
    external: &[ExternalForce<T>],
    tau: &mut [T],
) {
    move_bodies(model, data, q, dq);
    accelerate_bodies(model, data, ddq);
    collect_torques(model, data, external, tau);
    add_springs(data, q, tau);
    for ((tau, armature), ddq) in tau.iter_mut().zip(&data.armature).zip(ddq) {
        *tau = armature.mul_add(*ddq, *tau);
    }
}

/// Torques [N m] of joints that move without acceleration: C q̇ + g − Jᵀ f.
#[inline(always)]
pub fn bias_torque<T: Scalar>(
    model: &Model,
    data: &mut Data<T>,
    [q, dq]: [&[T]; 2],
    external: &[ExternalForce<T>],
    tau: &mut [T],
) {
    move_bodies(model, data, q, dq);
    collect_torques(model, data, external, tau);
    add_springs(data, q, tau);
}

/// Torques [N m] that hold the arm still, against gravity and springs: g(q).
#[inline(always)]
pub fn gravity_torque<T: Scalar>(model: &Model, data: &mut Data<T>, q: &[T], tau: &mut [T]) {
    let still = std::mem::take(&mut data.still);
    bias_torque(model, data, [q, &still], &[], tau);
    data.still = still;
}

/// Torques of Coriolis and centrifugal forces [N m]: C(q, q̇) q̇.
#[inline(always)]
pub fn coriolis_torque<T: Scalar>(model: &Model, data: &mut Data<T>, [q, dq]: [&[T]; 2], tau: &mut [T]) {
    let gravity = data.base_acceleration;
    data.base_acceleration = SpatialMotion::zero(gravity.linear[0]);
    move_bodies(model, data, q, dq);
    collect_torques(model, data, &[], tau);
    data.base_acceleration = gravity;
}

/// Adds the torques that stretch the springs.
#[inline(always)]
fn add_springs<T: Scalar>(data: &Data<T>, q: &[T], tau: &mut [T]) {
    for ((tau, [stiffness, reference]), q) in tau.iter_mut().zip(&data.springs).zip(q) {
        *tau = stiffness.mul_add(*q - *reference, *tau);
    }
}

/// Wrenches from velocities and accelerations, summed from the tips to the base; the part of each along its joint.
#[inline(always)]
fn collect_torques<T: Scalar>(
    model: &Model,
    data: &mut Data<T>,
    external: &[ExternalForce<T>],
    tau: &mut [T],
) {
    data.apart(
        #[inline(always)]
        |data| {
            place_inertias(data);
            find_wrenches(data);
            subtract(model, data, external);
            sum_wrenches(model, data);
            for (tau, body) in tau.iter_mut().zip(&data.bodies) {
                *tau = body.axis.dot(&body.wrench);
            }
        },
    )
}

/// Inertias in the axes of the base.
#[inline(always)]
pub(crate) fn place_inertias<T: Scalar>(data: &mut Data<T>) {
    for (body, inertia) in data.bodies.iter_mut().zip(&data.inertias) {
        body.inertia = inertia.placed(&body.rotation, body.position);
    }
}

/// I a + v ×* I v of every body.
#[inline(always)]
pub(crate) fn find_wrenches<T: Scalar>(data: &mut Data<T>) {
    for body in &mut data.bodies {
        body.momentum = body.inertia.mul(&body.velocity);
        body.wrench = body.inertia.mul(&body.acceleration).plus(&body.velocity.cross_wrench(&body.momentum));
    }
}

/// Adds to the wrench of every body those of the bodies that it carries.
#[inline(always)]
pub(crate) fn sum_wrenches<T: Scalar>(model: &Model, data: &mut Data<T>) {
    for (i, joint) in model.joints.iter().enumerate().rev() {
        if let Some(p) = joint.parent {
            let carried = data.bodies[i].wrench;
            data.bodies[p].wrench = data.bodies[p].wrench.plus(&carried);
        }
    }
}
