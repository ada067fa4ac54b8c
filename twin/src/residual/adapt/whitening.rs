//! Whitening of errors that contain a tracker's drift.
//!
//! A tracker's error that stays for minutes looks like a robot that has moved by as much. So errors are
//! modelled as a drift d, an Ornstein-Uhlenbeck process, plus noise without memory from sample to sample; the
//! innovations of a Kalman filter of them, over their deviation, are white, and least squares of these are
//! the best linear estimate (Kailath, Sayed, Hassibi 2000, section 9). The filter is linear in the errors and
//! its gains depend on none: the columns of a Jacobian pass through the same filter.

/// Model of the errors without the change sought: drift and noise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Whitening {
    /// Deviation of the drift [m].
    pub drift: f64,
    /// Correlation time of the drift [s].
    pub drift_time: f64,
    /// Variance of the noise in one sample [m²].
    pub noise: f64,
    /// Duration of a sample [s].
    pub step: f64,
}

impl Whitening {
    /// Innovations of `errors` over their deviation [-]; zero where `is_used` is false.
    pub fn apply(&self, errors: impl Iterator<Item = f64>, is_used: &[bool]) -> Vec<f64> {
        let kept = (-self.step / self.drift_time).exp();
        let stationary = self.drift * self.drift;
        let (mut mean, mut variance) = (0.0, stationary);
        let mut white = Vec::with_capacity(is_used.len());
        for (error, is_used) in errors.zip(is_used) {
            let mut innovation = 0.0;
            if *is_used {
                let spread = variance + self.noise;
                let gain = variance / spread;
                innovation = (error - mean) / spread.sqrt();
                mean += gain * (error - mean);
                variance -= gain * variance;
            }
            white.push(innovation);
            mean *= kept;
            variance = stationary + kept * kept * (variance - stationary);
        }
        white
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{DMatrix, DVector};

    #[test]
    fn least_squares_of_the_white_errors_are_those_with_the_whole_covariance() {
        let whitening = Whitening { drift: 0.3, drift_time: 2.0, noise: 0.04, step: 0.1 };
        let is_used: Vec<bool> = (0..40).map(|i| i % 7 != 3).collect();
        let errors: Vec<f64> = (0..40).map(|i| (0.4 * f64::from(i)).sin() + 0.5).collect();
        let column: Vec<f64> = (0..40).map(|i| (0.15 * f64::from(i)).cos()).collect();
        let [white, of_column] = [&errors, &column].map(|it| whitening.apply(it.iter().copied(), &is_used));
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let found = [dot(&white, &white), dot(&of_column, &white), dot(&of_column, &of_column)];
        // Independent of the filter: the covariance of all samples at once.
        let used: Vec<usize> = (0..40).filter(|&i| is_used[i]).collect();
        let covariance = DMatrix::from_fn(used.len(), used.len(), |a, b| {
            let apart = used[a].abs_diff(used[b]) as f64 * whitening.step;
            let drift = whitening.drift.powi(2) * (-apart / whitening.drift_time).exp();
            drift + if a == b { whitening.noise } else { 0.0 }
        });
        let of = |values: &[f64]| DVector::from_iterator(used.len(), used.iter().map(|&i| values[i]));
        let (errors, column) = (of(&errors), of(&column));
        let solved = covariance.cholesky().map(|factor| [factor.solve(&errors), factor.solve(&column)]);
        let [by_errors, by_column] =
            solved.unwrap_or_else(|| unreachable!("a covariance is positive definite"));
        let expected = [errors.dot(&by_errors), column.dot(&by_errors), column.dot(&by_column)];
        for (found, expected) in found.iter().zip(expected) {
            // Condition of the covariance (some 100) times round-off.
            assert!((found - expected).abs() < 1e-12 * expected.abs().max(1.0), "{found} {expected}");
        }
    }
}
