//! Fits the stateful design: truncated back-propagation through whole trajectories, the loss at the tip.
//!
//! With the identified strokes s* the twin's tip was y*, so near them it is y* + G (s - s*) (G = ∂y/∂s). The loss is
//! the squared distance of that from the measured tip: what the network gets wrong counts by what it does, and no two
//! strokes that do the same are told apart. All trajectories run side by side, pieces of them in order, with the
//! memory handed on.

use hysteron_base::{BadInput, rng};
use hysteron_learn::{
    Adam, ChannelErrors, FitReport, Learned, Lesson, Network, Normaliser, Schedule, SequenceOptions, Trainer,
    Training,
};
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
/// others take out. Networks are trained in parallel, each with a session of its own, and each with ranges and a
/// linear part of what it learns from alone. The decoder, of which there is one, is fitted to what no network holds
/// out; where nothing is left, to all, for it is made of the twin's sensitivities and not of the measured tip.
///
/// # Errors
/// Options out of range; sequences of different robots; a set of `held_out` without sequences, or with all of them;
/// a file of another training; training that leaves finite numbers, or that is ended before its first epoch is done.
pub fn fit_stateful(
    sequences: &[Sequence],
    held_out: &[Vec<usize>],
    scene_hash: &str,
    options: &StatefulOptions,
    sessions: &Sessions<'_>,
) -> Result<Fitted> {
    options.learning.check()?;
    let first = first_of_one_robot(sequences, sequences)?;
    let shared = shared(sequences, held_out);
    let decoder = match first.decoder.clone() {
        Some(decoder) => decoder,
        None => Decoder::fit(&shared)?,
    };
    let largest = shared.iter().flat_map(|s| &s.strokes).fold(0.0f64, |max, stroke| max.max(stroke.abs()));
    let spec = FeatureSpec {
        n_primary: first.n_primary,
        plays_m: options.plays.iter().map(|part| part * largest).collect(),
        lags_s: options.lags_s.clone(),
        feedback: options.feedback,
        step_s: first.step,
    };
    let n_networks = held_out.len().min(rayon::current_num_threads());
    let architecture = options.learning.architecture(spec.len(), 3);
    architecture.check_training([options.learning.piece, sequences.len()], n_networks)?;
    let course = Course { sequences, scene_hash, options, sessions, spec: &spec, decoder: &decoder };
    let members = held_out
        .par_iter()
        .enumerate()
        .map(|(number, held_out)| course.member(number, held_out))
        .collect::<Result<Vec<Member>>>()?;
    let inputs = Normaliser::union(&members.iter().map(|member| &member.inputs).collect::<Vec<_>>())?;
    let outputs = Normaliser::union(&members.iter().map(|member| &member.outputs).collect::<Vec<_>>())?;
    let (mut networks, mut linear, mut reports, mut told) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    let is_finished = members.iter().all(|member| member.learned.is_finished);
    for member in members {
        let Learned { network, held_out, epochs, .. } = &member.learned;
        told.push(json!({
            "held_out": member.report.validation, "held_out_rmse_mm": held_out, "epochs": epochs,
        }));
        networks.push(network.for_ranges([&member.inputs, &member.outputs], [&inputs, &outputs])?);
        let to_own = member.inputs.from_normalised(&inputs);
        linear.push(member.linear.for_ranges(&to_own[..spec.n_of_strokes()]));
        reports.push(member.report);
    }
    let model = ResidualModel {
        network: Network::mean_of(&networks)?,
        inputs,
        outputs,
        n_aux: first.auxiliary.len(),
        step_s: spec.step_s,
        design: Design::Stateful { features: spec, decoder, linear },
        scene_hash: scene_hash.to_owned(),
        change: None,
        adaptation: None,
        training: json!({ "options": options, "sequences": names(sequences), "members": told }),
    };
    Ok(Fitted { model, reports, is_finished })
}

/// Sequences that no network holds out, or all where there is none.
fn shared(sequences: &[Sequence], held_out: &[Vec<usize>]) -> Vec<Sequence> {
    let is_shared = |k: &usize| held_out.iter().all(|indices| !indices.contains(k));
    let shared: Vec<Sequence> =
        (0..sequences.len()).filter(is_shared).map(|k| sequences[k].clone()).collect();
    if shared.is_empty() { sequences.to_vec() } else { shared }
}

/// What all networks have in common.
struct Course<'a> {
    sequences: &'a [Sequence],
    scene_hash: &'a str,
    options: &'a StatefulOptions,
    sessions: &'a Sessions<'a>,
    spec: &'a FeatureSpec,
    decoder: &'a Decoder,
}

/// One network and what it was fitted with.
struct Member {
    learned: Learned,
    inputs: Normaliser,
    outputs: Normaliser,
    linear: LinearPart,
    report: FitReport,
}

impl Course<'_> {
    /// Fits ranges, linear part and network to all sequences but those `held_out`.
    fn member(&self, number: usize, held_out: &[usize]) -> Result<Member> {
        let Self { sequences, options, spec, .. } = *self;
        let (unseen, seen): (Vec<usize>, Vec<usize>) =
            (0..sequences.len()).partition(|k| held_out.contains(k));
        if seen.is_empty() || unseen.is_empty() {
            let found = format!("{} and {}", seen.len(), unseen.len());
            return Err(BadInput::new("sequences to learn from and to stop by", "some of each", found).into());
        }
        let listed = |indices: &[usize]| -> Vec<String> {
            indices.iter().map(|&k| sequences[k].name.clone()).collect()
        };
        let inputs = input_ranges(seen.iter().map(|&k| &sequences[k]), spec)?;
        let all: Vec<Seen> =
            sequences.par_iter().map(|sequence| Seen::new(sequence, spec, self.decoder, &inputs)).collect();
        let linear = LinearPart::fit(
            spec.n_primary,
            spec.n_of_strokes(),
            seen.iter().flat_map(|&k| all[k].equations()),
        )?;
        let outputs = output_ranges(&seen.iter().map(|&k| &all[k]).collect::<Vec<_>>(), &linear)?;
        let prepared = |indices: &[usize]| -> Vec<Prepared> {
            indices.iter().map(|&k| prepare(&all[k], spec, &linear, &inputs, &outputs)).collect()
        };
        let seed = rng(options.seed, &format!("residual/member/{number}")).random();
        let mut task = Trajectories { options, spec, seed, seen: prepared(&seen), unseen: prepared(&unseen) };
        let network = Network::new(&options.learning.architecture(spec.len(), 3), seed)?;
        let identity = json!({
            "scene": self.scene_hash, "options": options, "trained_on": listed(&seen), "held_out": listed(&unseen),
            "data_sha256": self.sequences.iter().map(Sequence::hash).collect::<Vec<_>>(),
            "inputs": inputs.channels, "outputs": outputs.channels,
        });
        let baselines = unseen.iter().map(|&k| all[k].squares(&linear)).collect();
        drop(all);
        let learned = self.sessions.teach(number, &mut task, network, seed, &identity)?;
        let report = FitReport {
            training: listed(&seen),
            validation: listed(&unseen),
            curve: learned.curve.clone(),
            epochs: learned.epochs,
            unit: "mm",
            methods: ["twin alone", "linear part alone", "network"].map(str::to_owned).to_vec(),
            channels: channel_errors(baselines, task.squares(&learned, seed)?),
        };
        Ok(Member { learned, inputs, outputs, linear, report })
    }
}

/// Root mean square errors of x, y and z: of the twin alone and with the linear part, sequence by sequence, and with
/// the network.
fn channel_errors(baselines: Vec<([[f64; 3]; 2], f64)>, network: [f64; 3]) -> Vec<ChannelErrors> {
    let count = baselines.iter().map(|(_, count)| count).sum::<f64>().max(1.0);
    let of_axis = |(a, axis): (usize, &str)| {
        let root = |sum: f64| (sum / count).sqrt();
        let baseline = |k: usize| root(baselines.iter().map(|(sums, _)| sums[k][a]).sum());
        ChannelErrors {
            name: format!("tip {axis}"),
            errors: vec![baseline(0), baseline(1), root(network[a])],
        }
    };
    ["x", "y", "z"].into_iter().enumerate().map(of_axis).collect()
}

fn input_ranges<'a>(
    sequences: impl Iterator<Item = &'a Sequence>,
    spec: &FeatureSpec,
) -> std::result::Result<Normaliser, BadInput> {
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

impl Trajectories<'_> {
    /// Sums of the squared errors of x, y and z on what is unseen, with the weights that are kept [mm²].
    fn squares(&mut self, learned: &Learned, seed: u64) -> Result<[f64; 3]> {
        let trainer = Trainer::new(learned.network.clone(), Adam::default(), seed)?;
        let mut still = || 0.0;
        let mut walk = Walk::new(&mut self.unseen, self.spec, [0.0; 2], &mut still);
        Training::new(trainer, None).judge_sequences(&mut walk, self.options.learning.piece)?;
        Ok(walk.squares)
    }
}

impl Lesson for Trajectories<'_> {
    type Error = Error;

    fn schedule(&self) -> Schedule {
        self.options.learning.schedule()
    }

    /// The tip that the network sees is its own of the pass before (measured at first): once the weights settle,
    /// that is its own feedback.
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
        let mut walk = Walk::new(&mut self.seen, self.spec, widths, &mut noise);
        Ok(training.train_sequences(&mut walk, self.options.learning.piece, on_step)?)
    }

    /// [mm]; the tip seen is the network's own of the pass before.
    fn validate(&mut self, training: &Training) -> Result<f64> {
        let mut still = || 0.0;
        let mut walk = Walk::new(&mut self.unseen, self.spec, [0.0; 2], &mut still);
        Ok(training.judge_sequences(&mut walk, self.options.learning.piece)?.mean().sqrt())
    }
}
