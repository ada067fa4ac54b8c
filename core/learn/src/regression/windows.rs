//! The published way to train (CoReAct paper, sections V-A d and V-B c): windows of samples, an output at the end of each, mean
//! squared error, Adam with a step size that may decay step by step.

use hysteron_base::{BadInput, rng};
use rand::seq::SliceRandom;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::engine::{MAX_EPOCHS, MAX_HIDDEN, MAX_LAYERS, MAX_ROWS, check_counts};
use crate::{
    Adam, Architecture, Backprop, Decay, Error, HeadActivation, HeadOutputs, Memory, Network, Normaliser,
    Result, Schedule, SequenceBatch, Training, TrainingTask, mean, mean_squared_error,
};

/// How to train on windows.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct WindowOptions {
    /// Samples of a window.
    pub window: usize,
    /// Samples between the ends of two windows.
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
    /// Epochs between two changes of the step size.
    pub decay_epochs: usize,
    /// Factor on the step size every `decay_epochs` epochs [-].
    pub decay_factor: f64,
    /// Weight decay of Adam.
    pub weight_decay: f64,
    /// Derivatives of at most this size become zero in back-propagation through time, which then ends early; at
    /// zero none do.
    pub gradient_floor: f32,
    /// Seed of weights, order and dropout.
    pub seed: u64,
}

impl WindowOptions {
    /// The network for so many inputs and outputs.
    pub fn architecture(&self, inputs: usize, outputs: usize, head: HeadActivation) -> Architecture {
        let Self { hidden, layers, dropout, .. } = *self;
        Architecture { inputs, hidden, layers, outputs, head, dropout }
    }

    /// Refuses options out of range.
    ///
    /// # Errors
    /// `BadInput` naming the option.
    pub fn check(&self) -> Result<()> {
        check_counts(&[
            ("window", self.window, MAX_ROWS),
            ("stride", self.stride, MAX_ROWS),
            ("epochs", self.epochs, MAX_EPOCHS),
            ("batch", self.batch, MAX_ROWS),
            ("decay_epochs", self.decay_epochs, MAX_EPOCHS),
            ("hidden", self.hidden, MAX_HIDDEN),
            ("layers", self.layers, MAX_LAYERS),
        ])?;
        if !(self.gradient_floor >= 0.0 && self.gradient_floor.is_finite()) {
            let found = self.gradient_floor.to_string();
            return Err(BadInput::new("gradient_floor", "a finite number >= 0", found).into());
        }
        Ok(())
    }
}

/// A normalised sequence, input of a network.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct WindowedSequence {
    /// Inputs (n × inputs).
    pub inputs: Vec<f32>,
    /// Targets (n × outputs).
    pub targets: Vec<f32>,
    /// Samples in which a window may end.
    pub ends: Vec<usize>,
}

/// Windows side by side, [step][row][channel]: each ends in a sample of a path of `n` channels, with zeros before its
/// beginning.
pub fn windows<'a>(
    ends: impl Iterator<Item = (&'a [f32], usize)> + Clone,
    window: usize,
    n: usize,
) -> Vec<f32> {
    let n_rows = ends.clone().count();
    let mut values = vec![0.0; window * n_rows * n];
    for (row, (path, end)) in ends.enumerate() {
        for step in 0..window {
            let Some(i) = (end + 1 + step).checked_sub(window) else { continue };
            let at = (step * n_rows + row) * n;
            values[at..at + n].copy_from_slice(&path[n * i..n * (i + 1)]);
        }
    }
    values
}

/// A network that learns from windows.
#[derive(Debug)]
pub struct WindowTask<'a> {
    options: &'a WindowOptions,
    n_inputs: usize,
    /// Half the range of each output, in the unit of errors.
    half_width: Vec<f64>,
    passes: Backprop,
    training: Vec<WindowedSequence>,
    validation: Vec<WindowedSequence>,
}

/// A path among several, and the last sample of a window in it.
type WindowEnd = (usize, usize);

impl<'a> WindowTask<'a> {
    /// Learns from `training`; the best weights are chosen by `validation`. `unit` is the unit of the outputs in that of errors,
    /// 1000 for metres in millimetres.
    ///
    /// # Errors
    /// Options out of range; `Tensors` if a card refuses.
    pub fn new(
        options: &'a WindowOptions,
        network: &Network,
        outputs: &Normaliser,
        unit: f64,
        [training, validation]: [Vec<WindowedSequence>; 2],
    ) -> Result<Self> {
        options.check()?;
        let half_width = outputs.channels.iter().map(|c| 0.5 * unit * (c.max - c.min)).collect();
        let n_inputs = network.architecture().inputs;
        let mut passes = Backprop::new(network.architecture(), options.seed)?;
        passes.set_gradient_floor(options.gradient_floor);
        Ok(Self { options, n_inputs, half_width, passes, training, validation })
    }

    /// Mean square error of each output in validation.
    ///
    /// # Errors
    /// As [`Backprop::predict`].
    pub fn squares(&self, network: &Network) -> Result<Vec<f64>> {
        let (ends, n) = (self.ends(&self.validation), self.half_width.len());
        let mut squares = vec![0.0; n];
        let placed = self.passes.place(network)?;
        for rows in ends.chunks(self.options.batch) {
            let (inputs, targets) = self.gather(&self.validation, rows);
            let mut memory = Memory::zeros(network.architecture(), rows.len());
            let found = placed.predict(&self.batch(&inputs, rows.len()), &mut memory)?;
            for (k, (found, target)) in found.iter().zip(targets).enumerate() {
                squares[k % n] += (self.half_width[k % n] * f64::from(found - target)).powi(2);
            }
        }
        Ok(squares.into_iter().map(|sum| sum / ends.len().max(1) as f64).collect())
    }

    /// Relative error that the floor of derivatives causes in the gradient of these weights [-]: the length
    /// of the difference over that of the whole gradient, on one batch of windows from all training paths.
    ///
    /// # Errors
    /// As [`Backprop::update`].
    pub fn gradient_floor_error(&self, network: &Network) -> Result<f64> {
        let all = self.ends(&self.training);
        let every = all.len().div_ceil(self.options.batch).max(1);
        let ends: Vec<WindowEnd> = all.into_iter().step_by(every).collect();
        let (inputs, targets) = self.gather(&self.training, &ends);
        let batch = self.batch(&inputs, ends.len());
        let gradient = |floor: f32| {
            let mut passes = Backprop::new(network.architecture(), self.options.seed)?;
            passes.set_gradient_floor(floor);
            let mut memory = Memory::zeros(network.architecture(), ends.len());
            passes
                .gradient(network, 0, &batch, &mut memory, |found, d| mean_squared_error(found, &targets, d))
        };
        let ((_, whole), (_, floored)) = (gradient(0.0)?, gradient(self.options.gradient_floor)?);
        let length = |values: &mut dyn Iterator<Item = f64>| values.map(|v| v * v).sum::<f64>().sqrt();
        let pairs = whole.iter().flatten().zip(floored.iter().flatten());
        let lost = length(&mut pairs.map(|(a, b)| f64::from(*a) - f64::from(*b)));
        Ok(lost / length(&mut whole.iter().flatten().map(|v| f64::from(*v))).max(f64::MIN_POSITIVE))
    }

    fn ends(&self, paths: &[WindowedSequence]) -> Vec<WindowEnd> {
        let of_path = |(k, path): (usize, &WindowedSequence)| {
            path.ends.iter().step_by(self.options.stride).map(move |&end| (k, end)).collect::<Vec<_>>()
        };
        paths.iter().enumerate().flat_map(of_path).collect()
    }

    /// Inputs [step][row][channel] and targets [row][channel].
    fn gather(&self, paths: &[WindowedSequence], ends: &[WindowEnd]) -> (Vec<f32>, Vec<f32>) {
        let n = self.half_width.len();
        let rows = ends.iter().map(|&(k, end)| (&paths[k].inputs[..], end));
        let targets = ends.iter().flat_map(|&(k, end)| &paths[k].targets[end * n..(end + 1) * n]);
        (windows(rows, self.options.window, self.n_inputs), targets.copied().collect())
    }

    fn batch<'b>(&self, inputs: &'b [f32], rows: usize) -> SequenceBatch<'b> {
        SequenceBatch { inputs, steps: self.options.window, rows, outputs: HeadOutputs::Last }
    }
}

impl TrainingTask<Network> for WindowTask<'_> {
    type Error = Error;

    fn schedule(&self) -> Schedule {
        let WindowOptions { epochs, learning_rate, weight_decay, decay_epochs, decay_factor, .. } =
            *self.options;
        Schedule {
            epochs,
            patience: epochs,
            adam: Adam { learning_rate, weight_decay, ..Adam::default() },
            decay: Decay::Step { epochs: decay_epochs, factor: decay_factor },
            ema: None,
        }
    }

    fn epoch(
        &mut self,
        training: &mut Training<Network>,
        on_step: &mut dyn FnMut(usize, usize) -> bool,
    ) -> Result<Option<f64>> {
        let mut ends = self.ends(&self.training);
        ends.shuffle(&mut rng(self.options.seed, &format!("windows/order/{}", training.epochs())));
        let batches = ends.chunks(self.options.batch);
        let (n_steps, mut sum, mut count) = (batches.len(), 0.0, 0.0);
        let architecture = training.model().architecture().clone();
        let mut updates = self.passes.updates(training)?;
        for (k, rows) in batches.enumerate() {
            let (inputs, targets) = self.gather(&self.training, rows);
            let mut memory = Memory::zeros(&architecture, rows.len());
            let batch = self.batch(&inputs, rows.len());
            let loss = updates
                .step(&batch, &mut memory, |found, gradient| mean_squared_error(found, &targets, gradient))?;
            sum += loss * rows.len() as f64;
            count += rows.len() as f64;
            if !on_step(k + 1, n_steps) {
                return Ok(None);
            }
        }
        updates.finish()?;
        let squares: Vec<f64> = self.half_width.iter().map(|width| width * width).collect();
        Ok(Some(mean(&squares) * sum / f64::max(count, 1.0)))
    }

    fn validate(&mut self, network: &Network) -> Result<f64> {
        Ok(mean(&self.squares(network)?).sqrt())
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)] // a test may stop where it stands

    use super::*;
    use crate::{ChannelRange, TrainingSession, fit};

    const OPTIONS: WindowOptions = WindowOptions {
        window: 8,
        stride: 1,
        hidden: 8,
        layers: 1,
        dropout: 0.0,
        epochs: 30,
        batch: 16,
        learning_rate: 2e-2,
        decay_epochs: 10,
        decay_factor: 0.5,
        weight_decay: 0.0,
        gradient_floor: 0.0,
        seed: 1,
    };

    #[test]
    fn windows_end_in_their_sample_and_begin_with_zeros() {
        let path: Vec<f32> = (1..=8).map(|v| v as f32).collect();
        let ends = [(&path[..], 1), (&path[..], 3)];
        // Steps of both rows: x, y; x, y.
        let expected = [0.0, 0.0, 3.0, 4.0, 1.0, 2.0, 5.0, 6.0, 3.0, 4.0, 7.0, 8.0];
        assert_eq!(windows(ends.iter().copied(), 3, 2), expected);
    }

    /// Play of half the range between input and output, which one sample cannot determine and a window can.
    fn play(n: usize, phase: f32) -> WindowedSequence {
        let inputs: Vec<f32> = (0..n).map(|i| (0.3 * i as f32 + phase).sin()).collect();
        let mut output = 0.0f32;
        let follow = |input: &f32| {
            output = output.clamp(input - 0.5, input + 0.5);
            output
        };
        WindowedSequence { targets: inputs.iter().map(follow).collect(), inputs, ends: (20..n).collect() }
    }

    fn outputs() -> Normaliser {
        Normaliser::new(vec![ChannelRange { name: "output".to_owned(), min: -0.5, max: 0.5 }]).unwrap()
    }

    fn network() -> Network {
        Network::new(&OPTIONS.architecture(1, 1, HeadActivation::Linear), 1).unwrap()
    }

    #[test]
    fn a_network_learns_from_windows_what_a_sample_does_not_tell() {
        let paths = [vec![play(120, 0.0), play(120, 1.0)], vec![play(120, 2.0)]];
        // The best estimate from one sample alone is the input itself, in the middle of both branches.
        let [held] = &paths[1][..] else { unreachable!() };
        let errors = held.ends.iter().map(|&i| f64::from(held.inputs[i] - held.targets[i]).powi(2));
        let alone = 500.0 * (errors.sum::<f64>() / held.ends.len() as f64).sqrt();
        let mut task = WindowTask::new(&OPTIONS, &network(), &outputs(), 1e3, paths).unwrap();
        let mut session = TrainingSession { file: None, progress: &mut |_| true };
        let found = fit(&mut task, network(), &hysteron_base::json!({}), &mut session).unwrap();
        assert!(found.validation < 0.25 * alone, "{} mm, without a window {alone} mm", found.validation);
    }

    #[test]
    fn the_step_size_decays_step_by_step() {
        let nothing = [Vec::new(), Vec::new()];
        let schedule = WindowTask::new(&OPTIONS, &network(), &outputs(), 1.0, nothing).unwrap().schedule();
        assert_eq!([0, 9, 10, 29].map(|epoch| schedule.learning_rate(epoch)), [2e-2, 2e-2, 1e-2, 5e-3]);
        assert_eq!((schedule.epochs, schedule.patience, schedule.ema), (30, 30, None));
    }

    #[test]
    #[cfg_attr(feature = "cuda", ignore = "acts on the processor")]
    fn what_a_floor_takes_from_the_gradient_is_measured() {
        let lost = |gradient_floor: f32| {
            let options = WindowOptions { gradient_floor, ..OPTIONS };
            let paths = [vec![play(120, 0.0)], Vec::new()];
            let task = WindowTask::new(&options, &network(), &outputs(), 1e3, paths).unwrap();
            task.gradient_floor_error(&network()).unwrap()
        };
        // Derivatives of a mean over 16 rows are some hundredths and less: all of it is below 1, part of it below 1e-3.
        assert_eq!(lost(0.0), 0.0);
        let (some, all) = (lost(1e-3), lost(1.0));
        assert!(1e-4 < some && some < 1.0 && some < all, "{some} {all}");
    }

    #[test]
    fn options_out_of_range_are_named() {
        let bad = [
            ("stride", WindowOptions { stride: 0, ..OPTIONS }),
            ("gradient_floor", WindowOptions { gradient_floor: -1.0, ..OPTIONS }),
            ("gradient_floor", WindowOptions { gradient_floor: f32::NAN, ..OPTIONS }),
        ];
        for (name, options) in bad {
            let refused = WindowTask::new(&options, &network(), &outputs(), 1.0, [Vec::new(), Vec::new()]);
            assert_eq!(refused.unwrap_err().to_string().split(':').next(), Some(name));
        }
    }
}
