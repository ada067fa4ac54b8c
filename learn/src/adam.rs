//! Adam on plain arrays.

use hysteron_base::BadInput;
use serde::{Deserialize, Serialize};

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
            clip_norm: None,
        }
    }
}

impl Adam {
    /// # Errors
    /// `BadInput` for a value out of its range, naming it.
    pub(crate) fn check(&self) -> Result<(), BadInput> {
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

    /// What the gradient of this norm is multiplied by.
    pub(crate) fn scale(&self, norm: f64) -> f64 {
        self.clip_norm.map_or(1.0, |clip| (clip / (norm + 1e-6)).min(1.0))
    }

    /// Moves `weights` by the gradient times `scale`; `step` counts from 1.
    pub(crate) fn update(
        &self,
        step: u64,
        scale: f64,
        gradient: &[f32],
        weights: &mut [f32],
        moments: &mut Moments,
    ) {
        let step = i32::try_from(step).unwrap_or(i32::MAX);
        let unbias = |beta: f64| 1.0 - beta.powi(step);
        let rate = (self.learning_rate / unbias(self.beta1)) as f32;
        let per_root = (1.0 / unbias(self.beta2).sqrt()) as f32;
        let [scale, decay, epsilon] = [scale, self.weight_decay, self.epsilon].map(|v| v as f32);
        let [b1, b2] = [self.beta1, self.beta2].map(|b| (b as f32, (1.0 - b) as f32));
        let moments = moments.mean.iter_mut().zip(&mut moments.square);
        for ((weight, gradient), (mean, square)) in weights.iter_mut().zip(gradient).zip(moments) {
            let g = scale * gradient + decay * *weight;
            *mean = b1.0 * *mean + b1.1 * g;
            *square = b2.0 * *square + b2.1 * g * g;
            *weight -= rate * *mean / (square.sqrt() * per_root + epsilon);
        }
    }
}

/// Means of the gradient of one vector of parameters.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Moments {
    /// Of the gradient.
    pub mean: Vec<f32>,
    /// Of its square.
    pub square: Vec<f32>,
}

impl Moments {
    pub fn zeros(len: usize) -> Self {
        Self { mean: vec![0.0; len], square: vec![0.0; len] }
    }
}
