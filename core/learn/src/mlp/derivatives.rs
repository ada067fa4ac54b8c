//! Where derivatives by parameters go: summed over the rows of a batch, or row by row.

use std::ops::Range;

use hysteron_base::lanes::{Isa, Simd, WithSimd};

use super::shape::LayerShape;
use crate::Float;
use crate::product::{multiply, multiply_add, rows};

/// Derivatives by parameters: where they go.
#[derive(Debug)]
pub enum ByParameters<'a, T> {
    /// Of the sum over all rows of a batch, added to what is there: [parameter].
    Sum(&'a mut [T]),
    /// The same in place of what is there, which need not have been cleared; each of the parameters once.
    First(&'a mut [T]),
    /// Of every row: a Jacobian [row][parameter].
    Rows {
        /// The Jacobian.
        values: &'a mut [T],
        /// Parameters of a row.
        width: usize,
        /// The parameter that counts as the first.
        start: usize,
    },
}

impl<T: Float> ByParameters<'_, T> {
    /// The same, counted from the parameter `first` on.
    pub fn from(&mut self, first: usize) -> ByParameters<'_, T> {
        match self {
            Self::Sum(values) => ByParameters::Sum(&mut values[first..]),
            Self::First(values) => ByParameters::First(&mut values[first..]),
            Self::Rows { values, width, start } => {
                ByParameters::Rows { values, width: *width, start: *start + first }
            }
        }
    }

    /// Before the first is added to any of these parameters.
    pub fn begin(&mut self, parameters: Range<usize>) {
        if let Self::First(values) = self {
            values[parameters].fill(T::default());
        }
    }

    /// Adds `value` to the derivative of a row by a parameter.
    #[inline]
    pub fn add(&mut self, row: usize, parameter: usize, value: T) {
        match self {
            Self::Sum(values) | Self::First(values) => values[parameter] += value,
            Self::Rows { values, width, start } => values[row * *width + *start + parameter] += value,
        }
    }

    /// Adds those of the biases of a layer: `cotangents` of its sums, of which those of the values come first, [stream][row][unit];
    /// none where values have none.
    pub(super) fn add_biases(&mut self, shape: &LayerShape, n_rows: usize, cotangents: &[T]) {
        let biases = shape.start + shape.outputs * shape.inputs;
        self.begin(biases..biases + shape.outputs);
        let (values, width) = match self {
            Self::Sum(values) | Self::First(values) => (&mut values[biases..], 0),
            Self::Rows { values, width, start } => (&mut values[*start + biases..], *width),
        };
        let cotangents = &cotangents[..cotangents.len().min(n_rows * shape.outputs)];
        Isa::detect().run(Biases { cotangents, n_units: shape.outputs, values, width });
    }

    /// Adds those of the weights of a layer: `cotangents` of its sums, `inputs` of it, both [stream][row][unit].
    pub(super) fn add_weights(&mut self, shape: &LayerShape, n_rows: usize, cotangents: &[T], inputs: &[T]) {
        let [by_sums, entered] = [rows(cotangents, shape.outputs), rows(inputs, shape.inputs)];
        match self {
            Self::Sum(values) => multiply_add(shape.weights_mut(values), by_sums.transpose(), entered),
            Self::First(values) => multiply(shape.weights_mut(values), by_sums.transpose(), entered),
            Self::Rows { values, width, start } => {
                let values = &mut values[*start..];
                Isa::detect().run(RowByRow { shape, n_rows, cotangents, inputs, values, width: *width });
            }
        }
    }
}

/// Adds every row to the values `width` numbers after those of the row before.
struct Biases<'a, T> {
    cotangents: &'a [T],
    n_units: usize,
    values: &'a mut [T],
    width: usize,
}

impl<T: Float> WithSimd for Biases<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        for (row, cotangents) in self.cotangents.chunks_exact(self.n_units).enumerate() {
            let sums = &mut self.values[row * self.width..][..cotangents.len()];
            for i in 0..cotangents.len() {
                sums[i] += cotangents[i];
            }
        }
    }
}

/// The outer products of every row.
struct RowByRow<'a, T> {
    shape: &'a LayerShape,
    n_rows: usize,
    cotangents: &'a [T],
    inputs: &'a [T],
    values: &'a mut [T],
    width: usize,
}

impl<T: Float> WithSimd for RowByRow<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let [n_in, n_out] = [self.shape.inputs, self.shape.outputs];
        for (row, values) in self.values.chunks_mut(self.width).take(self.n_rows).enumerate() {
            let weights = self.shape.weights_mut(values);
            let streams = self.cotangents.len() / (self.n_rows * n_out);
            for at in (0..streams).map(|s| s * self.n_rows + row) {
                let cotangents = &self.cotangents[at * n_out..(at + 1) * n_out];
                let inputs = &self.inputs[at * n_in..(at + 1) * n_in];
                for (weights, c) in weights.chunks_exact_mut(n_in).zip(cotangents) {
                    for (w, x) in weights.iter_mut().zip(inputs) {
                        *w += *c * *x;
                    }
                }
            }
        }
    }
}
