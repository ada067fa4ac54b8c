//! Fits the stateful design: truncated back-propagation through whole trajectories, the loss at the tip.
//!
//! With the identified strokes s* the twin's tip was y*, so near them it is y* + G (s - s*) (G = ∂y/∂s). The loss is
//! the squared distance of that from the measured tip: what the network gets wrong counts by what it does, and no two
//! strokes that do the same are told apart. All trajectories run side by side, pieces of them in order, with the
//! memory handed on.

use hysteron_base::{BadInput, rng};
use hysteron_learn::{
    Adam, Architecture, Batch, Head, Learned, Lesson, Memory, Network, Normaliser, Outputs, Training,
    half_cosine,
};
use rand::RngExt;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use serde_json::json;

use super::decoder::Decoding;
use super::linear::Equation;
use super::sequence::{first_of_one_robot, names};
use super::{Decoder, Design, FeatureSpec, Features, Fitted, LinearPart, ResidualModel, Sequence, Sessions};
use crate::{Error, Result};

/// How to train.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct StatefulOptions {
    /// Hidden units of each layer.
    pub hidden: usize,
    /// LSTM layers.
    pub layers: usize,
    /// Most epochs.
    pub epochs: usize,
    /// Epochs without a better held-out error after which it ends.
    pub patience: usize,
    /// Samples of a piece: back-propagation goes no further.
    pub piece: usize,
    /// Step size of Adam at the start; it falls to a hundredth along half a cosine.
    pub learning_rate: f64,
    /// Width of the uniform noise on normalised inputs while training, against learning trajectories by heart.
    pub input_noise: f64,
    /// Plays as parts of the largest stroke.
    pub plays: Vec<f64>,
    /// Time constants of lags [s].
    pub lags_s: Vec<f64>,
    /// Whether the network sees the twin's tip.
    pub feedback: bool,
    /// Standard deviation of what is added to that tip while training [m], so that the loop forgets errors.
    pub feedback_noise_m: f64,
    /// Seed of weights and noise.
    pub seed: u64,
}

impl Default for StatefulOptions {
    fn default() -> Self {
        Self {
            hidden: 64,
            layers: 1,
            epochs: 100,
            patience: 40,
            piece: 200,
            learning_rate: 2e-3,
            input_noise: 1.0,
            plays: vec![0.01, 0.03, 0.08, 0.2, 0.5],
            lags_s: vec![0.3, 3.0, 30.0],
            feedback: false,
            feedback_noise_m: 2e-4,
            seed: 1,
        }
    }
}

/// A trajectory as arrays of the network.
#[derive(Clone)]
struct Prepared {
    /// Normalised features of the strokes (n × n_of_strokes).
    features: Vec<f32>,
    /// Tip where the network says nothing, y* - G s*, less the measured one (n) [mm].
    offset: Vec<[f32; 3]>,
    /// What the network's outputs add to that: G D over the outputs' ranges (n, 3 × 3) [mm].
    gain: Vec<[[f32; 3]; 3]>,
    /// 0 where the tip was filled in.
    weight: Vec<f32>,
    /// Measured tip, normalised (n).
    measured: Vec<[f32; 3]>,
    /// Normalised tip per millimetre, by axis.
    tip_scale: [f32; 3],
    /// What the network sees as the tip (n), normalised; of the sample before.
    feedback: Vec<[f32; 3]>,
}

/// Trains a network for each set of `held_out`, on all `sequences` but those, keeps its weights that do best on those
/// (indices into `sequences`), and gives one network that is the mean of all: what chance makes of one training, the
/// others take out. Networks are trained in parallel, each with a session of its own. What they have in common, decoder,
/// linear part and ranges, is fitted to all `sequences`: errors on those held out are to stop by, not to judge by.
///
/// # Errors
/// Sequences of different robots; a set of `held_out` without sequences, or with all of them; a file of another training;
/// training that leaves finite numbers, or that is ended before its first epoch is done.
pub fn fit_stateful(
    sequences: &[Sequence],
    held_out: &[Vec<usize>],
    scene_hash: &str,
    options: &StatefulOptions,
    sessions: &Sessions<'_>,
) -> Result<Fitted> {
    let first = first_of_one_robot(sequences, sequences)?;
    let decoder = match first.decoder.clone() {
        Some(decoder) => decoder,
        None => Decoder::fit(sequences)?,
    };
    let largest = sequences.iter().flat_map(|s| &s.strokes).fold(0.0f64, |max, stroke| max.max(stroke.abs()));
    let spec = FeatureSpec {
        n_primary: first.n_primary,
        plays_m: options.plays.iter().map(|part| part * largest).collect(),
        lags_s: options.lags_s.clone(),
        feedback: options.feedback,
        step_s: first.step,
    };
    let inputs = input_ranges(sequences, &spec)?;
    let seen: Vec<Seen> =
        sequences.par_iter().map(|sequence| Seen::new(sequence, &spec, &decoder, &inputs)).collect();
    let equations = seen.iter().flat_map(Seen::equations);
    let linear = LinearPart::fit(spec.n_primary, spec.n_of_strokes(), equations)?;
    let outputs = output_ranges(&seen, &linear)?;
    let prepared: Vec<Prepared> =
        seen.iter().map(|seen| prepare(seen, &spec, &linear, &inputs, &outputs)).collect();
    let listed =
        |indices: &[usize]| -> Vec<&str> { indices.iter().map(|&k| sequences[k].name.as_str()).collect() };
    let train = |(number, held_out): (usize, &Vec<usize>)| {
        let (unseen, seen): (Vec<usize>, Vec<usize>) =
            (0..prepared.len()).partition(|k| held_out.contains(k));
        if seen.is_empty() || unseen.is_empty() {
            let found = format!("{} and {}", seen.len(), unseen.len());
            return Err(BadInput::new("sequences to learn from and to stop by", "some of each", found).into());
        }
        let seed = rng(options.seed, &format!("residual/member/{number}")).random();
        let copies = |indices: &[usize]| indices.iter().map(|&k| prepared[k].clone()).collect();
        let (seen_ones, unseen_ones) = (copies(&seen), copies(&unseen));
        let mut lesson = Trajectories { options, spec: &spec, seed, seen: seen_ones, unseen: unseen_ones };
        let network = Network::new(&options.architecture(spec.len()), seed)?;
        let identity = json!({
            "scene": scene_hash, "options": options, "trained_on": listed(&seen), "held_out": listed(&unseen),
            "inputs": inputs.channels, "outputs": outputs.channels,
        });
        sessions.teach(number, &mut lesson, network, seed, &identity)
    };
    let members = held_out.par_iter().enumerate().map(train).collect::<Result<Vec<Learned>>>()?;
    let report = |(member, held_out): (&Learned, &Vec<usize>)| {
        let held_out = listed(held_out);
        json!({ "held_out": held_out, "held_out_rmse_mm": member.held_out, "epochs": member.epochs })
    };
    let reports: Vec<_> = members.iter().zip(held_out).map(report).collect();
    let is_finished = members.iter().all(|member| member.is_finished);
    let networks: Vec<Network> = members.into_iter().map(|member| member.network).collect();
    let model = ResidualModel {
        network: Network::mean_of(&networks)?,
        inputs,
        outputs,
        n_aux: first.auxiliary.len(),
        step_s: spec.step_s,
        design: Design::Stateful { features: spec, decoder, linear },
        scene_hash: scene_hash.to_owned(),
        adaptation: None,
        training: json!({ "options": options, "sequences": names(sequences), "members": reports }),
    };
    Ok(Fitted { model, is_finished })
}

impl StatefulOptions {
    fn architecture(&self, inputs: usize) -> Architecture {
        Architecture {
            inputs,
            hidden: self.hidden,
            layers: self.layers,
            outputs: 3,
            head: Head::Linear,
            dropout: 0.0,
        }
    }
}

fn input_ranges(sequences: &[Sequence], spec: &FeatureSpec) -> std::result::Result<Normaliser, BadInput> {
    let names = spec.names();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let mut samples = Vec::new();
    for sequence in sequences {
        let mut features = Features::new(spec);
        for i in 0..sequence.len() {
            features.append(sequence.strokes_at(i), &mut samples);
            if spec.feedback {
                samples.extend_from_slice(&sequence.measured[i]);
            }
        }
    }
    Normaliser::from_samples(&names, samples.chunks_exact(spec.len()))
}

/// Ranges of the tip displacement that is missing and that the linear part does not say.
fn output_ranges(seen: &[Seen], linear: &LinearPart) -> std::result::Result<Normaliser, BadInput> {
    let (mut samples, mut terms) = (Vec::new(), Vec::new());
    for seen in seen {
        for (i, (undone, gain)) in seen.undone.iter().zip(&seen.gain).enumerate() {
            let said = linear.displacement(seen.features_at(i), &mut terms);
            let done = |a: usize| (0..3).map(|c| gain[a][c] * said[c]).sum::<f64>();
            samples.extend((0..3).map(|a| -undone[a] - done(a)));
        }
    }
    let names = ["residual_x_m", "residual_y_m", "residual_z_m"];
    let ranges = Normaliser::from_samples(&names, samples.chunks_exact(3))?;
    // A millimetre is as much along every axis: in a range of its own, an axis of small displacements would be learned later,
    // and the training might end before. What never changed still needs a range to be learned in.
    let widest = ranges.channels.iter().map(|channel| channel.max - channel.min).fold(1e-6, f64::max);
    ranges.widened(widest)
}

/// A trajectory in the coordinates of the decoder.
struct Seen {
    /// Normalised features of the strokes (n × n_of_strokes).
    features: Vec<f32>,
    n_features: usize,
    /// Measured tip, normalised (n); zeros where the network does not see it.
    measured: Vec<[f32; 3]>,
    /// What a displacement does to the tip, G D (n, 3 × 3) [-].
    gain: Vec<[[f64; 3]; 3]>,
    /// Tip without auxiliary strokes, y* - G s*, less the measured one (n) [m].
    undone: Vec<[f64; 3]>,
    /// True where the tip was filled in.
    gap: Vec<bool>,
}

impl Seen {
    fn new(sequence: &Sequence, spec: &FeatureSpec, decoder: &Decoder, inputs: &Normaliser) -> Self {
        let (n, n_features) = (sequence.len(), spec.n_of_strokes());
        let mut features = Features::new(spec);
        let (mut row, mut normalised) = (Vec::new(), vec![0.0f32; spec.len()]);
        let mut scratch = Decoding::new(sequence.auxiliary.len());
        let mut seen = Self {
            features: Vec::with_capacity(n * n_features),
            n_features,
            measured: Vec::with_capacity(n),
            gain: Vec::with_capacity(n),
            undone: Vec::with_capacity(n),
            gap: sequence.gap.clone(),
        };
        for i in 0..n {
            row.clear();
            features.append(sequence.strokes_at(i), &mut row);
            if spec.feedback {
                row.extend_from_slice(&sequence.measured[i]);
            }
            inputs.normalise_into(&row, &mut normalised);
            seen.features.extend_from_slice(&normalised[..n_features]);
            let tip = &normalised[n_features..];
            seen.measured.push(std::array::from_fn(|c| tip.get(c).copied().unwrap_or(0.0)));
            let g = sequence.sensitivity_at(i);
            seen.gain.push(decoder.seen_by(&g, sequence.strokes_at(i), &mut scratch));
            seen.undone.push(std::array::from_fn(|a| {
                sequence.twin[i][a] - by(&g[a], sequence.auxiliary_at(i)) - sequence.measured[i][a]
            }));
        }
        seen
    }

    fn features_at(&self, sample: usize) -> &[f32] {
        &self.features[sample * self.n_features..(sample + 1) * self.n_features]
    }

    /// Some samples, for least squares.
    fn equations(&self) -> impl Iterator<Item = Equation<'_>> {
        let measured = (0..self.gap.len()).step_by(FITTED_EVERY).filter(|&i| !self.gap[i]);
        measured.map(|i| Equation {
            features: self.features_at(i),
            gain: self.gain[i],
            error: self.undone[i],
        })
    }
}

/// Samples of which least squares see one: neighbours say the same.
const FITTED_EVERY: usize = 5;

fn by(axis: &[f64], strokes: impl Iterator<Item = f64>) -> f64 {
    axis.iter().zip(strokes).map(|(g, stroke)| g * stroke).sum()
}

fn prepare(
    seen: &Seen,
    spec: &FeatureSpec,
    linear: &LinearPart,
    inputs: &Normaliser,
    outputs: &Normaliser,
) -> Prepared {
    let (n, mut terms) = (seen.gap.len(), Vec::new());
    let mut prepared = Prepared {
        features: seen.features.clone(),
        offset: Vec::with_capacity(n),
        gain: Vec::with_capacity(n),
        weight: seen.gap.iter().map(|gap| f32::from(u8::from(!gap))).collect(),
        measured: seen.measured.clone(),
        tip_scale: [0.0; 3],
        feedback: seen.measured.clone(),
    };
    if spec.feedback {
        for (scale, channel) in prepared.tip_scale.iter_mut().zip(&inputs.channels[spec.n_of_strokes()..]) {
            *scale = (2e-3 / (channel.max - channel.min).max(f64::MIN_POSITIVE)) as f32;
        }
    }
    for (i, gain) in seen.gain.iter().enumerate() {
        let said = linear.displacement(seen.features_at(i), &mut terms);
        // A normalised output o means min + (o + 1)/2 (max - min).
        let half = |c: usize| 0.5 * (outputs.channels[c].max - outputs.channels[c].min);
        let middle = |c: usize| outputs.channels[c].min + half(c);
        prepared.gain.push(gain.map(|row| std::array::from_fn(|c| (1e3 * row[c] * half(c)) as f32)));
        prepared.offset.push(std::array::from_fn(|a| {
            let constant: f64 = (0..3).map(|c| gain[a][c] * (said[c] + middle(c))).sum();
            (1e3 * (seen.undone[i][a] + constant)) as f32
        }));
    }
    prepared
}

/// Pieces of all trajectories side by side: inputs [step][row][channel].
fn piece_inputs(
    sequences: &[Prepared],
    spec: &FeatureSpec,
    start: usize,
    steps: usize,
    [input_noise, tip_noise]: [f32; 2],
    noise: &mut dyn FnMut() -> f32,
) -> Vec<f32> {
    let n_features = spec.n_of_strokes();
    let mut inputs = Vec::with_capacity(steps * sequences.len() * spec.len());
    for i in start..start + steps {
        for sequence in sequences {
            // After its end a trajectory stands still; its weight is zero there.
            let i = i.min(sequence.offset.len() - 1);
            let features = &sequence.features[i * n_features..(i + 1) * n_features];
            inputs.extend(features.iter().map(|value| value + input_noise * noise()));
            if spec.feedback {
                let tip = sequence.feedback[i.saturating_sub(1)];
                inputs.extend((0..3).map(|c| tip[c] + tip_noise * noise() * sequence.tip_scale[c]));
            }
        }
    }
    inputs
}

/// Squared errors at the tip [mm²] summed over a piece, with their number and, where asked for, the gradient of
/// their mean; leaves the tip of each sample in `feedback` for the next pass.
fn tip_errors(
    sequences: &mut [Prepared],
    start: usize,
    outputs: &[f32],
    mut gradient: Option<&mut [f32]>,
) -> (f64, f64) {
    let n_rows = sequences.len();
    let (mut sum, mut count) = (0.0, 0.0);
    for (k, output) in outputs.as_chunks::<3>().0.iter().enumerate() {
        let (i, row) = (start + k / n_rows, k % n_rows);
        let sequence = &mut sequences[row];
        if i >= sequence.offset.len() {
            continue;
        }
        let (gain, offset, weight) = (&sequence.gain[i], sequence.offset[i], sequence.weight[i]);
        let error: [f32; 3] =
            std::array::from_fn(|a| offset[a] + (0..3).map(|c| gain[a][c] * output[c]).sum::<f32>());
        sum += f64::from(weight * error.iter().map(|e| e * e).sum::<f32>());
        count += f64::from(weight);
        if let Some(gradient) = gradient.as_deref_mut() {
            for c in 0..3 {
                gradient[3 * k + c] = 2.0 * weight * (0..3).map(|a| gain[a][c] * error[a]).sum::<f32>();
            }
        }
        let measured = sequence.measured[i];
        sequence.feedback[i] = std::array::from_fn(|c| measured[c] + error[c] * sequence.tip_scale[c]);
    }
    if let Some(gradient) = gradient {
        let scale = 1.0 / f64::max(count, 1.0) as f32;
        gradient.iter_mut().for_each(|g| *g *= scale);
    }
    (sum, count)
}

/// Part of the running mean of the weights that each step renews: it reaches back over some epochs.
const AVERAGED: f32 = 0.005;

/// Whole trajectories side by side, for one network.
struct Trajectories<'a> {
    options: &'a StatefulOptions,
    spec: &'a FeatureSpec,
    seed: u64,
    seen: Vec<Prepared>,
    unseen: Vec<Prepared>,
}

/// First sample and number of samples of each piece.
fn pieces(sequences: &[Prepared], piece: usize) -> Vec<(usize, usize)> {
    let longest = sequences.iter().map(|sequence| sequence.offset.len()).max().unwrap_or(0);
    (0..longest).step_by(piece).map(|start| (start, piece.min(longest - start))).collect()
}

impl Lesson for Trajectories<'_> {
    type Error = Error;

    fn epochs(&self) -> usize {
        self.options.epochs
    }

    fn patience(&self) -> usize {
        self.options.patience
    }

    fn adam(&self, epoch: usize) -> Adam {
        let part = epoch as f64 / self.options.epochs as f64;
        Adam {
            learning_rate: self.options.learning_rate * half_cosine(part),
            clip_norm: Some(1.0),
            ..Adam::default()
        }
    }

    fn renewed(&self) -> Option<f32> {
        Some(AVERAGED)
    }

    /// The tip that the network sees is its own of the pass before (measured at first): once the weights settle, that is
    /// its own feedback.
    fn train(
        &mut self,
        training: &mut Training,
        epoch: usize,
        on_step: &mut dyn FnMut(usize, usize) -> bool,
    ) -> Result<Option<f64>> {
        let mut memory = Memory::zeros(training.network().architecture(), self.seen.len());
        let width = (1e3 * self.options.feedback_noise_m * 12f64.sqrt()) as f32;
        let widths = [self.options.input_noise as f32, width];
        let mut stream = rng(self.seed, &format!("residual/noise/{epoch}"));
        let mut noise = || stream.random::<f32>() - 0.5;
        let pieces = pieces(&self.seen, self.options.piece);
        let (mut sum, mut count) = (0.0, 0.0);
        for (k, &(start, steps)) in pieces.iter().enumerate() {
            let inputs = piece_inputs(&self.seen, self.spec, start, steps, widths, &mut noise);
            let batch = Batch { inputs: &inputs, steps, rows: self.seen.len(), outputs: Outputs::All };
            training.step(&batch, &mut memory, |outputs, gradient| {
                let (squares, n) = tip_errors(&mut self.seen, start, outputs, Some(gradient));
                sum += squares;
                count += n;
                squares / f64::max(n, 1.0)
            })?;
            if !on_step(k + 1, pieces.len()) {
                return Ok(None);
            }
        }
        Ok(Some(sum / f64::max(count, 1.0)))
    }

    /// [mm]; the tip seen is the network's own of the pass before.
    fn validate(&mut self, training: &Training) -> Result<f64> {
        let mut memory = Memory::zeros(training.network().architecture(), self.unseen.len());
        let (mut sum, mut count) = (0.0, 0.0);
        for (start, steps) in pieces(&self.unseen, self.options.piece) {
            let inputs = piece_inputs(&self.unseen, self.spec, start, steps, [0.0; 2], &mut || 0.0);
            let batch = Batch { inputs: &inputs, steps, rows: self.unseen.len(), outputs: Outputs::All };
            let outputs = training.predict(&batch, &mut memory)?;
            let (squares, n) = tip_errors(&mut self.unseen, start, &outputs, None);
            sum += squares;
            count += n;
        }
        Ok((sum / f64::max(count, 1.0)).sqrt())
    }
}
