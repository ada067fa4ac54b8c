//! `ServoDrive`: what was identified of an arm's servos, as files have it.

use hysteron_actuator::law::{Law, LoadDependent};
use hysteron_base::BadInput;
use serde::{Deserialize, Serialize};

use crate::observer::{FrictionModel, LowSpeed, MotorTorque};

/// Below this a joint is at rest: half a step of the register is the least that is not zero [rad/s].
pub const STANDSTILL_SPEED: f64 = 0.02;

/// How a method takes motor torque and friction.
#[derive(Debug, Clone)]
pub(crate) struct FixedModel {
    pub motors: Vec<MotorTorque>,
    pub friction: FrictionModel,
}

/// Motors known by their PWM, friction that grows with the load, and noise of the external torques: "GMO-drive" of `study force`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ServoDrive {
    /// k_t, gear included [N m/A].
    pub torque_constant: f64,
    /// R, such that k_t (V − k_t q̇)/R is the torque [Ω].
    pub resistance: f64,
    /// Dry friction without load, of every joint [N m].
    pub dry: Vec<f64>,
    /// Growth of dry friction with the torque of the motor beyond the load's, of every joint [-].
    pub load_share: Vec<f64>,
    /// Viscous friction of every joint [N m s/rad].
    pub viscous: Vec<f64>,
    /// Standard deviation of every joint's external torque without contact [N m].
    pub noise: Vec<f64>,
}

impl ServoDrive {
    /// # Errors
    /// `BadInput` naming what is not for `n` joints or out of range.
    pub fn check(&self, n: usize) -> Result<(), BadInput> {
        let columns = [
            ("dry", &self.dry, 0.0),
            ("load_share", &self.load_share, 0.0),
            ("viscous", &self.viscous, 0.0),
            ("noise", &self.noise, f64::MIN_POSITIVE),
        ];
        for (name, values, least) in columns {
            if values.len() != n || values.iter().any(|value| !(*value >= least && value.is_finite())) {
                let expected = format!("{n} finite numbers, {least} or more");
                return Err(BadInput::new(name, expected, format!("{values:?}")));
            }
        }
        for (name, value) in [("torque_constant", self.torque_constant), ("resistance", self.resistance)] {
            if !(value > 0.0 && value.is_finite()) {
                return Err(BadInput::new(name, "a finite number above zero", value.to_string()));
            }
        }
        Ok(())
    }

    /// Largest friction of a joint at rest under a torque `motor` of its motor [N m].
    pub fn dry_friction(&self, joint: usize, motor: f64) -> f64 {
        self.dry[joint] + self.load_share[joint] * motor.abs()
    }

    /// As estimators take it.
    pub(super) fn known(&self) -> FixedModel {
        let motor = MotorTorque::Pwm { torque_constant: self.torque_constant, resistance: self.resistance };
        let law = |k: usize| {
            let own = vec![self.dry[k], self.viscous[k], 0.0, self.load_share[k], 0.0, 0.0, 0.0, 1.0, 1.0];
            (Law::LoadDependent(LoadDependent::M5), own)
        };
        let n = self.dry.len();
        let laws = (0..n).map(law).collect();
        FixedModel {
            motors: vec![motor; n],
            friction: FrictionModel::new(laws, LowSpeed::Absorb(STANDSTILL_SPEED)),
        }
    }
}
