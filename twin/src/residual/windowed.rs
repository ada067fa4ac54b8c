//! The paper's network, as published (section V-A d): windows of 100 samples of strokes and tip, 2 × 128, tanh head to
//! the auxiliary strokes, mean squared error, Adam.

use std::borrow::Cow;

use hysteron_base::BadInput;
use hysteron_learn::{
    ChannelErrors, ChannelRange, FitReport, FitResult, HeadActivation, Network, Normaliser, WindowOptions,
    WindowTask, WindowedSequence,
};

use super::sequence::{first_of_one_robot, names};
use super::training::{ResidualOptions, ResidualTraining};
use super::{FittedResidual, ResidualDesign, ResidualModel, Sequence, Sessions};
use crate::Result;

/// As published; the step size does not decay.
pub const PUBLISHED: WindowOptions = WindowOptions {
    window: 100,
    stride: 1,
    hidden: 128,
    layers: 2,
    dropout: 0.1,
    epochs: 30,
    batch: 256,
    learning_rate: 1e-3,
    decay_epochs: 30,
    decay_factor: 1.0,
    weight_decay: 1e-4,
    gradient_floor: 1e-16,
    seed: 1,
};

/// Trains the paper's design, with [`PUBLISHED`] options or others, on `training`; keeps the weights that do best on
/// `held_out`, root mean square error of the strokes.
///
/// # Errors
/// Options out of range, sequences of different robots, or none; a file of another training; training that leaves
/// finite numbers, or that is ended before its first epoch is done.
pub fn fit_windowed(
    training: &[Sequence],
    held_out: &[Sequence],
    scene_hash: &str,
    options: &WindowOptions,
    sessions: &Sessions<'_>,
) -> Result<FittedResidual> {
    options.check()?;
    let first = first_of_one_robot(training, held_out)?;
    if first.decoder.is_some() {
        let expected = "auxiliary strokes by identification, which this design learns";
        return Err(BadInput::new(&first.name, expected, "those of a network")
            .hint("identify without --residual for --design paper")
            .into());
    }
    let (inputs, outputs) = ranges(training, first)?;
    let paths = [training, held_out]
        .map(|sequences| sequences.iter().map(|one| normalised(one, &inputs, &outputs)).collect());
    let n_aux = outputs.channels.len();
    let architecture = options.architecture(inputs.channels.len(), n_aux, HeadActivation::Tanh);
    let hashes: Vec<String> = training.iter().chain(held_out).map(Sequence::hash).collect();
    let mut described = ResidualTraining {
        options: Some(ResidualOptions::Windowed(options.clone())),
        scene: Some(scene_hash.to_owned()),
        trained_on: names(training),
        held_out: names(held_out),
        data_sha256: hashes,
        ..ResidualTraining::default()
    };
    architecture.check_training([options.window, options.batch], 1)?;
    let network = Network::new(&architecture, options.seed)?;
    let mut task = WindowTask::new(options, &network, &outputs, 1e3, paths)?;
    let result = sessions.fit(0, &mut task, network, &described)?;
    described.gradient_floor_relative_error = Some(task.gradient_floor_error(&result.model)?);
    let report = report(training, held_out, &result, &task.squares(&result.model)?);
    described.held_out_stroke_rmse_mm = Some(result.validation);
    described.epochs = Some(result.epochs);
    let model = ResidualModel {
        network: result.model,
        inputs,
        outputs,
        design: ResidualDesign::Windowed { window: options.window },
        n_aux,
        step_s: first.step,
        scene_hash: scene_hash.to_owned(),
        change: None,
        adaptation: None,
        training: described,
    };
    Ok(FittedResidual { model, reports: vec![report], is_finished: result.is_finished })
}

/// Errors of the auxiliary strokes compared with strokes of zero, the twin alone. `squares` are the network's
/// mean squares [mm²].
fn report(
    training: &[Sequence],
    held_out: &[Sequence],
    result: &FitResult<Network>,
    squares: &[f64],
) -> FitReport {
    let channel = |(k, square): (usize, &f64)| {
        let strokes = || {
            let of_one = |s: &'_ Sequence| -> Vec<f64> {
                (0..s.len()).filter(|&i| !s.gap[i]).map(|i| s.auxiliary[k][i]).collect()
            };
            held_out.iter().flat_map(of_one)
        };
        let zero = strokes().map(|s| (1e3 * s).powi(2)).sum::<f64>() / (strokes().count().max(1) as f64);
        ChannelErrors { name: format!("aux {:02}", k + 1), errors: vec![zero.sqrt(), square.sqrt()] }
    };
    FitReport {
        training: names(training),
        validation: names(held_out),
        curve: result.curve.clone(),
        epochs: result.epochs,
        unit: Cow::Borrowed("mm"),
        methods: ["no strokes", "network"].map(str::to_owned).to_vec(),
        channels: squares.iter().enumerate().map(channel).collect(),
    }
}

fn ranges(
    sequences: &[Sequence],
    first: &Sequence,
) -> std::result::Result<(Normaliser, Normaliser), BadInput> {
    let range = |name: String, values: &mut dyn Iterator<Item = f64>| {
        let (min, max) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
        ChannelRange { name, min, max }
    };
    let mut inputs = Vec::new();
    for k in 0..first.n_primary {
        let mut values =
            sequences.iter().flat_map(|s| s.strokes.iter().skip(k).step_by(s.n_primary).copied());
        inputs.push(range(format!("stroke_{}_m", k + 1), &mut values));
    }
    for (c, axis) in ["x", "y", "z"].into_iter().enumerate() {
        let mut values = sequences.iter().flat_map(|s| s.measured.iter().map(|tip| tip[c]));
        inputs.push(range(format!("tip_{axis}_m"), &mut values));
    }
    let outputs = (0..first.auxiliary.len()).map(|k| {
        let mut values = sequences.iter().flat_map(|s| s.auxiliary[k].iter().copied());
        range(format!("aux_{:02}_m", k + 1), &mut values)
    });
    Ok((Normaliser::new(inputs)?, Normaliser::new(outputs.collect())?))
}

/// The tip next to a stroke is that of the sample before (eq. 11).
fn normalised(sequence: &Sequence, inputs: &Normaliser, outputs: &Normaliser) -> WindowedSequence {
    let (n_in, n_out) = (inputs.channels.len(), outputs.channels.len());
    let n = sequence.len();
    let mut path = WindowedSequence {
        inputs: vec![0.0; n * n_in],
        targets: vec![0.0; n * n_out],
        ends: (0..n).filter(|&i| !sequence.gap[i]).collect(),
    };
    for i in 0..n {
        let tip = &sequence.measured[i.saturating_sub(1)];
        let row: Vec<f64> = sequence.strokes_at(i).iter().chain(tip).copied().collect();
        inputs.normalise_into(&row, &mut path.inputs[i * n_in..(i + 1) * n_in]);
        let strokes: Vec<f64> = sequence.auxiliary_at(i).collect();
        outputs.normalise_into(&strokes, &mut path.targets[i * n_out..(i + 1) * n_out]);
    }
    path
}
