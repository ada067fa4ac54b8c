//! How a training goes from epoch to epoch.

use std::f64::consts::PI;

use hysteron_base::BadInput;
use hysteron_base::size::check_count;

use crate::Adam;

/// How the step size decays from that of the start.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Decay {
    /// To a hundredth over all epochs, along half a cosine.
    Cosine,
    /// Multiplied by `factor` after every so many epochs.
    Step {
        /// Epochs between two changes, at least 1.
        epochs: usize,
        /// Factor on the step size after these epochs [-].
        factor: f64,
    },
}

/// Epochs, optimiser and step sizes of a training.
#[derive(Debug, Clone, PartialEq)]
pub struct Schedule {
    /// Epochs at most.
    pub epochs: usize,
    /// Epochs without a better error after which it ends.
    pub patience: usize,
    /// The optimiser at the start.
    pub adam: Adam,
    /// How its step size decays.
    pub decay: Decay,
    /// Part of the exponential moving average of the weights that each update replaces; none for no average.
    pub ema: Option<f32>,
}

/// More than any training has.
pub const MAX_EPOCHS: usize = 100_000;
/// Most hidden units of a layer: one then has 67 million weights.
pub const MAX_HIDDEN: usize = 4096;
pub(crate) const MAX_LAYERS: usize = 16;
/// Most windows of a step, samples between two of them, and samples that go through a network at once.
pub const MAX_ROWS: usize = 1 << 16;

/// Refuses counts of a training that are zero, or above the maximum given with them.
pub(crate) fn check_counts(counts: &[(&str, usize, usize)]) -> Result<(), BadInput> {
    counts.iter().try_for_each(|(name, n, most)| check_count(name, *n, *most))
}

impl Schedule {
    /// Step size in an epoch, from 0.
    pub fn learning_rate(&self, epoch: usize) -> f64 {
        let factor = match self.decay {
            Decay::Cosine => {
                let part = epoch as f64 / self.epochs as f64;
                0.01 + 0.99 * 0.5 * (1.0 + (PI * part).cos())
            }
            Decay::Step { epochs, factor } => factor.powi(i32::try_from(epoch / epochs).unwrap_or(i32::MAX)),
        };
        self.adam.learning_rate * factor
    }
}

/// Part of the full step size at an update (from 0) of a training of `updates`: up along a line for `warm_up` of them, then down
/// to a tenth along half a cosine.
pub fn warm_up_cosine(update: u64, warm_up: u64, updates: u64) -> f64 {
    if update < warm_up {
        return (update + 1) as f64 / warm_up as f64;
    }
    let part = (update - warm_up) as f64 / updates.saturating_sub(warm_up).max(1) as f64;
    0.1 + 0.9 * 0.5 * (1.0 + (PI * part.min(1.0)).cos())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rates<const N: usize>(decay: Decay, epochs: [usize; N]) -> [f64; N] {
        let adam = Adam { learning_rate: 1e-3, ..Adam::default() };
        let schedule = Schedule { epochs: 30, patience: 30, adam, decay, ema: None };
        epochs.map(|epoch| schedule.learning_rate(epoch))
    }

    #[test]
    fn the_step_size_decays_step_by_step() {
        let steps = Decay::Step { epochs: 10, factor: 0.5 };
        assert_eq!(rates(steps, [0, 9, 10, 29]), [1e-3, 1e-3, 5e-4, 2.5e-4]);
    }

    #[test]
    fn or_along_half_a_cosine() {
        let [first, middle, last] = rates(Decay::Cosine, [0, 15, 30]);
        assert_eq!(first, 1e-3);
        // Halfway the cosine is zero, at the end it is -1: the mean of 1 and 0.01, and 0.01.
        assert!((middle - 0.505e-3).abs() < 1e-12 && (last - 1e-5).abs() < 1e-12, "{middle} {last}");
    }

    #[test]
    fn a_step_size_warms_up_and_decays_to_a_tenth() {
        let at = |update| warm_up_cosine(update, 10, 110);
        assert_eq!([at(0), at(9), at(10)], [0.1, 1.0, 1.0]);
        // Halfway the cosine is zero.
        assert!((at(60) - 0.55).abs() < 1e-12 && (at(110) - 0.1).abs() < 1e-12 && at(500) == at(110));
    }
}
