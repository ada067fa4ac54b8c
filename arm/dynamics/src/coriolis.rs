//! The Coriolis matrix, in the form in which Ṁ − 2C is skew.
//!
//! C = Σ_k J_kᵀ (I_k J̇_k + B_k J_k) with B = ½ (İ + A), İ = v×* I − I v×, A m = m ×* I v. About a common origin and in
//! common axes B has twelve numbers: with l and n the linear and angular momentum, J the second moment,
//! B = [ ½ (J̇ − n×), 0; −l×, 0 ].
//!
//! # Reference
//! Echeandia, Wensing (2021), Numerical methods to compute the Coriolis matrix and Christoffel symbols, eq. 10-16.

use crate::data::BodyState;
use crate::kinematics::move_bodies;
use crate::rnea::place_inertias;
use crate::spatial::{
    SpatialMotion, Sym3, Vec3, Wrench, add3, cross, cross_add, dot3, scale3, sub3, sym3_mul,
};
use crate::{Data, Model, Scalar};

/// Coriolis matrix C(q, q̇) (n × n, row by row): C q̇ is the Coriolis torque, Ṁ − 2C is skew.
#[inline(always)]
pub fn coriolis_matrix<T: Scalar>(model: &Model, data: &mut Data<T>, [q, dq]: [&[T]; 2], coriolis: &mut [T]) {
    let n = model.n_joints();
    move_bodies(model, data, q, dq);
    place_inertias(data);
    find_momenta(data);
    coriolis.fill(q[0].splat(0.0));
    for i in (0..n).rev() {
        let body = data.bodies[i];
        let column = body.inertia.mul(&body.axis_rate).plus(&twice_b(&body, &body.axis).halved());
        let (row, turned) =
            (body.inertia.mul(&body.axis), scale3(q[0].splat(0.5), twice_b_transposed(&body)));
        let mut next = Some(i);
        while let Some(j) = next {
            let BodyState { axis, axis_rate, .. } = &data.bodies[j];
            coriolis[n * j + i] = axis.dot(&column);
            coriolis[n * i + j] = axis_rate.dot(&row) + dot3(axis.angular, turned);
            next = model.joints[j].parent;
        }
        add_to_parent(model, data, i);
    }
}

/// Momenta, rates of the axes and of the second moments.
#[inline(always)]
pub(crate) fn find_momenta<T: Scalar>(data: &mut Data<T>) {
    for body in &mut data.bodies {
        body.momentum = body.inertia.mul(&body.velocity);
        body.axis_rate = body.velocity.cross(&body.axis);
        body.second_rate = second_rate(body);
    }
}

/// J̇ = ω× J − J ω× + 2 (v·h) 1 − h vᵀ − v hᵀ.
#[inline(always)]
pub(crate) fn second_rate<T: Scalar>(body: &BodyState<T>) -> Sym3<T> {
    let (SpatialMotion { angular, linear: v }, h) = (body.velocity, body.inertia.first);
    let [xx, xy, yy, xz, yz, zz] = body.inertia.second;
    // Columns of ω× J, less those of h vᵀ; with its transpose.
    let x = sub3(cross(angular, [xx, xy, xz]), scale3(v[0], h));
    let y = sub3(cross(angular, [xy, yy, yz]), scale3(v[1], h));
    let z = sub3(cross(angular, [xz, yz, zz]), scale3(v[2], h));
    let trace = dot3(v, h);
    let [a, b, c] = [x[0] + trace, y[1] + trace, z[2] + trace];
    [a + a, x[1] + y[0], b + b, x[2] + z[0], y[2] + z[1], c + c]
}

/// 2 B m.
#[inline(always)]
pub(crate) fn twice_b<T: Scalar>(body: &BodyState<T>, m: &SpatialMotion<T>) -> Wrench<T> {
    let force = cross(m.angular, body.momentum.force);
    Wrench {
        moment: cross_add(m.angular, body.momentum.moment, sym3_mul(&body.second_rate, m.angular)),
        force: add3(force, force),
    }
}

/// Moment of 2 Bᵀ S for the body's own axis S; its force is zero.
#[inline(always)]
pub(crate) fn twice_b_transposed<T: Scalar>(body: &BodyState<T>) -> Vec3<T> {
    twice_b_transposed_of(body, &body.axis)
}

/// Moment of 2 Bᵀ m; its force is zero.
#[inline(always)]
pub(crate) fn twice_b_transposed_of<T: Scalar>(body: &BodyState<T>, m: &SpatialMotion<T>) -> Vec3<T> {
    let turned = cross_add(body.momentum.moment, m.angular, sym3_mul(&body.second_rate, m.angular));
    let shifted = cross(body.momentum.force, m.linear);
    add3(turned, add3(shifted, shifted))
}

impl<T: Scalar> Wrench<T> {
    #[inline(always)]
    fn halved(&self) -> Self {
        Self { moment: self.moment.map(|x| x.scale(0.5)), force: self.force.map(|x| x.scale(0.5)) }
    }
}

/// Makes inertia, momentum and rate of the parent those of all that it carries.
#[inline(always)]
pub(crate) fn add_to_parent<T: Scalar>(model: &Model, data: &mut Data<T>, i: usize) {
    if let Some(p) = model.joints[i].parent {
        let BodyState { inertia, momentum, second_rate, .. } = data.bodies[i];
        let parent = &mut data.bodies[p];
        parent.inertia = parent.inertia.plus(&inertia);
        parent.momentum = parent.momentum.plus(&momentum);
        for (sum, part) in parent.second_rate.iter_mut().zip(second_rate) {
            *sum = *sum + part;
        }
    }
}
