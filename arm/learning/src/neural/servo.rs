//! A position servo: stiffness towards its goal, friction and damping.

use hysteron_base::BadInput;
use serde::{Deserialize, Serialize};

use super::features::FeatureLayout;
use super::motors::Motors;

/// A servo of which stiffness, friction and damping are found by rollout.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RolloutServo {
    /// Torque per error of each motor [N m/rad].
    pub stiffness: Vec<f64>,
    /// Coulomb friction of each motor [N m].
    pub friction: Vec<f64>,
    /// Further friction of each motor per torque through its gear [-]; empty where friction does not grow with that.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub load_friction: Vec<f64>,
    /// Of all motors [N m s/rad].
    pub damping: f64,
    /// Root mean square of the rollouts' errors on what it was fitted to [rad].
    pub rms: f64,
    /// True where friction holds a motor at rest exactly; false where it is F tanh(q̇/w), which lets a loaded motor creep.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub holds: bool,
    /// Parameters of its motors.
    #[serde(default, skip_serializing_if = "Motors::are_published")]
    pub motors: Motors,
    /// Gain of the position loops that the stiffness holds for, as the register has it; none where recordings have none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub position_gain: Option<f64>,
}

/// Speed w over which friction turns its sign where it does not hold [rad/s].
pub(super) const FRICTION_WIDTH: f64 = 0.05;

/// Largest friction per torque through the gear: at one half a motor that lifts a load holds all of its torque by friction [-].
pub(super) const MAX_LOAD_FRICTION: f64 = 0.45;

impl RolloutServo {
    /// # Errors
    /// `BadInput` where it is for other motors, or a number is negative or not finite.
    pub(super) fn check(&self, features: &FeatureLayout) -> Result<(), BadInput> {
        self.motors.check().map_err(|bad| bad.within("servo.motors"))?;
        let m = features.motors();
        for (name, values) in [("servo.stiffness", &self.stiffness), ("servo.friction", &self.friction)] {
            if values.len() != m || values.iter().any(|value| !(*value >= 0.0 && value.is_finite())) {
                let expected = format!("{m} finite numbers, zero or more");
                return Err(BadInput::new(name, expected, format!("{values:?}")));
            }
        }
        let shares = &self.load_friction;
        let are_shares = shares.iter().all(|share| (0.0..=MAX_LOAD_FRICTION).contains(share));
        if !(shares.is_empty() || self.holds && shares.len() == m && are_shares) {
            let expected = format!("none, or {m} from 0 to {MAX_LOAD_FRICTION} of friction that holds");
            return Err(BadInput::new("servo.load_friction", expected, format!("{shares:?}")));
        }
        if !(self.damping >= 0.0 && self.damping.is_finite()) {
            let expected = "a finite number, zero or more";
            return Err(BadInput::new("servo.damping", expected, self.damping.to_string()));
        }
        Ok(())
    }

    /// Torque of motor `k` towards `goal` at this position and speed [N m], and its derivatives by these two; without friction
    /// where that [`Self::holds`], for it is the integrator's then. `gain` is over that which the stiffness holds for.
    pub(super) fn torque(
        &self,
        k: usize,
        (goal, gain): (f64, f64),
        [position, speed]: [f64; 2],
    ) -> (f64, [f64; 2]) {
        let stiffness = gain * self.stiffness[k];
        let free = stiffness * (goal - position);
        if self.holds {
            return (free, [-stiffness, 0.0]);
        }
        let (sign, friction) = ((speed / FRICTION_WIDTH).tanh(), self.friction[k]);
        (free - friction * sign, [-stiffness, -friction / FRICTION_WIDTH * (1.0 - sign * sign)])
    }

    /// Friction of motor `k` that the integrator has to hold [N m], and its growth per torque through the gear.
    pub(super) fn holding_friction(&self, k: usize) -> [f64; 2] {
        let friction = if self.holds { self.friction[k] } else { 0.0 };
        [friction, self.load_friction.get(k).copied().unwrap_or(0.0)]
    }
}
