//! A trained network in use: physical values in, physical values out, one sample at a time.

use std::collections::VecDeque;

use crate::{Network, NetworkRunner, Normaliser, WeightFormat};

/// Part of a training range by which inputs may leave it before they count as extrapolation.
pub const RANGE_MARGIN: f64 = 0.02;
/// How far outputs may leave [-1, 1], the range of training: the output of a network far from its data is no reason to
/// pull.
const OUTPUT_MAX: f32 = 1.25;

/// A network with the ranges of its channels and its memory.
#[derive(Debug, Clone)]
pub struct Predictor<'a> {
    inputs: &'a Normaliser,
    outputs: &'a Normaliser,
    runner: NetworkRunner,
    /// Normalised inputs of the samples that a sliding window reaches back to, oldest first; none of a recurrent network.
    window: Option<VecDeque<Vec<f32>>>,
    normalised: Vec<f32>,
    bounded: Vec<f32>,
}

impl<'a> Predictor<'a> {
    /// A recurrent predictor, before the first sample.
    pub fn recurrent(
        network: &Network,
        [inputs, outputs]: [&'a Normaliser; 2],
        format: WeightFormat,
    ) -> Self {
        Self {
            runner: NetworkRunner::with_weights(network, format),
            window: None,
            normalised: vec![0.0; inputs.channels.len()],
            bounded: vec![0.0; outputs.channels.len()],
            inputs,
            outputs,
        }
    }

    /// A sliding-window predictor, before the first sample: each step recomputes the last so many samples;
    /// zeros come before the first one, as in training.
    pub fn windowed(network: &Network, ranges: [&'a Normaliser; 2], window: usize) -> Self {
        let predictor = Self::recurrent(network, ranges, WeightFormat::Float32);
        let before = std::iter::repeat_n(predictor.normalised.clone(), window).collect();
        Self { window: Some(before), ..predictor }
    }

    /// One sample further: writes the outputs, at most a quarter beyond their ranges. True where an input lies outside its range by
    /// more than [`RANGE_MARGIN`]. Does not allocate.
    ///
    /// # Panics
    /// If either has another number of channels than the network.
    pub fn step(&mut self, inputs: &[f64], outputs: &mut [f64]) -> bool {
        self.inputs.normalise_into(inputs, &mut self.normalised);
        let found = match &mut self.window {
            None => self.runner.step(&self.normalised),
            Some(window) => {
                let mut oldest = window.pop_front().unwrap_or_default();
                oldest.copy_from_slice(&self.normalised);
                window.push_back(oldest);
                self.runner.reset();
                let last = window.len() - 1;
                for inputs in window.iter().take(last) {
                    self.runner.step(inputs);
                }
                self.runner.step(&window[last])
            }
        };
        restore_bounded(self.outputs, found, &mut self.bounded, outputs);
        self.inputs.is_outside(inputs, RANGE_MARGIN)
    }

    /// The inputs of the last sample, normalised.
    pub fn normalised(&self) -> &[f32] {
        &self.normalised
    }
}

/// Writes what normalised outputs mean, at most a quarter beyond their ranges; `bounded` is scratch of the same length.
pub fn restore_bounded(ranges: &Normaliser, found: &[f32], bounded: &mut [f32], outputs: &mut [f64]) {
    for (kept, found) in bounded.iter_mut().zip(found) {
        *kept = found.clamp(-OUTPUT_MAX, OUTPUT_MAX);
    }
    ranges.restore_into(bounded, outputs);
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)] // a test may stop where it stands

    use super::*;
    use crate::{Architecture, ChannelRange, HeadActivation};

    fn range(name: &str, half: f64) -> Normaliser {
        Normaliser::new(vec![ChannelRange { name: name.to_owned(), min: -half, max: half }]).unwrap()
    }

    fn network() -> Network {
        let architecture = Architecture {
            inputs: 1,
            hidden: 4,
            layers: 1,
            outputs: 1,
            head: HeadActivation::Linear,
            dropout: 0.0,
        };
        Network::new(&architecture, 3).unwrap()
    }

    #[test]
    fn a_window_as_long_as_the_past_equals_the_cells() {
        let (network, ranges) = (network(), [range("u", 2.0), range("y", 5.0)]);
        let ranges = [&ranges[0], &ranges[1]];
        let mut cells = Predictor::recurrent(&network, ranges, WeightFormat::Float32);
        // Zeros before the beginning are samples too: the cells get them here.
        let mut window = Predictor::windowed(&network, ranges, 4);
        for _ in 0..3 {
            cells.step(&[0.0], &mut [0.0]);
        }
        let (mut a, mut b) = ([0.0], [0.0]);
        assert!(!cells.step(&[1.5], &mut a) && !window.step(&[1.5], &mut b));
        assert_eq!(a, b);
        assert_ne!(a, [0.0]);
    }

    #[test]
    fn inputs_outside_their_range_are_reported() {
        let (network, ranges) = (network(), [range("u", 2.0), range("y", 5.0)]);
        let mut predictor = Predictor::recurrent(&network, [&ranges[0], &ranges[1]], WeightFormat::Float32);
        let mut is_outside = |u: f64| predictor.step(&[u], &mut [0.0]);
        // The margin is a fiftieth of the range of 4.
        assert!(!is_outside(2.07) && is_outside(2.09) && is_outside(-2.09));
    }
}
