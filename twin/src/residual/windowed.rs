//! The paper's network, as published (section V-A d): windows of 100 samples of strokes and tip, 2 × 128, tanh head to
//! the auxiliary strokes, mean squared error, Adam.

use hysteron_base::{BadInput, rng};
use hysteron_learn::{
    Adam, Architecture, Batch, ChannelRange, Head, Memory, Network, Normaliser, Outputs, Trainer,
    mean_squared_error,
};
use rand::seq::SliceRandom;
use serde::{Deserialize, Serialize};

use super::sequence::{first_of_one_robot, names};
use super::{Design, Epoch, ResidualModel, Sequence};
use crate::Result;

/// How to train; the defaults are published.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct WindowedOptions {
    /// Samples of a window.
    pub window: usize,
    /// Samples between the ends of two windows; 1 is published.
    pub stride: usize,
    /// Hidden units of each layer.
    pub hidden: usize,
    /// LSTM layers.
    pub layers: usize,
    /// Dropout between layers.
    pub dropout: f64,
    /// Epochs.
    pub epochs: usize,
    /// Windows of a step.
    pub batch: usize,
    /// Step size of Adam.
    pub learning_rate: f64,
    /// Weight decay of Adam.
    pub weight_decay: f64,
    /// Seed of weights, order and dropout.
    pub seed: u64,
}

impl Default for WindowedOptions {
    fn default() -> Self {
        Self {
            window: 100,
            stride: 1,
            hidden: 128,
            layers: 2,
            dropout: 0.1,
            epochs: 30,
            batch: 256,
            learning_rate: 1e-3,
            weight_decay: 1e-4,
            seed: 1,
        }
    }
}

/// A trajectory, normalised.
struct Prepared {
    /// Strokes and measured tip (n × n_inputs).
    inputs: Vec<f32>,
    /// Auxiliary strokes (n × n_aux).
    targets: Vec<f32>,
}

/// Trains on `training`; keeps the weights that do best on `held_out`, root mean square error of the strokes.
/// `on_epoch` ends it where it returns false.
///
/// # Errors
/// Sequences of different robots, or none; training that leaves finite numbers.
pub fn fit_windowed(
    training: &[Sequence],
    held_out: &[Sequence],
    scene_hash: &str,
    options: &WindowedOptions,
    on_epoch: &(dyn Fn(&Epoch) -> bool + Sync),
) -> Result<ResidualModel> {
    let first = first_of_one_robot(training, held_out)?;
    let (inputs, outputs) = ranges(training, first)?;
    let prepare = |sequences: &[Sequence]| -> Vec<Prepared> {
        sequences.iter().map(|sequence| prepare(sequence, &inputs, &outputs)).collect()
    };
    let (seen, unseen) = (prepare(training), prepare(held_out));
    let (n_in, n_out) = (inputs.channels.len(), outputs.channels.len());
    let windows = |sequences: &[Prepared]| -> Vec<(usize, usize)> {
        let ends = |(k, s): (usize, &Prepared)| {
            (0..s.targets.len() / n_out).step_by(options.stride).map(move |end| (k, end)).collect::<Vec<_>>()
        };
        sequences.iter().enumerate().flat_map(ends).collect()
    };
    let (mut order, checked) = (windows(&seen), windows(&unseen));
    let architecture = Architecture {
        inputs: n_in,
        hidden: options.hidden,
        layers: options.layers,
        outputs: n_out,
        head: Head::Tanh,
        dropout: options.dropout,
    };
    let adam =
        Adam { learning_rate: options.learning_rate, weight_decay: options.weight_decay, ..Adam::default() };
    let mut trainer = Trainer::new(Network::new(&architecture, options.seed)?, adam, options.seed)?;
    // Mean width of the outputs' ranges: from normalised errors to millimetres.
    let half_width = outputs.channels.iter().map(|c| 500.0 * (c.max - c.min)).sum::<f64>() / n_out as f64;
    let mut best = (f64::INFINITY, 0, trainer.network().clone());
    for epoch in 0..options.epochs {
        order.shuffle(&mut rng(options.seed, &format!("residual/order/{epoch}")));
        let mut sum = 0.0;
        for batch in order.chunks(options.batch) {
            let (values, targets) = gather(&seen, batch, options.window, n_in, n_out);
            let mut memory = Memory::zeros(&architecture, batch.len());
            let entering =
                Batch { inputs: &values, steps: options.window, rows: batch.len(), outputs: Outputs::Last };
            let loss = trainer.step(&entering, &mut memory, |found, gradient| {
                mean_squared_error(found, &targets, gradient)
            })?;
            sum += loss * batch.len() as f64;
        }
        let mut held = 0.0;
        for batch in checked.chunks(options.batch) {
            let (values, targets) = gather(&unseen, batch, options.window, n_in, n_out);
            let mut memory = Memory::zeros(&architecture, batch.len());
            let entering =
                Batch { inputs: &values, steps: options.window, rows: batch.len(), outputs: Outputs::Last };
            let found = trainer.predict(&entering, &mut memory)?;
            held += found.iter().zip(&targets).map(|(a, b)| f64::from((a - b).powi(2))).sum::<f64>()
                / n_out as f64;
        }
        let mm = |sum: f64, n: usize| half_width * (sum / n.max(1) as f64).sqrt();
        let report_held = mm(held, checked.len());
        if report_held < best.0 {
            best = (report_held, epoch, trainer.network().clone());
        }
        let report = Epoch {
            member: 0,
            number: epoch + 1,
            training_mm: mm(sum, order.len()),
            held_out_mm: report_held,
            best_mm: best.0,
        };
        if !on_epoch(&report) {
            break;
        }
    }
    Ok(ResidualModel {
        network: best.2,
        inputs,
        outputs,
        design: Design::Windowed { window: options.window },
        n_aux: n_out,
        step_s: first.step,
        scene_hash: scene_hash.to_owned(),
        adaptation: None,
        training: serde_json::json!({
            "options": options, "trained_on": names(training), "held_out": names(held_out),
            "held_out_stroke_rmse_mm": best.0, "epochs": best.1 + 1,
        }),
    })
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

fn prepare(sequence: &Sequence, inputs: &Normaliser, outputs: &Normaliser) -> Prepared {
    let (n_in, n_out) = (inputs.channels.len(), outputs.channels.len());
    let mut prepared =
        Prepared { inputs: vec![0.0; sequence.len() * n_in], targets: vec![0.0; sequence.len() * n_out] };
    for i in 0..sequence.len() {
        let row: Vec<f64> = sequence.strokes_at(i).iter().chain(&sequence.measured[i]).copied().collect();
        inputs.normalise_into(&row, &mut prepared.inputs[i * n_in..(i + 1) * n_in]);
        let strokes: Vec<f64> = sequence.auxiliary_at(i).collect();
        outputs.normalise_into(&strokes, &mut prepared.targets[i * n_out..(i + 1) * n_out]);
    }
    prepared
}

/// Windows that end in the given samples, zeros before the beginning, [step][row][channel]; and their targets. The tip
/// is that of the sample before (eq. 11).
fn gather(
    sequences: &[Prepared],
    windows: &[(usize, usize)],
    window: usize,
    n_in: usize,
    n_out: usize,
) -> (Vec<f32>, Vec<f32>) {
    let mut values = vec![0.0; window * windows.len() * n_in];
    for (row, &(k, end)) in windows.iter().enumerate() {
        let inputs = &sequences[k].inputs;
        for step in 0..window {
            let Some(i) = (end + 1 + step).checked_sub(window) else { continue };
            let at = (step * windows.len() + row) * n_in;
            let tip = i.saturating_sub(1);
            values[at..at + n_in - 3].copy_from_slice(&inputs[i * n_in..(i + 1) * n_in - 3]);
            values[at + n_in - 3..at + n_in].copy_from_slice(&inputs[(tip + 1) * n_in - 3..(tip + 1) * n_in]);
        }
    }
    let targets = windows.iter().flat_map(|&(k, end)| &sequences[k].targets[end * n_out..(end + 1) * n_out]);
    (values, targets.copied().collect())
}
