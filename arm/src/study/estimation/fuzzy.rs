//! Fuzzy networks of one input: five Gaussian memberships, consequents that are lines (ANFIS) or constants (FNN).
//!
//! # Reference
//! Wan et al. (2026), eqs. 4 to 10: gradient on centres and widths, rate 0.005, at most 100 passes, batches of 10; consequents of the
//! ANFIS by least squares (Jang, 1993). The FNN is not specified there: constants, by gradient alone.

use nalgebra::{DMatrix, DVector};

/// Rules M.
const RULES: usize = 5;
/// Rate β of the gradient.
const RATE: f64 = 0.005;
/// Passes over the data.
const PASSES: usize = 100;
/// Samples of a step.
const BATCH: usize = 10;

/// What a rule says.
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
}

impl FuzzyNetwork {
    /// Memberships spread evenly over `least` to `most`, for outputs of the size of those in `pairs`.
    pub fn new(consequents: Consequents, [least, most]: [f64; 2], pairs: &[(f64, f64)]) -> Self {
        let step = (most - least) / (RULES - 1) as f64;
        Self {
            consequents,
            centers: std::array::from_fn(|j| least + step * j as f64),
            widths: [0.5 * step; RULES],
            lines: [[0.0; 2]; RULES],
            scale: pairs.iter().fold(f64::MIN_POSITIVE, |m, (_, y)| m.max(y.abs())),
        }
    }

    /// Shares of the rules at `x`; they sum to one.
    fn shares(&self, x: f64) -> [f64; RULES] {
        let logs: [f64; RULES] =
            std::array::from_fn(|j| -0.5 * ((x - self.centers[j]) / self.widths[j]).powi(2));
        let most = logs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let strengths = logs.map(|log| (log - most).exp());
        let sum: f64 = strengths.iter().sum();
        strengths.map(|s| s / sum)
    }

    /// Output at `x`.
    pub fn at(&self, x: f64) -> f64 {
        let mean: f64 =
            self.shares(x).iter().zip(&self.lines).map(|(share, [p0, p1])| share * (p0 + p1 * x)).sum();
        self.scale * mean
    }

    /// Learns from pairs of input and output; returns the root mean square error after every pass.
    pub fn learn(&mut self, pairs: &[(f64, f64)]) -> Vec<f64> {
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
            let x = pairs[i].0;
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
        for (x, target) in batch {
            let shares = self.shares(*x);
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
