//! `Sensing`: force on the tip, contact and condition of a motor from telemetry, by a network next to a
//! momentum observer.
//!
//! The published network estimates them within the simulation's loop. Here the inputs of a second network are measurements and the observer's force:
//! it learns what the observer leaves, in the weights of its own.

use std::collections::VecDeque;

use hysteron_base::BadInput;
use hysteron_learn::{
    TemporalForm, Transformer, TransformerRunner, TransformerShape, TransformerTape, WeightFormat,
};
use serde::{Deserialize, Serialize};

use super::data::Trajectory;
use super::features::{FeatureLayout, InputScale};
use super::loss::{Heads, sigmoid};
use super::observations::{IdentifiedArm, Observations, ObservedTrajectory, channels};
use hysteron_arm_dynamics::Model;

/// Force, contact and condition estimates of an arm, one per sample (n_samples).
#[derive(Debug, Clone, Default, PartialEq)]
pub struct SensedTrajectory {
    /// Force on the tip [N].
    pub force: Vec<[f64; 3]>,
    /// Probability of contact.
    pub gate: Vec<f64>,
    /// Probability that the watched motor is healthy.
    pub condition: Vec<f64>,
    /// Evidence for that, as [`ObservedTrajectory::evidence`].
    pub evidence: Vec<f64>,
}

/// The network of labels with what it needs.
#[derive(Debug, Clone)]
pub struct Sensing {
    /// The network, streaming.
    pub network: Transformer<f32>,
    /// How its inputs are scaled.
    pub scale: InputScale,
    /// Identified drives and healthy scatter of the arm.
    pub known: IdentifiedArm,
}

/// All but the parameters, as files have it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SensingHeader {
    pub shape: TransformerShape,
    scale: InputScale,
    known: IdentifiedArm,
}

impl SensingHeader {
    pub fn of(sensing: &Sensing) -> Self {
        Self {
            shape: sensing.network.shape().clone(),
            scale: sensing.scale.clone(),
            known: sensing.known.clone(),
        }
    }

    /// # Errors
    /// `BadInput` for sizes that do not belong together.
    pub fn check(&self, features: &FeatureLayout) -> Result<(), BadInput> {
        let n = channels(features);
        if self.shape.form != TemporalForm::Streaming {
            return Err(BadInput::new("shape.form", "streaming", "windows"));
        }
        self.shape.check()?;
        if self.shape.inputs != n || self.shape.heads != Heads::sizes(features) || !self.scale.is_for(n) {
            return Err(BadInput::new("shape", "sizes that belong together", "others"));
        }
        self.known.check(features.joints)
    }

    pub fn with(self, network: Transformer<f32>) -> Sensing {
        Sensing { network, scale: self.scale, known: self.known }
    }
}

/// Adds the estimates from outputs and the observer's force.
fn add(sensed: &mut SensedTrajectory, heads: &Heads, outputs: &[f64]) {
    sensed.force.push(heads.force_of(outputs));
    sensed.gate.push(sigmoid(outputs[heads.gate]));
    sensed.condition.push(sigmoid(outputs[heads.condition]));
}

impl Sensing {
    /// Force, contact and condition estimates along a trajectory; `model` is an arm as `observed_arm` gives
    /// it.
    ///
    /// # Errors
    /// `BadInput` where the recording has no PWM.
    pub fn along(
        &self,
        model: &Model,
        (features, period): (&FeatureLayout, f64),
        trajectory: &Trajectory,
    ) -> Result<SensedTrajectory, BadInput> {
        let observed = ObservedTrajectory::new(model, (features, &self.known, period), trajectory)?;
        let (heads, mut sensed) = (Heads::new(features), SensedTrajectory::default());
        let n = self.network.shape().outputs();
        outputs(&self.network, &self.scale, &observed)
            .chunks_exact(n)
            .for_each(|own| add(&mut sensed, &heads, own));
        sensed.evidence = observed.evidence;
        Ok(sensed)
    }
}

/// Outputs along an observed trajectory (rows × outputs), the observer's force added to the raw force.
pub(super) fn outputs(
    network: &Transformer<f32>,
    scale: &InputScale,
    observed: &ObservedTrajectory<'_>,
) -> Vec<f64> {
    let (shape, rows) = (network.shape(), observed.trajectory.len());
    let mut tape = TransformerTape::new(shape, rows, 1);
    let tokens: Vec<f32> = observed
        .rows
        .chunks_exact(shape.inputs)
        .flat_map(|row| row.iter().enumerate().map(|(k, x)| scale.at(k, *x).0 as f32))
        .collect();
    let found = tape.forward(network, 0..rows, &tokens);
    let mut all: Vec<f64> = found.iter().map(|y| f64::from(*y)).collect();
    for (row, outputs) in all.chunks_exact_mut(shape.outputs()).enumerate() {
        observed.complete(row, outputs);
    }
    all
}

/// Streaming estimator of force, contact and condition: one sample after the other as they come.
#[derive(Debug, Clone)]
pub struct SensingRunner<'m> {
    observations: Observations<'m>,
    runner: TransformerRunner,
    scale: InputScale,
    heads: Heads,
    channels: Vec<f64>,
    token: Vec<f32>,
    outputs: Vec<f64>,
    /// Health probabilities of the last samples, as many as a window of the condition has [-].
    recent: VecDeque<f64>,
}

/// Samples that the reported condition is the mean of.
const WINDOW: usize = 64;

/// Force, contact and condition estimates of an arm now.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactEstimate {
    /// Force on the tip [N].
    pub force: [f64; 3],
    /// Probability of contact.
    pub gate: f64,
    /// Probability that the watched motor is healthy, mean of the last 64 samples.
    pub condition: f64,
}

impl<'m> SensingRunner<'m> {
    /// For samples every `period` [s] of `model`, an arm as `observed_arm` gives it.
    ///
    /// # Errors
    /// `BadInput` where the model has no tip.
    pub fn new(
        sensing: &Sensing,
        model: &'m Model,
        (features, period): (&FeatureLayout, f64),
    ) -> Result<Self, BadInput> {
        let n = channels(features);
        Ok(Self {
            observations: Observations::new(model, (features, &sensing.known, period))?,
            runner: TransformerRunner::new(&sensing.network, WeightFormat::Float32),
            scale: sensing.scale.clone(),
            heads: Heads::new(features),
            channels: vec![0.0; n],
            token: vec![0.0; n],
            outputs: vec![0.0; sensing.network.shape().outputs()],
            recent: VecDeque::with_capacity(WINDOW),
        })
    }

    /// Takes a sample's inputs as [`FeatureLayout::gather`] orders them, its state, and voltages on the motors (n) [V].
    pub fn update(&mut self, sample: [&[f64]; 3]) -> ContactEstimate {
        let force = self.observations.next(sample, &mut self.channels);
        for (k, (to, x)) in self.token.iter_mut().zip(&self.channels).enumerate() {
            *to = self.scale.at(k, *x).0 as f32;
        }
        let outputs_of_step = self.runner.step(&self.token);
        self.outputs.iter_mut().zip(outputs_of_step).for_each(|(to, y)| *to = f64::from(*y));
        let base_frame = self.observations.base_frame();
        base_frame.add_force(&self.heads, (sample[1][0], &force), &mut self.outputs);
        let outputs = &self.outputs;
        if self.recent.len() == WINDOW {
            self.recent.pop_front();
        }
        self.recent.push_back(sigmoid(outputs[self.heads.condition]));
        let condition = self.recent.iter().sum::<f64>() / self.recent.len() as f64;
        ContactEstimate {
            force: self.heads.force_of(outputs),
            gate: sigmoid(outputs[self.heads.gate]),
            condition,
        }
    }
}
