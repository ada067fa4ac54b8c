//! Closed-loop rollout (eq. 11): the network drives the auxiliary tendons, the twin's tip goes back to the network.

use std::collections::VecDeque;

use hysteron_base::BadInput;
use hysteron_learn::Runner;

use super::{Design, Features, ResidualModel};
use crate::coreact::{Auxiliary, allowed_strokes};
use crate::model::{Target, Twin};
use crate::step::{StepReport, Stepper};
use crate::{Result, TwinState};

/// Part of a training range by which inputs may leave it before they count as extrapolation.
const MARGIN: f64 = 0.02;
/// How far outputs may leave [-1, 1], the range of training: what a network says far from its data is no reason to pull.
const LARGEST_OUTPUT: f64 = 1.25;

/// One sample of a rollout.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RolloutStep {
    /// Tip [m].
    pub tip: [f64; 3],
    /// True where an input of the network was outside its training range.
    pub is_extrapolating: bool,
    /// What the twin's step cost.
    pub report: StepReport,
}

/// Something that goes on by one sample when its primary strokes are given.
pub trait Plant {
    /// Goes on by one sample of primary strokes (n_primary) [m].
    ///
    /// # Errors
    /// Those of [`Stepper::step`].
    fn step(&mut self, primary: &[f64]) -> Result<RolloutStep>;

    /// Shape and tensions now.
    fn state(&self) -> &TwinState;

    /// See [`Stepper::tip_per_stroke`].
    fn tip_per_stroke(&mut self) -> Option<[Vec<f64>; 3]>;
}

/// A twin with its residual network.
#[derive(Debug, Clone)]
pub struct Rollout<'a> {
    twin: &'a Twin,
    auxiliary: &'a Auxiliary,
    model: &'a ResidualModel,
    runner: Runner,
    features: Option<Features>,
    /// Normalised inputs of the samples that a window reaches back to, oldest first.
    window: VecDeque<Vec<f32>>,
    stepper: Stepper,
    state: TwinState,
    /// Tip of the sample before [m].
    tip: [f64; 3],
    strokes: Vec<f64>,
    inputs: Vec<f64>,
    normalised: Vec<f32>,
    bounded: Vec<f32>,
    outputs: Vec<f64>,
    targets: Vec<Target>,
}

impl<'a> Rollout<'a> {
    /// Starts from rest.
    ///
    /// # Errors
    /// The model was trained for another robot or rate.
    pub fn new(
        twin: &'a Twin,
        auxiliary: &'a Auxiliary,
        model: &'a ResidualModel,
        step: f64,
    ) -> std::result::Result<Self, BadInput> {
        model.check(twin.n_primary, auxiliary.len(), step)?;
        let state = twin.rest();
        Ok(Self {
            tip: twin.tip_of(&state),
            runner: Runner::new(&model.network),
            features: match &model.design {
                Design::Stateful { features, .. } => Some(Features::new(features)),
                Design::Windowed { .. } => None,
            },
            window: VecDeque::new(),
            stepper: Stepper::new(twin),
            strokes: vec![0.0; auxiliary.len()],
            inputs: Vec::new(),
            normalised: vec![0.0; model.inputs.channels.len()],
            bounded: vec![0.0; model.outputs.channels.len()],
            outputs: vec![0.0; model.outputs.channels.len()],
            targets: Vec::new(),
            state,
            twin,
            auxiliary,
            model,
        })
    }

    /// Auxiliary strokes now (n_aux) [m].
    pub fn strokes(&self) -> &[f64] {
        &self.strokes
    }

    /// From normalised inputs to outputs.
    fn run_network(&mut self) {
        let largest = LARGEST_OUTPUT as f32;
        let outputs = match self.model.design {
            Design::Stateful { .. } => self.runner.step(&self.normalised),
            Design::Windowed { window } => {
                if self.window.is_empty() {
                    // Before the beginning there is nothing, which the paper pads with zeros.
                    self.window.extend(std::iter::repeat_n(vec![0.0; self.normalised.len()], window));
                }
                let mut oldest = self.window.pop_front().unwrap_or_default();
                oldest.copy_from_slice(&self.normalised);
                self.window.push_back(oldest);
                self.runner.reset();
                let (last, before) = (self.window.len() - 1, &self.window);
                for inputs in before.iter().take(last) {
                    self.runner.step(inputs);
                }
                self.runner.step(&before[last])
            }
        };
        for (kept, output) in self.bounded.iter_mut().zip(outputs) {
            *kept = output.clamp(-largest, largest);
        }
        self.model.outputs.restore_into(&self.bounded, &mut self.outputs);
    }
}

impl Plant for Rollout<'_> {
    fn step(&mut self, primary: &[f64]) -> Result<RolloutStep> {
        self.inputs.clear();
        let sees_tip = match (&self.model.design, &mut self.features) {
            (Design::Stateful { features: spec, .. }, Some(features)) => {
                features.append(primary, &mut self.inputs);
                spec.feedback
            }
            _ => {
                self.inputs.extend_from_slice(primary);
                true
            }
        };
        if sees_tip {
            self.inputs.extend_from_slice(&self.tip);
        }
        let is_extrapolating = self.model.inputs.is_outside(&self.inputs, MARGIN);
        self.model.inputs.normalise_into(&self.inputs, &mut self.normalised);
        self.run_network();
        let allowed = allowed_strokes(self.auxiliary, &self.strokes, self.model.step_s);
        match &self.model.design {
            Design::Stateful { decoder, .. } => {
                let [x, y, z] = self.outputs[..] else {
                    return Err(three_outputs(self.outputs.len()).into());
                };
                decoder.strokes_into([x, y, z], &mut self.strokes);
            }
            Design::Windowed { .. } => self.strokes.copy_from_slice(&self.outputs),
        }
        for (stroke, allowed) in self.strokes.iter_mut().zip(&allowed) {
            *stroke = allowed.clamp(*stroke);
        }
        self.auxiliary.targets_into(primary, &self.strokes, &mut self.targets);
        let report = self.stepper.step(self.twin, &self.targets, &mut self.state)?;
        self.tip = self.twin.tip_of(&self.state);
        Ok(RolloutStep { tip: self.tip, is_extrapolating, report })
    }

    fn state(&self) -> &TwinState {
        &self.state
    }

    fn tip_per_stroke(&mut self) -> Option<[Vec<f64>; 3]> {
        self.stepper.tip_per_stroke(self.twin, &self.state)
    }
}

/// A twin whose virtual tendons rest.
#[derive(Debug, Clone)]
pub struct Bare<'a> {
    twin: &'a Twin,
    resting: Vec<Target>,
    stepper: Stepper,
    state: TwinState,
    targets: Vec<Target>,
}

impl<'a> Bare<'a> {
    /// Starts from rest.
    pub fn new(twin: &'a Twin) -> Self {
        let resting = twin.tendons[twin.n_primary..].iter();
        let resting = resting.map(|tendon| Target::Tension(tendon.tension.clamp(0.0))).collect();
        Self { twin, resting, stepper: Stepper::new(twin), state: twin.rest(), targets: Vec::new() }
    }
}

impl Plant for Bare<'_> {
    fn step(&mut self, primary: &[f64]) -> Result<RolloutStep> {
        self.targets.clear();
        self.targets.extend(primary.iter().map(|stroke| Target::Stroke(*stroke)));
        self.targets.extend_from_slice(&self.resting);
        let report = self.stepper.step(self.twin, &self.targets, &mut self.state)?;
        Ok(RolloutStep { tip: self.twin.tip_of(&self.state), is_extrapolating: false, report })
    }

    fn state(&self) -> &TwinState {
        &self.state
    }

    fn tip_per_stroke(&mut self) -> Option<[Vec<f64>; 3]> {
        self.stepper.tip_per_stroke(self.twin, &self.state)
    }
}

fn three_outputs(found: usize) -> BadInput {
    BadInput::new("checkpoint: outputs", "3 channels", found.to_string())
}
