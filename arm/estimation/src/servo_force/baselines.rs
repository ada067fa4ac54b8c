//! `BaselineObservers`: the momentum observers of table VI, as files have them.

use hysteron_base::BadInput;
use serde::{Deserialize, Serialize};

use super::drive::FixedModel;
use super::estimator::ForceEstimator;
use super::identify::identify;
use super::{ServoDrive, ServoForceTelemetry};
use crate::observer::{FrictionModel, MotorTorque};
use hysteron_arm_dynamics::Model;

/// Motors that give k_t i + b, without friction: "GMO-linear" of Dou et al. (NeuralActuator).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LinearDrive {
    /// k_t of every joint [N m/A].
    pub torque_constant: Vec<f64>,
    /// b of every joint [N m].
    pub offset: Vec<f64>,
    /// Standard deviation of every joint's external torque without contact [N m].
    pub noise: Vec<f64>,
}

impl LinearDrive {
    fn known(&self) -> FixedModel {
        let motor = |(torque_constant, offset): (&f64, &f64)| MotorTorque::Current {
            torque_constant: *torque_constant,
            offset: *offset,
        };
        let motors: Vec<MotorTorque> = self.torque_constant.iter().zip(&self.offset).map(motor).collect();
        FixedModel { friction: FrictionModel::none(motors.len()), motors }
    }
}

/// GMO-linear and GMO-drive, identified on contact-free motion.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BaselineObservers {
    /// On currents.
    pub linear: LinearDrive,
    /// On the drives' PWM.
    pub drive: ServoDrive,
    /// Length of either's force that 99 % of the training rows stay below [N].
    pub contact: [f64; 2],
}

/// Share of training rows below a threshold.
const QUANTILE: f64 = 0.99;

impl BaselineObservers {
    /// From contact-free motion of `model`, an [`super::observed_arm`].
    ///
    /// # Errors
    /// `BadInput` where a joint hardly moves.
    pub fn identify(model: &Model, training: &[ServoForceTelemetry]) -> Result<Self, BadInput> {
        let ([linear, _], drive) = identify(model, training)?;
        let (torque_constant, offset) = linear
            .motors
            .iter()
            .map(|motor| match *motor {
                MotorTorque::Current { torque_constant, offset } => (torque_constant, offset),
                MotorTorque::Pwm { .. } => (0.0, 0.0),
            })
            .unzip();
        let mut linear = LinearDrive { torque_constant, offset, noise: Vec::new() };
        let noise = |known: &FixedModel| -> Result<Vec<f64>, BadInput> {
            Ok(ForceEstimator::momentum(model, known, training)?.noise().to_vec())
        };
        linear.noise = noise(&linear.known())?;
        let drive = ServoDrive { noise: noise(&drive.known())?, ..drive };
        let mut observers = Self { linear, drive, contact: [f64::INFINITY; 2] };
        let mut lengths = [Vec::new(), Vec::new()];
        for one in training {
            for (lengths, forces) in lengths.iter_mut().zip(observers.forces(model, one)?) {
                lengths.extend(forces.iter().map(|f| f.iter().map(|x| x * x).sum::<f64>().sqrt()));
            }
        }
        observers.contact = lengths.map(|mut lengths| {
            lengths.sort_by(f64::total_cmp);
            let at = (QUANTILE * lengths.len() as f64) as usize;
            lengths.get(at.min(lengths.len().saturating_sub(1))).copied().unwrap_or(f64::INFINITY)
        });
        Ok(observers)
    }

    /// # Errors
    /// `BadInput` naming what is not for `n` joints or out of range.
    pub fn check(&self, n: usize) -> Result<(), BadInput> {
        let LinearDrive { torque_constant, offset, noise } = &self.linear;
        let columns = [
            ("torque_constant", torque_constant, f64::MIN),
            ("offset", offset, f64::MIN),
            ("noise", noise, f64::MIN_POSITIVE),
        ];
        for (name, values, least) in columns {
            if values.len() != n || values.iter().any(|value| !(*value >= least && value.is_finite())) {
                let expected = format!("{n} finite numbers in range");
                return Err(BadInput::new(format!("linear: {name}"), expected, format!("{values:?}")));
            }
        }
        self.drive.check(n).map_err(|bad| bad.within("drive"))
    }

    /// Forces of either along a trajectory [N].
    ///
    /// # Errors
    /// `BadInput` where the model has no tip.
    pub fn forces(
        &self,
        model: &Model,
        trajectory: &ServoForceTelemetry,
    ) -> Result<[Vec<[f64; 3]>; 2], BadInput> {
        let of =
            |known: FixedModel, noise: &[f64]| ForceEstimator::known(model, known, noise).forces(trajectory);
        Ok([of(self.linear.known(), &self.linear.noise)?, of(self.drive.known(), &self.drive.noise)?])
    }
}
