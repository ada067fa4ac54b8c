//! Strokes for a path: the recurrent design sample by sample, the paper's window by window.

use hysteron_base::BadInput;
use hysteron_learn::{
    Backprop, HeadOutputs, Memory, Predictor, RANGE_MARGIN, RadialBasis, SequenceBatch, restore_bounded,
    windows,
};

use super::delay::ahead;
use super::model::check_limits;
use super::path_point::{PathPoint, smooth};
use super::windowed::normalised_path;
use super::{Check, FeatureSpec, Features, InverseDesign, InverseModel, StaticRegression, TipPosition};
use crate::{Result, StrokeLimits};

/// Windows that go through the network side by side.
const BATCH: usize = 256;

/// Flags of a sample: extrapolation and limits.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SampleFlags {
    /// True where the path leaves the training range.
    pub is_extrapolating: bool,
    /// True where a limit held a stroke.
    pub is_limited: bool,
}

/// Strokes for a whole path.
#[derive(Debug, Clone, PartialEq)]
pub struct Commands {
    /// Strokes (n_samples × n_tendons) [m].
    pub strokes: Vec<f64>,
    /// Flags of each sample (n_samples).
    pub steps: Vec<SampleFlags>,
}

/// The recurrent design on a path, one cell update a sample.
#[derive(Debug, Clone)]
pub struct InverseController<'a> {
    model: &'a InverseModel,
    regression: &'a StaticRegression,
    kernel: Option<&'a RadialBasis>,
    features: Features,
    predictor: Predictor<'a>,
    path: Vec<PathPoint>,
    limiter: Limiter,
    /// Samples done.
    n_done: usize,
    raw: Vec<f64>,
    /// Of the kernel.
    terms: Vec<f64>,
    correction: Vec<f64>,
}

impl<'a> InverseController<'a> {
    /// At the beginning of a path [m], with nothing remembered.
    ///
    /// # Errors
    /// A path without samples or with one that is not finite; limits that leave nothing; a model of the paper's design.
    pub fn new(model: &'a InverseModel, path: &[TipPosition], limits: StrokeLimits) -> Check<Self> {
        let InverseDesign::Recurrent { features, regression, kernel } = &model.design else {
            return Err(BadInput::new("checkpoint: design", "recurrent", "the paper's"));
        };
        let ranges = [&model.inputs, &model.outputs];
        Ok(Self {
            model,
            regression,
            kernel: kernel.as_deref(),
            terms: Vec::with_capacity(kernel.as_ref().map_or(0, |kernel| kernel.n_terms())),
            path: smoothed_path(path, features)?,
            features: Features::new(features),
            predictor: Predictor::recurrent(&model.network, ranges, model.weights),
            limiter: Limiter::new(limits, model)?,
            n_done: 0,
            raw: Vec::with_capacity(model.inputs.channels.len()),
            correction: vec![0.0; model.n_tendons],
        })
    }

    /// Strokes of the last step (n_tendons) [m].
    pub fn strokes(&self) -> &[f64] {
        &self.limiter.strokes
    }

    /// One sample further; none at the end of the path. Does not allocate.
    pub fn step(&mut self) -> Option<SampleFlags> {
        let point = self.path.get(self.n_done)?;
        self.regression.strokes_into(point.position, &mut self.limiter.desired);
        self.raw.clear();
        self.features.append(&self.path, self.n_done, &self.limiter.desired, &mut self.raw);
        if let Some(kernel) = self.kernel {
            kernel.add_to(&self.raw, &mut self.terms, &mut self.limiter.desired);
        }
        let is_new = self.predictor.step(&self.raw, &mut self.correction);
        let is_extrapolating = is_outside(self.model, point.position) || is_new;
        for (stroke, correction) in self.limiter.desired.iter_mut().zip(&self.correction) {
            *stroke += correction;
        }
        let is_limited = self.limiter.apply(self.n_done == 0);
        self.n_done += 1;
        Some(SampleFlags { is_extrapolating, is_limited })
    }
}

fn is_outside(model: &InverseModel, point: TipPosition) -> bool {
    model.workspace.is_outside(point, RANGE_MARGIN * model.workspace.width())
}

fn smoothed_path(path: &[TipPosition], spec: &FeatureSpec) -> Check<Vec<PathPoint>> {
    check_path(path)?;
    let half = (spec.half_width_s / spec.step_s).round() as usize;
    let smoothed = smooth(path, &vec![false; path.len()], spec.step_s, spec.smoothing, half);
    Ok(ahead(&smoothed, spec.delay_s / spec.step_s))
}

fn check_path(path: &[TipPosition]) -> Check<()> {
    if path.is_empty() {
        return Err(BadInput::new("target", "at least one sample", "none"));
    }
    match path.iter().position(|point| !point.iter().all(|v| v.is_finite())) {
        Some(i) => {
            Err(BadInput::new(format!("target: sample {i}"), "finite positions", format!("{:?}", path[i])))
        }
        None => Ok(()),
    }
}

/// Keeps strokes within their range, and their changes within their rate.
#[derive(Debug, Clone)]
struct Limiter {
    limits: StrokeLimits,
    /// Largest change in a sample [m].
    largest_change: f64,
    /// Asked for (n_tendons) [m].
    desired: Vec<f64>,
    /// Allowed (n_tendons) [m].
    strokes: Vec<f64>,
}

impl Limiter {
    fn new(limits: StrokeLimits, model: &InverseModel) -> Check<Self> {
        check_limits(&limits)?;
        let zeros = vec![0.0; model.n_tendons];
        let largest_change = limits.stroke_rate * model.step_s;
        Ok(Self { limits, largest_change, desired: zeros.clone(), strokes: zeros })
    }

    /// Moves as far towards the requested strokes as allowed; the first sample may begin anywhere in the
    /// range. True where a limit held a stroke.
    fn apply(&mut self, is_first: bool) -> bool {
        let mut is_limited = false;
        let largest = if is_first { f64::INFINITY } else { self.largest_change };
        for (stroke, &desired) in self.strokes.iter_mut().zip(&self.desired) {
            let within = desired.clamp(self.limits.stroke.min, self.limits.stroke.max);
            let allowed = within.clamp(*stroke - largest, *stroke + largest);
            is_limited |= allowed != desired;
            *stroke = allowed;
        }
        is_limited
    }
}

impl InverseModel {
    /// Strokes for a path at the rate of the training [m]. `progress` gets the samples done and ends it where it
    /// returns false: the result is then shorter.
    ///
    /// # Errors
    /// Those of [`InverseController::new`], but for the design.
    pub fn command(
        &self,
        path: &[TipPosition],
        limits: StrokeLimits,
        progress: &mut dyn FnMut(usize) -> bool,
    ) -> Result<Commands> {
        match self.design {
            InverseDesign::Recurrent { .. } => {
                let mut controller = InverseController::new(self, path, limits)?;
                let mut commands = Commands { strokes: Vec::new(), steps: Vec::new() };
                while let Some(step) = controller.step() {
                    commands.strokes.extend(controller.strokes());
                    commands.steps.push(step);
                    if !progress(commands.steps.len()) {
                        break;
                    }
                }
                Ok(commands)
            }
            InverseDesign::Windowed { window } => self.command_windows(path, window, limits, progress),
        }
    }

    fn command_windows(
        &self,
        path: &[TipPosition],
        window: usize,
        limits: StrokeLimits,
        progress: &mut dyn FnMut(usize) -> bool,
    ) -> Result<Commands> {
        check_path(path)?;
        let mut limiter = Limiter::new(limits, self)?;
        let passes = Backprop::new(self.network.architecture(), 0)?;
        let network = passes.place(&self.network)?;
        let normalised = normalised_path(path, &self.inputs);
        let mut commands = Commands { strokes: Vec::new(), steps: Vec::new() };
        let mut bounded = vec![0.0; self.n_tendons];
        for start in (0..path.len()).step_by(BATCH) {
            let ends = start..(start + BATCH).min(path.len());
            let inputs = windows(ends.clone().map(|end| (&normalised[..], end)), window, self.axes().len());
            let batch = SequenceBatch {
                inputs: &inputs,
                steps: window,
                rows: ends.len(),
                outputs: HeadOutputs::Last,
            };
            let mut memory = Memory::zeros(self.network.architecture(), ends.len());
            let outputs = network.predict(&batch, &mut memory)?;
            for (i, outputs) in ends.zip(outputs.chunks_exact(self.n_tendons)) {
                restore_bounded(&self.outputs, outputs, &mut bounded, &mut limiter.desired);
                let is_limited = limiter.apply(i == 0);
                let is_extrapolating = is_outside(self, path[i])
                    || self.inputs.is_outside(&path[i][..self.axes().len()], RANGE_MARGIN);
                commands.strokes.extend(&limiter.strokes);
                commands.steps.push(SampleFlags { is_extrapolating, is_limited });
            }
            if !progress(commands.steps.len()) {
                break;
            }
        }
        Ok(commands)
    }
}
