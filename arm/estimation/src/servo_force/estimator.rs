//! External joint torques and force at the tip, trajectory by trajectory or sample by sample.

use hysteron_actuator::filter::LowPass;
use hysteron_base::BadInput;

use super::drive::FixedModel;
use super::identify::{CUTOFF, identify};
use super::{ServoDrive, ServoForceTelemetry, TIP};
use crate::observer::{
    ArmSample, ContactPrior, DriveReading, FilteredInverseDynamics, MomentumObserver, Observer, RigidBody,
    TipForceEstimator, estimate,
};
use hysteron_arm_dynamics::Model;

/// K of the momentum observers [1/s]: a tenth of a second, six rows.
pub const GAIN: f64 = 10.0;
/// Prior standard deviation of a force: the largest of the data set's pushes [N].
const BELIEF: f64 = 9.0;

/// Where external torques come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum TorqueSource {
    InverseDynamics,
    Momentum,
}

/// A classical estimator, ready for trajectories.
#[derive(Debug, Clone)]
pub struct ForceEstimator<'m> {
    model: &'m Model,
    kind: TorqueSource,
    known: FixedModel,
    /// Standard deviation of the external torques without contact [N m].
    noise: Vec<f64>,
}

/// ID-Linear, ID-Friction, GMO-linear and GMO-drive, identified on contact-free motion.
///
/// # Errors
/// `BadInput` where a joint hardly moves.
pub fn estimators<'m>(
    model: &'m Model,
    training: &[ServoForceTelemetry],
) -> Result<[ForceEstimator<'m>; 4], BadInput> {
    let ([linear, friction], drive) = identify(model, training)?;
    let of = |kind, known: &FixedModel| ForceEstimator::new(model, kind, known, training);
    Ok([
        of(TorqueSource::InverseDynamics, &linear)?,
        of(TorqueSource::InverseDynamics, &friction)?,
        of(TorqueSource::Momentum, &linear)?,
        of(TorqueSource::Momentum, &drive.known())?,
    ])
}

impl<'m> ForceEstimator<'m> {
    /// One which learns its noise on the training trajectories.
    fn new(
        model: &'m Model,
        kind: TorqueSource,
        known: &FixedModel,
        training: &[ServoForceTelemetry],
    ) -> Result<Self, BadInput> {
        let n = model.n_joints();
        let mut estimator = Self { model, kind, known: known.clone(), noise: vec![1.0; n] };
        let (mut squares, mut count) = (vec![0.0; n], 0.0);
        for trajectory in training {
            for row in estimator.torques(trajectory)?.chunks(n) {
                count += 1.0;
                squares.iter_mut().zip(row).for_each(|(sum, torque)| *sum += torque * torque);
            }
        }
        estimator.noise = squares.iter().map(|sum| (sum / f64::max(count, 1.0)).sqrt().max(1e-3)).collect();
        Ok(estimator)
    }

    /// A momentum observer which learns its noise on the training trajectories.
    pub(super) fn momentum(
        model: &'m Model,
        known: &FixedModel,
        training: &[ServoForceTelemetry],
    ) -> Result<Self, BadInput> {
        Self::new(model, TorqueSource::Momentum, known, training)
    }

    /// A momentum observer whose noise is known.
    pub(super) fn known(model: &'m Model, known: FixedModel, noise: &[f64]) -> Self {
        Self { model, kind: TorqueSource::Momentum, known, noise: noise.to_vec() }
    }

    /// Standard deviation of the external torques without contact [N m].
    pub(super) fn noise(&self) -> &[f64] {
        &self.noise
    }

    /// External joint torques, row by row (n_samples × n) [N m].
    fn torques(&self, trajectory: &ServoForceTelemetry) -> Result<Vec<f64>, BadInput> {
        let n = self.model.n_joints();
        let mut torque: Vec<f64> = (0..trajectory.position.len())
            .map(|at| {
                // The voltage on the motor is known as one number.
                let reading = DriveReading {
                    current: trajectory.current[at],
                    voltage: trajectory.voltage[at],
                    pwm: 1.0,
                    velocity: trajectory.velocity[at],
                };
                self.known.motors[at % n].at(&reading)
            })
            .collect();
        let body = RigidBody::new(self.model);
        let friction = self.known.friction.clone();
        let mut observer: Box<dyn Observer> = match self.kind {
            TorqueSource::InverseDynamics => {
                let smoothing = LowPass::new(2, CUTOFF, trajectory.rate())?;
                Box::new(FilteredInverseDynamics::new(body, friction, smoothing))
            }
            TorqueSource::Momentum => {
                // Momentum changes by the mean torque since the row before.
                for at in (n..torque.len()).rev() {
                    torque[at] = 0.5 * (torque[at] + torque[at - n]);
                }
                Box::new(MomentumObserver::new(body, friction, &vec![GAIN; n]))
            }
        };
        let states = [&trajectory.position[..], &trajectory.velocity, &torque];
        Ok(estimate(observer.as_mut(), &trajectory.periods, states))
    }

    /// Forces at the tip, row by row [N].
    ///
    /// # Errors
    /// `BadInput` where the model has no tip, or rows come too seldom for the filter.
    pub fn forces(&self, trajectory: &ServoForceTelemetry) -> Result<Vec<[f64; 3]>, BadInput> {
        let n = self.model.n_joints();
        let frame = self.model.frame(TIP)?;
        let mut tip = TipForceEstimator::new(self.model, frame, &self.noise, ContactPrior::Force(BELIEF));
        let torques = self.torques(trajectory)?;
        let rows = trajectory.position.chunks(n).zip(torques.chunks(n));
        let force = |(q, torque): (&[f64], &[f64])| {
            tip.update(q, torque);
            [tip.force[0], tip.force[1], tip.force[2]]
        };
        Ok(rows.map(force).collect())
    }
}

/// Momentum observer on a [`ServoDrive`] with the force at the tip, sample by sample.
#[derive(Debug, Clone)]
pub struct DriveObserver<'m> {
    observer: MomentumObserver<RigidBody<'m>>,
    tip: TipForceEstimator<'m>,
    known: FixedModel,
    period: f64,
    is_started: bool,
    /// Torques of the motors at the sample before, now, and their mean [N m].
    torque: [Vec<f64>; 3],
    /// External torques of the joints [N m].
    pub external: Vec<f64>,
}

impl<'m> DriveObserver<'m> {
    /// For samples every `period` [s] of `model`, an [`super::observed_arm`], with K = `gain` [1/s].
    ///
    /// # Errors
    /// `BadInput` where the model has no tip.
    pub fn new(model: &'m Model, drive: &ServoDrive, (period, gain): (f64, f64)) -> Result<Self, BadInput> {
        let (n, known) = (model.n_joints(), drive.known());
        let friction = known.friction.clone();
        Ok(Self {
            observer: MomentumObserver::new(RigidBody::new(model), friction, &vec![gain; n]),
            tip: tip_force(model, &drive.noise)?,
            known,
            period,
            is_started: false,
            torque: [(); 3].map(|()| vec![0.0; n]),
            external: vec![0.0; n],
        })
    }

    /// Takes positions [rad], speeds [rad/s] and voltages on the motors [V]; gives the force at the tip [N].
    pub fn update(&mut self, position: &[f64], velocity: &[f64], voltage: &[f64]) -> [f64; 3] {
        let [before, now, mean] = &mut self.torque;
        before.copy_from_slice(now);
        for (k, motor) in self.known.motors.iter().enumerate() {
            let reading = DriveReading { current: 0.0, voltage: voltage[k], pwm: 1.0, velocity: velocity[k] };
            now[k] = motor.at(&reading);
        }
        if !std::mem::replace(&mut self.is_started, true) {
            before.copy_from_slice(now);
        }
        for ((mean, now), before) in mean.iter_mut().zip(now.iter()).zip(before.iter()) {
            *mean = 0.5 * (now + before);
        }
        let sample = ArmSample { period: self.period, position, velocity, torque: mean };
        self.observer.update(&sample, &mut self.external);
        self.tip.update(position, &self.external);
        [self.tip.force[0], self.tip.force[1], self.tip.force[2]]
    }

    /// Torque of a unit force along each axis at a joint [m].
    pub fn lever(&self, joint: usize) -> [f64; 3] {
        [0, 1, 2].map(|axis| self.tip.lever(axis, joint))
    }

    /// Torque that friction of a joint was taken to have against positive motion [N m].
    pub fn friction(&self, joint: usize) -> f64 {
        self.observer.friction(joint)
    }

    /// Torque of a motor, mean since the sample before [N m].
    pub fn motor(&self, joint: usize) -> f64 {
        self.torque[2][joint]
    }
}

/// Force at the tip from external torques with these standard deviations [N m].
///
/// # Errors
/// `BadInput` where the model has no tip.
pub fn tip_force<'m>(model: &'m Model, noise: &[f64]) -> Result<TipForceEstimator<'m>, BadInput> {
    Ok(TipForceEstimator::new(model, model.frame(TIP)?, noise, ContactPrior::Force(BELIEF)))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)] // a test may stop where it stands

    use hysteron_base::json;

    use super::*;
    use crate::servo_force::{BaselineObservers, observed_arm};

    /// Waves of all joints under a drive without friction, sampled evenly.
    fn motion(n_samples: usize) -> ServoForceTelemetry {
        let (n, period) = (4, 0.017);
        let wave = |row: usize, k: usize| {
            let phase = (0.9 + 0.3 * k as f64) * period * row as f64;
            [0.4 * phase.sin(), 0.4 * (0.9 + 0.3 * k as f64) * phase.cos()]
        };
        let all = |of: &dyn Fn(usize, usize) -> f64| {
            (0..n_samples).flat_map(|row| (0..n).map(move |k| (row, k))).map(|(row, k)| of(row, k)).collect()
        };
        ServoForceTelemetry {
            n_joints: n,
            time: (0..n_samples).map(|row| period * row as f64).collect(),
            periods: vec![period; n_samples],
            position: all(&|row, k| wave(row, k)[0] - 0.3),
            velocity: all(&|row, k| wave(row, k)[1]),
            current: all(&|row, k| wave(row, k)[0]),
            voltage: all(&|row, k| 2.0 + 3.0 * wave(row, k)[0] + wave(row, k)[1]),
            force: vec![[0.0; 3]; n_samples],
            is_labelled: vec![false; n_samples],
        }
    }

    #[test]
    fn a_drive_sample_by_sample_is_that_of_whole_trajectories_and_of_its_file() {
        let model = observed_arm(&Model::builtin("open-manipulator-x").unwrap(), 4).unwrap();
        let training = [motion(600)];
        let observers = BaselineObservers::identify(&model, &training).unwrap();
        let drive = observers.drive.clone();
        drive.check(4).unwrap();
        let read: ServoDrive = json::from_text(json::to_line(&drive).unwrap()).unwrap();
        assert_eq!(read, drive);
        let [_, _, linear, whole] = estimators(&model, &training).unwrap();
        let asked = motion(200);
        let forces = whole.forces(&asked).unwrap();
        let both = observers.forces(&model, &asked).unwrap();
        assert_eq!(both, [linear.forces(&asked).unwrap(), forces.clone()]);
        let mut observer = DriveObserver::new(&model, &read, (0.017, GAIN)).unwrap();
        for (row, expected) in forces.iter().enumerate() {
            let part = 4 * row..4 * row + 4;
            let [q, dq, volts] =
                [&asked.position, &asked.velocity, &asked.voltage].map(|of| &of[part.clone()]);
            assert_eq!(observer.update(q, dq, volts), *expected, "row {row}");
        }
        assert!(forces.iter().flatten().any(|f| f.abs() > 0.1), "nothing to compare");
        let bad = ServoDrive { noise: vec![0.0; 4], ..drive }.check(4).unwrap_err().to_string();
        assert!(bad.contains("noise"), "{bad}");
    }
}
