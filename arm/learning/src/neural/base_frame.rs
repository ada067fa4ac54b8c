//! `BaseFrame`: axes that turn with the arm's first joint, where that joint is vertical.
//!
//! Gravity is the same whichever way such an arm looks. A force in axes that turn with it has the same levers and does the same to the
//! motors, and of the first joint's angle and goal only the difference matters: what is learned in one direction holds in all.

use super::features::FeatureLayout;
use super::loss::Heads;
use hysteron_arm_dynamics::spatial::{Vec3, cross, dot3, mul3};
use hysteron_arm_dynamics::{JointKind, Model};

/// The axis about which an arm turns without a change of its dynamics.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct BaseFrame {
    /// Unit vector in the axes of the base; `None` where the first joint is not vertical.
    axis: Option<Vec3<f64>>,
}

/// Cosine of the angle between axis and gravity, from which on a joint is upright: what is left of gravity turns by 0.1 %.
const UPRIGHT: f64 = 1.0 - 5e-7;

impl BaseFrame {
    pub fn of(model: &Model) -> Self {
        let gravity = model.gravity();
        let axis = model.joints().first().filter(|joint| joint.kind == JointKind::Revolute);
        let axis = axis.map(|joint| mul3(&joint.placement.rotation, [0.0, 0.0, 1.0]));
        let is_upright =
            |axis: &Vec3<f64>| dot3(*axis, gravity).abs() >= UPRIGHT * dot3(gravity, gravity).sqrt();
        Self { axis: axis.filter(is_upright) }
    }

    /// A vector of axes that turn with the arm, in those of the base; `angle` of the first joint [rad].
    pub fn to_base(self, angle: f64, v: Vec3<f64>) -> Vec3<f64> {
        let Some(axis) = self.axis else { return v };
        let (sin, cos) = angle.sin_cos();
        let (across, along) = (cross(axis, v), (1.0 - cos) * dot3(axis, v));
        std::array::from_fn(|i| cos * v[i] + sin * across[i] + along * axis[i])
    }

    /// A vector of the base's axes, in axes that turn with the arm.
    pub fn to_arm(self, angle: f64, v: Vec3<f64>) -> Vec3<f64> {
        self.to_base(-angle, v)
    }

    /// Adds a force [N] to the raw force of outputs in axes that turn with the arm, whose first joint is at `angle` [rad]; then it is in those of
    /// the base.
    pub fn add_force(self, heads: &Heads, (angle, force): (f64, &Vec3<f64>), outputs: &mut [f64]) {
        heads.map_force(outputs, |raw| {
            let raw = self.to_base(angle, raw);
            std::array::from_fn(|i| raw[i] + force[i])
        });
    }

    /// Zeroes the first joint's angle and goal among a sample's inputs; their difference stays.
    pub fn remove_azimuth(self, features: &FeatureLayout, inputs: &mut [f64]) {
        if self.axis.is_some() {
            inputs[FeatureLayout::GOALS] = 0.0;
            inputs[features.positions()] = 0.0;
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)] // a test may stop where it stands

    use super::*;

    #[test]
    fn axes_that_turn_are_those_of_a_rotation_about_the_upright_joint_and_of_no_other_arm() {
        let model = Model::builtin("open-manipulator-x").unwrap();
        let frame = BaseFrame::of(&model);
        let (angle, v, w) = (0.7_f64, [1.0, -2.0, 0.5], [0.3, 0.4, -0.9]);
        let (sin, cos) = angle.sin_cos();
        let expected = [cos * v[0] - sin * v[1], sin * v[0] + cos * v[1], v[2]];
        let apart = |a: Vec3<f64>, b: Vec3<f64>| (0..3).map(|i| (a[i] - b[i]).abs()).fold(0.0, f64::max);
        assert!(apart(frame.to_base(angle, v), expected) < 1e-15);
        assert!(apart(frame.to_arm(angle, expected), v) < 1e-15);
        // The gradient goes back through the transpose.
        let both = [dot3(frame.to_base(angle, v), w), dot3(v, frame.to_arm(angle, w))];
        assert!((both[0] - both[1]).abs() < 1e-15, "{both:?}");
        // On a wall the first joint turns against gravity.
        let mounted = model.with_gravity([9.81, 0.0, 0.0]);
        assert_eq!(BaseFrame::of(&mounted), BaseFrame { axis: None });
        assert_eq!(BaseFrame::of(&mounted).to_base(angle, v), v);
    }
}
