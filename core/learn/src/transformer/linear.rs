//! Products of tokens and matrices, forward and backward.

use std::ops::Range;
use std::sync::OnceLock;

use super::kernels::add_scaled;
use super::small_batch::{FEW, RegisterPanels};
use crate::Float;
use crate::product::{multiply, multiply_add, rows};

/// A matrix as products with a few rows take it, one way and back; made when the first such product asks for it.
#[derive(Debug, Clone)]
pub(super) struct Packed<T> {
    /// Where the matrix begins in its vector of parameters.
    start: usize,
    forward: OnceLock<RegisterPanels<T>>,
    back: OnceLock<RegisterPanels<T>>,
}

impl<T> Packed<T> {
    /// Of a matrix that begins at `start`.
    pub fn new(start: usize) -> Self {
        Self { start, forward: OnceLock::new(), back: OnceLock::new() }
    }

    /// Discards the packed panels: the matrix has changed.
    pub fn invalidate(&mut self) {
        *self = Self::new(self.start);
    }
}

/// x W + b, with W (inputs × outputs).
#[derive(Clone, Copy)]
pub(super) struct Linear<'a, T> {
    weight: &'a [T],
    bias: &'a [T],
    packed: &'a Packed<T>,
}

impl<'a, T: Float> Linear<'a, T> {
    /// The linear map at `layout` in a vector of parameters, all of whose matrices are in `packed`.
    ///
    /// # Panics
    /// If there is no matrix.
    pub fn of(parameters: &'a [T], packed: &'a [Packed<T>], [weight, bias]: &[Range<usize>; 2]) -> Self {
        let at = packed.iter().position(|one| one.start == weight.start);
        let at = at.unwrap_or_else(|| panic!("no matrix at {}", weight.start));
        Self { weight: &parameters[weight.clone()], bias: &parameters[bias.clone()], packed: &packed[at] }
    }

    /// Inputs and outputs.
    fn size(&self) -> [usize; 2] {
        let outputs = self.bias.len();
        [self.weight.len() / outputs, outputs]
    }

    /// y = x W + b.
    pub fn forward(&self, x: &[T], y: &mut [T]) {
        let [inputs, outputs] = self.size();
        y.chunks_exact_mut(outputs).for_each(|row| row.copy_from_slice(self.bias));
        if y.len() <= FEW * outputs {
            let entry = |input: usize, output: usize| self.weight[input * outputs + output];
            self.packed
                .forward
                .get_or_init(|| RegisterPanels::new([inputs, outputs], entry))
                .multiply_add(x, y);
        } else {
            multiply_add(y, rows(x, inputs), rows(self.weight, outputs));
        }
    }

    /// dx = dy Wᵀ.
    pub fn back(&self, dy: &[T], dx: &mut [T]) {
        let [inputs, outputs] = self.size();
        if dy.len() <= FEW * outputs {
            dx.fill(T::default());
            let entry = |output: usize, input: usize| self.weight[input * outputs + output];
            self.packed
                .back
                .get_or_init(|| RegisterPanels::new([outputs, inputs], entry))
                .multiply_add(dy, dx);
        } else {
            multiply(dx, rows(dy, outputs), rows(self.weight, outputs).transpose());
        }
    }
}

/// Adds xᵀ dy and Σ dy to the gradients of weight and bias.
#[inline(always)]
pub(super) fn linear_gradient<T: Float>(
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
