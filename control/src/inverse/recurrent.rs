//! Our controller: features of the path in, one cell update a sample, corrections of a static regression out.
//!
//! Trained by truncated back-propagation through whole trajectories, see [`SequenceTask`].

use std::ops::Range;

use hysteron_base::BadInput;
use hysteron_learn::{
    ChannelRange, Evaluation, FitResult, Network, Normaliser, SequenceOptions, SequenceTask, Sequences,
    TrainingSession, WeightFormat, mean,
};

use super::base::{FittedBase, Raw};
use super::fit::{FitOutcome, FittedController, StrokeDesign, run};
use super::loss::{Loss, LossWeights, TrajectoryArrays};
use super::recurrent_options::RecurrentOptions;
use super::training::{InverseOptions, InverseTraining, TrainedDesign};
use super::{Check, Dataset, Demonstration, FeatureSpec};
use crate::Result;

impl RecurrentOptions {
    pub(super) fn check(&self) -> Check<()> {
        self.learning.check()?;
        let LossWeights { tip, smooth_s, pull, co_contraction_min_m } = self.loss;
        let late = ("largest_delay_s", self.largest_delay_s);
        let weights = [
            ("tip", tip),
            ("smooth_s", smooth_s),
            ("pull", pull),
            ("co_contraction_min_m", co_contraction_min_m),
            late,
        ];
        match weights.into_iter().find(|(_, weight)| !(*weight >= 0.0 && weight.is_finite())) {
            Some((name, weight)) => Err(BadInput::new(name, "a finite number >= 0", weight.to_string())),
            None => Ok(()),
        }
    }

    pub(super) fn features(&self, data: &Dataset, delay_s: f64) -> Check<FeatureSpec> {
        let largest =
            data.training.iter().flat_map(|one| &one.strokes).fold(0.0f64, |max, s| max.max(s.abs()));
        let spec = FeatureSpec {
            axes: data.axes,
            step_s: data.step,
            n_tendons: data.n_tendons,
            smoothing: self.smoothing,
            half_width_s: self.half_width_s,
            horizons_s: self.horizons_s.clone(),
            slow_m_s: self.slow_m_s,
            plays_m: self.plays.iter().map(|part| part * largest).collect(),
            filters_s: self.filters_s.clone(),
            delay_s,
        };
        spec.check()?;
        Ok(spec)
    }
}

/// Trains, see [`RecurrentOptions`].
///
/// # Errors
/// Options out of range, a tip that does not move, a file of another training, training that
/// leaves finite numbers.
pub fn fit_recurrent(
    data: &Dataset,
    options: &RecurrentOptions,
    session: &mut TrainingSession<'_>,
) -> Result<FittedController> {
    let base = FittedBase::new(data, options)?;
    let inputs = &base.inputs;
    let outputs = output_ranges(&data.training, &base.training)?;
    let gain: Vec<f32> = outputs.channels.iter().map(|c| (500.0 * (c.max - c.min)) as f32).collect();
    let loss = Loss::new(&options.loss, gain, data.step);
    let side = |all: &[Demonstration], raw: &[Raw]| Trajectories {
        rows: all.iter().zip(raw).map(|(one, raw)| raw.row(one, inputs, &outputs)).collect(),
        loss: &loss,
        n_inputs: inputs.channels.len(),
        noise: options.learning.input_noise as f32,
    };
    let sides = [side(&data.training, &base.training), side(&data.validation, &base.validation)];
    let architecture = options.learning.architecture(inputs.channels.len(), data.n_tendons);
    let n_rows = data.training.len().max(data.validation.len());
    architecture.check_training([options.learning.truncation, n_rows], 1)?;
    let network = Network::new(&architecture, options.seed)?;
    let mut task = SequenceTask::new(&options.learning, &network, (options.seed, "inverse/noise"), sides)?;
    let training =
        InverseTraining::of(TrainedDesign::Recurrent, InverseOptions::Recurrent(options.clone()), data);
    let outcome = run(&mut task, network, &training, session)?;
    outcome.into_fitted(data, training, base.into_parts(outputs, options.weights))
}

/// The map below the network alone, as a controller like the others: its network has one unit, and outputs without width.
///
/// # Errors
/// Options out of range, a tip that does not move.
pub fn fit_base(data: &Dataset, options: &RecurrentOptions) -> Result<FittedController> {
    let base = FittedBase::new(data, options)?;
    let nothing = |k: usize| ChannelRange { name: correction(k), min: 0.0, max: 0.0 };
    let outputs = Normaliser::new((0..data.n_tendons).map(nothing).collect())?;
    let smallest = SequenceOptions { hidden: 1, layers: 1, ..options.learning };
    let network =
        Network::new(&smallest.architecture(base.inputs.channels.len(), data.n_tendons), options.seed)?;
    let training =
        InverseTraining::of(TrainedDesign::Recurrent, InverseOptions::Recurrent(options.clone()), data);
    let held_out_mm = base.errors_mm.clone();
    let validation = mean(&held_out_mm);
    let result = FitResult { model: network, epochs: 0, validation, curve: Vec::new(), is_finished: true };
    let parts = base.into_parts(outputs, WeightFormat::Float32);
    FitOutcome { result, held_out_mm }.into_fitted(data, training, parts)
}

/// Name of the network's output for a tendon.
fn correction(tendon: usize) -> String {
    format!("correction_{}_m", tendon + 1)
}

/// Ranges of what the map below leaves.
fn output_ranges(all: &[Demonstration], raw: &[Raw]) -> Check<Normaliser> {
    let n = all[0].n_tendons;
    let names: Vec<String> = (0..n).map(correction).collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let missing: Vec<f64> = all
        .iter()
        .zip(raw)
        .flat_map(|(one, raw)| one.strokes.iter().zip(&raw.strokes).map(|(stroke, found)| stroke - found))
        .collect();
    // Strokes that the map predicts exactly still need a range, so that the network can fit them.
    Normaliser::from_samples(&names, missing.chunks_exact(n))?.widened(1e-6)
}

/// Trajectories side by side.
struct Trajectories<'a> {
    rows: Vec<TrajectoryArrays>,
    loss: &'a Loss,
    n_inputs: usize,
    /// Width of the noise on normalised inputs.
    noise: f32,
}

impl Sequences for Trajectories<'_> {
    fn rows(&self) -> usize {
        self.rows.len()
    }

    fn longest(&self) -> usize {
        self.rows.iter().map(TrajectoryArrays::len).max().unwrap_or(0)
    }

    fn inputs(&mut self, samples: Range<usize>, noise: &mut dyn FnMut() -> f32) -> Vec<f32> {
        let n = self.n_inputs;
        let mut inputs = Vec::with_capacity(samples.len() * self.rows.len() * n);
        for i in samples {
            for row in &self.rows {
                let i = i.min(row.len() - 1);
                inputs.extend(
                    row.features[i * n..(i + 1) * n].iter().map(|value| value + self.noise * noise()),
                );
            }
        }
        inputs
    }

    fn evaluate(&mut self, start: usize, outputs: &[f32], gradient: Option<&mut [f32]>) -> Evaluation {
        let mut unasked = vec![0.0; if gradient.is_some() { 0 } else { outputs.len() }];
        self.loss.evaluate(&self.rows, start, outputs, gradient.unwrap_or(&mut unasked))
    }

    /// Of the strokes, and of the tip where its Jacobian is known [mm].
    fn error(&self, all: &Evaluation) -> f64 {
        let squares = all.mean_squares();
        let (tip, strokes) = squares.split_last().unwrap_or((&0.0, &[]));
        (mean(strokes) + tip).sqrt()
    }
}

impl StrokeDesign for SequenceTask<'_, Trajectories<'_>> {
    fn squares(&mut self, network: &Network) -> hysteron_learn::Result<Vec<f64>> {
        let mut squares = self.evaluate(network)?.mean_squares();
        // Behind those of the strokes comes the tip's.
        squares.pop();
        Ok(squares)
    }
}
