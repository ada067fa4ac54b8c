//! Reverse mode of forward dynamics in O(n), without differentiating the articulated-body algorithm.
//!
//! For a cotangent w of q̈, μ = M⁻¹ w; then one reverse sweep of inverse dynamics at (q, q̇, q̈) gives −∂(μ·τ).
//! With w_k = Σ_{i ≤ k} S_i μ_i the motion that μ gives body k, μ·τ = Σ_k w_k · f_k, and for a joint j with parent λ
//! ∂/∂q_j = (w_λ × S_j)·F_j + Ψ̈_j·P_j + Ψ̇_j·Q_j, ∂/∂q̇_j = S_j·Q_j + 2 Ψ̇_j·P_j,
//! where F, P and Q sum f_k, I_k w_k and 2 B_kᵀ w_k over the bodies that j carries (names of `derivatives`).

use crate::coriolis::{find_momenta, twice_b_transposed_of};
use crate::data::BodyState;
use crate::external::{ExternalForce, lift_resisted, subtract};
use crate::rnea::find_wrenches;
use crate::spatial::{Inertia, SpatialMotion, Vec3, add3, dot3};
use crate::{Data, Model, Scalar, solve_mass};

/// Gradients with respect to the arguments of [`crate::forward_dynamics`].
#[derive(Debug, Clone)]
pub struct Cotangent<T> {
    /// By q.
    pub q: Vec<T>,
    /// By q̇.
    pub dq: Vec<T>,
    /// By τ: M⁻¹ w.
    pub tau: Vec<T>,
    /// By the ten parameters of every body, as in [`Inertia::parameters`].
    pub inertias: Vec<[T; 10]>,
    /// By the armature of every joint.
    pub armature: Vec<T>,
    /// By force and torque of every external force.
    pub external: Vec<[Vec3<T>; 2]>,
}

impl<T: Scalar> Cotangent<T> {
    /// Zeros for `model` with `n_external` external forces, of numbers like `like`.
    pub fn new(model: &Model, n_external: usize, like: T) -> Self {
        let (n, zero) = (model.n_joints(), like.splat(0.0));
        Self {
            q: vec![zero; n],
            dq: vec![zero; n],
            tau: vec![zero; n],
            inertias: vec![[zero; 10]; n],
            armature: vec![zero; n],
            external: vec![[[zero; 3]; 2]; n_external],
        }
    }
}

/// Gradients of w·q̈ with respect to q, q̇ and τ, and to the external forces.
///
/// `data` as [`crate::forward_dynamics`] left it for the same arguments.
#[inline(always)]
pub fn forward_dynamics_adjoint<T: Scalar>(
    model: &Model,
    data: &mut Data<T>,
    external: &[ExternalForce<T>],
    w: &[T],
    cotangent: &mut Cotangent<T>,
) {
    cotangent.tau.copy_from_slice(w);
    solve_mass(model, data, &mut cotangent.tau);
    sweep(model, data, external, cotangent);
}

/// Gradients of −μ·τ with respect to q and q̇ of inverse dynamics, μ in `cotangent.tau`, and those of μ·Jᵀf to the external forces.
///
/// `data` as [`crate::inverse_dynamics`] left it for the same arguments.
#[inline(always)]
pub(crate) fn inverse_dynamics_adjoint<T: Scalar>(
    model: &Model,
    data: &mut Data<T>,
    external: &[ExternalForce<T>],
    cotangent: &mut Cotangent<T>,
) {
    let still = SpatialMotion::zero(data.like());
    for (i, joint) in model.joints.iter().enumerate() {
        let carried = joint.parent.map_or(still, |p| data.bodies[p].motion);
        let body = &mut data.bodies[i];
        body.motion = carried.plus_scaled(cotangent.tau[i], &body.axis);
    }
    sweep(model, data, external, cotangent);
}

/// The reverse sweep of inverse dynamics for the motions that μ gives the bodies.
#[inline(always)]
fn sweep<T: Scalar>(
    model: &Model,
    data: &mut Data<T>,
    external: &[ExternalForce<T>],
    cotangent: &mut Cotangent<T>,
) {
    data.apart(
        #[inline(always)]
        |data| {
            find_wrenches(data);
            find_momenta(data);
            subtract(model, data, external);
            let zero = data.like().splat(0.0);
            // P in `load`, Q in `turned`; what forces that keep their direction bring, in `resisted`.
            for body in &mut data.bodies {
                body.load = body.inertia.mul(&body.motion);
                body.turned = twice_b_transposed_of(body, &body.motion);
                body.resisted = [zero; 3];
            }
            for (force, gradient) in external.iter().zip(&mut cotangent.external) {
                *gradient = [[zero; 3]; 2];
                if let Some((body, point)) = force.point(model, data) {
                    let body = &mut data.bodies[body];
                    *gradient = [body.motion.at(point), body.motion.angular];
                    body.resisted =
                        add3(body.resisted, crate::derivatives::resisted(force, point, &body.motion));
                }
            }
            for k in 0..data.lifts.len() {
                let lift = data.lifts[k];
                let body = lift.body;
                let resisted = lift_resisted(data, &lift, &data.bodies[body].motion);
                data.bodies[body].resisted = add3(data.bodies[body].resisted, resisted);
            }
            for (i, joint) in model.joints.iter().enumerate().rev() {
                let body = data.bodies[i];
                let BodyState { axis, axis_rate, load, turned, wrench, resisted, .. } = &body;
                let half = axis_rate.dot(load);
                cotangent.dq[i] = -(dot3(axis.angular, *turned) + half + half);
                let mut q = dot3(axis_rate.angular, *turned) + dot3(axis.angular, *resisted);
                if let Some([stiffness, _]) = data.springs.get(i) {
                    q = stiffness.mul_add(cotangent.tau[i], q);
                }
                match joint.parent {
                    Some(p) => {
                        let parent = &mut data.bodies[p];
                        let axis_acceleration =
                            parent.acceleration.cross(axis).plus(&parent.velocity.cross(axis_rate));
                        q = q + axis_acceleration.dot(load) + parent.motion.cross(axis).dot(wrench);
                        parent.load = parent.load.plus(load);
                        parent.wrench = parent.wrench.plus(wrench);
                        parent.turned = add3(parent.turned, *turned);
                        parent.resisted = add3(parent.resisted, *resisted);
                    }
                    None => q = q + data.base_acceleration.cross(axis).dot(load),
                }
                cotangent.q[i] = -q;
            }
        },
    )
}

/// Gradients of w·q̈ with respect to inertias and armatures; right after [`forward_dynamics_adjoint`], with q̈ at hand.
#[inline(always)]
pub fn parameter_adjoint<T: Scalar>(data: &Data<T>, ddq: &[T], cotangent: &mut Cotangent<T>) {
    for (i, body) in data.bodies.iter().enumerate() {
        // −∂(w·(I a + v ×* I v)) = −∂(w·I a) + ∂((v × w)·I v), in the body's own axes, in which parameters are constant.
        let (v, a, w) =
            (body.local(&body.velocity), body.local(&body.acceleration), body.local(&body.motion));
        let (first, second) = (Inertia::gradient(&w, &a), Inertia::gradient(&v.cross(&w), &v));
        for ((gradient, first), second) in cotangent.inertias[i].iter_mut().zip(first).zip(second) {
            *gradient = second - first;
        }
        cotangent.armature[i] = -(cotangent.tau[i] * ddq[i]);
    }
}

impl<T: Scalar> BodyState<T> {
    /// A motion about the origin of the body's frame, in its axes.
    #[inline(always)]
    pub fn local(&self, m: &SpatialMotion<T>) -> SpatialMotion<T> {
        let turned = |a| crate::spatial::mul3_transposed(&self.rotation, a);
        SpatialMotion { angular: turned(m.angular), linear: turned(m.at(self.position)) }
    }
}
