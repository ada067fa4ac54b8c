//! The loss of the recurrent design.
//!
//! For every sample, in mm² and with the error e of the strokes: their mean square; what that does at the tip
//! through the twin's Jacobian, where it was recorded; how fast the error changes, so that strokes stay smooth; and
//! how much the common pull of all tendons falls short of a least one, so that none goes slack.

use hysteron_learn::Evaluation;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Weights of the terms.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct LossWeights {
    /// Of the tip's error over that of the strokes [-].
    pub tip: f64,
    /// Time for which an error that changes counts as much as one of that size [s].
    pub smooth_s: f64,
    /// Of the missing common pull [-].
    pub pull: f64,
    /// Least mean of all strokes [m].
    pub co_contraction_min_m: f64,
}

/// A trajectory as arrays of the network.
pub(super) struct TrajectoryArrays {
    /// Normalised features (n × inputs).
    pub features: Vec<f32>,
    /// Stroke where the network's output is zero, less the commanded one (n × n_tendons) [mm].
    pub offset: Vec<f32>,
    /// Mean of the commanded strokes (n) [mm].
    pub pull: Vec<f32>,
    /// ∂tip/∂stroke (n × axes × n_tendons) [-]; empty where it was not recorded.
    pub jacobian: Vec<f32>,
    /// 0 where the tip was filled in, 1 otherwise (n).
    pub weight: Vec<f32>,
}

impl TrajectoryArrays {
    pub fn len(&self) -> usize {
        self.weight.len()
    }
}

/// The loss over parts of rows.
pub(super) struct Loss {
    /// Stroke for an output of 1, by tendon [mm].
    pub gain: Vec<f32>,
    /// Weight of the tip's error [-].
    pub tip: f32,
    /// Weight of the change of an error from sample to sample [-].
    pub smooth: f32,
    /// Weight of the missing common pull [-].
    pub pull: f32,
    /// Least common pull [mm].
    pub co_contraction_min: f32,
}

impl Loss {
    pub fn new(weights: &LossWeights, gain: Vec<f32>, step: f64) -> Self {
        Self {
            gain,
            tip: weights.tip as f32,
            smooth: (weights.smooth_s / step).powi(2) as f32,
            pull: weights.pull as f32,
            co_contraction_min: (1e3 * weights.co_contraction_min_m) as f32,
        }
    }

    /// Errors of the strokes [mm] for outputs [step][row][tendon] that begin at sample `start`; zero after
    /// the end of a row.
    fn errors(&self, rows: &[TrajectoryArrays], start: usize, outputs: &[f32]) -> Vec<f32> {
        let n = self.gain.len();
        let mut errors = vec![0.0; outputs.len()];
        for (k, (outputs, errors)) in outputs.chunks_exact(n).zip(errors.chunks_exact_mut(n)).enumerate() {
            let (i, row) = (start + k / rows.len(), &rows[k % rows.len()]);
            if i < row.len() {
                let offset = &row.offset[i * n..(i + 1) * n];
                for c in 0..n {
                    errors[c] = self.gain[c] * outputs[c] + offset[c];
                }
            }
        }
        errors
    }

    /// The sums over a truncation length, and the gradient of the mean loss by its outputs. Behind the squares of the strokes comes
    /// that of the tip, as the loss has it.
    pub fn evaluate(
        &self,
        rows: &[TrajectoryArrays],
        start: usize,
        outputs: &[f32],
        gradient: &mut [f32],
    ) -> Evaluation {
        let n = self.gain.len();
        let width = n * rows.len();
        let errors = self.errors(rows, start, outputs);
        let mut sums = Evaluation { squares: vec![0.0; n + 1], ..Evaluation::default() };
        for k in 0..outputs.len() / n {
            let (i, row) = (start + k / rows.len(), &rows[k % rows.len()]);
            let weight = row.weight.get(i).copied().unwrap_or(0.0);
            if weight == 0.0 {
                continue;
            }
            let at = k * n;
            sums.count += f64::from(weight);
            let (loss, tip) = self.sample(row, i, &errors[at..at + n], &mut gradient[at..at + n]);
            sums.loss += f64::from(loss);
            sums.squares[n] += f64::from(tip);
            for (sum, error) in sums.squares.iter_mut().zip(&errors[at..at + n]) {
                *sum += f64::from(error * error);
            }
            // The memory before a truncation is a constant, and so is its last error: no term.
            if k >= rows.len() && row.weight[i - 1] > 0.0 {
                sums.loss += f64::from(self.change(&errors, at, at - width, gradient, n));
            }
        }
        let scale = 1.0 / f64::max(sums.count, 1.0) as f32;
        for (gradient, gain) in gradient.iter_mut().zip(self.gain.iter().cycle()) {
            *gradient *= scale * gain;
        }
        sums
    }

    /// Terms of one sample, of all and of its tip, and their gradient by its errors.
    fn sample(&self, row: &TrajectoryArrays, i: usize, errors: &[f32], gradient: &mut [f32]) -> (f32, f32) {
        let n = errors.len();
        let per_tendon = 1.0 / n as f32;
        let mut loss = per_tendon * errors.iter().map(|e| e * e).sum::<f32>();
        for (gradient, error) in gradient.iter_mut().zip(errors) {
            *gradient += 2.0 * per_tendon * error;
        }
        let mut at_tip = 0.0;
        if !row.jacobian.is_empty() {
            let size = row.jacobian.len() / row.len();
            let weight = self.tip * n as f32 / size as f32;
            for axis in row.jacobian[size * i..size * (i + 1)].chunks_exact(n) {
                let tip: f32 = axis.iter().zip(errors).map(|(j, e)| j * e).sum();
                at_tip += weight * tip * tip;
                for (gradient, j) in gradient.iter_mut().zip(axis) {
                    *gradient += 2.0 * weight * j * tip;
                }
            }
        }
        loss += at_tip;
        let short = self.co_contraction_min - row.pull[i] - per_tendon * errors.iter().sum::<f32>();
        if short > 0.0 {
            loss += self.pull * short * short;
            gradient.iter_mut().for_each(|gradient| *gradient -= 2.0 * self.pull * short * per_tendon);
        }
        (loss, at_tip)
    }

    /// The term of the change from the errors at `before` to those at `at`.
    fn change(&self, errors: &[f32], at: usize, before: usize, gradient: &mut [f32], n: usize) -> f32 {
        let weight = self.smooth / n as f32;
        let mut loss = 0.0;
        for c in 0..n {
            let change = errors[at + c] - errors[before + c];
            loss += weight * change * change;
            gradient[at + c] += 2.0 * weight * change;
            gradient[before + c] -= 2.0 * weight * change;
        }
        loss
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use hysteron_base::rng;
    use rand::RngExt;

    /// Two rows of two tendons, one shorter than the other and with a gap.
    fn rows() -> Vec<TrajectoryArrays> {
        let mut stream = rng(1, "loss");
        let mut uniform = |n: usize| (0..n).map(|_| stream.random_range(-1.0..1.0)).collect::<Vec<f32>>();
        let mut row = |n: usize, has_jacobian: bool| TrajectoryArrays {
            features: Vec::new(),
            offset: uniform(2 * n),
            pull: uniform(n),
            jacobian: if has_jacobian { uniform(4 * n) } else { Vec::new() },
            weight: (0..n).map(|i| if i == 2 { 0.0 } else { 1.0 }).collect(),
        };
        vec![row(6, true), row(4, false)]
    }

    #[test]
    fn the_gradient_is_the_derivative_of_every_term() {
        let rows = rows();
        let outputs: Vec<f32> = (0..5 * 2 * 2).map(|k| (k as f32).sin()).collect();
        for term in 0..4 {
            let on = |k: usize| if term == k { 3.0 } else { 0.0 };
            let loss = Loss {
                gain: vec![0.5, 2.0],
                tip: on(1),
                smooth: on(2),
                pull: on(3),
                co_contraction_min: 0.2,
            };
            let mut gradient = vec![0.0; outputs.len()];
            let sums = loss.evaluate(&rows, 1, &outputs, &mut gradient);
            assert_eq!(sums.count, 4.0 + 2.0, "samples 1 to 5 and 1 to 3, less one in a gap each");
            let value = |outputs: &[f32]| {
                loss.evaluate(&rows, 1, outputs, &mut vec![0.0; outputs.len()]).loss / sums.count
            };
            // A quadratic between its breakpoints: central differences are exact but for rounding of f32,
            // about 1e-7 of a loss of up to 100 over a step of 0.02.
            for k in 0..outputs.len() {
                let at = |by: f32| {
                    let mut moved = outputs.clone();
                    moved[k] += by;
                    value(&moved)
                };
                let expected = (at(0.01) - at(-0.01)) / 0.02;
                let tolerance = 1e-3 * expected.abs().max(1.0);
                assert!((f64::from(gradient[k]) - expected).abs() < tolerance, "{term} {k}: {expected}");
            }
            assert!(gradient.iter().any(|g| *g != 0.0));
        }
    }

    #[test]
    fn right_strokes_with_enough_pull_cost_nothing() {
        let mut rows = rows();
        for row in &mut rows {
            row.offset.fill(0.0);
            row.pull.fill(0.3);
        }
        let loss = Loss { gain: vec![1.0; 2], tip: 1.0, smooth: 1.0, pull: 1.0, co_contraction_min: 0.2 };
        let mut gradient = vec![0.0; 16];
        assert_eq!(loss.evaluate(&rows, 0, &[0.0; 16], &mut gradient).loss, 0.0);
        assert!(gradient.iter().all(|g| *g == 0.0));
    }
}
