//! `LiveEstimator`: torques, force, contact and condition from the telemetry of servos, one sample after the other as they come.
//!
//! It holds both networks: that in the loop gives the torques at measured states, that of `sensing` the rest. A recording and a bus go
//! through the same object.

use hysteron_base::BadInput;
use hysteron_learn::{TransformerRunner, WeightFormat};

use super::actuator::NeuralActuator;
use super::data::gain_ratio;
use super::features::{FeatureLayout, InputScale};
use super::loss::Heads;
use super::sensing::{ContactEstimate, SensingRunner};
use super::simulation::SimulationOptions;
use hysteron_arm_dynamics::Model;

/// Measurements of an arm's servos at one instant: the joints in their order, then the gripper's motor (m
/// each), SI.
#[derive(Debug, Clone, Copy)]
pub struct ServoTelemetry<'a> {
    /// Where they were sent [rad].
    pub goal: &'a [f64],
    /// Positions [rad].
    pub position: &'a [f64],
    /// Speeds [rad/s].
    pub velocity: &'a [f64],
    /// Currents [A].
    pub current: &'a [f64],
    /// Supply voltages [V].
    pub voltage: &'a [f64],
    /// Temperatures [°C].
    pub temperature: &'a [f64],
    /// Parts of the supply's voltage on the motors, -1 to 1 [-].
    pub pwm: &'a [f64],
    /// Where the jaws were sent [m]; not read without a gripper.
    pub goal_aperture: f64,
}

/// A trained actuator that estimates sample by sample.
#[derive(Debug, Clone)]
pub struct LiveEstimator<'m> {
    features: FeatureLayout,
    scale: InputScale,
    simulation: SimulationOptions,
    /// Gain of the servos' position loops over that which the stiffness holds for.
    gain: f64,
    network: TransformerRunner,
    sensing: SensingRunner<'m>,
    inputs: Vec<f64>,
    state: Vec<f64>,
    voltage: Vec<f64>,
    token: Vec<f32>,
    torque: Vec<f64>,
    /// Winding and case of every motor [°C]; nothing before the first sample.
    heat: Vec<[f64; 2]>,
}

impl<'m> LiveEstimator<'m> {
    /// Of `model`, the arm that [`NeuralActuator::observed_arm`] gives. It has seen no sample yet.
    ///
    /// # Errors
    /// `BadInput` where the actuator has no network for measured states, or the model no tip.
    pub fn new(actuator: &NeuralActuator, model: &'m Model) -> Result<Self, BadInput> {
        let features = actuator.features;
        let sensing = actuator.sensing.as_ref().ok_or_else(|| {
            BadInput::new("actuator", "one that was trained with --sensing observer", "--sensing loop").hint(
                "the network in the loop estimates force and condition only in a simulation: hysteron arm evaluate",
            )
        })?;
        let zeros = |n: usize| vec![0.0; n];
        Ok(Self {
            network: TransformerRunner::new(&actuator.network, WeightFormat::Float32),
            sensing: SensingRunner::new(sensing, model, (&features, actuator.simulation.period))?,
            scale: actuator.scale.clone(),
            simulation: actuator.simulation.clone(),
            gain: 1.0,
            inputs: zeros(features.len()),
            state: zeros(features.state()),
            voltage: zeros(features.joints),
            token: vec![0.0; features.len()],
            torque: zeros(features.motors()),
            heat: Vec::with_capacity(features.motors()),
            features,
        })
    }

    /// Of servos whose position loops have this gain, as the register has it; that of the training where it is none.
    ///
    /// # Errors
    /// `BadInput` without a gain where a drive is in the loop.
    pub fn with_position_gain(self, position_gain: Option<f64>) -> Result<Self, BadInput> {
        self.simulation.check_gain("recording", position_gain)?;
        let known = self.simulation.position_gain();
        Ok(Self { gain: gain_ratio(position_gain, known), ..self })
    }

    /// Takes a sample as servos report it.
    ///
    /// # Panics
    /// Where it has another number of motors.
    pub fn update(&mut self, sample: &ServoTelemetry<'_>) -> ContactEstimate {
        let (m, n) = (self.features.motors(), self.features.joints);
        self.state[..m].copy_from_slice(sample.position);
        self.state[m..].copy_from_slice(sample.velocity);
        let [goal, current, voltage] = [sample.goal, sample.current, sample.voltage];
        let series = [goal, &self.state, current, voltage, sample.temperature];
        self.features.gather(series, sample.goal_aperture, &mut self.inputs);
        for (k, to) in self.voltage.iter_mut().enumerate().take(n) {
            *to = sample.voltage[k] * sample.pwm[k];
        }
        let own = [&mut self.inputs, &mut self.state, &mut self.voltage].map(std::mem::take);
        let now = self.update_inputs([&own[0], &own[1], &own[2]]);
        [self.inputs, self.state, self.voltage] = own;
        now
    }

    /// Takes a sample as [`FeatureLayout::gather`] orders it, with its state, and voltages on the motors of the joints (n) [V].
    pub fn update_inputs(&mut self, [inputs, state, voltage]: [&[f64]; 3]) -> ContactEstimate {
        for (k, (to, x)) in self.token.iter_mut().zip(inputs).enumerate() {
            *to = self.scale.at(k, *x).0 as f32;
        }
        let m = self.features.motors();
        self.warm(inputs, state);
        let outputs = &self.network.step(&self.token)[Heads::TORQUE..];
        for (k, (torque, y)) in self.torque.iter_mut().zip(outputs).enumerate() {
            let limit = self.simulation.torque_limits[usize::from(k >= self.features.joints)];
            *torque = limit * (f64::from(*y) / limit).tanh();
            if let Some(drive_model) = self.simulation.drive_model() {
                let at = [state[k], state[m + k]];
                let (own, _) = drive_model.torque(k, (inputs[k], self.gain), at, self.heat[k][0]);
                *torque = drive_model.left_by_friction(k, (*torque + own).clamp(-limit, limit), at[1]);
            }
        }
        self.sensing.update([inputs, state, voltage])
    }

    /// Windings and cases of drives in the loop since the last sample; at the temperature of the first sample at the beginning.
    fn warm(&mut self, inputs: &[f64], state: &[f64]) {
        let (m, first) = (self.features.motors(), self.features.temperatures());
        if self.heat.is_empty() {
            self.heat.extend(inputs[first..][..m].iter().map(|temperature| [*temperature; 2]));
        }
        let Some(one) = &self.simulation.drive else { return };
        for (k, now) in self.heat.iter_mut().enumerate() {
            let off = [inputs[k] - state[k], state[m + k]];
            *now = one.drive.warmed_by_following(self.gain, off, *now, self.simulation.period);
        }
    }

    /// Torques of all motors at the last sample (m) [N m], as the network in the loop gives them: those that move the simulated arm, with
    /// its armature and damping, as the sample moves.
    pub fn torque(&self) -> &[f64] {
        &self.torque
    }
}
