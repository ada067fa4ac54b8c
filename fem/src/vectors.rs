//! Long-vector arithmetic for steppers: dot products, sums and linear combinations.
//!
//! Plain loops over independent partial sums; dispatch lets the compiler use wide registers for them.

use hysteron_base::lanes::{Isa, Simd, WithSimd};

const PARTS: usize = 16;
/// Numbers that stay in the nearest cache, or in registers, while columns are added to them.
const PIECE: usize = 256;

/// Σ a_i b_i.
pub fn dot(isa: Isa, a: &[f64], b: &[f64]) -> f64 {
    isa.run(Dot { a, b })
}

/// No closure: one that returns a number is compiled by itself, without the instruction set that the dispatch chose.
struct Dot<'a> {
    a: &'a [f64],
    b: &'a [f64],
}

impl WithSimd for Dot<'_> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) -> f64 {
        let (a, b) = (self.a.as_chunks::<PARTS>(), self.b.as_chunks::<PARTS>());
        let mut sums = [0.0; PARTS];
        for (a, b) in a.0.iter().zip(b.0) {
            for p in 0..PARTS {
                sums[p] += a[p] * b[p];
            }
        }
        for (p, (a, b)) in a.1.iter().zip(b.1).enumerate() {
            sums[p] += a * b;
        }
        sums.iter().sum()
    }
}

/// y += factor x.
pub fn axpy(isa: Isa, factor: f64, x: &[f64], y: &mut [f64]) {
    isa.run(
        #[inline(always)]
        || {
            for (x, y) in x.iter().zip(y) {
                *y += factor * x;
            }
        },
    );
}

/// out += Σ factors_k columns_k: one pass over `out`, for any number of columns.
pub fn combine_into<T: Copy + Into<f64>>(
    isa: Isa,
    factors: &[f64],
    columns: &[impl AsRef<[T]>],
    out: &mut [f64],
) {
    isa.run(
        #[inline(always)]
        || {
            for (at, out) in out.chunks_mut(PIECE).enumerate() {
                let begin = at * PIECE;
                for (factor, column) in factors.iter().zip(columns) {
                    if *factor != 0.0 {
                        let column = &column.as_ref()[begin..][..out.len()];
                        for (x, y) in column.iter().zip(out.iter_mut()) {
                            *y += factor * (*x).into();
                        }
                    }
                }
            }
        },
    );
}
