//! Products of row-major matrices on one thread; alone knows faer.
//!
//! Callers split their work in ways that do not depend on the number of threads, so results do not either.

pub use faer::traits::ComplexField as Field;

use faer::linalg::matmul::matmul;
use faer::{Accum, MatMut, MatRef, Par};

/// The rows of a row-major matrix.
pub(crate) fn rows<T>(values: &[T], n_columns: usize) -> MatRef<'_, T> {
    MatRef::from_row_major_slice(values, values.len() / n_columns, n_columns)
}

/// out = a b.
pub(crate) fn multiply<T: Field + Copy>(out: &mut [T], a: MatRef<'_, T>, b: MatRef<'_, T>) {
    let out = MatMut::from_row_major_slice_mut(out, a.nrows(), b.ncols());
    matmul(out, Accum::Replace, a, b, T::one_impl(), Par::Seq);
}

/// out += a b.
pub(crate) fn multiply_add<T: Field + Copy>(out: &mut [T], a: MatRef<'_, T>, b: MatRef<'_, T>) {
    let out = MatMut::from_row_major_slice_mut(out, a.nrows(), b.ncols());
    matmul(out, Accum::Add, a, b, T::one_impl(), Par::Seq);
}
