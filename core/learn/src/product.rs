//! Products of row-major matrices on one thread, built here once for each kind of number.
//!
//! Callers split their work in ways that do not depend on the number of threads, so results do not either.

use faer::linalg::matmul::matmul;
use faer::{Accum, MatMut, MatRef, Par};

/// Numbers whose matrices can be multiplied.
pub trait Field: Sized {
    /// out = a b, or out += a b.
    fn product(out: MatMut<'_, Self>, sum: Accum, a: MatRef<'_, Self>, b: MatRef<'_, Self>);
}

macro_rules! field {
    ($t:ty) => {
        impl Field for $t {
            #[inline(never)]
            fn product(out: MatMut<'_, Self>, sum: Accum, a: MatRef<'_, Self>, b: MatRef<'_, Self>) {
                matmul(out, sum, a, b, 1.0, Par::Seq);
            }
        }
    };
}

field!(f32);
field!(f64);

/// The rows of a row-major matrix.
pub(crate) fn rows<T>(values: &[T], n_columns: usize) -> MatRef<'_, T> {
    MatRef::from_row_major_slice(values, values.len() / n_columns, n_columns)
}

/// out = a b.
pub(crate) fn multiply<T: Field>(out: &mut [T], a: MatRef<'_, T>, b: MatRef<'_, T>) {
    let out = MatMut::from_row_major_slice_mut(out, a.nrows(), b.ncols());
    T::product(out, Accum::Replace, a, b);
}

/// out += a b.
pub(crate) fn multiply_add<T: Field>(out: &mut [T], a: MatRef<'_, T>, b: MatRef<'_, T>) {
    let out = MatMut::from_row_major_slice_mut(out, a.nrows(), b.ncols());
    T::product(out, Accum::Add, a, b);
}
