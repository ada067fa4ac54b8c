//! The path of the next repeat, learned from how the repeats before missed their goal.

use std::path::Path;

use hysteron_base::Recording;
use hysteron_control::inverse::TipPosition;
use hysteron_control::path::PathSpan;
use hysteron_control::repetition::{Repeat, RepetitionLearning};

use crate::shared::memory;
use crate::tendon::command::Target;

/// The best repeat so far, and how far the next one goes from it.
pub(super) struct LearnedPath {
    learning: RepetitionLearning,
    best: Option<(Repeat, f64)>,
}

impl LearnedPath {
    /// Before the first repeat.
    pub(super) fn new() -> Self {
        Self { learning: RepetitionLearning::default(), best: None }
    }

    /// Takes in the recording of a repeat whose strokes led the tip along `led`; gives the path for the next repeat. One that was no better
    /// than the best before it is forgotten, and the next goes half as far.
    ///
    /// # Errors
    /// A recording that cannot be read, or that has no tip.
    pub(super) fn next(
        &mut self,
        goal: &Target,
        led: Vec<TipPosition>,
        recorded: &Path,
    ) -> anyhow::Result<Vec<TipPosition>> {
        let repeat = repeat(&memory::recording(recorded)?, goal, led)?;
        let error = repeat.error_m(&goal.path);
        tracing::info!("{}: {:.3} mm (rms) from where the tip was to be", recorded.display(), 1e3 * error);
        match &self.best {
            Some((_, least)) if error >= *least => self.learning.gain *= 0.5,
            _ => self.best = Some((repeat, error)),
        }
        let next = |(best, _): &(Repeat, f64)| best.next(&goal.path, goal.step, &self.learning);
        Ok(self.best.as_ref().map_or_else(|| goal.path.clone(), next))
    }
}

/// The samples of a recording that belong to the path.
fn repeat(recording: &Recording, goal: &Target, led: Vec<TipPosition>) -> anyhow::Result<Repeat> {
    let first = (PathSpan::of(recording)?.begins / goal.step).round() as usize;
    let names = ["tip_x_m", "tip_y_m", "tip_z_m"];
    for name in &names[..goal.axes.len()] {
        recording.require(name)?;
    }
    let channels = names.map(|name| recording.channel(name));
    let is_led = |c: usize| c < goal.axes.len();
    let at = |i: usize| -> TipPosition {
        std::array::from_fn(|c| match channels[c].and_then(|values| values.get(first + i)) {
            Some(value) if is_led(c) => *value,
            _ if is_led(c) => f64::NAN,
            // Nobody leads it.
            _ => goal.path[i][c],
        })
    };
    let is_gap = |i: usize| recording.gap().get(first + i).copied().unwrap_or(false);
    let n = goal.path.len();
    Ok(Repeat { led, tip: (0..n).map(at).collect(), gap: (0..n).map(is_gap).collect() })
}
