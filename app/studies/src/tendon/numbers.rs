//! Sums and tables that several studies need.

use hysteron_workflow::Context;

/// Distance of two points.
pub(super) fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|c| (a[c] - b[c]).powi(2)).sum::<f64>().sqrt()
}

/// Root of the mean square.
pub(super) fn rms(values: impl IntoIterator<Item = f64>) -> f64 {
    let (mut sum, mut n) = (0.0, 0.0);
    for value in values {
        sum += value * value;
        n += 1.0;
    }
    f64::sqrt(sum / n)
}

/// Value that the share `p` of `values` stays below; NaN when there is none.
pub(super) fn percentile(values: &[f64], p: f64) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let last = sorted.len().saturating_sub(1);
    sorted.get((p * last as f64).round() as usize).copied().unwrap_or(f64::NAN)
}

/// Prints rows of cells, columns aligned, the first one to the left.
pub(super) fn print_cells(context: &Context, cells: &[Vec<String>]) {
    crate::runner::table::aligned(cells).into_iter().for_each(|line| context.print(line));
}
