//! Models that drive the motors of the simulated arm next to the network.

use hysteron_actuator::Drive;
use hysteron_actuator::number::Dual;

use super::servo::{FRICTION_WIDTH, RolloutServo};

/// Model that drives every motor next to the network.
#[derive(Debug, Clone, Copy)]
pub(super) enum DriveModel<'a> {
    /// Stiffness, friction and damping.
    Servo(&'a RolloutServo),
    /// A motor on its supply, with heat and limits of current.
    Drive(&'a Drive),
}

impl DriveModel<'_> {
    /// Torque of motor `k` towards `goal` at this position and speed [N m], and its derivatives by these two; without friction that holds,
    /// which is the integrator's. `gain` is that of a drive's register, or over the one that a servo's stiffness holds for, `winding` the temperature of a drive's [°C].
    pub fn torque(
        &self,
        k: usize,
        (goal, gain): (f64, f64),
        [position, speed]: [f64; 2],
        winding: f64,
    ) -> (f64, [f64; 2]) {
        match self {
            Self::Servo(servo) => servo.torque(k, (goal, gain), [position, speed]),
            Self::Drive(drive) => {
                let at = |error, speed| drive.follow(gain, [error, speed], winding)[0];
                let by_error = at(Dual::variable(goal - position), Dual::from(speed));
                let by_speed = at(Dual::from(goal - position), Dual::variable(speed));
                (by_error.value, [-by_error.slope, by_speed.slope])
            }
        }
    }

    /// Friction of motor `k` that the integrator has to hold [N m] and its growth per torque through the gear, each with its derivative by
    /// the speed.
    pub fn friction(&self, k: usize, speed: f64) -> [Dual; 2] {
        match self {
            Self::Servo(servo) => servo.holding_friction(k).map(Dual::from),
            Self::Drive(drive) => drive.load_friction(Dual::variable(speed)),
        }
    }

    /// Torque of motor `k` after friction [N m], at a speed where inertia takes nothing:
    /// b of τ − b = s (F + μ |τ + b|).
    pub fn left_by_friction(&self, k: usize, torque: f64, speed: f64) -> f64 {
        if matches!(self, Self::Servo(servo) if !servo.holds) {
            return torque;
        }
        let [friction, share] = self.friction(k, speed).map(|one| one.value);
        let against = (speed / FRICTION_WIDTH).tanh();
        let grows = against * share * torque.signum();
        (torque * (1.0 - grows) - against * friction) / (1.0 + grows)
    }

    /// Whether [`Self::friction`] is more than a number for each motor.
    pub fn friction_varies(&self) -> bool {
        match self {
            Self::Servo(servo) => !servo.load_friction.is_empty(),
            Self::Drive(_) => true,
        }
    }
}
