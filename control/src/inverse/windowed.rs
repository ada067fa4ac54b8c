//! The paper's controller, as published (section V-B c): windows of 200 samples of the tip's x and y, 2 × 512 units with
//! dropout, linear head to all strokes, mean squared error, Adam with a step size that falls in stairs.

use hysteron_base::{BadInput, rng};
use hysteron_learn::{
    Adam, Architecture, ChannelRange, Gathered, Head, Lesson, Network, Normaliser, Session, Training, Windows,
};
use rand::seq::SliceRandom;
use serde::{Deserialize, Serialize};
use serde_json::json;

use super::fit::{Fitted, Parts, Strokes, identity, mean, run};
use super::smooth::{Smoothed, Smoothing, smoothed};
use super::{Axes, Check, Dataset, Demonstration, Design, Tip};
use crate::{Error, Result};

/// How to train; the defaults are published, but for the stairs.
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
    /// Step size of Adam at the start.
    pub learning_rate: f64,
    /// Epochs of a stair; the paper names a StepLR and not its numbers.
    pub stair: usize,
    /// What the step size is multiplied by from stair to stair.
    pub stair_factor: f64,
    /// Weight decay of Adam.
    pub weight_decay: f64,
    /// Seed of weights, order and dropout.
    pub seed: u64,
}

/// Half the time over which the tip is smoothed for the static regression and the workspace; the network sees it as it is.
const HALF_WIDTH_S: f64 = 0.1;

impl Default for WindowedOptions {
    fn default() -> Self {
        Self {
            window: 200,
            stride: 1,
            hidden: 512,
            layers: 2,
            dropout: 0.1,
            epochs: 30,
            batch: 256,
            learning_rate: 1e-3,
            stair: 10,
            stair_factor: 0.5,
            weight_decay: 1e-4,
            seed: 1,
        }
    }
}

impl WindowedOptions {
    fn architecture(&self, axes: Axes, n_tendons: usize) -> Architecture {
        Architecture {
            inputs: axes.len(),
            hidden: self.hidden,
            layers: self.layers,
            outputs: n_tendons,
            head: Head::Linear,
            dropout: self.dropout,
        }
    }

    fn check(&self) -> Check<()> {
        let counts = [
            ("window", self.window),
            ("stride", self.stride),
            ("epochs", self.epochs),
            ("batch", self.batch),
            ("stair", self.stair),
        ];
        match counts.iter().find(|(_, n)| *n == 0) {
            Some((name, _)) => Err(BadInput::new(*name, "at least 1", "0")),
            None => Ok(()),
        }
    }
}

/// Trains, see [`WindowedOptions`].
///
/// # Errors
/// Options out of range, a file to go on from that belongs to another training, training that leaves finite numbers.
pub fn fit_windowed(data: &Dataset, options: &WindowedOptions, session: &mut Session<'_>) -> Result<Fitted> {
    options.check()?;
    let Smoothed { regression_mm, workspace, .. } = smoothed(data, Smoothing::Centred, HALF_WIDTH_S)?;
    let (inputs, outputs) = (input_ranges(data)?, output_ranges(data)?);
    let prepare = |all: &[Demonstration]| -> Vec<Prepared> {
        all.iter().map(|one| prepare(one, &inputs, &outputs)).collect()
    };
    let mut lesson = Paths {
        half_width_mm: outputs.channels.iter().map(|c| 500.0 * (c.max - c.min)).collect(),
        seen: prepare(&data.training),
        unseen: prepare(&data.validation),
        n_inputs: inputs.channels.len(),
        options,
    };
    let network = Network::new(&options.architecture(data.axes, data.n_tendons), options.seed)?;
    let training = identity("paper", json!(options), data);
    let outcome = run(&mut lesson, network, options.seed, &training, session)?;
    Ok(outcome.into_fitted(
        data,
        training,
        Parts {
            inputs,
            outputs,
            design: Design::Windowed { window: options.window },
            workspace,
            regression_mm,
        },
    ))
}

fn input_ranges(data: &Dataset) -> Check<Normaliser> {
    let names: Vec<String> = data.axes.names().iter().map(|axis| format!("tip_{axis}_m")).collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let tips = data.training.iter().flat_map(|one| one.tip.iter().map(|tip| &tip[..names.len()]));
    Normaliser::from_samples(&names, tips)
}

fn output_ranges(data: &Dataset) -> Check<Normaliser> {
    let names: Vec<String> = (1..=data.n_tendons).map(|k| format!("stroke_{k}_m")).collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let ranges = Normaliser::from_samples(
        &names,
        data.training.iter().flat_map(|one| one.strokes.chunks_exact(data.n_tendons)),
    )?;
    match ranges.channels.iter().find(|channel| channel.min == channel.max) {
        Some(ChannelRange { name, min, .. }) => {
            Err(BadInput::new(name, "a stroke that changes", format!("{min} m throughout")))
        }
        None => Ok(ranges),
    }
}

/// A trajectory, normalised.
struct Prepared {
    /// Tip (n × axes).
    inputs: Vec<f32>,
    /// Strokes (n × n_tendons).
    targets: Vec<f32>,
    /// Samples that were measured, where windows may end.
    ends: Vec<usize>,
}

fn prepare(one: &Demonstration, inputs: &Normaliser, outputs: &Normaliser) -> Prepared {
    let mut prepared = Prepared {
        inputs: normalised_path(&one.tip, inputs),
        targets: vec![0.0; one.strokes.len()],
        ends: (0..one.len()).filter(|&i| !one.gap[i]).collect(),
    };
    for (i, target) in prepared.targets.chunks_exact_mut(one.n_tendons).enumerate() {
        outputs.normalise_into(one.strokes_at(i), target);
    }
    prepared
}

/// A path as the network sees it (n × axes).
pub(super) fn normalised_path(path: &[Tip], inputs: &Normaliser) -> Vec<f32> {
    let n = inputs.channels.len();
    let mut values = vec![0.0; n * path.len()];
    for (tip, out) in path.iter().zip(values.chunks_exact_mut(n)) {
        inputs.normalise_into(&tip[..n], out);
    }
    values
}

/// Windows side by side, [step][row][channel]: each ends in a sample of a normalised path of `n` channels, with zeros
/// before its beginning.
pub(super) fn gather<'a>(
    windows: impl Iterator<Item = (&'a [f32], usize)> + Clone,
    window: usize,
    n: usize,
) -> Vec<f32> {
    let n_rows = windows.clone().count();
    let mut values = vec![0.0; window * n_rows * n];
    for (row, (path, end)) in windows.enumerate() {
        for step in 0..window {
            let Some(i) = (end + 1 + step).checked_sub(window) else { continue };
            let at = (step * n_rows + row) * n;
            values[at..at + n].copy_from_slice(&path[n * i..n * (i + 1)]);
        }
    }
    values
}

struct Paths<'a> {
    options: &'a WindowedOptions,
    /// Channels of a path.
    n_inputs: usize,
    seen: Vec<Prepared>,
    unseen: Vec<Prepared>,
    /// From normalised errors of each stroke to millimetres.
    half_width_mm: Vec<f64>,
}

impl Paths<'_> {
    /// Trajectory and last sample of each window.
    fn of(&self, all: &[Prepared]) -> Vec<(usize, usize)> {
        let ends = |(k, one): (usize, &Prepared)| {
            one.ends.iter().step_by(self.options.stride).map(move |&end| (k, end)).collect::<Vec<_>>()
        };
        all.iter().enumerate().flat_map(ends).collect()
    }

    /// Inputs and targets of some windows.
    fn gather(&self, all: &[Prepared], windows: &[(usize, usize)]) -> Gathered {
        let n = self.half_width_mm.len();
        let rows = windows.iter().map(|&(k, end)| (&all[k].inputs[..], end));
        let targets = windows.iter().flat_map(|&(k, end)| &all[k].targets[end * n..(end + 1) * n]);
        (gather(rows, self.options.window, self.n_inputs), targets.copied().collect())
    }
}

impl Lesson for Paths<'_> {
    type Error = Error;

    fn epochs(&self) -> usize {
        self.options.epochs
    }

    fn patience(&self) -> usize {
        self.options.epochs
    }

    fn adam(&self, epoch: usize) -> Adam {
        let stairs = i32::try_from(epoch / self.options.stair).unwrap_or(i32::MAX);
        Adam {
            learning_rate: self.options.learning_rate * self.options.stair_factor.powi(stairs),
            weight_decay: self.options.weight_decay,
            ..Adam::default()
        }
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
        order.shuffle(&mut rng(self.options.seed, &format!("inverse/order/{epoch}")));
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
        let squares: Vec<f64> = self.half_width_mm.iter().map(|mm| mm * mm).collect();
        Ok(loss.map(|loss| mean(&squares) * loss))
    }

    fn validate(&mut self, training: &Training) -> Result<f64> {
        Ok(mean(&self.squares(training)?).sqrt())
    }
}

impl Strokes for Paths<'_> {
    fn squares(&self, training: &Training) -> Result<Vec<f64>> {
        let order = self.of(&self.unseen);
        let n = self.half_width_mm.len();
        let mut squares = vec![0.0; n];
        let gather = |windows: &[_]| self.gather(&self.unseen, windows);
        training.judge_windows(
            &Windows {
                samples: self.options.window,
                order: &order,
                batch: self.options.batch,
                gather: &gather,
            },
            &mut |found, targets| {
                for (k, (found, target)) in found.iter().zip(targets).enumerate() {
                    squares[k % n] += (self.half_width_mm[k % n] * f64::from(found - target)).powi(2);
                }
            },
        )?;
        Ok(squares.into_iter().map(|sum| sum / order.len().max(1) as f64).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_network_is_the_published_one() {
        // Section V-B c: windows of 200 × 2, two layers of 512 with dropout 0.1, linear head to 4 strokes. Parameters by
        // hand: 4·512·(2 + 512 + 1) + 4·512·(512 + 512 + 1) + 4·(512 + 1).
        let options = WindowedOptions::default();
        let architecture = options.architecture(Axes::Planar, 4);
        assert_eq!((options.window, options.batch, options.epochs), (200, 256, 30));
        assert_eq!((architecture.dropout, architecture.head), (0.1, Head::Linear));
        assert_eq!(Network::new(&architecture, 1).map(|n| n.n_parameters()).ok(), Some(3_155_972));
    }

    #[test]
    fn windows_end_in_their_sample_and_begin_with_zeros() {
        let path: Vec<f32> = (1..=8).map(|v| v as f32).collect();
        let windows = [(&path[..], 1), (&path[..], 3)];
        // Steps of both rows: x, y; x, y.
        let expected = [0.0, 0.0, 3.0, 4.0, 1.0, 2.0, 5.0, 6.0, 3.0, 4.0, 7.0, 8.0];
        assert_eq!(gather(windows.iter().copied(), 3, 2), expected);
    }

    #[test]
    fn the_step_size_falls_in_stairs() {
        let lesson = Paths {
            options: &WindowedOptions::default(),
            n_inputs: 2,
            seen: Vec::new(),
            unseen: Vec::new(),
            half_width_mm: Vec::new(),
        };
        let rates = [0, 9, 10, 29].map(|epoch| lesson.adam(epoch).learning_rate);
        assert_eq!(rates, [1e-3, 1e-3, 5e-4, 2.5e-4]);
    }
}
