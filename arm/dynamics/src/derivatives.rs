//! Analytic derivatives of inverse and forward dynamics.
//!
//! With S the axes, Ψ̇ = v_λ × S, Ψ̈ = a_λ × S + v_λ × Ψ̇ (λ the parent, gravity in a), composites ᶜ of all that a body
//! carries, and B of `coriolis`: for a joint j on the way from i to the base,
//! ∂τ_i/∂q_j = (Iᶜ S_i)·Ψ̈_j + (2Bᶜᵀ S_i)·Ψ̇_j, ∂τ_j/∂q_i = S_j·(Iᶜ Ψ̈_i + 2Bᶜ Ψ̇_i + S_i ×* fᶜ),
//! ∂τ_i/∂q̇_j = 2 (Iᶜ S_i)·Ψ̇_j + (2Bᶜᵀ S_i)·S_j, ∂τ_j/∂q̇_i = S_j·(2 Iᶜ Ψ̇_i + 2Bᶜ S_i).
//!
//! # Reference
//! Singh, Russell, Wensing (2022), Efficient analytical derivatives of rigid-body dynamics using spatial vector algebra.

use crate::coriolis::{add_to_parent, find_momenta, twice_b, twice_b_transposed};
use crate::data::BodyState;
use crate::dense;
use crate::external::{ExternalForce, lift_resisted, subtract};
use crate::kinematics::{accelerate_bodies, move_bodies};
use crate::rnea::{find_wrenches, place_inertias, sum_wrenches};
use crate::spatial::{SpatialMotion, cross, cross_add, dot3};
use crate::{Data, Model, Scalar};

/// ∂τ/∂q, ∂τ/∂q̇ and ∂τ/∂q̈ = M of [`crate::inverse_dynamics`] (each n × n, row by row); external forces keep their
/// direction while the arm moves.
#[inline(always)]
pub fn inverse_dynamics_derivatives<T: Scalar>(
    model: &Model,
    data: &mut Data<T>,
    [q, dq, ddq]: [&[T]; 3],
    external: &[ExternalForce<T>],
    derivatives: [&mut [T]; 3],
) {
    move_bodies(model, data, q, dq);
    place_inertias(data);
    accelerate_bodies(model, data, ddq);
    differentiate(model, data, external, derivatives);
}

/// ∂q̈/∂q, ∂q̈/∂q̇ and ∂q̈/∂τ = M⁻¹ of [`crate::forward_dynamics`] (each n × n, row by row). Writes q̈ to `ddq`.
#[inline(always)]
pub fn forward_dynamics_derivatives<T: Scalar>(
    model: &Model,
    data: &mut Data<T>,
    [q, dq, tau]: [&[T]; 3],
    external: &[ExternalForce<T>],
    ddq: &mut [T],
    [by_q, by_dq, by_tau]: [&mut [T]; 3],
) {
    let n = model.n_joints();
    crate::forward_dynamics(model, data, [q, dq, tau], external, ddq);
    differentiate(model, data, external, [&mut *by_q, &mut *by_dq, &mut *by_tau]);
    let mut mass = std::mem::take(&mut data.matrix);
    mass.copy_from_slice(by_tau);
    dense::factor(n, &mut mass);
    dense::invert(n, &mass, by_tau);
    for by in [by_q, by_dq] {
        dense::solve_columns(n, &mass, by);
        by.iter_mut().for_each(|x| *x = -*x);
    }
    data.matrix = mass;
}

/// From bodies that are placed and move; their inertias, momenta and wrenches become composites.
#[inline(always)]
fn differentiate<T: Scalar>(
    model: &Model,
    data: &mut Data<T>,
    external: &[ExternalForce<T>],
    [by_q, by_dq, mass]: [&mut [T]; 3],
) {
    data.apart(
        #[inline(always)]
        |data| {
            let n = model.n_joints();
            find_wrenches(data);
            find_momenta(data);
            subtract(model, data, external);
            sum_wrenches(model, data);
            find_axis_accelerations(model, data);
            let zero = data.like().splat(0.0);
            for matrix in [&mut *by_q, &mut *by_dq, &mut *mass] {
                matrix.fill(zero);
            }
            for i in (0..n).rev() {
                let body = data.bodies[i];
                let (row, turned) = (body.inertia.mul(&body.axis), twice_b_transposed(&body));
                let twice_rate = body.axis_rate.plus(&body.axis_rate);
                let column_q = body
                    .inertia
                    .mul(&body.axis_acceleration)
                    .plus(&twice_b(&body, &body.axis_rate))
                    .plus(&body.axis.cross_wrench(&body.wrench));
                let column_dq = body.inertia.mul(&twice_rate).plus(&twice_b(&body, &body.axis));
                let mut next = Some(i);
                while let Some(j) = next {
                    let BodyState { axis, axis_rate, axis_acceleration, .. } = &data.bodies[j];
                    let (here, across) = (n * i + j, n * j + i);
                    mass[here] = axis.dot(&row);
                    mass[across] = mass[here];
                    by_q[across] = axis.dot(&column_q);
                    by_dq[across] = axis.dot(&column_dq);
                    let half = axis_rate.dot(&row);
                    by_q[here] = axis_acceleration.dot(&row) + dot3(axis_rate.angular, turned);
                    by_dq[here] = half + half + dot3(axis.angular, turned);
                    next = model.joints[j].parent;
                }
                mass[n * i + i] = mass[n * i + i] + data.armature[i];
                if let Some([stiffness, _]) = data.springs.get(i) {
                    by_q[n * i + i] = by_q[n * i + i] + *stiffness;
                }
                add_to_parent(model, data, i);
            }
            add_external(model, data, external, by_q);
        },
    )
}

/// Ψ̈ of every joint.
#[inline(always)]
fn find_axis_accelerations<T: Scalar>(model: &Model, data: &mut Data<T>) {
    for (i, joint) in model.joints.iter().enumerate() {
        let (done, rest) = data.bodies.split_at_mut(i);
        let body = &mut rest[0];
        body.axis_acceleration = match joint.parent {
            Some(p) => {
                let BodyState { velocity, acceleration, .. } = &done[p];
                acceleration.cross(&body.axis).plus(&velocity.cross(&body.axis_rate))
            }
            None => data.base_acceleration.cross(&body.axis),
        };
    }
}

/// Adds to the derivatives by q the terms of forces that keep their direction instead of turning with their
/// body.
#[inline(always)]
fn add_external<T: Scalar>(model: &Model, data: &Data<T>, external: &[ExternalForce<T>], by_q: &mut [T]) {
    for force in external {
        let Some((body, point)) = force.point(model, data) else { continue };
        add_turned(model, data, body, by_q, |axis| resisted(force, point, axis));
    }
    for lift in &data.lifts {
        add_turned(model, data, lift.body, by_q, |axis| lift_resisted(data, lift, axis));
    }
}

/// Adds what a force on `body` brings to the derivatives, from what it resists a motion with.
#[inline(always)]
fn add_turned<T: Scalar>(
    model: &Model,
    data: &Data<T>,
    body: usize,
    by_q: &mut [T],
    resisted: impl Fn(&SpatialMotion<T>) -> [T; 3],
) {
    let n = model.n_joints();
    for i in model.way_to_base(body) {
        let turned = resisted(&data.bodies[i].axis);
        for j in model.way_to_base(body) {
            by_q[n * i + j] = by_q[n * i + j] + dot3(data.bodies[j].axis.angular, turned);
        }
    }
}

/// n × ω + f × u, u the velocity at `point` of a body that moves with (ω, v).
#[inline(always)]
pub(crate) fn resisted<T: Scalar>(force: &ExternalForce<T>, point: [T; 3], m: &SpatialMotion<T>) -> [T; 3] {
    cross_add(force.torque, m.angular, cross(force.force, m.at(point)))
}
