//! Our controller: features of the path in, one cell update a sample, corrections of a static regression out.
//!
//! Trained by truncated back-propagation through whole trajectories, which run side by side, pieces of them in order,
//! with the memory handed on. The weights kept are a running mean.

use std::ops::Range;

use hysteron_base::{BadInput, rng};
use hysteron_learn::{
    Lesson, Network, Normaliser, Schedule, SequenceOptions, Sequences, Session, Sum, Training, WeightFormat,
    mean,
};
use rand::RngExt;
use serde::{Deserialize, Serialize};
use serde_json::json;

use super::fit::{Fitted, Parts, Strokes, identity, run};
use super::loss::{Loss, LossWeights, Row, Sums};
use super::smooth::{PathPoint, Smoothed, Smoothing, smoothed};
use super::{Check, Dataset, Demonstration, Design, FeatureSpec, Features, StaticRegression};
use crate::{Error, Result};

/// How to train.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct StatefulOptions {
    /// What it has in common with other trainings on whole trajectories.
    #[serde(flatten)]
    pub learning: SequenceOptions,
    /// Which samples positions and rates come from.
    pub smoothing: Smoothing,
    /// Half the time that they span [s].
    pub half_width_s: f64,
    /// How far ahead the path is seen [s]; with [`Smoothing::Causal`] and none, a path need not be known in advance.
    pub horizons_s: Vec<f64>,
    /// Speed at which the direction counts about half [m/s].
    pub slow_m_s: f64,
    /// Plays as parts of the largest stroke.
    pub plays: Vec<f64>,
    /// Time constants of lags [s].
    pub lags_s: Vec<f64>,
    /// Weights of the terms of the loss.
    pub loss: LossWeights,
    /// Largest delay of the tip behind its strokes that is sought [s]; none is where it is zero, as for a path that
    /// is not known in advance.
    pub largest_delay_s: f64,
    /// What the weights are kept as where the controller commands.
    pub weights: WeightFormat,
    /// Seed of weights and noise.
    pub seed: u64,
}

impl Default for StatefulOptions {
    fn default() -> Self {
        Self {
            learning: SequenceOptions {
                hidden: 128,
                layers: 1,
                epochs: 30,
                patience: 40,
                piece: 200,
                learning_rate: 2e-3,
                input_noise: 0.3,
                renewed: 0.005,
            },
            smoothing: Smoothing::Centred,
            half_width_s: 0.1,
            horizons_s: vec![0.1, 0.2, 0.4],
            slow_m_s: 1e-3,
            plays: vec![0.02, 0.05, 0.12, 0.3, 0.6],
            lags_s: vec![0.3, 3.0, 30.0],
            loss: LossWeights { tip: 1.0, smooth_s: 0.1, pull: 1.0, co_contraction_min_m: 0.0 },
            largest_delay_s: 0.5,
            weights: WeightFormat::Float32,
            seed: 1,
        }
    }
}

impl StatefulOptions {
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
            lags_s: self.lags_s.clone(),
            delay_s,
        };
        spec.check()?;
        Ok(spec)
    }
}

/// Trains, see [`StatefulOptions`].
///
/// # Errors
/// Options out of range, a tip that does not move, a file to go on from that belongs to another training, training that
/// leaves finite numbers.
pub fn fit_stateful(data: &Dataset, options: &StatefulOptions, session: &mut Session<'_>) -> Result<Fitted> {
    options.check()?;
    options.features(data, 0.0)?;
    let Smoothed { training, validation, delay_s, regression, regression_mm, without_delay_mm, workspace } =
        smoothed(data, options.smoothing, options.half_width_s, options.largest_delay_s)?;
    let spec = options.features(data, delay_s)?;
    let seen: Vec<Raw> = training.iter().map(|path| Raw::new(path, &spec, &regression)).collect();
    let unseen: Vec<Raw> = validation.iter().map(|path| Raw::new(path, &spec, &regression)).collect();
    let inputs = input_ranges(&seen, &spec)?;
    let outputs = output_ranges(&data.training, &seen)?;
    let rows = |all: &[Demonstration], raw: &[Raw]| -> Vec<Row> {
        all.iter().zip(raw).map(|(one, raw)| raw.row(one, &inputs, &outputs)).collect()
    };
    let gain: Vec<f32> = outputs.channels.iter().map(|c| (500.0 * (c.max - c.min)) as f32).collect();
    let mut lesson = Trajectories {
        options,
        seen: rows(&data.training, &seen),
        unseen: rows(&data.validation, &unseen),
        loss: Loss::new(&options.loss, gain, data.step),
        n_inputs: inputs.channels.len(),
    };
    let architecture = options.learning.architecture(lesson.n_inputs, data.n_tendons);
    let n_rows = data.training.len().max(data.validation.len());
    architecture.check_training([options.learning.piece, n_rows], 1)?;
    let network = Network::new(&architecture, options.seed)?;
    let training = identity("stateful", json!(options), data);
    let outcome = run(&mut lesson, network, options.seed, &training, session)?;
    let parts = Parts {
        inputs,
        outputs,
        design: Design::Stateful { features: spec, regression },
        workspace,
        weights: options.weights,
        regressions_mm: [without_delay_mm, regression_mm],
        delay_s,
    };
    outcome.into_fitted(data, training, parts)
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

    fn row(&self, one: &Demonstration, inputs: &Normaliser, outputs: &Normaliser) -> Row {
        let n_inputs = inputs.channels.len();
        let mut features = vec![0.0; self.features.len()];
        for (raw, out) in self.features.chunks_exact(n_inputs).zip(features.chunks_exact_mut(n_inputs)) {
            inputs.normalise_into(raw, out);
        }
        let middle = outputs.channels.iter().map(|c| 0.5 * (c.min + c.max)).cycle();
        let offset = self.regression.iter().zip(&one.strokes).zip(middle);
        let mean = |i: usize| one.strokes_at(i).iter().sum::<f64>() / one.n_tendons as f64;
        Row {
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

fn input_ranges(seen: &[Raw], spec: &FeatureSpec) -> Check<Normaliser> {
    let names = spec.names();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    Normaliser::from_samples(&names, seen.iter().flat_map(|raw| raw.features.chunks_exact(names.len())))
}

/// Ranges of what the static regression misses.
fn output_ranges(all: &[Demonstration], seen: &[Raw]) -> Check<Normaliser> {
    let n = all[0].n_tendons;
    let names: Vec<String> = (1..=n).map(|k| format!("correction_{k}_m")).collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let missing: Vec<f64> = all
        .iter()
        .zip(seen)
        .flat_map(|(one, raw)| one.strokes.iter().zip(&raw.regression).map(|(stroke, found)| stroke - found))
        .collect();
    // Strokes that the regression finds exactly still need a range to be learned in.
    Normaliser::from_samples(&names, missing.chunks_exact(n))?.widened(1e-6)
}

struct Trajectories<'a> {
    options: &'a StatefulOptions,
    seen: Vec<Row>,
    unseen: Vec<Row>,
    loss: Loss,
    n_inputs: usize,
}

/// Rows on their way through a network.
struct Walk<'a> {
    rows: &'a [Row],
    loss: &'a Loss,
    n_inputs: usize,
    /// Added to normalised inputs.
    noise: &'a mut dyn FnMut() -> f32,
    /// Sums of the squared errors of each stroke so far [mm²].
    squares: Vec<f64>,
}

impl Trajectories<'_> {
    fn walk<'a>(&'a self, rows: &'a [Row], noise: &'a mut dyn FnMut() -> f32) -> Walk<'a> {
        let squares = vec![0.0; self.loss.gain.len()];
        Walk { rows, loss: &self.loss, n_inputs: self.n_inputs, noise, squares }
    }
}

impl Sequences for Walk<'_> {
    fn rows(&self) -> usize {
        self.rows.len()
    }

    fn longest(&self) -> usize {
        self.rows.iter().map(Row::len).max().unwrap_or(0)
    }

    fn inputs(&mut self, samples: Range<usize>) -> Vec<f32> {
        let n = self.n_inputs;
        let mut inputs = Vec::with_capacity(samples.len() * self.rows.len() * n);
        for i in samples {
            for row in self.rows {
                let i = i.min(row.len() - 1);
                inputs.extend(row.features[i * n..(i + 1) * n].iter().map(|value| value + (self.noise)()));
            }
        }
        inputs
    }

    fn judge(&mut self, start: usize, outputs: &[f32], gradient: Option<&mut [f32]>) -> Sum {
        let mut unasked = vec![0.0; if gradient.is_some() { 0 } else { outputs.len() }];
        let Sums { loss, squares, count } =
            self.loss.evaluate(self.rows, start, outputs, gradient.unwrap_or(&mut unasked));
        self.squares.iter_mut().zip(&squares).for_each(|(sum, square)| *sum += square);
        Sum { loss, count }
    }
}

impl Lesson for Trajectories<'_> {
    type Error = Error;

    fn schedule(&self) -> Schedule {
        self.options.learning.schedule()
    }

    fn train(
        &mut self,
        training: &mut Training,
        epoch: usize,
        on_step: &mut dyn FnMut(usize, usize) -> bool,
    ) -> Result<Option<f64>> {
        let mut stream = rng(self.options.seed, &format!("inverse/noise/{epoch}"));
        let width = self.options.learning.input_noise as f32;
        let mut noise = || width * (stream.random::<f32>() - 0.5);
        let mut walk = self.walk(&self.seen, &mut noise);
        Ok(training.train_sequences(&mut walk, self.options.learning.piece, on_step)?)
    }

    fn validate(&mut self, training: &Training) -> Result<f64> {
        Ok(mean(&self.squares(training)?).sqrt())
    }
}

impl Strokes for Trajectories<'_> {
    fn squares(&self, training: &Training) -> Result<Vec<f64>> {
        let mut still = || 0.0;
        let mut walk = self.walk(&self.unseen, &mut still);
        let sum = training.judge_sequences(&mut walk, self.options.learning.piece)?;
        Ok(walk.squares.into_iter().map(|square| square / f64::max(sum.count, 1.0)).collect())
    }
}
