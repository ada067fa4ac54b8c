//! Products of a few rows with a matrix in panels, whose entries are stored in the order of their use: a rollout that goes
//! step by step multiplies as many rows as there are arms side by side, and a general product would spend as long on putting the matrix in
//! order, or on reading it across, as on multiplying.

use std::marker::PhantomData;

use hysteron_base::lanes::{Isa, Simd, WithSimd};

use crate::Float;

/// Rows up to which products are made so; with more a general product has its panels used often enough.
pub(super) const FEW: usize = 24;
/// Registers of a panel's width.
const ACROSS: usize = 2;
/// Numbers of two of the widest registers.
const MAX_WIDTH: usize = ACROSS * 16;

/// A matrix in panels as wide as two registers: for each panel, for each row of the matrix, the entries of its columns. The last panel is
/// filled up with zeros.
#[derive(Debug, Clone)]
pub(super) struct RegisterPanels<T> {
    entries: Vec<T>,
    size: [usize; 2],
}

/// Columns of a panel.
struct Wide<T>(PhantomData<T>);

impl<T> WithSimd for Wide<T> {
    type Output = usize;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> usize {
        ACROSS * size_of::<S::f32s>() / size_of::<T>()
    }
}

impl<T: Float> RegisterPanels<T> {
    /// Of `size` rows and columns, `entry` by `entry`.
    pub fn new(size: [usize; 2], entry: impl Fn(usize, usize) -> T) -> Self {
        let [n_rows, n_columns] = size;
        let wide = Isa::detect().run(Wide(PhantomData::<T>));
        let mut entries = vec![T::default(); n_rows * n_columns.next_multiple_of(wide)];
        for (p, panel) in entries.chunks_exact_mut(n_rows * wide).enumerate() {
            let columns = p * wide..n_columns.min((p + 1) * wide);
            for (row, entries) in panel.chunks_exact_mut(wide).enumerate() {
                columns.clone().zip(entries).for_each(|(column, to)| *to = entry(row, column));
            }
        }
        Self { entries, size }
    }

    /// out += x A for every row of `x`.
    pub fn multiply_add(&self, x: &[T], out: &mut [T]) {
        Isa::detect().run(MultiplyAdd { panels: self, x, out });
    }
}

struct MultiplyAdd<'a, T> {
    panels: &'a RegisterPanels<T>,
    x: &'a [T],
    out: &'a mut [T],
}

impl<T: Float> MultiplyAdd<'_, T> {
    /// `R` rows from `first` on, with one panel whose columns begin at `column`; how many that were.
    #[inline(always)]
    fn some<S: Simd, const R: usize>(
        &mut self,
        simd: S,
        first: usize,
        (column, panel): (usize, &[T]),
    ) -> usize {
        let [n, n_columns] = self.panels.size;
        let wide = panel.len() / n;
        let mut x: [&[T]; R] = [&[]; R];
        for r in 0..R {
            x[r] = &self.x[(first + r) * n..][..n];
        }
        let mut sums = [[T::splat(simd, T::default()); ACROSS]; R];
        for (k, entries) in T::split::<S>(panel).as_chunks::<ACROSS>().0.iter().enumerate() {
            for r in 0..R {
                let x = T::splat(simd, x[r][k]);
                for c in 0..ACROSS {
                    sums[r][c] = T::mul_add(simd, entries[c], x, sums[r][c]);
                }
            }
        }
        for r in 0..R {
            let mut stored = [T::default(); MAX_WIDTH];
            T::split_mut::<S>(&mut stored[..wide]).copy_from_slice(&sums[r]);
            let out = &mut self.out[(first + r) * n_columns..][column..n_columns.min(column + wide)];
            out.iter_mut().zip(&stored).for_each(|(out, sum)| *out += *sum);
        }
        R
    }
}

impl<T: Float> WithSimd for MultiplyAdd<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) {
        let [n, n_columns] = self.panels.size;
        let n_rows = self.x.len() / n;
        let wide = Wide(PhantomData::<T>).with_simd(simd);
        let panels = self.panels.entries.chunks_exact(n * wide);
        for panel in (0..n_columns).step_by(wide).zip(panels) {
            let mut row = 0;
            while row < n_rows {
                // Eight registers of sums hide the latency of an addition; with twelve the compiler runs out of AVX2's sixteen and keeps
                // one in memory, which takes twice as long. With AVX-512's 32 a panel, which comes from afar, is read half as often.
                row += match n_rows - row {
                    8.. if size_of::<S::f32s>() == 64 => self.some::<S, 8>(simd, row, panel),
                    4.. => self.some::<S, 4>(simd, row, panel),
                    _ => self.some::<S, 1>(simd, row, panel),
                };
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn products_are_those_of_the_definition_for_any_size() {
        for (n_rows, n, n_columns) in [(1, 5, 3), (4, 7, MAX_WIDTH), (11, 6, 2 * MAX_WIDTH + 5)] {
            let number = |k: usize| (1.3 * k as f64).sin();
            let entry = |row: usize, column: usize| number(row * n_columns + column);
            let x: Vec<f64> = (0..n_rows * n).map(|k| number(3 * k + 1)).collect();
            let mut out: Vec<f64> = (0..n_rows * n_columns).map(number).collect();
            RegisterPanels::new([n, n_columns], entry).multiply_add(&x, &mut out);
            for (at, found) in out.iter().enumerate() {
                let (row, column) = (at / n_columns, at % n_columns);
                let sum: f64 = (0..n).map(|k| x[row * n + k] * entry(k, column)).sum();
                // Rounding of a sum of up to eight numbers below 1.
                assert!((found - number(at) - sum).abs() < 64.0 * f64::EPSILON, "{row}, {column}");
            }
        }
    }
}
