//! Generalized momentum, and what changes it apart from the torques of the joints.
//!
//! With the velocity v_i and the axis S_i of body i, and the momentum h_i of all that it carries: p_i = S_i · h_i, and
//! ½ ∂(q̇ᵀM q̇)/∂q_i = (v_i × S_i) · h_i. One pass outwards and one inwards.

use crate::data::BodyState;
use crate::external::subtract;
use crate::kinematics::move_bodies;
use crate::rnea::place_inertias;
use crate::{Data, Model, Scalar};

/// Generalized momentum p = M q̇ [N m s] and the part of its rate that no torque brings, Cᵀ q̇ − g [N m]:
/// ṗ = τ + Cᵀ q̇ − g with Ṁ = C + Cᵀ.
///
/// # Reference
/// De Luca, Mattone (2005), Sensorless robot collision detection and hybrid force/motion control, eqs. 7 to 9.
#[inline(always)]
pub fn generalized_momentum<T: Scalar>(
    model: &Model,
    data: &mut Data<T>,
    [q, dq]: [&[T]; 2],
    momentum: &mut [T],
    rate: &mut [T],
) {
    move_bodies(model, data, q, dq);
    place_inertias(data);
    let base = data.base_acceleration;
    for body in &mut data.bodies {
        body.momentum = body.inertia.mul(&body.velocity);
        // Its weight, the other way round.
        body.wrench = body.inertia.mul(&base);
    }
    subtract(model, data, &[]);
    for (i, joint) in model.joints.iter().enumerate().rev() {
        let BodyState { axis, velocity, momentum: carried, wrench, .. } = data.bodies[i];
        momentum[i] = data.armature[i].mul_add(dq[i], axis.dot(&carried));
        rate[i] = velocity.cross(&axis).dot(&carried) - axis.dot(&wrench);
        if let Some([stiffness, reference]) = data.springs.get(i) {
            rate[i] = rate[i] - *stiffness * (q[i] - *reference);
        }
        if let Some(p) = joint.parent {
            let parent = &mut data.bodies[p];
            parent.momentum = parent.momentum.plus(&carried);
            parent.wrench = parent.wrench.plus(&wrench);
        }
    }
}
