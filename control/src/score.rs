//! How close a predicted tip comes to the measured one, sample by sample.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Errors along one axis.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct AxisScore {
    /// Root mean square error [m].
    pub rmse_m: f64,
    /// The same over the range of the measured path [-]; none where that is a point.
    pub nrmse: Option<f64>,
}

/// Errors of a path.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PathScore {
    /// Along x, y and z.
    pub axes: [AxisScore; 3],
    /// Root mean square distance [m].
    pub rmse_m: f64,
    /// Largest distance [m].
    pub max_m: f64,
    /// Samples compared: those that were measured.
    pub samples: usize,
}

/// Compares paths at the same times (n_samples each) [m]; samples with `gap` were not measured and do not count.
///
/// # Reference
/// CoReAct paper, eqs. 18 and 19.
pub fn score(measured: [&[f64]; 3], predicted: [&[f64]; 3], gap: &[bool]) -> PathScore {
    let counted: Vec<usize> = (0..gap.len()).filter(|&i| !gap[i]).collect();
    let n = counted.len().max(1) as f64;
    let error = |c: usize, i: usize| predicted[c][i] - measured[c][i];
    let axes = std::array::from_fn(|c| {
        let rmse_m = (counted.iter().map(|&i| error(c, i).powi(2)).sum::<f64>() / n).sqrt();
        let values = || counted.iter().map(|&i| measured[c][i]);
        let range = values().fold(f64::NEG_INFINITY, f64::max) - values().fold(f64::INFINITY, f64::min);
        AxisScore { rmse_m, nrmse: (range > 0.0).then(|| rmse_m / range) }
    });
    let distance = |&i: &usize| (0..3).map(|c| error(c, i).powi(2)).sum::<f64>();
    let largest = counted.iter().map(distance).fold(0.0, f64::max);
    PathScore {
        axes,
        rmse_m: (counted.iter().map(distance).sum::<f64>() / n).sqrt(),
        max_m: largest.sqrt(),
        samples: counted.len(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_of_a_shifted_circle_are_the_shift() {
        let n = 400;
        let angle = |i: usize| std::f64::consts::TAU * i as f64 / n as f64;
        let x: Vec<f64> = (0..n).map(|i| angle(i).cos()).collect();
        let y: Vec<f64> = (0..n).map(|i| 2.0 * angle(i).sin()).collect();
        let z = vec![0.5; n];
        let shifted: Vec<f64> = x.iter().map(|x| x + 0.03).collect();
        let mut gap = vec![false; n];
        // A tip that was not measured may have any value.
        gap[7] = true;
        let mut wrong = y.clone();
        wrong[7] = 100.0;
        let found = score([&x, &y, &z], [&shifted, &wrong, &z], &gap);
        assert!((found.axes[0].rmse_m - 0.03).abs() < 1e-15);
        assert!((found.axes[0].nrmse.expect("a range") - 0.015).abs() < 1e-15);
        assert_eq!(found.axes[1], AxisScore { rmse_m: 0.0, nrmse: Some(0.0) });
        assert_eq!(found.axes[2].nrmse, None);
        assert!((found.rmse_m - 0.03).abs() < 1e-15 && (found.max_m - 0.03).abs() < 1e-15);
        assert_eq!(found.samples, n - 1);
    }

    #[test]
    fn rmse_of_a_sine_is_its_amplitude_over_root_two() {
        let n = 1000;
        let wave: Vec<f64> = (0..n).map(|i| (std::f64::consts::TAU * i as f64 / n as f64).sin()).collect();
        let zero = vec![0.0; n];
        let found = score([&wave, &zero, &zero], [&zero, &zero, &zero], &vec![false; n]);
        assert!((found.axes[0].rmse_m - 0.5f64.sqrt()).abs() < 1e-12);
        // The range of the samples is 2: n is a multiple of 4.
        assert!((found.axes[0].nrmse.expect("a range") - 0.5 * 0.5f64.sqrt()).abs() < 1e-12);
    }
}
