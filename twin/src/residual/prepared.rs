//! Trajectories as inputs of the recurrent design: in the coordinates of the decoder, then as arrays of the
//! network.

use std::ops::Range;

use hysteron_base::BadInput;
use hysteron_learn::{Evaluation, Normaliser, Sequences};

use super::decoder::Decoding;
use super::linear::Equation;
use super::{FeatureSpec, Features, LinearPart, Sequence, StrokeDecoder};

/// Ranges of the missing tip displacement that the linear part does not predict.
pub(super) fn output_ranges(
    trajectories: &[&LinearisedTrajectory],
    linear: &LinearPart,
) -> std::result::Result<Normaliser, BadInput> {
    let (mut samples, mut terms) = (Vec::new(), Vec::new());
    for one in trajectories {
        for (i, (undone, gain)) in one.undone.iter().zip(&one.gain).enumerate() {
            let displacement = linear.displacement(one.features_at(i), &mut terms);
            let done = |a: usize| (0..3).map(|c| gain[a][c] * displacement[c]).sum::<f64>();
            samples.extend((0..3).map(|a| -undone[a] - done(a)));
        }
    }
    let names = ["residual_x_m", "residual_y_m", "residual_z_m"];
    let ranges = Normaliser::from_samples(&names, samples.chunks_exact(3))?;
    // A millimetre is as much along every axis: in a range of its own, an axis of small displacements would
    // be fitted later, and the training might end before. A constant channel still needs a range for the fit.
    let widest = ranges.channels.iter().map(|channel| channel.max - channel.min).fold(1e-6, f64::max);
    ranges.widened(widest)
}

/// A trajectory near the identified strokes, in the coordinates of the decoder.
pub(super) struct LinearisedTrajectory {
    /// Normalised features of the strokes (n × n_of_strokes).
    features: Vec<f32>,
    n_features: usize,
    /// Measured tip, normalised (n); zeros where it is no input of the network.
    measured: Vec<[f32; 3]>,
    /// Response of the tip to a displacement, G D (n, 3 × 3) [-].
    gain: Vec<[[f64; 3]; 3]>,
    /// Tip without auxiliary strokes, y* - G s*, less the measured one (n) [m].
    undone: Vec<[f64; 3]>,
    /// True where the tip was filled in.
    gap: Vec<bool>,
}

impl LinearisedTrajectory {
    pub fn new(
        sequence: &Sequence,
        spec: &FeatureSpec,
        decoder: &StrokeDecoder,
        inputs: &Normaliser,
    ) -> Self {
        let (n, n_features) = (sequence.len(), spec.n_of_strokes());
        let mut features = Features::new(spec);
        let (mut row, mut normalised) = (Vec::new(), vec![0.0f32; spec.len()]);
        let mut scratch = Decoding::new(sequence.auxiliary.len());
        let mut one = Self {
            features: Vec::with_capacity(n * n_features),
            n_features,
            measured: Vec::with_capacity(n),
            gain: Vec::with_capacity(n),
            undone: Vec::with_capacity(n),
            gap: sequence.gap.clone(),
        };
        for i in 0..n {
            row.clear();
            features.append(sequence.strokes_at(i), &mut row);
            if spec.feedback {
                row.extend_from_slice(&sequence.measured[i]);
            }
            inputs.normalise_into(&row, &mut normalised);
            one.features.extend_from_slice(&normalised[..n_features]);
            let tip = &normalised[n_features..];
            one.measured.push(std::array::from_fn(|c| tip.get(c).copied().unwrap_or(0.0)));
            let g = sequence.sensitivity_at(i);
            one.gain.push(decoder.seen_by(&g, sequence.strokes_at(i), &mut scratch));
            one.undone.push(std::array::from_fn(|a| {
                sequence.twin[i][a] - by(&g[a], sequence.auxiliary_at(i)) - sequence.measured[i][a]
            }));
        }
        one
    }

    fn features_at(&self, sample: usize) -> &[f32] {
        &self.features[sample * self.n_features..(sample + 1) * self.n_features]
    }

    /// Errors of x, y and z in the samples that were measured, where nothing is added, and where the linear part alone is [mm].
    pub fn errors(&self, linear: &LinearPart) -> Vec<[[f64; 3]; 2]> {
        let mut terms = Vec::new();
        let error = |i: usize| {
            let displacement = linear.displacement(self.features_at(i), &mut terms);
            let added = |a: usize| (0..3).map(|c| self.gain[i][a][c] * displacement[c]).sum::<f64>();
            let undone = self.undone[i].map(|error| 1e3 * error);
            [undone, std::array::from_fn(|a| undone[a] + 1e3 * added(a))]
        };
        (0..self.gap.len()).filter(|&i| !self.gap[i]).map(error).collect()
    }

    /// Some samples, for least squares.
    pub fn equations(&self) -> impl Iterator<Item = Equation<'_>> {
        let measured = (0..self.gap.len()).step_by(FITTED_EVERY).filter(|&i| !self.gap[i]);
        measured.map(|i| Equation {
            features: self.features_at(i),
            gain: self.gain[i],
            error: self.undone[i],
        })
    }
}

/// Samples of which least squares use one: neighbours are alike.
const FITTED_EVERY: usize = 5;

fn by(axis: &[f64], strokes: impl Iterator<Item = f64>) -> f64 {
    axis.iter().zip(strokes).map(|(g, stroke)| g * stroke).sum()
}

/// A trajectory as arrays of the network.
#[derive(Clone)]
pub(super) struct PreparedTrajectory {
    /// Normalised features of the strokes (n × n_of_strokes).
    features: Vec<f32>,
    /// Tip where the network's output is zero, y* - G s*, less the measured one (n) [mm].
    offset: Vec<[f32; 3]>,
    /// Response of that to the network's outputs: G D over the outputs' ranges (n, 3 × 3) [mm].
    gain: Vec<[[f32; 3]; 3]>,
    /// 0 where the tip was filled in.
    weight: Vec<f32>,
    /// Measured tip, normalised (n).
    measured: Vec<[f32; 3]>,
    /// Normalised tip per millimetre, by axis.
    tip_scale: [f32; 3],
    /// Tip that enters the network (n), normalised; of the sample before.
    feedback: Vec<[f32; 3]>,
    /// Squared distance of the tip by the last evaluation (n) [mm²].
    squares: Vec<f32>,
}

pub(super) fn prepare(
    one: &LinearisedTrajectory,
    spec: &FeatureSpec,
    linear: &LinearPart,
    inputs: &Normaliser,
    outputs: &Normaliser,
) -> PreparedTrajectory {
    let (n, mut terms) = (one.gap.len(), Vec::new());
    let mut prepared = PreparedTrajectory {
        features: one.features.clone(),
        offset: Vec::with_capacity(n),
        gain: Vec::with_capacity(n),
        weight: one.gap.iter().map(|gap| f32::from(u8::from(!gap))).collect(),
        measured: one.measured.clone(),
        tip_scale: [0.0; 3],
        feedback: one.measured.clone(),
        squares: vec![0.0; n],
    };
    if spec.feedback {
        for (scale, channel) in prepared.tip_scale.iter_mut().zip(&inputs.channels[spec.n_of_strokes()..]) {
            *scale = (2e-3 / (channel.max - channel.min).max(f64::MIN_POSITIVE)) as f32;
        }
    }
    for (i, gain) in one.gain.iter().enumerate() {
        let displacement = linear.displacement(one.features_at(i), &mut terms);
        // A normalised output o means min + (o + 1)/2 (max - min).
        let half = |c: usize| 0.5 * (outputs.channels[c].max - outputs.channels[c].min);
        let middle = |c: usize| outputs.channels[c].min + half(c);
        prepared.gain.push(gain.map(|row| std::array::from_fn(|c| (1e3 * row[c] * half(c)) as f32)));
        prepared.offset.push(std::array::from_fn(|a| {
            let constant: f64 = (0..3).map(|c| gain[a][c] * (displacement[c] + middle(c))).sum();
            (1e3 * (one.undone[i][a] + constant)) as f32
        }));
    }
    prepared
}

/// Trajectories side by side, for one network. The tip that it sees is its own of the pass before (measured at first): once the
/// weights settle, that is its own feedback.
pub(super) struct TipSequences<'a> {
    sequences: Vec<PreparedTrajectory>,
    spec: &'a FeatureSpec,
    /// Widths of the noise on normalised features [-] and on the tip [mm].
    widths: [f32; 2],
}

impl<'a> TipSequences<'a> {
    /// `noise`: the width of that on normalised features [-], and the standard deviation of that on the tip [m].
    pub fn new(sequences: Vec<PreparedTrajectory>, spec: &'a FeatureSpec, noise: [f64; 2]) -> Self {
        let of_tip = (1e3 * noise[1] * 12f64.sqrt()) as f32;
        Self { sequences, spec, widths: [noise[0] as f32, of_tip] }
    }

    /// Distances of the tip by the last evaluation in the samples that were measured, trajectory by trajectory [mm].
    pub fn distances(&self) -> impl Iterator<Item = Vec<f64>> {
        self.sequences.iter().map(|one| {
            let measured = one.squares.iter().zip(&one.weight).filter(|(_, weight)| **weight > 0.0);
            measured.map(|(square, _)| f64::from(*square).sqrt()).collect()
        })
    }
}

impl Sequences for TipSequences<'_> {
    fn rows(&self) -> usize {
        self.sequences.len()
    }

    fn longest(&self) -> usize {
        self.sequences.iter().map(|sequence| sequence.offset.len()).max().unwrap_or(0)
    }

    fn inputs(&mut self, samples: Range<usize>, noise: &mut dyn FnMut() -> f32) -> Vec<f32> {
        let (n_features, [input_width, tip_width]) = (self.spec.n_of_strokes(), self.widths);
        let mut inputs = Vec::with_capacity(samples.len() * self.sequences.len() * self.spec.len());
        for i in samples {
            for sequence in &self.sequences {
                // After its end the last sample of a trajectory is repeated; it is not evaluated there.
                let i = i.min(sequence.offset.len() - 1);
                let features = &sequence.features[i * n_features..(i + 1) * n_features];
                inputs.extend(features.iter().map(|value| value + input_width * noise()));
                if self.spec.feedback {
                    let tip = sequence.feedback[i.saturating_sub(1)];
                    let added = |c: usize| tip_width * sequence.tip_scale[c];
                    inputs.extend((0..3).map(|c| tip[c] + added(c) * noise()));
                }
            }
        }
        inputs
    }

    /// Squared errors at the tip [mm²]; leaves the tip of each sample in `feedback` for the next pass.
    fn evaluate(&mut self, start: usize, outputs: &[f32], mut gradient: Option<&mut [f32]>) -> Evaluation {
        let n_rows = self.sequences.len();
        let mut all = Evaluation { squares: vec![0.0; 3], ..Evaluation::default() };
        for (k, output) in outputs.as_chunks::<3>().0.iter().enumerate() {
            let (i, row) = (start + k / n_rows, k % n_rows);
            let sequence = &mut self.sequences[row];
            if i >= sequence.offset.len() {
                continue;
            }
            let (gain, offset, weight) = (&sequence.gain[i], sequence.offset[i], sequence.weight[i]);
            let error: [f32; 3] =
                std::array::from_fn(|a| offset[a] + (0..3).map(|c| gain[a][c] * output[c]).sum::<f32>());
            let square = error.iter().map(|e| e * e).sum::<f32>();
            sequence.squares[i] = square;
            all.loss += f64::from(weight * square);
            for (sum, e) in all.squares.iter_mut().zip(error) {
                *sum += f64::from(weight * e * e);
            }
            all.count += f64::from(weight);
            if let Some(gradient) = gradient.as_deref_mut() {
                for c in 0..3 {
                    gradient[3 * k + c] = 2.0 * weight * (0..3).map(|a| gain[a][c] * error[a]).sum::<f32>();
                }
            }
            let measured = sequence.measured[i];
            sequence.feedback[i] = std::array::from_fn(|c| measured[c] + error[c] * sequence.tip_scale[c]);
        }
        if let Some(gradient) = gradient {
            let scale = 1.0 / f64::max(all.count, 1.0) as f32;
            gradient.iter_mut().for_each(|g| *g *= scale);
        }
        all
    }

    /// [mm].
    fn error(&self, all: &Evaluation) -> f64 {
        all.mean().sqrt()
    }
}
