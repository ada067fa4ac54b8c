//! Long-vector arithmetic for steppers: dot products, sums and linear combinations.
//!
//! Plain loops over independent partial sums; dispatch lets the compiler use wide registers for them.

use super::Isa;

const PARTS: usize = 16;
/// Numbers that stay in the nearest cache, or in registers, while columns are added to them.
const PIECE: usize = 256;

/// Σ a_i b_i.
pub fn dot(isa: Isa, a: &[f64], b: &[f64]) -> f64 {
    isa.run(
        #[inline(always)]
        || {
            let (a, b) = (a.as_chunks::<PARTS>(), b.as_chunks::<PARTS>());
            let mut sums = [0.0; PARTS];
            for (a, b) in a.0.iter().zip(b.0) {
                for p in 0..PARTS {
                    sums[p] += a[p] * b[p];
                }
            }
            let tail: f64 = a.1.iter().zip(b.1).map(|(a, b)| a * b).sum();
            sums.iter().sum::<f64>() + tail
        },
    )
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

/// out += Σ factors_k columns_k: `out` is gone through once, whatever the number of columns.
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
