//! Fits the stateful design: truncated back-propagation through whole trajectories, the loss at the tip.
//!
//! With the identified strokes s* the twin's tip was y*, so near them it is y* + G (s - s*) (G = ∂y/∂s). The loss is
//! the squared distance of that from the measured tip: what the network gets wrong counts by what it does, and no two
//! strokes that do the same are told apart. All trajectories run side by side, pieces of them in order, with the
//! memory handed on.

use hysteron_base::{BadInput, rng};
use hysteron_learn::{Learned, Lesson, Network, Normaliser, Schedule, SequenceOptions, Training};
use rand::RngExt;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use serde_json::json;

use super::prepared::{Prepared, Seen, Walk, output_ranges, prepare};
use super::sequence::{first_of_one_robot, names};
use super::{Decoder, Design, FeatureSpec, Features, Fitted, LinearPart, ResidualModel, Sequence, Sessions};
use crate::{Error, Result};

/// How to train.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct StatefulOptions {
    /// What it has in common with other trainings on whole trajectories.
    #[serde(flatten)]
    pub learning: SequenceOptions,
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
            learning: SequenceOptions {
                hidden: 64,
                layers: 1,
                epochs: 100,
                patience: 40,
                piece: 200,
                learning_rate: 2e-3,
                input_noise: 1.0,
                // The mean reaches back over some epochs.
                renewed: 0.005,
            },
            plays: vec![0.01, 0.03, 0.08, 0.2, 0.5],
            lags_s: vec![0.3, 3.0, 30.0],
            feedback: false,
            feedback_noise_m: 2e-4,
            seed: 1,
        }
    }
}

/// Trains a network for each set of `held_out`, on all `sequences` but those, keeps its weights that do best on those
/// (indices into `sequences`), and gives one network that is the mean of all: what chance makes of one training, the
/// others take out. Networks are trained in parallel, each with a session of its own. What they have in common, decoder,
/// linear part and ranges, is fitted to all `sequences`: errors on those held out are to stop by, not to judge by.
///
/// # Errors
/// Options out of range; sequences of different robots; a set of `held_out` without sequences, or with all of them; a file of
/// another training; training that leaves finite numbers, or that is ended before its first epoch is done.
pub fn fit_stateful(
    sequences: &[Sequence],
    held_out: &[Vec<usize>],
    scene_hash: &str,
    options: &StatefulOptions,
    sessions: &Sessions<'_>,
) -> Result<Fitted> {
    options.learning.check()?;
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
        let network = Network::new(&options.learning.architecture(spec.len(), 3), seed)?;
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

/// Whole trajectories side by side, for one network.
struct Trajectories<'a> {
    options: &'a StatefulOptions,
    spec: &'a FeatureSpec,
    seed: u64,
    seen: Vec<Prepared>,
    unseen: Vec<Prepared>,
}

impl Lesson for Trajectories<'_> {
    type Error = Error;

    fn schedule(&self) -> Schedule {
        self.options.learning.schedule()
    }

    /// The tip that the network sees is its own of the pass before (measured at first): once the weights settle, that is
    /// its own feedback.
    fn train(
        &mut self,
        training: &mut Training,
        epoch: usize,
        on_step: &mut dyn FnMut(usize, usize) -> bool,
    ) -> Result<Option<f64>> {
        let width = (1e3 * self.options.feedback_noise_m * 12f64.sqrt()) as f32;
        let mut stream = rng(self.seed, &format!("residual/noise/{epoch}"));
        let mut noise = || stream.random::<f32>() - 0.5;
        let widths = [self.options.learning.input_noise as f32, width];
        let mut walk = Walk { sequences: &mut self.seen, spec: self.spec, widths, noise: &mut noise };
        Ok(training.train_sequences(&mut walk, self.options.learning.piece, on_step)?)
    }

    /// [mm]; the tip seen is the network's own of the pass before.
    fn validate(&mut self, training: &Training) -> Result<f64> {
        let mut still = || 0.0;
        let mut walk =
            Walk { sequences: &mut self.unseen, spec: self.spec, widths: [0.0; 2], noise: &mut still };
        Ok(training.judge_sequences(&mut walk, self.options.learning.piece)?.mean().sqrt())
    }
}
