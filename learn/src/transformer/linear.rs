//! Products of tokens and matrices, forward and backward.

use std::ops::Range;

use super::kernels::add_scaled;
use crate::Real;
use crate::product::{multiply, multiply_add, rows};

/// y = x W + b, with W (inputs × outputs).
pub(super) fn linear<T: Real>(x: &[T], weight: &[T], bias: &[T], y: &mut [T]) {
    let n = bias.len();
    y.chunks_exact_mut(n).for_each(|row| row.copy_from_slice(bias));
    multiply_add(y, rows(x, weight.len() / n), rows(weight, n));
}

/// dx = dy Wᵀ.
pub(super) fn linear_back<T: Real>(dy: &[T], weight: &[T], outputs: usize, dx: &mut [T]) {
    multiply(dx, rows(dy, outputs), rows(weight, outputs).transpose());
}

/// Adds xᵀ dy and Σ dy to the gradients of weight and bias.
pub(super) fn linear_gradient<T: Real>(
    [x, dy]: [&[T]; 2],
    [weight, bias]: &[Range<usize>; 2],
    gradient: &mut [T],
) {
    let n = bias.len();
    let inputs = weight.len() / n;
    multiply_add(&mut gradient[weight.clone()], rows(x, inputs).transpose(), rows(dy, n));
    for dy in dy.chunks_exact(n) {
        add_scaled(&mut gradient[bias.clone()], T::of(1.0), dy);
    }
}
