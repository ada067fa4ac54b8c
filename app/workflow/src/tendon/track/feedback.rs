//! Strokes with all that feedback of the tip needs: the goal, and how the strokes change with it.

use hysteron_base::{Channel, Recording};
use hysteron_control::inverse::TipPosition;
use hysteron_control::path::PathSpan;
use hysteron_rig::session::{FEEDBACK_GATE, response_channel};

use crate::Context;
use crate::tendon::command::{LimitOverrides, Target, Way};

/// Displacement of the whole path that shows how the strokes change with it [m].
const SHIFT: f64 = 1e-3;
/// Time over which the correction comes at the beginning of the path and goes after its end [s].
const FADE_S: f64 = 0.5;

/// The recording of `commanded`, which leads the tip along `led`, with the channels of feedback. The response du/dd is the difference
/// of strokes for the same path and for one that is moved along x or y.
///
/// # Errors
/// Those of finding strokes.
pub(super) fn with_feedback(
    (way, goal, led): (&Way, &Target, &[TipPosition]),
    commanded: &Recording,
    overrides: &LimitOverrides,
    context: &Context,
) -> anyhow::Result<Recording> {
    let n = goal.path.len();
    let first = first_row(commanded, goal.step)?;
    let strokes = commanded.strokes();
    let rows = commanded.n_samples();
    let mut channels = commanded.channels().to_vec();
    for axis in 0..2 {
        let moved: Vec<TipPosition> = led
            .iter()
            .map(|point| std::array::from_fn(|c| point[c] + if c == axis { SHIFT } else { 0.0 }))
            .collect();
        let moved = way.strokes_led(goal, &moved, overrides, context)?;
        let first_moved = first_row(&moved, goal.step)?;
        for (k, (own, moved)) in strokes.iter().zip(moved.strokes()).enumerate() {
            let response = |i: usize| {
                let sample = i.saturating_sub(first).min(n - 1);
                fade(i, first, n, goal.step) * (moved[first_moved + sample] - own[first + sample]) / SHIFT
            };
            channels.push(Channel::new(response_channel(k + 1, axis), (0..rows).map(response).collect()));
        }
    }
    let gate = |i: usize| f64::from(u8::from((first..first + n).contains(&i)));
    channels.push(Channel::new(FEEDBACK_GATE, (0..rows).map(gate).collect()));
    let (time, gap, meta) = (commanded.time().to_vec(), commanded.gap().to_vec(), commanded.meta().clone());
    Ok(Recording::new(time, channels, gap, meta)?)
}

/// The row in which the path begins.
fn first_row(recording: &Recording, step: f64) -> anyhow::Result<usize> {
    Ok((PathSpan::of(recording)?.begins / step).round() as usize)
}

/// Part of the correction in a row.
fn fade(row: usize, first: usize, n: usize, step: f64) -> f64 {
    if row < first {
        return 0.0;
    }
    let since_begin = (row - first) as f64 * step / FADE_S;
    let since_end = row.saturating_sub(first + n - 1) as f64 * step / FADE_S;
    since_begin.min(1.0).min((1.0 - since_end).max(0.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_correction_comes_and_goes_within_half_a_second() {
        let of = |row| fade(row, 100, 200, 0.01);
        assert_eq!(
            [of(0), of(100), of(125), of(150), of(299), of(349), of(400)],
            [0.0, 0.0, 0.5, 1.0, 1.0, 0.0, 0.0]
        );
        assert!((of(324) - 0.5).abs() < 1e-12);
    }
}
