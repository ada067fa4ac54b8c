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

use super::sequence::{first_of_one_robot, names};
use super::{Decoder, Design, FeatureSpec, Features, Fitted, ResidualModel, Sequence, Sessions};
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
    /// γ of the [`Decoder`] [-].
    pub decoder: f64,
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
            decoder: 1e-3,
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
/// others take out. Networks are trained in parallel, each with a session of its own.
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
    let decoder = Decoder { regularisation: options.decoder };
    let largest = sequences.iter().flat_map(|s| &s.strokes).fold(0.0f64, |max, stroke| max.max(stroke.abs()));
    let spec = FeatureSpec {
        n_primary: first.n_primary,
        plays_m: options.plays.iter().map(|part| part * largest).collect(),
        lags_s: options.lags_s.clone(),
        feedback: options.feedback,
        step_s: first.step,
    };
    let inputs = input_ranges(sequences, &spec)?;
    let outputs = output_ranges(sequences)?;
    let prepared: Vec<Prepared> =
        sequences.iter().map(|sequence| prepare(sequence, &spec, &decoder, &inputs, &outputs)).collect();
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
        design: Design::Stateful { features: spec, decoder },
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

/// Ranges of the tip displacement that the identified strokes made.
fn output_ranges(sequences: &[Sequence]) -> std::result::Result<Normaliser, BadInput> {
    let mut samples = Vec::new();
    for sequence in sequences {
        for i in 0..sequence.len() {
            let g = sequence.sensitivity_at(i);
            samples.extend(g.iter().map(|axis| by(axis, sequence.auxiliary_at(i))));
        }
    }
    let names = ["residual_x_m", "residual_y_m", "residual_z_m"];
    // A displacement that never changed still needs a range to be learned in.
    Normaliser::from_samples(&names, samples.chunks_exact(3))?.widened(1e-6)
}

fn by(axis: &[f64], strokes: impl Iterator<Item = f64>) -> f64 {
    axis.iter().zip(strokes).map(|(g, stroke)| g * stroke).sum()
}

fn prepare(
    sequence: &Sequence,
    spec: &FeatureSpec,
    decoder: &Decoder,
    inputs: &Normaliser,
    outputs: &Normaliser,
) -> Prepared {
    let n = sequence.len();
    let n_features = spec.n_of_strokes();
    let mut features = Features::new(spec);
    let (mut row, mut normalised) = (Vec::new(), vec![0.0f32; spec.len()]);
    let mut prepared = Prepared {
        features: Vec::with_capacity(n * n_features),
        offset: Vec::with_capacity(n),
        gain: Vec::with_capacity(n),
        weight: sequence.gap.iter().map(|gap| f32::from(u8::from(!gap))).collect(),
        measured: Vec::with_capacity(n),
        tip_scale: [0.0; 3],
        feedback: Vec::new(),
    };
    if spec.feedback {
        for (scale, channel) in prepared.tip_scale.iter_mut().zip(&inputs.channels[n_features..]) {
            *scale = (2e-3 / (channel.max - channel.min).max(f64::MIN_POSITIVE)) as f32;
        }
    }
    for i in 0..n {
        row.clear();
        features.append(sequence.strokes_at(i), &mut row);
        if spec.feedback {
            row.extend_from_slice(&sequence.measured[i]);
        }
        inputs.normalise_into(&row, &mut normalised);
        prepared.features.extend_from_slice(&normalised[..n_features]);
        let tip = &normalised[n_features..];
        prepared.measured.push(std::array::from_fn(|c| tip.get(c).copied().unwrap_or(0.0)));
        let g = sequence.sensitivity_at(i);
        let seen = decoder.seen_by(&g);
        // A normalised output o means min + (o + 1)/2 (max - min).
        let half = |c: usize| 0.5 * (outputs.channels[c].max - outputs.channels[c].min);
        let middle = |c: usize| outputs.channels[c].min + half(c);
        prepared.gain.push(seen.map(|row| std::array::from_fn(|c| (1e3 * row[c] * half(c)) as f32)));
        prepared.offset.push(std::array::from_fn(|a| {
            let constant: f64 = (0..3).map(|c| seen[a][c] * middle(c)).sum();
            let undone = sequence.twin[i][a] - by(&g[a], sequence.auxiliary_at(i));
            (1e3 * (undone + constant - sequence.measured[i][a])) as f32
        }));
    }
    prepared.feedback = prepared.measured.clone();
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
