//! Adam on plain arrays.

use hysteron_base::BadInput;
use hysteron_base::lanes::{Isa, Simd, WithSimd};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::{Error, Float, Result};

/// How the weights' decay acts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Penalty {
    /// As a part of the gradient, which enters the moments.
    #[default]
    Coupled,
    /// Next to the step that the moments make: AdamW (Loshchilov, Hutter 2019).
    Decoupled,
}

impl Penalty {
    fn is_coupled(&self) -> bool {
        *self == Self::Coupled
    }
}

/// The optimiser and its settings.
///
/// # Reference
/// Kingma, Ba (2015), Adam: a method for stochastic optimization, algorithm 1; the penalty on weights is added to
/// the gradient and the norm clipped before that, as PyTorch's `Adam` and `clip_grad_norm_` do.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Adam {
    /// Step size α.
    pub learning_rate: f64,
    /// Decay of the mean of the gradient.
    pub beta1: f64,
    /// Decay of the mean of its square.
    pub beta2: f64,
    /// Keeps the step finite where the gradient is zero.
    pub epsilon: f64,
    /// λ of the penalty λ/2 |w|².
    pub weight_decay: f64,
    /// Whether the gradient gets it, or the step.
    #[serde(default, skip_serializing_if = "Penalty::is_coupled")]
    pub penalty: Penalty,
    /// Largest norm of the gradient over all parameters; a larger one is scaled down to it.
    pub clip_norm: Option<f64>,
}

impl Default for Adam {
    fn default() -> Self {
        Self {
            learning_rate: 1e-3,
            beta1: 0.9,
            beta2: 0.999,
            epsilon: 1e-8,
            weight_decay: 0.0,
            penalty: Penalty::Coupled,
            clip_norm: None,
        }
    }
}

impl Adam {
    /// # Errors
    /// `BadInput` for a value out of its range, naming it.
    pub(crate) fn check(&self) -> std::result::Result<(), BadInput> {
        let positive = |v: f64| v > 0.0 && v.is_finite();
        let not_negative = |v: f64| v >= 0.0 && v.is_finite();
        let checks = [
            ("learning_rate", self.learning_rate, not_negative(self.learning_rate), "a rate >= 0"),
            ("beta1", self.beta1, (0.0..1.0).contains(&self.beta1), "0 <= beta1 < 1"),
            ("beta2", self.beta2, (0.0..1.0).contains(&self.beta2), "0 <= beta2 < 1"),
            ("epsilon", self.epsilon, positive(self.epsilon), "epsilon > 0"),
            ("weight_decay", self.weight_decay, not_negative(self.weight_decay), "weight_decay >= 0"),
        ];
        let clip = self.clip_norm.unwrap_or(1.0);
        for (name, value, fits, expected) in
            checks.into_iter().chain([("clip_norm", clip, positive(clip), "clip_norm > 0")])
        {
            if !fits {
                return Err(BadInput::new(format!("adam: {name}"), expected, value.to_string()));
            }
        }
        Ok(())
    }

    /// Factor that clips a gradient of this norm [-]; checks settings, loss and norm.
    ///
    /// # Errors
    /// `BadInput` for a setting out of its range; `NotFinite` if the loss or the norm is not finite.
    pub(crate) fn checked_scale(&self, step: u64, loss: f64, norm: f64) -> Result<f64> {
        self.check()?;
        for (what, value) in [("loss", loss), ("norm of the gradient", norm)] {
            if !value.is_finite() {
                return Err(Error::NotFinite { step, what, value });
            }
        }
        Ok(self.scale(norm))
    }

    fn scale(&self, norm: f64) -> f64 {
        self.clip_norm.map_or(1.0, |clip| (clip / (norm + 1e-6)).min(1.0))
    }

    /// Factors of update `step`, from 1, whose gradient is scaled by `scale`.
    pub(crate) fn factors(&self, step: u64, scale: f64) -> AdamFactors {
        let step = i32::try_from(step).unwrap_or(i32::MAX);
        let unbias = |beta: f64| 1.0 - beta.powi(step);
        let (decay, decoupled) = match self.penalty {
            Penalty::Coupled => (self.weight_decay, 0.0),
            Penalty::Decoupled => (0.0, self.learning_rate * self.weight_decay),
        };
        AdamFactors {
            scale,
            decay,
            kept: 1.0 - decoupled,
            rate: self.learning_rate / unbias(self.beta1),
            per_root: 1.0 / unbias(self.beta2).sqrt(),
            epsilon: self.epsilon,
            mean: [self.beta1, 1.0 - self.beta1],
            square: [self.beta2, 1.0 - self.beta2],
        }
    }

    /// Moves `weights` by the gradient times `scale`, on all threads; `step` counts from 1.
    pub(crate) fn update<T: Float>(
        &self,
        step: u64,
        scale: f64,
        gradient: &[T],
        weights: &mut [T],
        moments: &mut Moments<T>,
    ) {
        let (factors, isa) = (self.factors(step, scale), Isa::detect());
        let moments = moments.mean.par_chunks_mut(CHUNK).zip(moments.square.par_chunks_mut(CHUNK));
        let weights = weights.par_chunks_mut(CHUNK).zip(gradient.par_chunks(CHUNK));
        weights.zip(moments).for_each(|((weights, gradient), (mean, square))| {
            isa.run(AdamStep { factors, gradient, weights, mean, square });
        });
    }
}

/// Parameters that a thread takes at once.
pub(super) const CHUNK: usize = 4096;

/// [`AdamFactors`] on some parameters.
struct AdamStep<'a, T> {
    factors: AdamFactors,
    gradient: &'a [T],
    weights: &'a mut [T],
    mean: &'a mut [T],
    square: &'a mut [T],
}

impl<T: Float> WithSimd for AdamStep<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let AdamFactors { scale, decay, kept, rate, per_root, epsilon, mean, square } = self.factors;
        let [scale, decay, kept, rate, per_root, epsilon] =
            [scale, decay, kept, rate, per_root, epsilon].map(T::of);
        let [b1, b2] = [mean, square].map(|part| part.map(T::of));
        let moments = self.mean.iter_mut().zip(self.square);
        for ((weight, gradient), (mean, square)) in self.weights.iter_mut().zip(self.gradient).zip(moments) {
            let g = scale * *gradient + decay * *weight;
            *mean = b1[0] * *mean + b1[1] * g;
            *square = b2[0] * *square + b2[1] * g * g;
            *weight *= kept;
            *weight -= rate * *mean / (square.root() * per_root + epsilon);
        }
    }
}

/// The sum of the squares of all numbers, on all threads; the same bits on any number of them.
pub(super) fn sum_of_squares<T: Float>(values: &[T]) -> f64 {
    let isa = Isa::detect();
    let parts: Vec<f64> = values.par_chunks(CHUNK).map(|values| isa.run(SquaresOf(values))).collect();
    parts.iter().sum()
}

struct SquaresOf<'a, T>(&'a [T]);

impl<T: Float> WithSimd for SquaresOf<'_, T> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> f64 {
        /// Sums side by side.
        const LANES: usize = 16;
        let (groups, rest) = self.0.as_chunks::<LANES>();
        let mut sums = [0.0; LANES];
        for group in groups {
            for (sum, value) in sums.iter_mut().zip(group) {
                *sum += value.to_f64() * value.to_f64();
            }
        }
        sums.iter().sum::<f64>() + rest.iter().map(|value| value.to_f64().powi(2)).sum::<f64>()
    }
}

/// An update: with g ← scale g + decay w, m ← mean·(m, g) and v ← square·(v, g²), w ← kept w − rate m/(√v per_root + epsilon).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct AdamFactors {
    pub scale: f64,
    pub decay: f64,
    pub kept: f64,
    pub rate: f64,
    pub per_root: f64,
    pub epsilon: f64,
    pub mean: [f64; 2],
    pub square: [f64; 2],
}

/// Means of the gradient of one vector of parameters.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Moments<T> {
    /// Of the gradient.
    pub mean: Vec<T>,
    /// Of its square.
    pub square: Vec<T>,
}

impl<T: Float> Moments<T> {
    pub fn zeros(len: usize) -> Self {
        Self { mean: vec![T::default(); len], square: vec![T::default(); len] }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Round-off of a few operations in `f32`.
    const TOL: f32 = 8.0 * f32::EPSILON;

    #[test]
    fn constant_gradients_move_weights_by_the_rate() {
        // Then mean = (1 - β₁ᵗ) g and square = (1 - β₂ᵗ) g²: every step is α g/(|g| + ε).
        let adam = Adam { learning_rate: 0.25, ..Adam::default() };
        let (mut weights, mut moments) = ([1.0f32, 1.0, 1.0], Moments::zeros(3));
        for step in 1..=8 {
            adam.update(step, 1.0, &[3.0, -0.01, 0.0], &mut weights, &mut moments);
            let moved = 0.25 * step as f32;
            // Moments are small differences from 1 at first: (1 - β₂) is rounded to `f32` relative to 1e-3.
            for (found, expected) in weights.iter().zip([1.0 - moved, 1.0 + moved, 1.0]) {
                assert!((found - expected).abs() <= 100.0 * TOL, "step {step}: {found} {expected}");
            }
        }
    }

    #[test]
    fn the_second_step_is_that_of_the_paper() {
        // Gradients 1 and -1 at β₁ = 0.5, β₂ = 0.75: mean -0.25/0.75, square 0.4375/0.4375.
        let adam = Adam { learning_rate: 0.5, beta1: 0.5, beta2: 0.75, ..Adam::default() };
        let (mut weight, mut moments) = ([0.0f32], Moments::zeros(1));
        adam.update(1, 1.0, &[1.0], &mut weight, &mut moments);
        assert!((weight[0] + 0.5).abs() <= TOL, "{}", weight[0]);
        adam.update(2, 1.0, &[-1.0], &mut weight, &mut moments);
        assert!((weight[0] - (-0.5 + 0.5 / 3.0)).abs() <= TOL, "{}", weight[0]);
    }

    #[test]
    fn a_penalty_is_a_gradient_and_a_long_gradient_is_scaled() {
        let adam = Adam { weight_decay: 0.5, clip_norm: Some(2.0), ..Adam::default() };
        let (mut weight, mut moments) = ([4.0f32], Moments::zeros(1));
        let scale = adam.scale(8.0);
        assert!((scale - 0.25).abs() < 1e-6 && adam.scale(1.0) == 1.0, "{scale}");
        adam.update(1, scale, &[8.0], &mut weight, &mut moments);
        // g = 0.25 · 8 + 0.5 · 4, mean (1 - β₁) g; the scale is short by 1e-6/8.
        assert!((moments.mean[0] - 0.4).abs() < 1e-6, "{}", moments.mean[0]);
    }

    #[test]
    fn a_decoupled_penalty_leaves_the_moments_alone() {
        // w ← w (1 − α λ) − α sign g after the first step.
        let adam =
            Adam { learning_rate: 0.25, weight_decay: 0.5, penalty: Penalty::Decoupled, ..Adam::default() };
        let (mut weight, mut moments) = ([4.0f32], Moments::zeros(1));
        adam.update(1, 1.0, &[8.0], &mut weight, &mut moments);
        assert!((weight[0] - (4.0 * 0.875 - 0.25)).abs() <= 4.0 * TOL, "{}", weight[0]);
        // (1 - β₁) g, with 0.1 rounded.
        assert!((moments.mean[0] - 0.8).abs() <= TOL, "{}", moments.mean[0]);
    }

    #[test]
    fn a_quadratic_is_minimised() {
        let adam = Adam { learning_rate: 0.05, ..Adam::default() };
        let (mut weights, mut moments) = ([3.0f32, -2.0], Moments::zeros(2));
        for step in 1..=1000 {
            let gradient = [weights[0] - 1.0, 40.0 * (weights[1] - 0.5)];
            adam.update(step, 1.0, &gradient, &mut weights, &mut moments);
        }
        // A step is at most about the rate; it fades with the gradient.
        assert!((weights[0] - 1.0).abs() < 1e-3 && (weights[1] - 0.5).abs() < 1e-3, "{weights:?}");
    }
}
