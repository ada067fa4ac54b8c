//! Forces from outside.

use crate::spatial::{Vec3, Wrench, mul3_add, splat3};
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

/// Takes external forces from what the bodies need.
#[inline(always)]
pub(crate) fn subtract<T: Scalar>(model: &Model, data: &mut Data<T>, external: &[ExternalForce<T>]) {
    for force in external {
        if let Some((body, point)) = force.point(model, data) {
            let wrench = Wrench::at(point, force.force, force.torque);
            data.bodies[body].wrench = data.bodies[body].wrench.minus(&wrench);
        }
    }
}
