//! Smoothing and differentiation by local polynomials.
//!
//! # Reference
//! Savitzky, Golay (1964); the ends as scipy's `savgol_filter` with mode "interp": the polynomial of the outermost window.

use hysteron_base::BadInput;
use nalgebra::DMatrix;

/// Weights of a window.
#[derive(Debug, Clone, PartialEq)]
pub struct SavitzkyGolay {
    /// Row k: weights over the window that give the value at its k-th sample.
    weights: DMatrix<f64>,
    half: usize,
}

impl SavitzkyGolay {
    /// A window of 2 `half` + 1 samples, polynomials of `degree`, the `derivative`-th derivative per second at `rate` samples per
    /// second [Hz].
    ///
    /// # Errors
    /// `BadInput` where the window does not determine the polynomial, or the derivative is above its degree.
    pub fn new(half: usize, degree: usize, derivative: usize, rate: f64) -> Result<Self, BadInput> {
        let window = 2 * half + 1;
        if degree >= window || derivative > degree || half > 10_000 || rate <= 0.0 || !rate.is_finite() {
            let found = format!("{window} samples, degree {degree}, derivative {derivative}, {rate} Hz");
            let expected = "derivative <= degree < samples of the window <= 20001, and a rate above 0";
            return Err(BadInput::new("Savitzky-Golay filter", expected, found));
        }
        // Powers of x = k/half keep the fit well conditioned.
        let scale = half.max(1) as f64;
        let x = |k: usize| (k as f64 - half as f64) / scale;
        let powers = DMatrix::from_fn(window, degree + 1, |k, j| x(k).powi(j as i32));
        let fit = powers
            .pseudo_inverse(1e-14)
            .map_err(|found| BadInput::new("Savitzky-Golay filter", "a window that has a fit", found))?;
        let factor = |j: usize| (j + 1 - derivative..=j).map(|i| i as f64).product::<f64>();
        let differentiate = DMatrix::from_fn(window, degree + 1, |k, j| match j >= derivative {
            true => factor(j) * x(k).powi((j - derivative) as i32) * (rate / scale).powi(derivative as i32),
            false => 0.0,
        });
        Ok(Self { weights: differentiate * fit, half })
    }

    /// The whole signal, without delay. A signal shorter than the window comes back as zeros for a derivative, else as it is.
    pub fn apply(&self, signal: &[f64]) -> Vec<f64> {
        let (n, window) = (signal.len(), 2 * self.half + 1);
        if n < window {
            let sum: f64 = self.weights.row(self.half).iter().sum();
            return signal.iter().map(|x| x * sum.round()).collect();
        }
        let at = |k: usize| {
            let start = k.saturating_sub(self.half).min(n - window);
            let row = self.weights.row(k - start);
            row.iter().zip(&signal[start..start + window]).map(|(w, x)| w * x).sum()
        };
        (0..n).map(at).collect()
    }
}
