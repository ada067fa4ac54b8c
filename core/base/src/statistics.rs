//! Quantiles, and statistics that a few wild values do not move.

/// Standard deviation over median absolute deviation of a normal distribution: 1 / Φ⁻¹(3/4) [-].
const SIGMA_OVER_MAD: f64 = 1.4826;

/// The value at the place, in ascending order, that is nearest to a `part` of the way from the first to the last: 0.5 is the median, of an
/// even number of values the upper of the two in the middle. `None` of none. Reorders `values`, in linear time.
pub fn nearest_quantile(values: &mut [f64], part: f64) -> Option<f64> {
    let last = values.len().checked_sub(1)?;
    ordered(values, (part * last as f64).round() as usize)
}

/// The smallest value that more than a `part` of the values do not exceed, the largest for a part of 1: in ascending order at most one
/// place from [`nearest_quantile`]. `None` of none. Reorders `values`, in linear time.
pub fn upper_quantile(values: &mut [f64], part: f64) -> Option<f64> {
    let last = values.len().checked_sub(1)?;
    ordered(values, ((part * values.len() as f64) as usize).min(last))
}

/// The value at place `k` in ascending order.
fn ordered(values: &mut [f64], k: usize) -> Option<f64> {
    Some(*values.select_nth_unstable_by(k, f64::total_cmp).1)
}

/// Standard deviation of the values about zero by their median absolute value.
pub fn robust_deviation(values: impl Iterator<Item = f64>) -> f64 {
    let mut sizes: Vec<f64> = values.map(f64::abs).collect();
    SIGMA_OVER_MAD * nearest_quantile(&mut sizes, 0.5).unwrap_or(0.0)
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_values_in_order_and_differ_by_one_place_at_most() {
        let values = [5.0, 1.0, 4.0, 2.0, 3.0, 6.0];
        let nearest = [0.0, 0.1, 0.5, 0.9, 1.0].map(|part| nearest_quantile(&mut values.clone(), part));
        assert_eq!(nearest, [1.0, 2.0, 4.0, 6.0, 6.0].map(Some));
        let upper = [0.0, 0.1, 0.4, 0.5, 0.9, 1.0].map(|part| upper_quantile(&mut values.clone(), part));
        assert_eq!(upper, [1.0, 1.0, 3.0, 4.0, 6.0, 6.0].map(Some));
        assert_eq!((nearest_quantile(&mut [], 0.5), upper_quantile(&mut [], 0.5)), (None, None));
    }
}
