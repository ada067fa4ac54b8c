//! Products of tokens and matrices, forward and backward.

use std::ops::Range;

use super::few::{FEW, Panels};
use super::kernels::add_scaled;
use crate::Real;
use crate::product::{multiply, multiply_add, rows};

/// A matrix as products with a few rows take it, one way and back.
#[derive(Debug, Clone)]
pub(super) struct Packed<T> {
    /// Where the matrix begins in its vector of parameters.
    start: usize,
    forward: Panels<T>,
    back: Panels<T>,
}

impl<T: Real> Packed<T> {
    /// Of W (inputs × outputs) that begins at `start`.
    pub fn new(start: usize, weight: &[T], outputs: usize) -> Self {
        let inputs = weight.len() / outputs;
        let forward = Panels::new([inputs, outputs], |k, output| weight[k * outputs + output]);
        let back = Panels::new([outputs, inputs], |k, input| weight[input * outputs + k]);
        Self { start, forward, back }
    }
}

/// x W + b, with W (inputs × outputs).
#[derive(Clone, Copy)]
pub(super) struct Linear<'a, T> {
    pub weight: &'a [T],
    pub bias: &'a [T],
    pub packed: &'a Packed<T>,
}

impl<'a, T: Real> Linear<'a, T> {
    /// What stands at `layout` in a vector of parameters, all of whose matrices are in `packed`.
    ///
    /// # Panics
    /// If there is no matrix.
    pub fn of(parameters: &'a [T], packed: &'a [Packed<T>], [weight, bias]: &[Range<usize>; 2]) -> Self {
        let at = packed.iter().position(|one| one.start == weight.start);
        let at = at.unwrap_or_else(|| panic!("no matrix at {}", weight.start));
        Self { weight: &parameters[weight.clone()], bias: &parameters[bias.clone()], packed: &packed[at] }
    }

    /// y = x W + b.
    pub fn forward(&self, x: &[T], y: &mut [T]) {
        let outputs = self.bias.len();
        y.chunks_exact_mut(outputs).for_each(|row| row.copy_from_slice(self.bias));
        if y.len() <= FEW * outputs {
            self.packed.forward.multiply_add(x, y);
        } else {
            multiply_add(y, rows(x, self.weight.len() / outputs), rows(self.weight, outputs));
        }
    }

    /// dx = dy Wᵀ.
    pub fn back(&self, dy: &[T], dx: &mut [T]) {
        let outputs = self.bias.len();
        if dy.len() <= FEW * outputs {
            dx.fill(T::default());
            self.packed.back.multiply_add(dy, dx);
        } else {
            multiply(dx, rows(dy, outputs), rows(self.weight, outputs).transpose());
        }
    }
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
