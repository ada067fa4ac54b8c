//! Success rates of controllers in the same trials.

use hysteron_base::statistics::nearest_quantile;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// 1.96: 95 % of the normal distribution.
const Z: f64 = 1.959_963_985;

/// Task with the object.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Task {
    /// Over to the other side and down.
    Place,
    /// Up, and stay there.
    Stay,
}

/// One row of the table.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct Row {
    /// Task of the trials.
    pub task: Task,
    /// Observation of the policy; none for the expert and for goals that do not lead.
    pub method: String,
    /// Trials and successes.
    pub trials: usize,
    /// See `trials`.
    pub successes: usize,
    /// Successes over trials, and its 95 % interval (Wilson).
    pub rate: f64,
    /// See `rate`.
    pub interval: [f64; 2],
    /// Median over the trials of the largest distance in the last seconds [mm].
    pub distance_mm: f64,
    /// Against the policy that observes plan and positions alone: trials that only this row, or only that one, masters, and the
    /// probability of a difference as large if both were alike (McNemar, exact).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub against_nothing: Option<([usize; 2], f64)>,
}

impl Row {
    /// Scores of the largest distances in trials, successes up to `near` [m], compared with those of the policy that observes least.
    pub fn of(task: Task, method: &str, (distances, near): (&[f64], f64), nothing: Option<&[f64]>) -> Self {
        let is_good = |distance: &f64| *distance <= near;
        let successes = distances.iter().filter(|d| is_good(d)).count();
        let against_nothing = nothing.map(|nothing| {
            let pairs = || distances.iter().map(is_good).zip(nothing.iter().map(is_good));
            let only =
                [(true, false), (false, true)].map(|wanted| pairs().filter(|pair| *pair == wanted).count());
            (only, sign_test(only))
        });
        Self {
            task,
            method: method.to_owned(),
            trials: distances.len(),
            successes,
            rate: successes as f64 / distances.len() as f64,
            interval: wilson(successes, distances.len()),
            distance_mm: 1e3 * nearest_quantile(&mut distances.to_vec(), 0.5).unwrap_or(f64::NAN),
            against_nothing,
        }
    }
}

/// 95 % interval of a probability.
///
/// # Reference
/// Wilson (1927), Probable inference, the law of succession, and statistical inference.
fn wilson(successes: usize, trials: usize) -> [f64; 2] {
    let (n, p) = (trials as f64, successes as f64 / trials as f64);
    let middle = p + Z * Z / (2.0 * n);
    let half = Z * (p * (1.0 - p) / n + Z * Z / (4.0 * n * n)).sqrt();
    [-1.0, 1.0].map(|sign| (middle + sign * half) / (1.0 + Z * Z / n))
}

/// Probability of a division as uneven, or more so, by a fair coin.
fn sign_test([a, b]: [usize; 2]) -> f64 {
    let (n, least) = (a + b, a.min(b));
    // In logarithms: a half to the 400th is less than the least number.
    let mut term = -(n as f64) * std::f64::consts::LN_2;
    let mut sum = 0.0;
    for k in 0..=least {
        sum += term.exp();
        term += ((n - k) as f64 / (k + 1) as f64).ln();
    }
    (2.0 * sum).min(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn intervals_and_tests_are_those_of_tables() {
        // 37 of 40 (the paper's 92.5 %): 80.1 to 97.4 %, Newcombe (1998), method 3.
        let [low, high] = wilson(37, 40);
        assert!((low - 0.8014).abs() < 1e-4 && (high - 0.9742).abs() < 1e-4, "{low} {high}");
        assert!(wilson(0, 400)[0].abs() < 1e-15 && wilson(400, 400)[1] > 1.0 - 1e-12);
        // Two of ten by a fair coin, either way: 112/1024.
        assert!((sign_test([8, 2]) - 112.0 / 1024.0).abs() < 1e-12);
        assert!((sign_test([5, 5]) - 1.0).abs() < 1e-12 && sign_test([300, 0]) < 1e-80);
    }
}
