//! Closed-loop rollout (eq. 11): the network drives the auxiliary tendons, the twin's tip goes back to the network.

use std::borrow::Cow;
use std::collections::VecDeque;

use hysteron_base::BadInput;
use hysteron_learn::Runner;

use super::adaptation::terms_into;
use super::change::ChangedStrokes;
use super::decoder::Decoding;
use super::linear::mean_displacement;
use super::{Design, Features, ResidualModel};
use crate::coreact::{
    Auxiliary, AuxiliaryPolicy, FrictionPoints, Goal, Step, allowed_strokes, distance, sensitivity,
};
use crate::model::{Target, Twin};
use crate::plant::{Plant, PlantStep};
use crate::step::Stepper;
use crate::{Result, TwinState};

/// Part of a training range by which inputs may leave it before they count as extrapolation.
const MARGIN: f64 = 0.02;
/// How far outputs may leave [-1, 1], the range of training: what a network says far from its data is no reason to
/// pull.
const LARGEST_OUTPUT: f64 = 1.25;

/// A twin with its residual network.
#[derive(Debug, Clone)]
pub struct Rollout<'a> {
    /// With the friction that the robot has now.
    twin: Cow<'a, Twin>,
    auxiliary: &'a Auxiliary,
    model: &'a ResidualModel,
    runner: Runner,
    features: Option<Features>,
    /// Normalised inputs of the samples that a window reaches back to, oldest first.
    window: VecDeque<Vec<f32>>,
    stepper: Stepper,
    state: TwinState,
    /// Tip of the sample before [m]: that of the body, and what is missing along z.
    tip: [f64; 3],
    strokes: Vec<f64>,
    inputs: Vec<f64>,
    normalised: Vec<f32>,
    bounded: Vec<f32>,
    outputs: Vec<f64>,
    targets: Vec<Target>,
    decoding: Decoding,
    /// Terms of the correction.
    terms: Vec<f64>,
    /// Where the robot has changed: what commanded strokes come to, and these [m].
    changed: Option<ChangedStrokes>,
    primary: Vec<f64>,
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
        let twin = match &model.change {
            Some(change) if change.friction_ratio != 1.0 => Cow::Owned(change.twin(twin)),
            _ => Cow::Borrowed(twin),
        };
        let state = twin.rest();
        Ok(Self {
            tip: twin.tip_of(&state),
            runner: Runner::new(&model.network),
            features: match &model.design {
                Design::Stateful { features, .. } => Some(Features::new(features)),
                Design::Windowed { .. } => None,
            },
            window: VecDeque::new(),
            stepper: Stepper::new(&twin),
            strokes: vec![0.0; auxiliary.len()],
            inputs: Vec::new(),
            normalised: vec![0.0; model.inputs.channels.len()],
            bounded: vec![0.0; model.outputs.channels.len()],
            outputs: vec![0.0; model.outputs.channels.len()],
            targets: Vec::new(),
            decoding: Decoding::new(auxiliary.len()),
            terms: Vec::new(),
            changed: model.change.as_ref().map(ChangedStrokes::new),
            primary: Vec::new(),
            state,
            twin,
            auxiliary,
            model,
        })
    }

    /// Terms of the linear correction in this sample; none of the paper's design.
    pub(super) fn terms(&self) -> &[f64] {
        &self.terms
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

    /// From outputs to auxiliary strokes, within their bounds and rate; gives what is missing along z [m].
    fn auxiliary_strokes(&mut self) -> Result<f64> {
        let allowed = allowed_strokes(self.auxiliary, &self.strokes, self.model.step_s);
        let mut along = 0.0;
        match &self.model.design {
            Design::Stateful { features, decoder, linear } => {
                let [x, y, z] = self.outputs[..] else {
                    return Err(three_outputs(self.outputs.len()).into());
                };
                let of_strokes = &self.normalised[..features.n_of_strokes()];
                let [lx, ly, lz] = mean_displacement(linear, of_strokes, &mut self.terms);
                terms_into(features, &self.inputs, &mut self.terms);
                let [dx, dy, dz] =
                    self.model.adaptation.as_ref().map_or([0.0; 3], |of| of.displacement(&self.terms));
                let across = [x + lx + dx, y + ly + dy];
                decoder.strokes_into(&self.primary, across, &mut self.decoding, &mut self.strokes);
                along = z + lz + dz;
            }
            Design::Windowed { .. } => self.strokes.copy_from_slice(&self.outputs),
        }
        for (stroke, allowed) in self.strokes.iter_mut().zip(&allowed) {
            *stroke = allowed.clamp(*stroke);
        }
        Ok(along)
    }
}

impl Plant for Rollout<'_> {
    fn step(&mut self, commanded: &[f64]) -> Result<PlantStep> {
        match &mut self.changed {
            Some(changed) => changed.follow_into(commanded, &mut self.primary),
            None => commanded.clone_into(&mut self.primary),
        }
        self.inputs.clear();
        let sees_tip = match (&self.model.design, &mut self.features) {
            (Design::Stateful { features: spec, .. }, Some(features)) => {
                features.append(&self.primary, &mut self.inputs);
                spec.feedback
            }
            _ => {
                self.inputs.extend_from_slice(&self.primary);
                true
            }
        };
        if sees_tip {
            self.inputs.extend_from_slice(&self.tip);
        }
        let is_extrapolating = self.model.inputs.is_outside(&self.inputs, MARGIN);
        self.model.inputs.normalise_into(&self.inputs, &mut self.normalised);
        self.run_network();
        let along = self.auxiliary_strokes()?;
        self.auxiliary.targets_into(&self.primary, &self.strokes, &mut self.targets);
        let report = self.stepper.step(&self.twin, &self.targets, &mut self.state)?;
        self.tip = self.twin.tip_of(&self.state);
        self.tip[2] += along;
        Ok(PlantStep { tip: self.tip, is_extrapolating, report })
    }

    fn state(&self) -> &TwinState {
        &self.state
    }

    fn tip_per_stroke(&mut self) -> Option<[Vec<f64>; 3]> {
        self.stepper.tip_per_stroke(&self.twin, &self.state)
    }
}

impl AuxiliaryPolicy for Rollout<'_> {
    fn step(&mut self, primary: &[f64], goal: Option<&Goal>, _duration: f64) -> Result<Step> {
        let reported = Plant::step(self, primary)?.tip;
        let distance = goal.map_or(0.0, |goal| distance(goal.position, reported));
        let tip = self.twin.tip_of(&self.state);
        Ok(Step { tip, distance, statuses: Vec::new(), bounds: vec![None; self.strokes.len()] })
    }

    fn strokes(&self) -> &[f64] {
        &self.strokes
    }

    fn sensitivity(&mut self) -> Option<[Vec<f64>; 3]> {
        let Self { stepper, twin, auxiliary, state, .. } = self;
        sensitivity(stepper, twin, auxiliary, state, FrictionPoints::Slipping)
    }
}

fn three_outputs(found: usize) -> BadInput {
    BadInput::new("checkpoint: outputs", "3 channels", found.to_string())
}
