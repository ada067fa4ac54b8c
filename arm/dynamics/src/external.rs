//! Forces from outside.

use crate::data::Lift;
use crate::spatial::{SpatialMotion, Vec3, Wrench, add_scaled3, cross, mul3, mul3_add, scale3, splat3};
use crate::{Data, Model, Scalar};

/// A force that acts on the arm at the origin of a frame, in the axes of the base.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ExternalForce<T> {
    /// Number of the frame in [`Model::frames`].
    pub frame: usize,
    /// [N].
    pub force: Vec3<T>,
    /// [N m].
    pub torque: Vec3<T>,
}

impl<T: Scalar> ExternalForce<T> {
    /// The body that it acts on and where; `None` on the base, which does not move.
    #[inline(always)]
    pub(crate) fn point(&self, model: &Model, data: &Data<T>) -> Option<(usize, Vec3<T>)> {
        let frame = &model.frames[self.frame];
        let body = frame.joint?;
        let at = &data.bodies[body];
        Some((body, mul3_add(&at.rotation, splat3(at.position[0], frame.pose.position), at.position)))
    }
}

impl<T: Scalar> Data<T> {
    /// Sum of the weightless mass times place of a lift, about the base's origin and in its axes.
    #[inline(always)]
    pub(crate) fn lifted(&self, lift: &Lift<T>) -> Vec3<T> {
        let at = &self.bodies[lift.body];
        add_scaled3(mul3(&at.rotation, lift.first), lift.mass, at.position)
    }
}

/// Resistance of a lift to a motion of its body: as `resisted` of `derivatives`, for a force that carries a
/// mass.
#[inline(always)]
pub(crate) fn lift_resisted<T: Scalar>(data: &Data<T>, lift: &Lift<T>, m: &SpatialMotion<T>) -> Vec3<T> {
    let moved = add_scaled3(cross(m.angular, data.lifted(lift)), lift.mass, m.linear);
    cross(data.base_acceleration.linear, moved)
}

/// Takes external forces, and what carries the weightless, from what the bodies need.
#[inline(always)]
pub(crate) fn subtract<T: Scalar>(model: &Model, data: &mut Data<T>, external: &[ExternalForce<T>]) {
    for force in external {
        if let Some((body, point)) = force.point(model, data) {
            let wrench = Wrench::at(point, force.force, force.torque);
            data.bodies[body].wrench = data.bodies[body].wrench.minus(&wrench);
        }
    }
    for k in 0..data.lifts.len() {
        let lift = data.lifts[k];
        let up = data.base_acceleration.linear;
        let wrench = Wrench { moment: cross(data.lifted(&lift), up), force: scale3(lift.mass, up) };
        data.bodies[lift.body].wrench = data.bodies[lift.body].wrench.minus(&wrench);
    }
}
