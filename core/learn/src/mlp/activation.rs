//! Activation functions with the derivatives that tangents need, over whole arrays.

use hysteron_base::lanes::{Isa, Simd, WithSimd};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::Float;

/// Activation between two layers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Activation {
    /// max(x, 0): its first derivative jumps, its second is taken as zero.
    Relu,
    /// Hyperbolic tangent.
    Tanh,
    /// ln(1 + eˣ): a smooth ReLU.
    Softplus,
}

impl Activation {
    /// Whether the second derivative is more than zero anywhere.
    pub(crate) fn is_curved(self) -> bool {
        self != Self::Relu
    }

    /// Value, first and second derivative.
    #[inline(always)]
    pub fn at<T: Float>(self, x: T) -> [T; 3] {
        let one = T::of(1.0);
        match self {
            Self::Relu => {
                let is_on = x > T::of(0.0);
                [if is_on { x } else { T::of(0.0) }, if is_on { one } else { T::of(0.0) }, T::of(0.0)]
            }
            Self::Tanh => {
                // Within a unit of rounding of 1, not of tanh(x) near zero: a network adds a bias anyway.
                let e = (T::of(-2.0) * x.size()).exponential();
                let y = x.sign_on((one - e) / (one + e));
                let d = one - y * y;
                [y, d, T::of(-2.0) * y * d]
            }
            Self::Softplus => {
                let e = (-x.size()).exponential();
                let y = x.larger(T::of(0.0)) + e.log_one_plus();
                let tail = one / (one + e);
                let d = if x > T::of(0.0) { tail } else { e * tail };
                [y, d, d * (one - d)]
            }
        }
    }

    /// The third derivative, from the value and the first two.
    #[inline(always)]
    pub fn third<T: Float>(self, [y, d, dd]: [T; 3]) -> T {
        match self {
            Self::Relu => T::of(0.0),
            Self::Tanh => d * (T::of(6.0) * y * y - T::of(2.0)),
            Self::Softplus => dd * (T::of(1.0) - T::of(2.0) * d),
        }
    }

    /// y, f'(x) and f''(x) for every x.
    pub fn apply<T: Float>(self, x: &[T], y: &mut [T], d: &mut [T], dd: &mut [T]) {
        self.apply_to_sums(x, &[], y, d, dd);
    }

    /// The same of x + b: `x` is [row][unit], `biases` b of every unit, or none of them.
    pub(super) fn apply_to_sums<T: Float>(
        self,
        x: &[T],
        biases: &[T],
        y: &mut [T],
        d: &mut [T],
        dd: &mut [T],
    ) {
        let inputs = Inputs { x, biases, y, d, dd };
        match self {
            Self::Relu => Isa::detect().run(ReluArrays(inputs)),
            Self::Tanh => Isa::detect().run(TanhArrays(inputs)),
            Self::Softplus => Isa::detect().run(SoftplusArrays(inputs)),
        }
    }
}

struct Inputs<'a, T> {
    x: &'a [T],
    biases: &'a [T],
    y: &'a mut [T],
    d: &'a mut [T],
    dd: &'a mut [T],
}

impl<T: Float> Inputs<'_, T> {
    #[inline(always)]
    fn run(self, activation: Activation) {
        let n = self.x.len();
        let (x, y, d, dd) = (self.x, &mut self.y[..n], &mut self.d[..n], &mut self.dd[..n]);
        if self.biases.is_empty() {
            for i in 0..n {
                [y[i], d[i], dd[i]] = activation.at(x[i]);
            }
            return;
        }
        let width = self.biases.len();
        let rows = x.chunks_exact(width).zip(y.chunks_exact_mut(width));
        let rows = rows.zip(d.chunks_exact_mut(width).zip(dd.chunks_exact_mut(width)));
        for ((x, y), (d, dd)) in rows {
            for i in 0..width {
                [y[i], d[i], dd[i]] = activation.at(x[i] + self.biases[i]);
            }
        }
    }
}

/// A loop compiled for each instruction set, with the activation known to the compiler.
macro_rules! arrays {
    ($name:ident, $activation:expr) => {
        struct $name<'a, T>(Inputs<'a, T>);
        impl<T: Float> WithSimd for $name<'_, T> {
            type Output = ();
            #[inline(always)]
            fn with_simd<S: Simd>(self, _: S) {
                self.0.run($activation);
            }
        }
    };
}
arrays!(ReluArrays, Activation::Relu);
arrays!(TanhArrays, Activation::Tanh);
arrays!(SoftplusArrays, Activation::Softplus);

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: [Activation; 3] = [Activation::Relu, Activation::Tanh, Activation::Softplus];

    #[test]
    fn values_are_those_of_the_standard_library() {
        for i in -400..=400 {
            let x = f64::from(i) * 0.1003;
            let found = ALL.map(|activation| activation.at(x)[0]);
            let softplus = x.max(0.0) + (-x.abs()).exp().ln_1p();
            for (found, exact) in found.into_iter().zip([x.max(0.0), x.tanh(), softplus]) {
                assert!(
                    (found - exact).abs() <= 4.0 * f64::EPSILON * exact.abs().max(1.0),
                    "{x}: {found} {exact}"
                );
            }
        }
    }

    #[test]
    fn derivatives_are_those_of_differences() {
        // Central differences of step h err by h²/6 times the third derivative (at most 2) and by rounding 1e-16/h.
        let (h, tol) = (1e-5, 1e-9);
        for activation in ALL {
            for i in -30..30 {
                let x = f64::from(i) * 0.13 + 0.05;
                let (before, here, after) = (activation.at(x - h), activation.at(x), activation.at(x + h));
                let slope = |k: usize| (after[k] - before[k]) / (2.0 * h);
                for (found, exact) in
                    [(here[1], slope(0)), (here[2], slope(1)), (activation.third(here), slope(2))]
                {
                    assert!((found - exact).abs() < tol, "{activation:?} {x}: {found} {exact}");
                }
            }
        }
    }

    #[test]
    fn every_instruction_set_does_the_same() {
        let x: Vec<f32> = (0..103).map(|i| 0.31 * (i as f32 - 50.0)).collect();
        for activation in ALL {
            let mut arrays = [vec![0.0; x.len()], vec![0.0; x.len()], vec![0.0; x.len()]];
            let [y, d, dd] = &mut arrays;
            activation.apply(&x, y, d, dd);
            for (i, x) in x.iter().enumerate() {
                assert_eq!(activation.at(*x), [y[i], d[i], dd[i]], "{activation:?} at {x}");
            }
        }
    }
}
