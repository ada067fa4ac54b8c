//! An arm as estimators find it: friction that gives way before it slides and drifts, encoders with steps, a motor constant that is
//! not quite right. It knows nothing of the estimators: forward dynamics by ABA, friction by its own bristles.

use hysteron_arm_dynamics::{
    Data, ExternalForce, Model, forward_dynamics, forward_kinematics, frame_jacobian, inverse_dynamics,
};

/// Size of steady friction at a speed, by direction [N m].
pub type Curve = Box<dyn Fn(f64) -> f64 + Send + Sync>;

/// Friction of one joint: bristles of LuGre's model whose steady state is a curve.
pub struct TrueFriction {
    /// Steady friction over speed, above 0.
    pub curve: Curve,
    /// Stiffness of the bristles [N m/rad].
    pub stiffness: f64,
    /// Their damping [N m s/rad].
    pub damping: f64,
    /// Factor of the whole, for drift [-].
    pub scale: f64,
    /// Share by which it varies with the angle [-].
    pub ripple: f64,
}

/// Imperfections of the measurements.
#[derive(Debug, Clone, Copy)]
pub struct Imperfections {
    /// Step of the encoders at the joint [rad].
    pub encoder_step: f64,
    /// Relative error of the torque constant: the drive reports this much too much [-].
    pub torque_error: f64,
    /// Standard deviation of the noise of the reported torques [N m].
    pub torque_noise: f64,
}

/// A path of joints: coordinates, speeds, accelerations at a time.
pub type Path<'a> = &'a (dyn Fn(f64) -> [Vec<f64>; 3] + Sync);

/// Feedback gains of a controller, added to the feedforward torques of the model.
#[derive(Debug, Clone)]
pub struct Controller {
    /// [N m/rad].
    pub stiffness: Vec<f64>,
    /// [N m s/rad].
    pub damping: Vec<f64>,
}

/// Forces that act on the arm at a time.
pub type Loading<'a> = &'a (dyn Fn(f64) -> Vec<ExternalForce<f64>> + Sync);

/// Measured and true signals, row by row (n_samples × n).
#[derive(Debug, Clone, Default)]
pub struct PlantTrial {
    /// [s].
    pub period: f64,
    /// Positions by the encoders [rad].
    pub position: Vec<f64>,
    /// Torques reported by the drives [N m].
    pub torque: Vec<f64>,
    /// True coordinates [rad].
    pub true_position: Vec<f64>,
    /// True speed [rad/s].
    pub true_velocity: Vec<f64>,
    /// External torque of the forces [N m].
    pub external: Vec<f64>,
}

/// An arm in motion.
pub struct Plant<'m> {
    model: &'m Model,
    /// Friction joint by joint.
    pub friction: Vec<TrueFriction>,
    /// Imperfections of the measurements.
    pub imperfections: Imperfections,
    /// Time between samples [s].
    pub period: f64,
    /// Parts of a sample.
    pub substeps: usize,
}

impl<'m> Plant<'m> {
    /// Of `model`, sampled every `period` [s].
    pub fn new(
        model: &'m Model,
        friction: Vec<TrueFriction>,
        imperfections: Imperfections,
        period: f64,
    ) -> Self {
        assert_eq!(model.n_joints(), friction.len());
        Self { model, friction, imperfections, period, substeps: 10 }
    }

    /// Follows `path` for `duration` [s] under `loading`. Noise comes from `noise`, standard normal numbers.
    pub fn run(
        &self,
        path: Path,
        controller: &Controller,
        loading: Loading,
        duration: f64,
        noise: &mut dyn FnMut() -> f64,
    ) -> PlantTrial {
        let n = self.model.n_joints();
        let (h, mut data) = (self.period / self.substeps as f64, Data::new(self.model, 0.0));
        let [mut q, mut dq, _] = path(0.0);
        let [mut ddq, mut drive, mut bristles, mut feed] = [0; 4].map(|_| vec![0.0; n]);
        let mut jacobian = vec![0.0; 6 * n];
        let mut trial = PlantTrial { period: self.period, ..PlantTrial::default() };
        let mut command = vec![0.0; n];
        for k in 0..(duration / self.period).round() as usize {
            let t = k as f64 * self.period;
            let forces = loading(t);
            self.measure(&mut trial, [&q, &dq, &command], noise);
            trial.external.extend(torques(self.model, &mut data, &q, &forces, &mut jacobian));
            let [want, speed, acceleration] = path(t);
            inverse_dynamics(self.model, &mut data, [&want, &speed, &acceleration], &[], &mut feed);
            let step = self.imperfections.encoder_step;
            for j in 0..n {
                let measured = if step > 0.0 { step * (q[j] / step).round() } else { q[j] };
                command[j] = feed[j]
                    + controller.stiffness[j] * (want[j] - measured)
                    + controller.damping[j] * (speed[j] - dq[j]);
            }
            for _ in 0..self.substeps {
                for j in 0..n {
                    drive[j] = command[j] - self.friction[j].step(&mut bristles[j], q[j], dq[j], h);
                }
                forward_dynamics(self.model, &mut data, [&q, &dq, &drive], &forces, &mut ddq);
                for j in 0..n {
                    dq[j] += h * ddq[j];
                    q[j] += h * dq[j];
                }
            }
        }
        trial
    }

    /// Adds a sample: torques of the drive since the last one, positions of the joints now.
    fn measure(&self, trial: &mut PlantTrial, [q, dq, command]: [&[f64]; 3], noise: &mut dyn FnMut() -> f64) {
        let Imperfections { encoder_step: step, torque_error, torque_noise } = self.imperfections;
        trial.position.extend(q.iter().map(|q| if step > 0.0 { step * (q / step).round() } else { *q }));
        trial.torque.extend(command.iter().map(|tau| tau * (1.0 + torque_error) + torque_noise * noise()));
        trial.true_position.extend(q);
        trial.true_velocity.extend(dq);
    }
}

impl TrueFriction {
    /// Torque against motion over the next `h` [s]; `z` is the deflection of the bristles [rad].
    fn step(&self, z: &mut f64, q: f64, dq: f64, h: f64) -> f64 {
        let bound = self.scale * (1.0 + self.ripple * (7.0 * q).sin()) * (self.curve)(dq);
        // dz/dt = v - σ |v| z / g, implicitly.
        let before = *z;
        *z = (before + h * dq) / (1.0 + h * self.stiffness * dq.abs() / bound);
        self.stiffness * *z + self.damping * (*z - before) / h
    }
}

/// Joint torques of `forces` at `q`.
fn torques(
    model: &Model,
    data: &mut Data<f64>,
    q: &[f64],
    forces: &[ExternalForce<f64>],
    jacobian: &mut [f64],
) -> Vec<f64> {
    let n = q.len();
    let mut sum = vec![0.0; n];
    forward_kinematics(model, data, q);
    for force in forces {
        frame_jacobian(model, data, force.frame, jacobian);
        for (i, component) in force.force.iter().chain(&force.torque).enumerate() {
            for j in 0..n {
                sum[j] += jacobian[n * i + j] * component;
            }
        }
    }
    sum
}
