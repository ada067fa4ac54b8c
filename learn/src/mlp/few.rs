//! Products of a few rows with a row-major matrix: one sample at a time spends its time on reading weights, so they are read once, in
//! the order in which they stand, and nothing is packed.

use hysteron_base::lanes::{Isa, Simd, WithSimd};

use crate::Real;

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
pub(super) fn times_transposed<T: Real>(out: &mut [T], x: &[T], weights: &[T], n_in: usize) {
    Isa::detect().run(TimesTransposed { out, x, weights, n_in });
}

/// out[row][i] = Σ_o c[row][o] W[o][i].
pub(super) fn times<T: Real>(out: &mut [T], c: &[T], weights: &[T], n_in: usize) {
    Isa::detect().run(Times { out, c, weights, n_in });
}

struct TimesTransposed<'a, T> {
    out: &'a mut [T],
    x: &'a [T],
    weights: &'a [T],
    n_in: usize,
}

impl<T: Real> WithSimd for TimesTransposed<'_, T> {
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

struct Times<'a, T> {
    out: &'a mut [T],
    c: &'a [T],
    weights: &'a [T],
    n_in: usize,
}

impl<T: Real> WithSimd for Times<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let n_out = self.weights.len() / self.n_in;
        for (c, out) in self.c.chunks_exact(n_out).zip(self.out.chunks_exact_mut(self.n_in)) {
            let whole = self.n_in - self.n_in % WIDE;
            for (block, out) in out[..whole].as_chunks_mut::<WIDE>().0.iter_mut().enumerate() {
                let mut sums = [T::default(); WIDE];
                for (w, c) in self.weights.chunks_exact(self.n_in).zip(c) {
                    let w = &w.as_chunks::<WIDE>().0[block];
                    for k in 0..WIDE {
                        sums[k] += *c * w[k];
                    }
                }
                *out = sums;
            }
            let rest = &mut out[whole..];
            rest.fill(T::default());
            for (w, c) in self.weights.chunks_exact(self.n_in).zip(c) {
                for (out, w) in rest.iter_mut().zip(&w[whole..]) {
                    *out += *c * *w;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_are_those_of_the_definition_for_widths_that_fill_no_block() {
        let number = |i: usize| f64::from((37 * i as u32 + 11) % 64) - 31.0; // whole numbers: sums are exact
        for [rows, n_in, n_out] in [[1, 14, 5], [2, 128, 28], [3, 79, 33], [1, 1, 1], [2, 32, 1]] {
            let weights: Vec<f64> = (0..n_in * n_out).map(number).collect();
            let x: Vec<f64> = (0..rows * n_in).map(|i| number(3 * i + 1)).collect();
            let c: Vec<f64> = (0..rows * n_out).map(|i| number(5 * i + 2)).collect();
            let (mut y, mut back) = (vec![1.0; rows * n_out], vec![1.0; rows * n_in]);
            times_transposed(&mut y, &x, &weights, n_in);
            times(&mut back, &c, &weights, n_in);
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
