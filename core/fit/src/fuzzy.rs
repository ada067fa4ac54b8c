//! Fuzzy networks of one input: five Gaussian memberships, consequents that are lines (ANFIS) or constants (FNN).
//!
//! # Reference
//! Wan et al. (2026), eqs. 4 to 10: gradient on centres and widths, rate 0.005, at most 100 passes, batches of 10; consequents of the
//! ANFIS by least squares (Jang, 1993). The FNN is not specified there: constants, by gradient alone.

use nalgebra::{DMatrix, DVector};

/// Rules M of every network.
const RULES: usize = 5;
/// Rate β of the gradient.
const RATE: f64 = 0.005;
/// Passes over the data.
const PASSES: usize = 100;
/// Samples of a step.
const BATCH: usize = 10;

/// Form of a rule's consequent.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Consequents {
    /// p₀ + p₁ x, by least squares in every pass.
    Lines,
    /// p₀, by gradient.
    Constants,
}

/// y = Σ α_j y_j / Σ α_j.
#[derive(Debug, Clone)]
pub struct FuzzyNetwork {
    consequents: Consequents,
    centers: [f64; RULES],
    widths: [f64; RULES],
    /// p₀ and p₁ of every rule, in units of the scale.
    lines: [[f64; 2]; RULES],
    /// Largest output: learning rates are for outputs of order one.
    scale: f64,
    /// Least input and the range of inputs: rates are for inputs from 0 to 1.
    range: [f64; 2],
}

impl FuzzyNetwork {
    /// Memberships spread evenly over `least` to `most`, for outputs of the size of those in `pairs`: (input, output).
    pub fn new(consequents: Consequents, [least, most]: [f64; 2], pairs: &[(f64, f64)]) -> Self {
        let step = 1.0 / (RULES - 1) as f64;
        Self {
            consequents,
            centers: std::array::from_fn(|j| step * j as f64),
            widths: [0.5 * step; RULES],
            lines: [[0.0; 2]; RULES],
            scale: pairs.iter().fold(f64::MIN_POSITIVE, |m, (_, y)| m.max(y.abs())),
            range: [least, (most - least).max(f64::MIN_POSITIVE)],
        }
    }

    /// Place of an input within the range, 0 to 1.
    fn place(&self, x: f64) -> f64 {
        (x - self.range[0]) / self.range[1]
    }

    /// Shares of the rules at a place; they sum to one.
    fn shares(&self, x: f64) -> [f64; RULES] {
        let logs: [f64; RULES] =
            std::array::from_fn(|j| -0.5 * ((x - self.centers[j]) / self.widths[j]).powi(2));
        let most = logs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let strengths = logs.map(|log| (log - most).exp());
        let sum: f64 = strengths.iter().sum();
        strengths.map(|s| s / sum)
    }

    /// Output at `x`, an input in its own unit.
    pub fn at(&self, x: f64) -> f64 {
        let x = self.place(x);
        let mean: f64 =
            self.shares(x).iter().zip(&self.lines).map(|(share, [p0, p1])| share * (p0 + p1 * x)).sum();
        self.scale * mean
    }

    /// Fits the network to pairs of input and output; returns the root mean square error after every pass.
    pub fn fit(&mut self, pairs: &[(f64, f64)]) -> Vec<f64> {
        let passes = (0..PASSES).map(|_| {
            if self.consequents == Consequents::Lines {
                self.solve_lines(pairs);
            }
            pairs.chunks(BATCH).for_each(|batch| self.descend(batch));
            self.error(pairs)
        });
        let mut errors: Vec<f64> = passes.collect();
        if self.consequents == Consequents::Lines {
            self.solve_lines(pairs);
            errors.push(self.error(pairs));
        }
        errors
    }

    /// Root mean square error.
    pub fn error(&self, pairs: &[(f64, f64)]) -> f64 {
        (pairs.iter().map(|(x, y)| (self.at(*x) - y).powi(2)).sum::<f64>() / pairs.len() as f64).sqrt()
    }

    /// Lines that are best for the memberships as they are.
    fn solve_lines(&mut self, pairs: &[(f64, f64)]) {
        let rows = DMatrix::from_fn(pairs.len(), 2 * RULES, |i, k| {
            let x = self.place(pairs[i].0);
            self.shares(x)[k / 2] * if k % 2 == 0 { 1.0 } else { x }
        });
        let side = DVector::from_fn(pairs.len(), |i, _| pairs[i].1 / self.scale);
        if let Ok(found) = rows.svd(true, true).solve(&side, 1e-9) {
            for (j, line) in self.lines.iter_mut().enumerate() {
                *line = [found[2 * j], found[2 * j + 1]];
            }
        }
    }

    /// One step against the gradient of E = ½ Σ (t − y)² over a batch.
    fn descend(&mut self, batch: &[(f64, f64)]) {
        let [mut by_center, mut by_width, mut by_constant] = [[0.0; RULES]; 3];
        for (input, target) in batch {
            let x = self.place(*input);
            let shares = self.shares(x);
            let outputs = self.lines.map(|[p0, p1]| p0 + p1 * x);
            let y: f64 = shares.iter().zip(outputs).map(|(s, o)| s * o).sum();
            let error = y - target / self.scale;
            for j in 0..RULES {
                let away = x - self.centers[j];
                let pull = error * (outputs[j] - y) * shares[j];
                by_center[j] += pull * away / self.widths[j].powi(2);
                by_width[j] += pull * away * away / self.widths[j].powi(3);
                by_constant[j] += error * shares[j];
            }
        }
        for j in 0..RULES {
            self.centers[j] -= RATE * by_center[j];
            // A membership without width is none.
            self.widths[j] = (self.widths[j] - RATE * by_width[j]).max(0.02);
            if self.consequents == Consequents::Constants {
                self.lines[j][0] -= RATE * by_constant[j];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(slope: f64) -> Vec<(f64, f64)> {
        (0..60).map(|k| 0.05 * f64::from(k)).map(|x| (x, 1.5 + slope * x)).collect()
    }

    #[test]
    fn rules_with_lines_hold_a_line_exactly() {
        let pairs = line(-0.7);
        let mut network = FuzzyNetwork::new(Consequents::Lines, [0.0, 3.0], &pairs);
        let errors = network.fit(&pairs);
        // Shares sum to one, so lines that are all alike are the line; the singular values cut at 1e-9 are what is left.
        assert!(errors.last().is_some_and(|error| *error < 1e-7), "{:?}", errors.last());
        assert!((network.at(1.234) - (1.5 - 0.7 * 1.234)).abs() < 1e-6);
    }

    #[test]
    fn a_fit_does_not_depend_on_the_units_of_input_and_output() {
        let curve = |x: f64| 2.0 + (-x * x).exp() + 0.3 * x;
        let pairs = |x_unit: f64, y_unit: f64| -> Vec<(f64, f64)> {
            (0..80).map(|k| 0.05 * f64::from(k)).map(|x| (x * x_unit, curve(x) * y_unit)).collect()
        };
        for consequents in [Consequents::Lines, Consequents::Constants] {
            let [plain, scaled] = [(1.0, 1.0), (64.0, 0.125)].map(|(x_unit, y_unit)| {
                let pairs = pairs(x_unit, y_unit);
                let mut network = FuzzyNetwork::new(consequents, [0.0, 4.0 * x_unit], &pairs);
                network.fit(&pairs);
                network.at(1.7 * x_unit) / y_unit
            });
            // Powers of two: only the cut of singular values may have another rounding.
            assert!((plain - scaled).abs() < 1e-9 * plain.abs(), "{consequents:?}: {plain} {scaled}");
        }
    }

    #[test]
    fn constants_err_more_than_lines_on_a_curve() {
        let pairs: Vec<(f64, f64)> = (0..100)
            .map(|k| 0.01 * f64::from(k))
            .map(|x| (x, 6.0 + 5.0 * (-(x / 0.2) * (x / 0.2)).exp() + 12.0 * x))
            .collect();
        let error = |consequents| {
            let mut network = FuzzyNetwork::new(consequents, [0.0, 1.0], &pairs);
            network.fit(&pairs);
            network.error(&pairs)
        };
        let [lines, constants] = [Consequents::Lines, Consequents::Constants].map(error);
        assert!(lines < 0.05 && constants > 3.0 * lines, "{lines} {constants}");
    }
}
