//! The gripper: a servo that closes two jaws on an object.

use super::servo::{MotorLine, ServoState, VirtualServo};

/// Jaws on a servo.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VirtualGripper {
    /// Servo that drives the jaws.
    pub servo: VirtualServo,
    /// Aperture per angle of the motor [m/rad].
    pub lever: f64,
    /// Angle at which the jaws touch [rad].
    pub closed: f64,
    /// Of jaws and object [N/m].
    pub stiffness: f64,
    /// Of the jaws on an object [-].
    pub friction: f64,
}

impl VirtualGripper {
    /// Aperture at an angle of the motor [m].
    pub fn aperture(&self, angle: f64) -> f64 {
        self.lever * (angle - self.closed)
    }

    /// Angle of the motor for an aperture [rad].
    pub fn angle(&self, aperture: f64) -> f64 {
        self.closed + aperture / self.lever
    }

    /// Force on an object of that width, or of one jaw on the other without any [N].
    pub fn force(&self, angle: f64, width: f64) -> f64 {
        self.stiffness * (width - self.aperture(angle)).max(0.0)
    }

    /// Whether that force holds a weight [N] between both jaws.
    pub fn holds(&self, force: f64, weight: f64) -> bool {
        2.0 * self.friction * force >= weight
    }

    /// Advances by `h` [s] with a motor that follows `line`, around an object of `width` [m].
    pub fn step(&self, state: &mut ServoState, line: &MotorLine, width: f64, h: f64) {
        let servo = &self.servo;
        let push = self.lever * self.force(state.angle, width);
        let stiffness = if push > 0.0 { self.stiffness * self.lever * self.lever } else { 0.0 };
        let (motor, _) = line.at(state.speed);
        let dry = servo.bearing + servo.friction.dry(state.speed, motor, push);
        let inertia = servo.armature / h;
        let held = inertia * state.speed + line.at_rest + push;
        let beyond = (held.abs() - dry).max(0.0);
        let along = inertia + line.slope + servo.friction.viscous + h * stiffness;
        state.speed = if beyond == 0.0 { 0.0 } else { beyond.copysign(held) / along };
        state.current = line.at(state.speed).1;
        state.angle += h * state.speed;
    }
}
