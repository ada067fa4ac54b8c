//! Products of a few rows with a row-major matrix: one sample at a time spends its time on reading weights, so they are read once, in
//! their order in memory, and nothing is packed.

use hysteron_base::lanes::{Isa, Simd, WithSimd};

use crate::Float;

/// Rows up to which these are faster than blocked products.
pub(super) const FEW: usize = 3;
/// Partial sums side by side.
const WIDE: usize = 32;
/// Of what is left of a row.
const NARROW: usize = 8;

/// Whole narrow blocks, and the rest.
#[inline(always)]
fn split<T>(values: &[T]) -> [&[T]; 2] {
    let (whole, rest) = values.split_at(values.len() - values.len() % NARROW);
    [whole, rest]
}

/// out[row][o] = Σ_i W[o][i] x[row][i].
pub(super) fn times_transposed<T: Float>(out: &mut [T], x: &[T], weights: &[T], n_in: usize) {
    Isa::detect().run(TimesTransposed { out, x, weights, n_in });
}

/// out[row][i] = Σ_o c[row][o] W[o][i], or, if it `adds`, as much more; of up to [`FEW`] rows.
pub(super) fn times<T: Float>(out: &mut [T], c: &[T], weights: &[T], n_in: usize, adds: bool) {
    Isa::detect().run(SmallProduct { out, c, weights, n_in, adds });
}

/// W[o][i] as [i][o].
pub(super) fn transposed<T: Float>(weights: &[T], n_in: usize) -> Vec<T> {
    (0..n_in).flat_map(|i| weights.iter().skip(i).step_by(n_in).copied()).collect()
}

struct TimesTransposed<'a, T> {
    out: &'a mut [T],
    x: &'a [T],
    weights: &'a [T],
    n_in: usize,
}

impl<T: Float> WithSimd for TimesTransposed<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let n_out = self.weights.len() / self.n_in;
        for (x, out) in self.x.chunks_exact(self.n_in).zip(self.out.chunks_exact_mut(n_out)) {
            for (w, out) in self.weights.chunks_exact(self.n_in).zip(out) {
                let mut sums = [T::default(); WIDE];
                let (blocks, rest) = w.as_chunks::<WIDE>();
                let (x_blocks, x_rest) = x.as_chunks::<WIDE>();
                for (w, x) in blocks.iter().zip(x_blocks) {
                    for k in 0..WIDE {
                        sums[k] += w[k] * x[k];
                    }
                }
                let ([narrow, tail], [x_narrow, x_tail]) = (split(rest), split(x_rest));
                for (w, x) in narrow.as_chunks::<NARROW>().0.iter().zip(x_narrow.as_chunks::<NARROW>().0) {
                    for k in 0..NARROW {
                        sums[k] += w[k] * x[k];
                    }
                }
                let tail: T = tail.iter().zip(x_tail).map(|(w, x)| *w * *x).sum();
                let mut half = WIDE / 2;
                while half > 0 {
                    for k in 0..half {
                        let other = sums[k + half];
                        sums[k] += other;
                    }
                    half /= 2;
                }
                *out = sums[0] + tail;
            }
        }
    }
}

struct SmallProduct<'a, T> {
    out: &'a mut [T],
    c: &'a [T],
    weights: &'a [T],
    n_in: usize,
    adds: bool,
}

impl<T: Float> WithSimd for SmallProduct<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        match self.out.len() / self.n_in {
            1 => self.of_rows::<1>(),
            2 => self.of_rows::<2>(),
            FEW => self.of_rows::<FEW>(),
            n => debug_assert_eq!(n, 0, "rows"),
        }
    }
}

impl<T: Float> SmallProduct<'_, T> {
    #[inline(always)]
    fn of_rows<const ROWS: usize>(mut self) {
        let wide = self.n_in - self.n_in % (2 * WIDE);
        for block in 0..wide / (2 * WIDE) {
            self.block::<ROWS, { 2 * WIDE }>(2 * WIDE * block);
        }
        let whole = self.n_in - self.n_in % WIDE;
        if whole > wide {
            self.block::<ROWS, WIDE>(wide);
        }
        let n_out = self.weights.len() / self.n_in;
        for (out, c) in self.out.chunks_exact_mut(self.n_in).zip(self.c.chunks_exact(n_out)) {
            let rest = &mut out[whole..];
            if !self.adds {
                rest.fill(T::default());
            }
            for (w, c) in self.weights.chunks_exact(self.n_in).zip(c) {
                for (out, w) in rest.iter_mut().zip(&w[whole..]) {
                    *out += *c * *w;
                }
            }
        }
    }

    /// Columns `at` to `at + WIDTH` of all rows: what is read of the matrix serves all of them.
    #[inline(always)]
    fn block<const ROWS: usize, const WIDTH: usize>(&mut self, at: usize) {
        let (n_in, n_out) = (self.n_in, self.weights.len() / self.n_in);
        let mut sums = [[T::default(); WIDTH]; ROWS];
        if self.adds {
            for (sums, out) in sums.iter_mut().zip(self.out.chunks_exact(n_in)) {
                sums.copy_from_slice(&out[at..at + WIDTH]);
            }
        }
        let c: [&[T]; ROWS] = std::array::from_fn(|row| &self.c[row * n_out..(row + 1) * n_out]);
        for (o, w) in self.weights.chunks_exact(n_in).enumerate() {
            let w = &w[at..at + WIDTH];
            for (sums, c) in sums.iter_mut().zip(c) {
                let c = c[o];
                for k in 0..WIDTH {
                    sums[k] += c * w[k];
                }
            }
        }
        for (sums, out) in sums.iter().zip(self.out.chunks_exact_mut(n_in)) {
            out[at..at + WIDTH].copy_from_slice(sums);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_are_those_of_the_definition_for_widths_that_fill_no_block() {
        let number = |i: usize| f64::from((37 * i as u32 + 11) % 64) - 31.0; // whole numbers: sums are exact
        for [rows, n_in, n_out] in [[1, 14, 5], [2, 128, 28], [3, 79, 97], [1, 1, 1], [2, 32, 1]] {
            let weights: Vec<f64> = (0..n_in * n_out).map(number).collect();
            let x: Vec<f64> = (0..rows * n_in).map(|i| number(3 * i + 1)).collect();
            let c: Vec<f64> = (0..rows * n_out).map(|i| number(5 * i + 2)).collect();
            let (mut y, mut back) = (vec![1.0; rows * n_out], vec![1.0; rows * n_in]);
            times_transposed(&mut y, &x, &weights, n_in);
            let (mut through, transposed) = (vec![1.0; rows * n_out], transposed(&weights, n_in));
            times(&mut through, &x, &transposed, n_out, false);
            assert_eq!(through, y, "{rows} {n_in} {n_out}");
            times(&mut through, &x, &transposed, n_out, true);
            assert!(
                through.iter().zip(&y).all(|(twice, once)| *twice == 2.0 * once),
                "{rows} {n_in} {n_out}"
            );
            times(&mut back, &c, &weights, n_in, false);
            for row in 0..rows {
                for o in 0..n_out {
                    let sum: f64 = (0..n_in).map(|i| weights[o * n_in + i] * x[row * n_in + i]).sum();
                    assert_eq!(y[row * n_out + o], sum, "{rows} {n_in} {n_out}");
                }
                for i in 0..n_in {
                    let sum: f64 = (0..n_out).map(|o| c[row * n_out + o] * weights[o * n_in + i]).sum();
                    assert_eq!(back[row * n_in + i], sum, "{rows} {n_in} {n_out}");
                }
            }
        }
    }
}
