//! Small symmetric positive definite matrices (n × n, row by row): L D Lᵀ without pivots or square roots.

use crate::Scalar;

/// Replaces `a` by L (below the diagonal) and 1 / D (on it).
#[inline(always)]
pub fn factor<T: Scalar>(n: usize, a: &mut [T]) {
    for j in 0..n {
        for k in 0..j {
            // Column k is final: L_jk D_k is stored above the diagonal.
            let scaled = a[n * j + k];
            a[n * k + j] = scaled;
            a[n * j + k] = scaled * a[n * k + k];
        }
        let mut pivot = a[n * j + j];
        for k in 0..j {
            pivot = (-a[n * j + k]).mul_add(a[n * k + j], pivot);
        }
        a[n * j + j] = pivot.recip();
        for i in j + 1..n {
            let mut sum = a[n * i + j];
            for k in 0..j {
                sum = (-a[n * i + k]).mul_add(a[n * j + k], sum);
            }
            a[n * i + j] = sum;
        }
    }
}

/// Solves for every column of `b` (n × m, row by row) in place.
#[inline(always)]
pub fn solve_columns<T: Scalar>(n: usize, factor: &[T], b: &mut [T]) {
    let m = b.len() / n;
    for i in 0..n {
        let (done, row) = b.split_at_mut(m * i);
        for k in 0..i {
            let l = -factor[n * i + k];
            for (x, y) in row[..m].iter_mut().zip(&done[m * k..m * (k + 1)]) {
                *x = l.mul_add(*y, *x);
            }
        }
    }
    for i in (0..n).rev() {
        let (rows, below) = b.split_at_mut(m * (i + 1));
        let row = &mut rows[m * i..];
        for x in row.iter_mut() {
            *x = *x * factor[n * i + i];
        }
        for k in i + 1..n {
            let l = -factor[n * k + i];
            for (x, y) in row.iter_mut().zip(&below[m * (k - i - 1)..m * (k - i)]) {
                *x = l.mul_add(*y, *x);
            }
        }
    }
}

/// Writes the inverse of the matrix that `factor` comes from.
#[inline(always)]
pub fn invert<T: Scalar>(n: usize, factor: &[T], inverse: &mut [T]) {
    let like = factor[0];
    inverse.fill(like.splat(0.0));
    for i in 0..n {
        inverse[n * i + i] = like.splat(1.0);
    }
    solve_columns(n, factor, inverse);
}
