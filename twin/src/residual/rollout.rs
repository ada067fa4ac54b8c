//! Closed-loop rollout (eq. 11): the network drives the auxiliary tendons, the twin's tip goes back to the network.

use std::collections::VecDeque;

use hysteron_base::BadInput;
use hysteron_learn::Runner;

use super::adaptation::{Filter, terms_into};
use super::decoder::Decoding;
use super::{AdaptOptions, Design, Features, ResidualModel};
use crate::coreact::{
    Auxiliary, Chooser, FrictionPoints, Goal, Step, allowed_strokes, distance, sensitivity,
};
use crate::model::{Target, Twin};
use crate::plant::{Plant, PlantStep};
use crate::step::Stepper;
use crate::{Result, TwinState};

/// Part of a training range by which inputs may leave it before they count as extrapolation.
const MARGIN: f64 = 0.02;
/// How far outputs may leave [-1, 1], the range of training: what a network says far from its data is no reason to pull.
const LARGEST_OUTPUT: f64 = 1.25;

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
    /// What learns the correction, if anything does.
    filter: Option<Filter>,
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
        Ok(Self::at_rest(twin, auxiliary, model))
    }

    fn at_rest(twin: &'a Twin, auxiliary: &'a Auxiliary, model: &'a ResidualModel) -> Self {
        let state = twin.rest();
        Self {
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
            decoding: Decoding::new(auxiliary.len()),
            terms: Vec::new(),
            filter: None,
            state,
            twin,
            auxiliary,
            model,
        }
    }

    /// Back to rest; what was learned stays.
    pub fn restart(&mut self) {
        let filter = self.filter.take();
        *self = Self { filter, ..Self::at_rest(self.twin, self.auxiliary, self.model) };
    }

    /// Learns what to add to the correction of the network, which stays what it is meanwhile.
    ///
    /// # Errors
    /// The paper's design, which has none.
    pub fn adapt(&mut self, options: AdaptOptions) -> std::result::Result<(), BadInput> {
        let Design::Stateful { features, .. } = &self.model.design else {
            return Err(BadInput::new("checkpoint", "a stateful network", "the paper's design")
                .hint("only the stateful design has a correction that can learn"));
        };
        self.filter = Some(Filter::new(features, options));
        Ok(())
    }

    /// Learns from where the robot's tip was measured in this sample [m], if it is to learn.
    pub fn learn(&mut self, measured: [f64; 3]) {
        if let Some(filter) = &mut self.filter {
            filter.update(&self.terms, std::array::from_fn(|c| measured[c] - self.tip[c]));
        }
    }

    /// The model with what has been learned.
    pub fn adapted(&self) -> ResidualModel {
        let before = self.model.adaptation.as_ref();
        let after = self.filter.as_ref().map(|filter| filter.added_to(before));
        ResidualModel { adaptation: after.or_else(|| before.cloned()), ..self.model.clone() }
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
    fn step(&mut self, primary: &[f64]) -> Result<PlantStep> {
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
        let mut along = 0.0;
        match &self.model.design {
            Design::Stateful { features, decoder, linear } => {
                let [x, y, z] = self.outputs[..] else {
                    return Err(three_outputs(self.outputs.len()).into());
                };
                let of_strokes = &self.normalised[..features.n_of_strokes()];
                let [lx, ly, lz] = linear.displacement(of_strokes, &mut self.terms);
                terms_into(features, &self.inputs, &mut self.terms);
                let [dx, dy, dz] =
                    self.model.adaptation.as_ref().map_or([0.0; 3], |of| of.displacement(&self.terms));
                let across = [x + lx + dx, y + ly + dy];
                decoder.strokes_into(primary, across, &mut self.decoding, &mut self.strokes);
                along = z + lz + dz;
            }
            Design::Windowed { .. } => self.strokes.copy_from_slice(&self.outputs),
        }
        for (stroke, allowed) in self.strokes.iter_mut().zip(&allowed) {
            *stroke = allowed.clamp(*stroke);
        }
        self.auxiliary.targets_into(primary, &self.strokes, &mut self.targets);
        let report = self.stepper.step(self.twin, &self.targets, &mut self.state)?;
        self.tip = self.twin.tip_of(&self.state);
        self.tip[2] += along;
        Ok(PlantStep { tip: self.tip, is_extrapolating, report })
    }

    fn state(&self) -> &TwinState {
        &self.state
    }

    fn tip_per_stroke(&mut self) -> Option<[Vec<f64>; 3]> {
        self.stepper.tip_per_stroke(self.twin, &self.state)
    }
}

impl Chooser for Rollout<'_> {
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
