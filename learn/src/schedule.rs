//! How a training goes from epoch to epoch.

use std::f64::consts::PI;

use hysteron_base::BadInput;
use hysteron_base::size::check_count;

use crate::Adam;

/// How the step size falls from that of the start.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Fall {
    /// To a hundredth over all epochs, along half a cosine.
    HalfCosine,
    /// Multiplied by `factor` after every so many epochs.
    Stairs {
        /// Epochs of a stair, at least 1.
        epochs: usize,
        /// From stair to stair.
        factor: f64,
    },
}

/// The course of a training.
#[derive(Debug, Clone, PartialEq)]
pub struct Schedule {
    /// Epochs at most.
    pub epochs: usize,
    /// Epochs without a better error after which it ends.
    pub patience: usize,
    /// The optimiser at the start.
    pub adam: Adam,
    /// What becomes of its step size.
    pub fall: Fall,
    /// Part of the running mean of the weights that each step renews; none for no mean.
    pub renewed: Option<f32>,
    /// Derivatives of at most this size become zero on the way back through time; at zero none do. Where the loss sees the
    /// last of many steps alone, they die away by many powers of ten, the way back ends where all are zero, and below 1e-38
    /// a processor may multiply a hundred times slower.
    pub gradient_floor: f32,
}

/// More than any training has.
pub const MOST_EPOCHS: usize = 100_000;
/// Most hidden units of a layer: one then has 67 million weights.
pub const MOST_HIDDEN: usize = 4096;
pub(crate) const MOST_LAYERS: usize = 16;
/// Most windows of a step, samples between two of them, and samples that go through a network at once.
pub const MOST_ROWS: usize = 1 << 16;

/// Refuses counts of a training that are zero, or beyond the largest that stands beside them.
pub(crate) fn check_counts(counts: &[(&str, usize, usize)]) -> Result<(), BadInput> {
    counts.iter().try_for_each(|(name, n, most)| check_count(name, *n, *most))
}

impl Schedule {
    /// Step size in an epoch, from 0.
    pub fn learning_rate(&self, epoch: usize) -> f64 {
        let factor = match self.fall {
            Fall::HalfCosine => {
                let part = epoch as f64 / self.epochs as f64;
                0.01 + 0.99 * 0.5 * (1.0 + (PI * part).cos())
            }
            Fall::Stairs { epochs, factor } => factor.powi(i32::try_from(epoch / epochs).unwrap_or(i32::MAX)),
        };
        self.adam.learning_rate * factor
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rates<const N: usize>(fall: Fall, epochs: [usize; N]) -> [f64; N] {
        let adam = Adam { learning_rate: 1e-3, ..Adam::default() };
        let schedule = Schedule { epochs: 30, patience: 30, adam, fall, renewed: None, gradient_floor: 0.0 };
        epochs.map(|epoch| schedule.learning_rate(epoch))
    }

    #[test]
    fn the_step_size_falls_in_stairs() {
        let stairs = Fall::Stairs { epochs: 10, factor: 0.5 };
        assert_eq!(rates(stairs, [0, 9, 10, 29]), [1e-3, 1e-3, 5e-4, 2.5e-4]);
    }

    #[test]
    fn or_along_half_a_cosine() {
        let [first, middle, last] = rates(Fall::HalfCosine, [0, 15, 30]);
        assert_eq!(first, 1e-3);
        // Halfway the cosine is zero, at the end it is -1: the mean of 1 and 0.01, and 0.01.
        assert!((middle - 0.505e-3).abs() < 1e-12 && (last - 1e-5).abs() < 1e-12, "{middle} {last}");
    }
}
