//! Closed-loop rollout (eq. 11): the network drives the auxiliary tendons, the twin's tip goes back to the network.

use std::borrow::Cow;

use hysteron_base::BadInput;
use hysteron_learn::{Predictor, WeightFormat};

use super::adaptation::terms_into;
use super::change::ChangedStrokes;
use super::decoder::Decoding;
use super::linear::mean_displacement;
use super::{Features, ResidualDesign, ResidualModel};
use crate::coreact::{
    AuxiliaryLimits, AuxiliaryPolicy, IdentifiedSample, TipMeasurement, allowed_strokes, distance,
    sensitivity,
};
use crate::friction_points::FrictionPoints;
use crate::model::{Target, Twin};
use crate::plant::{Plant, PlantStep};
use crate::stepper::Stepper;
use crate::{Result, TipResponse, TwinState};

/// A twin with its residual network.
#[derive(Debug, Clone)]
pub struct CorrectedRollout<'a> {
    /// With the friction that the robot has now.
    twin: Cow<'a, Twin>,
    auxiliary: &'a AuxiliaryLimits,
    model: &'a ResidualModel,
    predictor: Predictor<'a>,
    features: Option<Features>,
    stepper: Stepper,
    /// Tip of the sample before [m]: that of the body, and what is missing along z.
    tip: [f64; 3],
    strokes: Vec<f64>,
    inputs: Vec<f64>,
    outputs: Vec<f64>,
    targets: Vec<Target>,
    decoding: Decoding,
    /// Terms of the correction.
    terms: Vec<f64>,
    /// Where the robot has changed: what commanded strokes come to, and these [m].
    changed: Option<ChangedStrokes>,
    primary: Vec<f64>,
}

impl<'a> CorrectedRollout<'a> {
    /// Starts from rest.
    ///
    /// # Errors
    /// The model was trained for another robot or rate.
    pub fn new(
        twin: &'a Twin,
        auxiliary: &'a AuxiliaryLimits,
        model: &'a ResidualModel,
        step: f64,
    ) -> std::result::Result<Self, BadInput> {
        model.check(twin.n_primary, auxiliary.len(), step)?;
        let twin = match &model.change {
            Some(change) if change.friction_ratio != 1.0 => Cow::Owned(change.twin(twin)),
            _ => Cow::Borrowed(twin),
        };
        let ranges = [&model.inputs, &model.outputs];
        let (features, predictor) = match &model.design {
            ResidualDesign::Recurrent { features, .. } => {
                let predictor = Predictor::recurrent(&model.network, ranges, WeightFormat::Float32);
                (Some(Features::new(features)), predictor)
            }
            ResidualDesign::Windowed { window } => {
                (None, Predictor::windowed(&model.network, ranges, *window))
            }
        };
        Ok(Self {
            tip: twin.tip_of(&twin.rest()),
            predictor,
            features,
            stepper: Stepper::new(&twin),
            strokes: vec![0.0; auxiliary.len()],
            inputs: Vec::new(),
            outputs: vec![0.0; model.outputs.channels.len()],
            targets: Vec::new(),
            decoding: Decoding::new(auxiliary.len()),
            terms: Vec::new(),
            changed: model.change.as_ref().map(ChangedStrokes::new),
            primary: Vec::new(),
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

    /// Radius of the band about the tip in this sample [m], where recordings were left out in learning.
    fn tip_band(&self) -> Option<f64> {
        let band = self.model.training.tip_band?;
        let ResidualDesign::Recurrent { features, .. } = &self.model.design else { return None };
        let of_strokes = &self.predictor.normalised()[..features.n_of_strokes()];
        let farthest = of_strokes.iter().fold(1.0f32, |most, x| most.max(x.abs()));
        Some(band.radius(f64::from(farthest) - 1.0))
    }

    /// From outputs to auxiliary strokes, within their bounds and rate; gives what is missing along z [m].
    fn auxiliary_strokes(&mut self) -> Result<f64> {
        let allowed = allowed_strokes(self.auxiliary, &self.strokes, self.model.step_s);
        let mut along = 0.0;
        match &self.model.design {
            ResidualDesign::Recurrent { features, decoder, linear } => {
                let [x, y, z] = self.outputs[..] else {
                    return Err(three_outputs(self.outputs.len()).into());
                };
                let of_strokes = &self.predictor.normalised()[..features.n_of_strokes()];
                let [lx, ly, lz] = mean_displacement(linear, of_strokes, &mut self.terms);
                terms_into(features, &self.inputs, &mut self.terms);
                let [dx, dy, dz] =
                    self.model.adaptation.as_ref().map_or([0.0; 3], |of| of.displacement(&self.terms));
                let across = [x + lx + dx, y + ly + dy];
                decoder.strokes_into(&self.primary, across, &mut self.decoding, &mut self.strokes);
                along = z + lz + dz;
            }
            ResidualDesign::Windowed { .. } => self.strokes.copy_from_slice(&self.outputs),
        }
        for (stroke, allowed) in self.strokes.iter_mut().zip(&allowed) {
            *stroke = allowed.clamp(*stroke);
        }
        Ok(along)
    }
}

impl Plant for CorrectedRollout<'_> {
    fn step(&mut self, commanded: &[f64]) -> Result<PlantStep> {
        match &mut self.changed {
            Some(changed) => changed.follow_into(commanded, &mut self.primary),
            None => commanded.clone_into(&mut self.primary),
        }
        self.inputs.clear();
        let sees_tip = match (&self.model.design, &mut self.features) {
            (ResidualDesign::Recurrent { features: spec, .. }, Some(features)) => {
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
        let is_extrapolating = self.predictor.step(&self.inputs, &mut self.outputs);
        let along = self.auxiliary_strokes()?;
        self.auxiliary.targets_into(&self.primary, &self.strokes, &mut self.targets);
        let report = self.stepper.step(&self.twin, &self.targets)?;
        self.tip = self.twin.tip_of(self.stepper.state());
        self.tip[2] += along;
        Ok(PlantStep { tip: self.tip, is_extrapolating, tip_band: self.tip_band(), report })
    }

    fn state(&self) -> &TwinState {
        self.stepper.state()
    }

    fn tip_response(&mut self, friction: FrictionPoints) -> Option<TipResponse> {
        self.stepper.tip_response(&self.twin, friction)
    }
}

impl AuxiliaryPolicy for CorrectedRollout<'_> {
    fn step(
        &mut self,
        primary: &[f64],
        goal: Option<&TipMeasurement>,
        _duration: f64,
    ) -> Result<IdentifiedSample> {
        let step = Plant::step(self, primary)?;
        let distance = goal.map_or(0.0, |goal| distance(goal.position, step.tip));
        let tip = self.twin.tip_of(self.stepper.state());
        Ok(IdentifiedSample {
            tip,
            distance,
            statuses: Vec::new(),
            bounds: vec![None; self.strokes.len()],
            outside: step.report.outside,
        })
    }

    fn strokes(&self) -> &[f64] {
        &self.strokes
    }

    fn sensitivity(&mut self) -> Option<[Vec<f64>; 3]> {
        let Self { stepper, twin, auxiliary, .. } = self;
        sensitivity(stepper, twin, auxiliary, FrictionPoints::Slipping)
    }
}

fn three_outputs(found: usize) -> BadInput {
    BadInput::new("checkpoint: outputs", "3 channels", found.to_string())
}
