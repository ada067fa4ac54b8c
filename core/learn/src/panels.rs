//! Matrices for products with one row or a few rows: in panels, whose entries are stored in the order of their use.
//!
//! Results are the same on every instruction set.

mod short;

use pulp::{Arch, Simd, WithSimd};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use short::ShortPanels;

/// Outputs that a product makes at a time.
const PANEL: usize = 64;

/// How what steps a network keeps the weights of its matrices. A network that does not stay in a core's own cache takes as long for a
/// sample as its weights take to come from memory: half as many bits come in half the time.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum WeightFormat {
    /// As they were trained, `f32`.
    #[default]
    Float32,
    /// Whole numbers in 16 bits, an 8191th of the largest of their row; inputs of a product likewise. Sums of 32 are exact.
    Int16,
}

/// A matrix in panels of [`PANEL`] rows: for each panel, for each column, the entries of its rows.
#[derive(Debug, Clone)]
pub(crate) enum Panels {
    Single(Vec<[f32; PANEL]>),
    Short(ShortPanels),
}

impl Panels {
    /// From a row-major matrix; the last panel is filled up with zeros.
    pub fn new(matrix: &[f32], n_columns: usize, format: WeightFormat) -> Self {
        if format == WeightFormat::Int16 {
            return Self::Short(ShortPanels::new(matrix, n_columns));
        }
        let panel = |rows: &[f32], column: usize| -> [f32; PANEL] {
            std::array::from_fn(|r| rows.get(r * n_columns + column).copied().unwrap_or(0.0))
        };
        let panels = matrix.chunks(PANEL * n_columns);
        Self::Single(panels.flat_map(|rows| (0..n_columns).map(move |c| panel(rows, c))).collect())
    }

    /// out += A x.
    pub fn multiply_add(&self, x: &[f32], out: &mut [f32]) {
        match self {
            Self::Single(panels) => multiply_add_panels(panels, x, out),
            Self::Short(panels) => panels.multiply_add(x, out),
        }
    }

    /// out += A x for every row of `x`, of `inputs` numbers each; the rows of `out` are filled up to whole panels.
    pub fn multiply_add_rows(&self, inputs: usize, x: &[f32], out: &mut [f32]) {
        match self {
            Self::Single(panels) if x.len() > inputs => {
                Arch::new().dispatch(RowProducts { panels, inputs, x, out })
            }
            _ => {
                let width = out.len() * inputs / x.len();
                let rows = x.chunks_exact(inputs).zip(out.chunks_exact_mut(width));
                rows.for_each(|(x, out)| self.multiply_add(x, out));
            }
        }
    }
}

/// `n` zeros, and more up to whole panels.
pub(crate) fn padded(n: usize) -> Vec<f32> {
    vec![0.0; n.next_multiple_of(PANEL)]
}

/// out += A x for one column x, A in panels: for each [`PANEL`] outputs, for each column, their entries.
fn multiply_add_panels(panels: &[[f32; PANEL]], x: &[f32], out: &mut [f32]) {
    Arch::new().dispatch(
        #[inline(always)]
        || {
            for (panel, out) in panels.chunks_exact(x.len()).zip(out.as_chunks_mut::<PANEL>().0) {
                let mut sums = *out;
                for (column, x) in panel.iter().zip(x) {
                    for l in 0..PANEL {
                        sums[l] = column[l].mul_add(*x, sums[l]);
                    }
                }
                *out = sums;
            }
        },
    );
}

/// out += A x for several rows x.
struct RowProducts<'a> {
    panels: &'a [[f32; PANEL]],
    inputs: usize,
    x: &'a [f32],
    out: &'a mut [f32],
}

impl RowProducts<'_> {
    /// Panel `p` for `R` rows from row `first` on, `C` registers of outputs at a time: enough sums that none waits for the one before.
    /// How many rows that were.
    #[inline(always)]
    fn some<S: Simd, const R: usize, const C: usize>(&mut self, simd: S, p: usize, first: usize) -> usize {
        let (n, lanes) = (self.inputs, S::F32_LANES);
        let width = self.out.len() / (self.x.len() / n);
        let mut x: [&[f32]; R] = [&[]; R];
        for r in 0..R {
            x[r] = &self.x[(first + r) * n..][..n];
        }
        let panel = &self.panels[p * n..][..n];
        for at in (0..PANEL / lanes).step_by(C) {
            let mut sums = [[simd.splat_f32s(0.0); C]; R];
            for k in 0..n {
                let (weights, _) = S::as_simd_f32s(&panel[k]);
                for r in 0..R {
                    let x = simd.splat_f32s(x[r][k]);
                    for c in 0..C {
                        sums[r][c] = simd.mul_add_f32s(weights[at + c], x, sums[r][c]);
                    }
                }
            }
            for r in 0..R {
                for c in 0..C {
                    let start = (first + r) * width + p * PANEL + (at + c) * lanes;
                    let out = &mut self.out[start..][..lanes];
                    let sum = simd.add_f32s(simd.partial_load_f32s(out), sums[r][c]);
                    simd.partial_store_f32s(out, sum);
                }
            }
        }
        R
    }
}

impl WithSimd for RowProducts<'_> {
    type Output = ();

    /// A panel comes from memory once, in the order of storage, and is in the cache for all rows after the first.
    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) {
        let n_rows = self.x.len() / self.inputs;
        for p in 0..self.panels.len() / self.inputs {
            let mut row = 0;
            while row < n_rows {
                // As many sums as there are registers for: 20 of 32 with AVX-512, 6 of 16 else.
                row += match n_rows - row {
                    5.. if S::F32_LANES == 16 => self.some::<S, 5, 4>(simd, p, row),
                    4 if S::F32_LANES == 16 => self.some::<S, 4, 4>(simd, p, row),
                    3.. => self.some::<S, 3, 2>(simd, p, row),
                    _ => self.some::<S, 1, 2>(simd, p, row),
                };
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::short::LARGEST;
    use super::*;

    #[test]
    fn short_weights_are_off_by_half_a_unit_of_their_row_and_of_the_inputs() {
        // Neither whole panels nor, in row 3, anything but zeros.
        let (n_rows, n_columns) = (PANEL + 6, 33);
        let entry =
            |k: usize| if k / n_columns == 3 { 0.0 } else { (k as f32 * 0.7).sin() / (1 + k % 5) as f32 };
        let matrix: Vec<f32> = (0..n_rows * n_columns).map(entry).collect();
        let x: Vec<f32> = (0..n_columns).map(|k| (k as f32 * 1.3).cos()).collect();
        let product = |format| {
            let mut out = padded(n_rows);
            Panels::new(&matrix, n_columns, format).multiply_add(&x, &mut out);
            out
        };
        let (single, short) = (product(WeightFormat::Float32), product(WeightFormat::Int16));
        let reach: f32 = x.iter().map(|x| x.abs()).sum();
        let step = x.iter().fold(0.0f32, |max, x| max.max(x.abs())) / LARGEST;
        let mut n_different = 0;
        for (r, row) in matrix.chunks(n_columns).enumerate() {
            let unit = row.iter().fold(0.0f32, |max, value| max.max(value.abs())) / LARGEST;
            let entries: f32 = row.iter().map(|w| w.abs()).sum();
            // Half a unit for every weight and every input and their product, and the round-off of sums of 33 products.
            let tol =
                0.5 * (unit * reach + step * entries) + 33.0 * (0.25 * unit * step + f32::EPSILON * reach);
            assert!((single[r] - short[r]).abs() <= tol, "row {r}: {} {}", single[r], short[r]);
            n_different += usize::from(single[r] != short[r]);
        }
        assert!(n_different > n_rows / 2, "{n_different}");
        assert_eq!([short[3], short[n_rows]], [0.0; 2]);
    }

    #[test]
    fn several_rows_are_the_rows_one_by_one() {
        let (n_rows, n_columns) = (PANEL + 6, 33);
        let matrix: Vec<f32> = (0..n_rows * n_columns).map(|k| (k as f32 * 0.7).sin()).collect();
        let panels = Panels::new(&matrix, n_columns, WeightFormat::Float32);
        for several in [1, 2, 9, 14] {
            let x: Vec<f32> = (0..several * n_columns).map(|k| (k as f32 * 1.3).cos()).collect();
            let width = padded(n_rows).len();
            let mut out = vec![0.5; several * width];
            panels.multiply_add_rows(n_columns, &x, &mut out);
            for (x, found) in x.chunks(n_columns).zip(out.chunks(width)) {
                let mut one = vec![0.5; width];
                panels.multiply_add(x, &mut one);
                // The bias is added first or last: one rounding of a sum of 33 products below 1.
                for (found, one) in found.iter().zip(&one) {
                    assert!((found - one).abs() <= 34.0 * 33.0 * 0.5 * f32::EPSILON, "{found} {one}");
                }
            }
        }
    }
}
