//! Fits the recurrent design: truncated back-propagation through whole trajectories, the loss at the tip.
//!
//! With the identified strokes s* the twin's tip was y*, so near them it is y* + G (s - s*) (G = ∂y/∂s). The loss is
//! the squared distance of that from the measured tip: errors of the network count by their effect at the
//! tip, and strokes of equal effect count as equal. All trajectories run side by side; see [`SequenceTask`].

use std::borrow::Cow;

use hysteron_base::{BadInput, parallel, rng};
use hysteron_learn::{
    ChannelErrors, ChannelRange, FitReport, FitResult, Member, Network, Normaliser, SequenceOptions,
    SequenceTask, mean,
};
use rand::RngExt;
use serde::Serialize;

use super::band::{LeftOut, TipBand};
use super::prepared::{LinearisedTrajectory, TipSequences, output_ranges, prepare};
use super::recurrent_options::RecurrentOptions;
use super::sequence::{first_of_one_robot, fit_decoder, names};
use super::training::{ResidualOptions, ResidualTraining, TrainedMember};
use super::{
    FeatureSpec, Features, FittedResidual, LinearPart, ResidualDesign, ResidualModel, ResidualPart, Sequence,
    Sessions, StrokeDecoder,
};
use crate::Result;

/// Trains a network for each set of `held_out`, on all `sequences` but those, and keeps its weights that do best on those
/// (indices into `sequences`). A part that gains nothing there is left out of the model. With `n_of_all` that many networks then learn
/// from all sequences, for as many epochs as the others took in the mean; without, the others are used but for those that do worse
/// in validation than the twin alone. The model is the mean of its networks: what chance makes of one training, the others take out.
/// Networks are trained in parallel, each with a session of its own, and each with ranges and a linear part of what it learns from
/// alone. The decoder, of which there is one, is fitted to what no network holds out; where nothing is left, to all, for it is made of
/// the twin's sensitivities and not of the measured tip.
///
/// # Errors
/// Options out of range; sequences of different robots; a set of `held_out` without sequences, or with all of them;
/// a file of another training; training that leaves finite numbers, or that is ended before its first epoch is done.
pub fn fit_recurrent(
    sequences: &[Sequence],
    (held_out, n_of_all): (&[Vec<usize>], usize),
    scene_hash: &str,
    options: &RecurrentOptions,
    sessions: &Sessions<'_>,
) -> Result<FittedResidual> {
    options.learning.check()?;
    let first = first_of_one_robot(sequences, sequences)?;
    let shared = shared(sequences, held_out);
    let decoder = match first.decoder.clone() {
        Some(decoder) => decoder,
        None => fit_decoder(&shared)?,
    };
    let largest = shared.iter().flat_map(|s| &s.strokes).fold(0.0f64, |max, stroke| max.max(stroke.abs()));
    let spec = FeatureSpec {
        n_primary: first.n_primary,
        plays_m: options.plays.iter().map(|part| part * largest).collect(),
        filters_s: options.filters_s.clone(),
        feedback: options.feedback,
        step_s: first.step,
    };
    let n_networks = held_out.len().max(n_of_all).min(rayon::current_num_threads());
    let architecture = options.learning.architecture(spec.len(), 3);
    architecture.check_training([options.learning.truncation, sequences.len()], n_networks)?;
    let setting = NetworkInputs { sequences, scene_hash, options, sessions, spec: &spec, decoder: &decoder };
    let numbered: Vec<_> = held_out.iter().enumerate().collect();
    let members = parallel::try_map(&numbered, |(number, held_out)| setting.member(*number, held_out, None))?;
    let mut is_finished = members.iter().all(|member| member.result.is_finished);
    let reports: Vec<FitReport> = members.iter().map(|member| member.report.clone()).collect();
    let part = ResidualPart::best(&reports);
    let left_out: Vec<&LeftOut> = members.iter().flat_map(|member| &member.left_out).collect();
    let tip_band = TipBand::new(part, &left_out);
    let is_of_all = is_finished && n_of_all > 0;
    let mut summaries: Vec<TrainedMember> = members.iter().map(|member| member.summary(part)).collect();
    let used = if is_of_all {
        summaries.iter_mut().for_each(|member| member.is_kept = part != ResidualPart::Nothing);
        let of_all = setting.of_all(part, (held_out.len(), n_of_all), &summaries)?;
        is_finished = of_all.iter().all(|member| member.result.is_finished);
        of_all
    } else {
        let is_used = |(k, member): &(usize, TrainedNetwork)| {
            part == ResidualPart::Nothing && *k == 0 || part.gains(&member.report)
        };
        members.into_iter().enumerate().filter(is_used).map(|(_, member)| member).collect()
    };
    let n_used = used.len();
    let kept = used.into_iter().map(|member| setting.with_part(part, member)).collect::<Result<Vec<_>>>()?;
    let parts = kept.iter().map(|TrainedNetwork { result, inputs, outputs, .. }| Member {
        network: &result.model,
        inputs,
        outputs,
    });
    let (network, inputs, outputs) = Network::ensemble(&parts.collect::<Vec<_>>())?;
    let to_common = |member: TrainedNetwork| {
        let to_own = member.inputs.from_normalised(&inputs);
        member.linear.for_ranges(&to_own[..spec.n_of_strokes()])
    };
    let linear = kept.into_iter().map(to_common).collect();
    let model = ResidualModel {
        network,
        inputs,
        outputs,
        n_aux: first.auxiliary.len(),
        step_s: spec.step_s,
        design: ResidualDesign::Recurrent { features: spec, decoder, linear },
        scene_hash: scene_hash.to_owned(),
        change: None,
        adaptation: None,
        training: ResidualTraining {
            options: Some(ResidualOptions::Recurrent(options.clone())),
            sequences: names(sequences),
            members: summaries,
            part: Some(part),
            networks_of_all: is_of_all.then_some(n_used),
            tip_band,
            ..ResidualTraining::default()
        },
    };
    Ok(FittedResidual { model, reports, is_finished })
}

/// Sequences that no network holds out, or all where there is none.
fn shared(sequences: &[Sequence], held_out: &[Vec<usize>]) -> Vec<Sequence> {
    let is_shared = |k: &usize| held_out.iter().all(|indices| !indices.contains(k));
    let shared: Vec<Sequence> =
        (0..sequences.len()).filter(is_shared).map(|k| sequences[k].clone()).collect();
    if shared.is_empty() { sequences.to_vec() } else { shared }
}

/// Inputs common to all networks.
struct NetworkInputs<'a> {
    sequences: &'a [Sequence],
    scene_hash: &'a str,
    options: &'a RecurrentOptions,
    sessions: &'a Sessions<'a>,
    spec: &'a FeatureSpec,
    decoder: &'a StrokeDecoder,
}

/// Identity of the training of one network: a file to resume from holds it.
#[derive(Serialize)]
struct MemberIdentity<'a> {
    scene: &'a str,
    options: &'a RecurrentOptions,
    trained_on: Vec<String>,
    held_out: Vec<String>,
    data_sha256: Vec<String>,
    inputs: &'a [ChannelRange],
    outputs: &'a [ChannelRange],
}

/// One network and what it was fitted with.
struct TrainedNetwork {
    result: FitResult<Network>,
    inputs: Normaliser,
    outputs: Normaliser,
    linear: LinearPart,
    report: FitReport,
    left_out: Vec<LeftOut>,
}

impl TrainedNetwork {
    fn summary(&self, part: ResidualPart) -> TrainedMember {
        TrainedMember {
            held_out: self.report.validation.clone(),
            held_out_rmse_mm: self.result.validation,
            epochs: self.result.epochs,
            is_kept: part.gains(&self.report),
        }
    }
}

impl NetworkInputs<'_> {
    /// The same with what is not of `part` silent: a network of one unit whose outputs have no width, a linear part of zeros.
    fn with_part(&self, part: ResidualPart, mut member: TrainedNetwork) -> Result<TrainedNetwork> {
        if part != ResidualPart::Network {
            let smallest = SequenceOptions { hidden: 1, layers: 1, ..self.options.learning };
            member.result.model =
                Network::new(&smallest.architecture(self.spec.len(), 3), self.options.seed)?;
            let silent = |channel: ChannelRange| ChannelRange { min: 0.0, max: 0.0, ..channel };
            member.outputs = Normaliser::new(member.outputs.channels.into_iter().map(silent).collect())?;
        }
        if part == ResidualPart::Nothing {
            member.linear = member.linear.silent();
        }
        Ok(member)
    }

    /// Networks of all sequences, numbered from `first` on, for as many epochs as others took in the mean. Where no network is
    /// used, one that is as good as not trained.
    fn of_all(
        &self,
        part: ResidualPart,
        (first, n): (usize, usize),
        others: &[TrainedMember],
    ) -> Result<Vec<TrainedNetwork>> {
        let epochs: Vec<f64> = others.iter().map(|member| member.epochs as f64).collect();
        let (n, epochs) = match part {
            ResidualPart::Network => (n, (mean(&epochs).round() as usize).max(1)),
            ResidualPart::Linear | ResidualPart::Nothing => (1, 1),
        };
        let numbers: Vec<usize> = (first..first + n).collect();
        parallel::try_map(&numbers, |number| self.member(*number, &[], Some(epochs)))
    }

    /// Fits ranges, linear part and network to all sequences but those `held_out`, which choose its weights, or where `ends_after`
    /// says after how many epochs.
    fn member(&self, number: usize, held_out: &[usize], ends_after: Option<usize>) -> Result<TrainedNetwork> {
        let Self { sequences, spec, .. } = *self;
        let learning = SequenceOptions { ends_after, ..self.options.learning };
        let options = &RecurrentOptions { learning, ..self.options.clone() };
        let (validation, training): (Vec<usize>, Vec<usize>) =
            (0..sequences.len()).partition(|k| held_out.contains(k));
        if training.is_empty() || validation.is_empty() && ends_after.is_none() {
            let found = format!("{} and {}", training.len(), validation.len());
            return Err(BadInput::new("sequences for training and validation", "some of each", found).into());
        }
        let listed = |indices: &[usize]| -> Vec<String> {
            indices.iter().map(|&k| sequences[k].name.clone()).collect()
        };
        let inputs = input_ranges(training.iter().map(|&k| &sequences[k]), spec)?;
        let linearise =
            |sequence: &Sequence| LinearisedTrajectory::new(sequence, spec, self.decoder, &inputs);
        let all: Vec<LinearisedTrajectory> = parallel::map(sequences, linearise);
        let linear = LinearPart::fit(
            spec.n_primary,
            spec.n_of_strokes(),
            training.iter().flat_map(|&k| all[k].equations()),
        )?;
        let outputs = output_ranges(&training.iter().map(|&k| &all[k]).collect::<Vec<_>>(), &linear)?;
        let prepared = |indices: &[usize]| {
            let one = |&k: &usize| prepare(&all[k], spec, &linear, &inputs, &outputs);
            let noise = [options.learning.input_noise, options.feedback_noise_m];
            TipSequences::new(indices.iter().map(one).collect(), spec, noise)
        };
        let seed = rng(options.seed, &format!("residual/member/{number}")).random();
        let network = Network::new(&options.learning.architecture(spec.len(), 3), seed)?;
        let sides = [prepared(&training), prepared(&validation)];
        let mut task = SequenceTask::new(&options.learning, &network, (seed, "residual/noise"), sides)?;
        let identity = MemberIdentity {
            scene: self.scene_hash,
            options,
            trained_on: listed(&training),
            held_out: listed(&validation),
            data_sha256: sequences.iter().map(Sequence::hash).collect(),
            inputs: &inputs.channels,
            outputs: &outputs.channels,
        };
        let baselines: Vec<Vec<[[f64; 3]; 2]>> = validation.iter().map(|&k| all[k].errors(&linear)).collect();
        drop(all);
        let result = self.sessions.fit(number, &mut task, network, &identity)?;
        let mut squares = task.evaluate(&result.model)?.squares;
        // Of no sample there are none.
        squares.resize(3, 0.0);
        let report = FitReport {
            training: listed(&training),
            validation: listed(&validation),
            curve: result.curve.clone(),
            epochs: result.epochs,
            unit: Cow::Borrowed("mm"),
            methods: ResidualPart::ALL.map(|part| part.name().to_owned()).to_vec(),
            channels: channel_errors(&baselines, &squares),
        };
        let norm = |error: &[f64; 3]| error.iter().map(|e| e * e).sum::<f64>().sqrt();
        let left_out = baselines.iter().zip(task.validation().distances()).map(|(errors, network)| {
            let [nothing, linear] = [0, 1].map(|k| errors.iter().map(|both| norm(&both[k])).collect());
            [nothing, linear, network]
        });
        let left_out = left_out.collect();
        Ok(TrainedNetwork { result, inputs, outputs, linear, report, left_out })
    }
}

/// Root mean square errors of x, y and z: of the twin alone and with the linear part, sequence by sequence, and with
/// the network.
fn channel_errors(baselines: &[Vec<[[f64; 3]; 2]>], network: &[f64]) -> Vec<ChannelErrors> {
    let count = baselines.iter().map(|errors| errors.len() as f64).sum::<f64>().max(1.0);
    let of_axis = |(a, axis): (usize, &str)| {
        let root = |sum: f64| (sum / count).sqrt();
        let baseline = |k: usize| root(baselines.iter().flatten().map(|errors| errors[k][a].powi(2)).sum());
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
