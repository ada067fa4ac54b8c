//! The paper's network, as published (section V-A d): windows of 100 samples of strokes and tip, 2 × 128, tanh head to
//! the auxiliary strokes, mean squared error, Adam.

use hysteron_base::BadInput;
use hysteron_learn::{
    ChannelRange, Head, Network, Normaliser, WindowedLesson, WindowedOptions, WindowedPath,
};
use serde_json::json;

use super::sequence::{first_of_one_robot, names};
use super::{Design, Fitted, ResidualModel, Sequence, Sessions};
use crate::Result;

/// As published; there are no stairs.
pub const PUBLISHED: WindowedOptions = WindowedOptions {
    window: 100,
    stride: 1,
    hidden: 128,
    layers: 2,
    dropout: 0.1,
    epochs: 30,
    batch: 256,
    learning_rate: 1e-3,
    stair: 30,
    stair_factor: 1.0,
    weight_decay: 1e-4,
    seed: 1,
};

/// Trains the paper's design, with [`PUBLISHED`] options or others, on `training`; keeps the weights that do best on
/// `held_out`, root mean square error of the strokes.
///
/// # Errors
/// Options out of range, sequences of different robots, or none; a file of another training; training that leaves finite
/// numbers, or that is ended before its first epoch is done.
pub fn fit_windowed(
    training: &[Sequence],
    held_out: &[Sequence],
    scene_hash: &str,
    options: &WindowedOptions,
    sessions: &Sessions<'_>,
) -> Result<Fitted> {
    let first = first_of_one_robot(training, held_out)?;
    if first.decoder.is_some() {
        let expected = "auxiliary strokes by identification, which this design learns";
        return Err(BadInput::new(&first.name, expected, "those that a network said")
            .hint("identify without --residual for --design paper")
            .into());
    }
    let (inputs, outputs) = ranges(training, first)?;
    let paths = [training, held_out]
        .map(|sequences| sequences.iter().map(|one| normalised(one, &inputs, &outputs)).collect());
    let mut lesson = WindowedLesson::new(options, [&inputs, &outputs], 1e3, paths)?;
    let n_aux = outputs.channels.len();
    let architecture = options.architecture(inputs.channels.len(), n_aux, Head::Tanh);
    let mut identity = json!({
        "scene": scene_hash, "options": options, "trained_on": names(training), "held_out": names(held_out),
    });
    let network = Network::new(&architecture, options.seed)?;
    let learned = sessions.teach(0, &mut lesson, network, options.seed, &identity)?;
    identity["held_out_stroke_rmse_mm"] = json!(learned.held_out);
    identity["epochs"] = json!(learned.epochs);
    let model = ResidualModel {
        network: learned.network,
        inputs,
        outputs,
        design: Design::Windowed { window: options.window },
        n_aux,
        step_s: first.step,
        scene_hash: scene_hash.to_owned(),
        adaptation: None,
        training: identity,
    };
    Ok(Fitted { model, is_finished: learned.is_finished })
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

/// The tip beside a stroke is that of the sample before (eq. 11).
fn normalised(sequence: &Sequence, inputs: &Normaliser, outputs: &Normaliser) -> WindowedPath {
    let (n_in, n_out) = (inputs.channels.len(), outputs.channels.len());
    let n = sequence.len();
    let mut path = WindowedPath {
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
