//! The estimators of table VI.

use hysteron_actuator::filter::LowPass;
use hysteron_base::BadInput;

use super::Telemetry;
use super::identify::{CUTOFF, Known};
use crate::Model;
use crate::observer::{
    Belief, DriveReading, InverseDynamics, MomentumObserver, Observer, RigidBody, TipForce, estimate,
};

/// Rows of the tables. The first says that there is no force.
pub const METHODS: [&str; 5] = ["no force", "ID-Linear", "ID-Friction", "GMO-linear", "GMO-drive"];
/// Tasks of table VI.
pub const TASKS: [&str; 7] = [
    "go_up_and_stay_still_200g",
    "go_up_and_stay_still_300g",
    "go_up_and_stay_still_400g",
    "pick_place_object_200g",
    "pick_place_object_300g",
    "pick_place_object_400g",
    "pick_place_object_500g",
];
/// Table VI of Dou et al.: ID-Linear, ID-Friction, GMO, and their network, task by task, and the mean as printed [N].
pub const PUBLISHED: [(&str, [f64; 8]); 4] = [
    ("ID-Linear", [1.37, 1.81, 2.30, 0.72, 0.95, 1.22, 1.47, 1.41]),
    ("ID-Friction", [1.06, 1.59, 2.15, 0.62, 0.82, 1.10, 1.31, 1.23]),
    ("GMO-linear", [0.58, 0.66, 1.23, 0.33, 0.47, 0.63, 0.75, 0.66]),
    ("NeuralActuator", [0.12, 0.20, 0.07, 0.24, 0.00, 0.19, 0.05, 0.12]),
];
/// K of the momentum observers [1/s]: a tenth of a second, six rows.
const GAIN: f64 = 10.0;
/// What is believed of a force before it is felt: the largest of the data set's pushes [N].
const BELIEF: f64 = 9.0;

/// One method, ready for trajectories.
pub(super) struct Method<'m> {
    model: &'m Model,
    kind: usize,
    known: Known,
    /// Standard deviation of the external torques without contact [N m].
    deviations: Vec<f64>,
}

impl<'m> Method<'m> {
    /// The method of this row of [`METHODS`], which learns its noise on the training trajectories.
    pub fn new(
        model: &'m Model,
        kind: usize,
        known: &Known,
        training: &[Telemetry],
    ) -> Result<Self, BadInput> {
        let n = model.n_joints();
        let mut method = Self { model, kind, known: known.clone(), deviations: vec![1.0; n] };
        let (mut squares, mut count) = (vec![0.0; n], 0.0);
        for trajectory in training {
            for row in method.torques(trajectory)?.chunks(n) {
                count += 1.0;
                squares.iter_mut().zip(row).for_each(|(sum, torque)| *sum += torque * torque);
            }
        }
        method.deviations = squares.iter().map(|sum| (sum / f64::max(count, 1.0)).sqrt().max(1e-3)).collect();
        Ok(method)
    }

    /// External joint torques, row by row (n_samples × n) [N m].
    fn torques(&self, trajectory: &Telemetry) -> Result<Vec<f64>, BadInput> {
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
        if self.kind >= 3 {
            // Momentum changes by the mean torque since the row before.
            for at in (n..torque.len()).rev() {
                torque[at] = 0.5 * (torque[at] + torque[at - n]);
            }
        }
        let mut observer: Box<dyn Observer> = if self.kind < 3 {
            let smoothing = LowPass::new(2, CUTOFF, trajectory.rate())?;
            Box::new(InverseDynamics::new(body, friction, smoothing))
        } else {
            Box::new(MomentumObserver::new(body, friction, &vec![GAIN; n]))
        };
        let states = [&trajectory.position[..], &trajectory.velocity, &torque];
        Ok(estimate(observer.as_mut(), &trajectory.periods, states))
    }

    /// Forces at the tip, row by row [N].
    pub fn forces(&self, trajectory: &Telemetry) -> Result<Vec<[f64; 3]>, BadInput> {
        if self.kind == 0 {
            return Ok(vec![[0.0; 3]; trajectory.n_samples()]);
        }
        let n = self.model.n_joints();
        let frame = self.model.frame("end_effector_link")?;
        let mut tip = TipForce::new(self.model, frame, &self.deviations, Belief::Force(BELIEF));
        let torques = self.torques(trajectory)?;
        let rows = trajectory.position.chunks(n).zip(torques.chunks(n));
        let force = |(q, torque): (&[f64], &[f64])| {
            tip.update(q, torque);
            [tip.force[0], tip.force[1], tip.force[2]]
        };
        Ok(rows.map(force).collect())
    }
}
