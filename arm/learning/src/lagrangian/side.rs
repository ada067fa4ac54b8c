//! Rows of a batch side by side in registers, and products of them with the factor of a mass matrix.
//!
//! Outputs of a network are stored row by row; a factor of seven joints has 28 numbers that are not always zero, which fill no register evenly.
//! [`SIDE`] rows go through registers together instead: every array is [group of rows][element], each element one number of each of
//! those rows. The values in places of rows that the last group lacks are not used.

use hysteron_base::lanes::{Isa, Simd, WithSimd};
use hysteron_learn::Float;

/// Rows of a group.
pub(super) const SIDE: usize = 16;

/// A number of every row of a group.
pub(super) type Side<T> = [T; SIDE];

/// The factors of a product.
type FactorPair<'a, T> = (&'a [Side<T>], &'a [Side<T>]);

/// Writes `values` ([row][`width`]) side by side.
pub(super) fn put_side_by_side<T: Float>(values: &[T], width: usize, out: &mut Vec<Side<T>>) {
    out.clear();
    for rows in values.chunks(SIDE * width) {
        let begin = out.len();
        out.resize(begin + width, [T::default(); SIDE]);
        for (r, row) in rows.chunks_exact(width).enumerate() {
            for (out, value) in out[begin..].iter_mut().zip(row) {
                out[r] = *value;
            }
        }
    }
}

/// One number of a row: of [group][`width`].
#[inline(always)]
pub(super) fn of_row<T: Copy>(values: &[Side<T>], width: usize, row: usize, element: usize) -> T {
    values[row / SIDE * width + element][row % SIDE]
}

/// The elements of L = [T | R] that a network gives: n rows of a lower triangle, each followed by its part of some dense columns.
#[derive(Debug, Clone, Copy)]
pub(super) struct FactorForm {
    pub n: usize,
    /// Dense columns.
    pub squares: usize,
}

impl FactorForm {
    /// Elements.
    pub fn len(self) -> usize {
        self.n * (self.n + 1) / 2 + self.n * self.squares
    }

    /// Columns.
    pub fn width(self) -> usize {
        self.n + self.squares
    }

    /// The diagonal element of row `i`.
    pub fn on_diagonal(self, i: usize) -> usize {
        i * (i + 1) / 2 + i * self.squares + i
    }

    /// Elements of row `i`.
    #[inline(always)]
    fn row<V>(self, i: usize, elements: &[V]) -> &[V] {
        &elements[self.on_diagonal(i) - i..][..i + 1 + self.squares]
    }

    /// Out of numbers of every column, those that row `i` has elements in.
    #[inline(always)]
    fn columns<V>(self, i: usize, values: &[V]) -> impl Iterator<Item = &V> {
        let (triangle, dense) = values.split_at(self.n);
        triangle[..=i].iter().chain(dense)
    }

    /// out = Σ Lᵀ v over pairs (L, v): [group][column].
    pub fn transposed_times<T: Float, const N: usize>(
        self,
        pairs: [FactorPair<'_, T>; N],
        out: &mut Vec<Side<T>>,
    ) {
        out.resize(pairs[0].1.len() / self.n * self.width(), [T::default(); SIDE]);
        Isa::detect().run(TransposedTimes { form: self, pairs, out });
    }

    /// out = Σ L u over pairs (L, u): [group][row of L].
    pub fn times<T: Float, const N: usize>(self, pairs: [FactorPair<'_, T>; N], out: &mut Vec<Side<T>>) {
        out.resize(pairs[0].1.len() / self.width() * self.n, [T::default(); SIDE]);
        Isa::detect().run(Times { form: self, pairs, out });
    }

    /// The derivatives of Σ wᵀ L u over pairs (w, u) by the elements of L: [group][element].
    pub fn outer_products<T: Float, const N: usize>(
        self,
        pairs: [FactorPair<'_, T>; N],
        by_l: &mut Vec<Side<T>>,
    ) {
        by_l.resize(pairs[0].0.len() / self.n * self.len(), [T::default(); SIDE]);
        Isa::detect().run(OuterProducts { form: self, pairs, by_l });
    }
}

struct TransposedTimes<'a, T, const N: usize> {
    form: FactorForm,
    pairs: [FactorPair<'a, T>; N],
    out: &'a mut [Side<T>],
}

impl<T: Float, const N: usize> WithSimd for TransposedTimes<'_, T, N> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let form = self.form;
        for (g, out) in self.out.chunks_exact_mut(form.width()).enumerate() {
            out.fill([T::default(); SIDE]);
            let (triangle, dense) = out.split_at_mut(form.n);
            for (l, v) in self.pairs {
                let (l, v) = (part(l, g, form.len()), part(v, g, form.n));
                for (i, v) in v.iter().enumerate() {
                    let out = triangle[..=i].iter_mut().chain(&mut *dense);
                    out.zip(form.row(i, l)).for_each(|(out, l)| add_products(out, l, v));
                }
            }
        }
    }
}

struct Times<'a, T, const N: usize> {
    form: FactorForm,
    pairs: [FactorPair<'a, T>; N],
    out: &'a mut [Side<T>],
}

impl<T: Float, const N: usize> WithSimd for Times<'_, T, N> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let form = self.form;
        for (g, out) in self.out.chunks_exact_mut(form.n).enumerate() {
            for (i, out) in out.iter_mut().enumerate() {
                let mut sum = [T::default(); SIDE];
                for (l, u) in self.pairs {
                    let (l, u) = (part(l, g, form.len()), part(u, g, form.width()));
                    form.columns(i, u).zip(form.row(i, l)).for_each(|(u, l)| add_products(&mut sum, l, u));
                }
                *out = sum;
            }
        }
    }
}

struct OuterProducts<'a, T, const N: usize> {
    form: FactorForm,
    pairs: [FactorPair<'a, T>; N],
    by_l: &'a mut [Side<T>],
}

impl<T: Float, const N: usize> WithSimd for OuterProducts<'_, T, N> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let form = self.form;
        for (g, by_l) in self.by_l.chunks_exact_mut(form.len()).enumerate() {
            let pairs = self.pairs.map(|(w, u)| (part(w, g, form.n), part(u, g, form.width())));
            let mut rest = by_l;
            for i in 0..form.n {
                let (row, after) = rest.split_at_mut(i + 1 + form.squares);
                rest = after;
                let (triangle, dense) = row.split_at_mut(i + 1);
                for (begin, of_row) in [(0, triangle), (form.n, dense)] {
                    let us = pairs.map(|(_, u)| &u[begin..][..of_row.len()]);
                    for (k, by_l) in of_row.iter_mut().enumerate() {
                        let mut sum = [T::default(); SIDE];
                        for (u, (w, _)) in us.iter().zip(&pairs) {
                            add_products(&mut sum, &w[i], &u[k]);
                        }
                        *by_l = sum;
                    }
                }
            }
        }
    }
}

/// The part of an array that belongs to one group.
#[inline(always)]
fn part<V>(values: &[V], group: usize, len: usize) -> &[V] {
    &values[group * len..][..len]
}

/// sum += a b, number by number.
#[inline(always)]
fn add_products<T: Float>(sum: &mut Side<T>, a: &Side<T>, b: &Side<T>) {
    for k in 0..SIDE {
        sum[k] += a[k] * b[k];
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ROWS: usize = SIDE + 3;

    /// Numbers that differ, [row][`width`], and the same side by side.
    fn numbers(width: usize, seed: usize) -> (Vec<f64>, Vec<Side<f64>>) {
        let values: Vec<f64> = (0..ROWS * width).map(|i| ((7 * i + seed) as f64).sin()).collect();
        let mut out = Vec::new();
        put_side_by_side(&values, width, &mut out);
        (values, out)
    }

    /// Rounding of sums of some products of numbers below one.
    fn assert_near(found: f64, expected: f64) {
        assert!((found - expected).abs() < 1e-14, "{found} {expected}");
    }

    #[test]
    fn products_are_those_of_matrices_with_zeros_above_the_diagonal() {
        let form = FactorForm { n: 4, squares: 3 };
        let (n, width) = (form.n, form.width());
        let ((l, l_side), (v, v_side), (u, u_side)) =
            (numbers(form.len(), 1), numbers(n, 2), numbers(width, 3));
        let mut matrices = vec![vec![vec![0.0; width]; n]; ROWS];
        for (matrix, elements) in matrices.iter_mut().zip(l.chunks_exact(form.len())) {
            let mut elements = elements.iter();
            for (i, row) in matrix.iter_mut().enumerate() {
                for c in (0..=i).chain(n..width) {
                    row[c] = elements.next().copied().unwrap_or(f64::NAN);
                }
            }
        }
        let [mut pulled, mut pushed, mut by_l] = [(); 3].map(|()| Vec::new());
        form.transposed_times([(&l_side, &v_side), (&l_side, &v_side)], &mut pulled);
        form.times([(&l_side, &u_side), (&l_side, &u_side)], &mut pushed);
        form.outer_products([(&v_side, &u_side), (&v_side, &u_side)], &mut by_l);
        for (r, matrix) in matrices.iter().enumerate() {
            let (v, u) = (&v[r * n..][..n], &u[r * width..][..width]);
            for c in 0..width {
                let expected: f64 = (0..n).map(|i| 2.0 * matrix[i][c] * v[i]).sum();
                assert_near(of_row(&pulled, width, r, c), expected);
            }
            let mut k = 0;
            for i in 0..n {
                let expected: f64 = (0..width).map(|c| 2.0 * matrix[i][c] * u[c]).sum();
                assert_near(of_row(&pushed, n, r, i), expected);
                for c in (0..=i).chain(n..width) {
                    assert_near(of_row(&by_l, form.len(), r, k), 2.0 * v[i] * u[c]);
                    k += 1;
                }
                assert_eq!(form.on_diagonal(i), k - form.squares - 1);
            }
        }
    }
}
