//! Energy and momentum of the whole arm.

use crate::kinematics::{move_bodies, place_bodies};
use crate::rnea::place_inertias;
use crate::spatial::{Vec3, Wrench, add_scaled3, dot3, sub3};
use crate::{Data, Model, Scalar};

/// Kinetic energy [J] of the bodies, and of the rotors (½ armature q̇²).
#[inline(always)]
pub fn kinetic_energy<T: Scalar>(model: &Model, data: &mut Data<T>, q: &[T], dq: &[T]) -> T {
    move_bodies(model, data, q, dq);
    place_inertias(data);
    let mut twice = q[0].splat(0.0);
    for ((body, armature), dq) in data.bodies.iter().zip(&data.armature).zip(dq) {
        twice = twice + body.velocity.dot(&body.inertia.mul(&body.velocity)) + *armature * *dq * *dq;
    }
    twice.scale(0.5)
}

/// Potential energy [J] in gravity, zero where every mass is at the height of the base's origin, and in springs. Links on the base do
/// not count.
#[inline(always)]
pub fn potential_energy<T: Scalar>(model: &Model, data: &mut Data<T>, q: &[T]) -> T {
    let (_, mut first) = first_moment(model, data, q);
    for lift in &data.lifts {
        first = sub3(first, data.lifted(lift));
    }
    let in_gravity = dot3(data.base_acceleration.linear, first);
    q.iter().zip(&data.springs).fold(in_gravity, |energy, (q, [stiffness, reference])| {
        let stretched = *q - *reference;
        energy + (*stiffness * stretched * stretched).scale(0.5)
    })
}

/// Angular (about the base's origin) and linear momentum of the bodies, without their rotors [N m s, N s].
#[inline(always)]
pub fn momentum<T: Scalar>(model: &Model, data: &mut Data<T>, q: &[T], dq: &[T]) -> Wrench<T> {
    move_bodies(model, data, q, dq);
    place_inertias(data);
    let zero = Wrench::zero(q[0]);
    data.bodies.iter().fold(zero, |sum, body| sum.plus(&body.inertia.mul(&body.velocity)))
}

/// Mass [kg] and first moment [kg m] of all that moves.
#[inline(always)]
fn first_moment<T: Scalar>(model: &Model, data: &mut Data<T>, q: &[T]) -> (T, Vec3<T>) {
    place_bodies(model, data, q);
    let zero = q[0].splat(0.0);
    data.bodies.iter().zip(&data.inertias).fold((zero, [zero; 3]), |(mass, first), (body, inertia)| {
        let turned = crate::spatial::mul3_add(&body.rotation, inertia.first, first);
        (mass + inertia.mass, add_scaled3(turned, inertia.mass, body.position))
    })
}
