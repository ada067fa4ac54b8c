//! The paper's network, as published (section V-A d): windows of 100 samples of strokes and tip, 2 × 128, tanh head to
//! the auxiliary strokes, mean squared error, Adam.

use hysteron_base::{BadInput, rng};
use hysteron_learn::{
    Adam, Architecture, ChannelRange, Gathered, Head, Lesson, Network, Normaliser, Training, Windows,
};
use rand::seq::SliceRandom;
use serde::{Deserialize, Serialize};
use serde_json::json;

use super::sequence::{first_of_one_robot, names};
use super::{Design, Fitted, ResidualModel, Sequence, Sessions};
use crate::{Error, Result};

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
///
/// # Errors
/// Sequences of different robots, or none; a file of another training; training that leaves finite numbers, or that is
/// ended before its first epoch is done.
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
    let prepare = |sequences: &[Sequence]| -> Vec<Prepared> {
        sequences.iter().map(|sequence| prepare(sequence, &inputs, &outputs)).collect()
    };
    let (n_in, n_out) = (inputs.channels.len(), outputs.channels.len());
    let mut lesson = Recordings {
        options,
        n_in,
        n_out,
        half_width_mm: outputs.channels.iter().map(|c| 500.0 * (c.max - c.min)).sum::<f64>() / n_out as f64,
        seen: prepare(training),
        unseen: prepare(held_out),
    };
    let architecture = Architecture {
        inputs: n_in,
        hidden: options.hidden,
        layers: options.layers,
        outputs: n_out,
        head: Head::Tanh,
        dropout: options.dropout,
    };
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
        n_aux: n_out,
        step_s: first.step,
        scene_hash: scene_hash.to_owned(),
        adaptation: None,
        training: identity,
    };
    Ok(Fitted { model, is_finished: learned.is_finished })
}

/// Windows of trajectories, in an order that is drawn anew in every epoch.
struct Recordings<'a> {
    options: &'a WindowedOptions,
    n_in: usize,
    n_out: usize,
    /// Mean half width of the outputs' ranges: from normalised errors to millimetres.
    half_width_mm: f64,
    seen: Vec<Prepared>,
    unseen: Vec<Prepared>,
}

impl Recordings<'_> {
    /// Trajectory and last sample of each window.
    fn of(&self, all: &[Prepared]) -> Vec<(usize, usize)> {
        let n_samples = |one: &Prepared| one.targets.len() / self.n_out;
        let ends = |(k, one): (usize, &Prepared)| {
            (0..n_samples(one)).step_by(self.options.stride).map(move |end| (k, end)).collect::<Vec<_>>()
        };
        all.iter().enumerate().flat_map(ends).collect()
    }

    fn gather(&self, all: &[Prepared], windows: &[(usize, usize)]) -> Gathered {
        gather(all, windows, self.options.window, self.n_in, self.n_out)
    }
}

impl Lesson for Recordings<'_> {
    type Error = Error;

    fn epochs(&self) -> usize {
        self.options.epochs
    }

    fn patience(&self) -> usize {
        self.options.epochs
    }

    fn adam(&self, _epoch: usize) -> Adam {
        let WindowedOptions { learning_rate, weight_decay, .. } = *self.options;
        Adam { learning_rate, weight_decay, ..Adam::default() }
    }

    fn renewed(&self) -> Option<f32> {
        None
    }

    fn train(
        &mut self,
        training: &mut Training,
        epoch: usize,
        on_step: &mut dyn FnMut(usize, usize) -> bool,
    ) -> Result<Option<f64>> {
        let mut order = self.of(&self.seen);
        order.shuffle(&mut rng(self.options.seed, &format!("residual/order/{epoch}")));
        let gather = |windows: &[_]| self.gather(&self.seen, windows);
        let loss = training.train_windows(
            &Windows {
                samples: self.options.window,
                order: &order,
                batch: self.options.batch,
                gather: &gather,
            },
            on_step,
        )?;
        Ok(loss.map(|loss| self.half_width_mm.powi(2) * loss))
    }

    /// [mm]
    fn validate(&mut self, training: &Training) -> Result<f64> {
        let order = self.of(&self.unseen);
        let mut squares = 0.0;
        let gather = |windows: &[_]| self.gather(&self.unseen, windows);
        training.judge_windows(
            &Windows {
                samples: self.options.window,
                order: &order,
                batch: self.options.batch,
                gather: &gather,
            },
            &mut |found, targets| {
                squares += found.iter().zip(targets).map(|(a, b)| f64::from((a - b).powi(2))).sum::<f64>();
            },
        )?;
        let n = (order.len() * self.n_out).max(1);
        Ok(self.half_width_mm * (squares / n as f64).sqrt())
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
) -> Gathered {
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
