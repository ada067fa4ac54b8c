//! Statistics that a few wild values do not move.

/// Standard deviation over median absolute deviation of a normal distribution: 1 / Φ⁻¹(3/4) [-].
const SIGMA_OVER_MAD: f64 = 1.4826;

/// The value below which a `part` of the values lies; 0 of none. Orders them in linear time.
pub fn quantile(values: &mut [f64], part: f64) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    let at = (part * (values.len() - 1) as f64).round() as usize;
    *values.select_nth_unstable_by(at, f64::total_cmp).1
}

/// Standard deviation of the values about zero by their median absolute value.
pub fn robust_deviation(values: impl Iterator<Item = f64>) -> f64 {
    let mut sizes: Vec<f64> = values.map(f64::abs).collect();
    SIGMA_OVER_MAD * quantile(&mut sizes, 0.5)
}

/// Smallest and largest value; of none, an empty range.
pub fn extremes(values: impl Iterator<Item = f64>) -> [f64; 2] {
    values.fold([f64::INFINITY, f64::NEG_INFINITY], |[min, max], value| [min.min(value), max.max(value)])
}

/// Largest less smallest value; 0 of none.
pub fn range(values: impl Iterator<Item = f64>) -> f64 {
    let [min, max] = extremes(values);
    (max - min).max(0.0)
}

/// Standard deviation of the noise of a smooth signal by its second differences [unit of the signal]. Motion adds to them, so
/// it is an upper bound.
pub fn noise(values: &[f64]) -> f64 {
    // The variance of x₋ − 2x + x₊ is 6 σ².
    robust_deviation(values.windows(3).map(|w| w[0] - 2.0 * w[1] + w[2])) / 6f64.sqrt()
}
