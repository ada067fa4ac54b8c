//! Inverse dynamics as a linear function of the inertial parameters.

use crate::kinematics::{accelerate_bodies, move_bodies};
use crate::spatial::Inertia;
use crate::{Data, Model, Scalar};

/// Regressor Y (n × 10 n, row by row): τ = Y π + armature q̈, with π the ten parameters of every body, joint by joint
/// ([`Inertia::parameters`]).
#[inline(always)]
pub fn regressor<T: Scalar>(model: &Model, data: &mut Data<T>, [q, dq, ddq]: [&[T]; 3], regressor: &mut [T]) {
    let width = 10 * model.n_joints();
    move_bodies(model, data, q, dq);
    accelerate_bodies(model, data, ddq);
    regressor.fill(q[0].splat(0.0));
    for k in 0..model.n_joints() {
        let body = &data.bodies[k];
        let (v, a) = (body.local(&body.velocity), body.local(&body.acceleration));
        for i in model.way_to_base(k) {
            // S·(I a + v ×* I v) = S·I a − (v × S)·I v.
            let s = body.local(&data.bodies[i].axis);
            let (first, second) = (Inertia::gradient(&s, &a), Inertia::gradient(&v.cross(&s), &v));
            for (p, (first, second)) in first.into_iter().zip(second).enumerate() {
                regressor[width * i + 10 * k + p] = first - second;
            }
        }
    }
}
