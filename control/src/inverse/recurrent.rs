//! Our controller: features of the path in, one cell update a sample, corrections of a static regression out.
//!
//! Trained by truncated back-propagation through whole trajectories, see [`SequenceTask`].

use std::ops::Range;

use hysteron_base::BadInput;
use hysteron_learn::{
    ChannelRange, Evaluation, FitResult, Network, Normaliser, SequenceOptions, SequenceTask, Sequences,
    TrainingSession, WeightFormat, mean,
};

use super::fit::{ControllerParts, FitOutcome, FittedController, StrokeDesign, run};
use super::loss::{Loss, LossWeights, TrajectoryArrays};
use super::path_point::PathPoint;
use super::recurrent_options::RecurrentOptions;
use super::smooth::{Smoothed, smoothed};
use super::training::{InverseOptions, InverseTraining, TrainedDesign};
use super::{
    Check, Dataset, Demonstration, FeatureSpec, Features, InverseDesign, StaticRegression, TipWorkspace,
};
use crate::Result;

impl RecurrentOptions {
    fn check(&self) -> Check<()> {
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

    fn features(&self, data: &Dataset, delay_s: f64) -> Check<FeatureSpec> {
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
    let base = RegressionBase::new(data, options)?;
    let (inputs, validation) = (&base.inputs, base.raw(&base.validation));
    let outputs = output_ranges(&data.training, &base.training)?;
    let gain: Vec<f32> = outputs.channels.iter().map(|c| (500.0 * (c.max - c.min)) as f32).collect();
    let loss = Loss::new(&options.loss, gain, data.step);
    let side = |all: &[Demonstration], raw: &[Raw]| Trajectories {
        rows: all.iter().zip(raw).map(|(one, raw)| raw.row(one, inputs, &outputs)).collect(),
        loss: &loss,
        n_inputs: inputs.channels.len(),
        noise: options.learning.input_noise as f32,
    };
    let sides = [side(&data.training, &base.training), side(&data.validation, &validation)];
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

/// The static regression alone, as a controller like the others: its network has one unit, and outputs without width.
///
/// # Errors
/// Options out of range, a tip that does not move.
pub fn fit_regression(data: &Dataset, options: &RecurrentOptions) -> Result<FittedController> {
    let base = RegressionBase::new(data, options)?;
    let nothing = |k: usize| ChannelRange { name: correction(k), min: 0.0, max: 0.0 };
    let outputs = Normaliser::new((0..data.n_tendons).map(nothing).collect())?;
    let smallest = SequenceOptions { hidden: 1, layers: 1, ..options.learning };
    let network =
        Network::new(&smallest.architecture(base.inputs.channels.len(), data.n_tendons), options.seed)?;
    let training =
        InverseTraining::of(TrainedDesign::Recurrent, InverseOptions::Recurrent(options.clone()), data);
    let [_, held_out_mm] = base.regressions_mm.clone();
    let validation = mean(&held_out_mm);
    let result = FitResult { model: network, epochs: 0, validation, curve: Vec::new(), is_finished: true };
    let parts = base.into_parts(outputs, WeightFormat::Float32);
    FitOutcome { result, held_out_mm }.into_fitted(data, training, parts)
}

/// The part of a controller below its network, and the data as it sees them.
struct RegressionBase {
    spec: FeatureSpec,
    regression: StaticRegression,
    training: Vec<Raw>,
    /// Smoothed paths of the validation.
    validation: Vec<Vec<PathPoint>>,
    inputs: Normaliser,
    workspace: TipWorkspace,
    /// See [`ControllerParts`].
    regressions_mm: [Vec<f64>; 2],
    delay_s: f64,
}

impl RegressionBase {
    fn new(data: &Dataset, options: &RecurrentOptions) -> Result<Self> {
        options.check()?;
        options.features(data, 0.0)?;
        let Smoothed {
            training,
            validation,
            delay_s,
            regression,
            regression_mm,
            without_delay_mm,
            workspace,
        } = smoothed(data, options.smoothing, options.half_width_s, options.largest_delay_s)?;
        let spec = options.features(data, delay_s)?;
        let training = raw(&training, &spec, &regression);
        let inputs = input_ranges(&training, &spec)?;
        let regressions_mm = [without_delay_mm, regression_mm];
        Ok(Self { spec, regression, training, validation, inputs, workspace, regressions_mm, delay_s })
    }

    fn raw(&self, paths: &[Vec<PathPoint>]) -> Vec<Raw> {
        raw(paths, &self.spec, &self.regression)
    }

    fn into_parts(self, outputs: Normaliser, weights: WeightFormat) -> ControllerParts {
        ControllerParts {
            inputs: self.inputs,
            outputs,
            design: InverseDesign::Recurrent { features: self.spec, regression: self.regression },
            workspace: self.workspace,
            weights,
            regressions_mm: self.regressions_mm,
            delay_s: self.delay_s,
        }
    }
}

fn raw(paths: &[Vec<PathPoint>], spec: &FeatureSpec, regression: &StaticRegression) -> Vec<Raw> {
    paths.iter().map(|path| Raw::new(path, spec, regression)).collect()
}

/// Name of the network's output for a tendon.
fn correction(tendon: usize) -> String {
    format!("correction_{}_m", tendon + 1)
}

/// A trajectory before it is normalised.
struct Raw {
    /// Features (n × inputs).
    features: Vec<f64>,
    /// Strokes of the static regression (n × n_tendons) [m].
    regression: Vec<f64>,
}

impl Raw {
    fn new(path: &[PathPoint], spec: &FeatureSpec, regression: &StaticRegression) -> Self {
        let mut raw = Self { features: Vec::new(), regression: vec![0.0; path.len() * spec.n_tendons] };
        let mut features = Features::new(spec);
        for (i, strokes) in raw.regression.chunks_exact_mut(spec.n_tendons).enumerate() {
            regression.strokes_into(path[i].position, strokes);
            features.append(path, i, strokes, &mut raw.features);
        }
        raw
    }

    fn row(&self, one: &Demonstration, inputs: &Normaliser, outputs: &Normaliser) -> TrajectoryArrays {
        let n_inputs = inputs.channels.len();
        let mut features = vec![0.0; self.features.len()];
        for (raw, out) in self.features.chunks_exact(n_inputs).zip(features.chunks_exact_mut(n_inputs)) {
            inputs.normalise_into(raw, out);
        }
        let middle = outputs.channels.iter().map(|c| 0.5 * (c.min + c.max)).cycle();
        let offset = self.regression.iter().zip(&one.strokes).zip(middle);
        let mean = |i: usize| one.strokes_at(i).iter().sum::<f64>() / one.n_tendons as f64;
        TrajectoryArrays {
            features,
            offset: offset
                .map(|((found, stroke), middle)| (1e3 * (found + middle - stroke)) as f32)
                .collect(),
            pull: (0..one.len()).map(|i| (1e3 * mean(i)) as f32).collect(),
            jacobian: one.jacobian.iter().map(|&j| j as f32).collect(),
            weight: one.gap.iter().map(|&gap| if gap { 0.0 } else { 1.0 }).collect(),
        }
    }
}

fn input_ranges(training: &[Raw], spec: &FeatureSpec) -> Check<Normaliser> {
    let names = spec.names();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    Normaliser::from_samples(&names, training.iter().flat_map(|raw| raw.features.chunks_exact(names.len())))
}

/// Ranges of the residuals of the static regression.
fn output_ranges(all: &[Demonstration], raw: &[Raw]) -> Check<Normaliser> {
    let n = all[0].n_tendons;
    let names: Vec<String> = (0..n).map(correction).collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let missing: Vec<f64> = all
        .iter()
        .zip(raw)
        .flat_map(|(one, raw)| one.strokes.iter().zip(&raw.regression).map(|(stroke, found)| stroke - found))
        .collect();
    // Strokes that the regression predicts exactly still need a range, so that the network can fit them.
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
