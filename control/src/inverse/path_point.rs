//! Positions and rates of a noisy tip.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::TipPosition;

/// Which samples a line is drawn through.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum PathSmoothing {
    /// As many before as after.
    Centred,
    /// The sample and those before: for a path that is not known in advance.
    Causal,
}

/// Position and rate of a tip.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PathPoint {
    /// Position [m].
    pub position: TipPosition,
    /// Rate [m/s].
    pub rate: TipPosition,
}

/// Smooths a path [m]: a straight line through the samples around each, over twice `half` samples, which leaves out
/// those in `gap` unless there are no two others.
pub(super) fn smooth(
    path: &[TipPosition],
    gap: &[bool],
    step: f64,
    smoothing: PathSmoothing,
    half: usize,
) -> Vec<PathPoint> {
    let (before, after) = match smoothing {
        PathSmoothing::Centred => (half, half),
        PathSmoothing::Causal => (2 * half, 0),
    };
    let line = |i: usize| {
        let around = i.saturating_sub(before)..(i + after + 1).min(path.len());
        let there = around.clone().filter(|&j| !gap[j]);
        if there.clone().count() >= 2 {
            line_through(there, i, path, step)
        } else {
            line_through(around, i, path, step)
        }
    };
    (0..path.len()).map(line).collect()
}

/// The line of least squares through some samples, at sample `i`.
fn line_through(
    samples: impl Iterator<Item = usize>,
    i: usize,
    path: &[TipPosition],
    step: f64,
) -> PathPoint {
    let (mut n, mut t1, mut t2, mut p, mut tp) = (0.0, 0.0, 0.0, [0.0; 3], [0.0; 3]);
    for j in samples {
        let t = (j as f64 - i as f64) * step;
        (n, t1, t2) = (n + 1.0, t1 + t, t2 + t * t);
        for c in 0..3 {
            p[c] += path[j][c];
            tp[c] += t * path[j][c];
        }
    }
    let spread = n * t2 - t1 * t1;
    let rate = [0, 1, 2].map(|c| if spread > 0.0 { (n * tp[c] - t1 * p[c]) / spread } else { 0.0 });
    PathPoint { position: [0, 1, 2].map(|c| (p[c] - rate[c] * t1) / n), rate }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Positions on a line, and what is measured of them.
    fn line(n: usize) -> Vec<TipPosition> {
        (0..n).map(|i| [2.0 * i as f64, -0.5 * i as f64, i as f64]).collect()
    }

    #[test]
    fn a_straight_path_comes_through_unchanged() {
        for smoothing in [PathSmoothing::Centred, PathSmoothing::Causal] {
            let path = line(30);
            let found = smooth(&path, &[false; 30], 0.1, smoothing, 5);
            for (i, (point, expected)) in found.iter().zip(&path).enumerate() {
                // Round-off of sums of some ten values of about 60.
                let off = (0..3).map(|c| (point.position[c] - expected[c]).abs()).fold(0.0, f64::max);
                assert!(off < 1e-12, "{smoothing:?} {i}: {off}");
                // One sample has no rate.
                let is_alone = smoothing == PathSmoothing::Causal && i == 0;
                let rate = if is_alone { [0.0; 3] } else { [20.0, -5.0, 10.0] };
                assert!(
                    (0..3).all(|c| (point.rate[c] - rate[c]).abs() < 1e-11),
                    "{smoothing:?} {i}: {point:?}"
                );
            }
        }
    }

    #[test]
    fn causal_smoothing_does_not_look_ahead() {
        let (mut path, gap) = (line(30), [false; 30]);
        let before = smooth(&path, &gap, 0.1, PathSmoothing::Causal, 5);
        path[20] = [100.0; 3];
        let after = smooth(&path, &gap, 0.1, PathSmoothing::Causal, 5);
        assert_eq!(before[..20], after[..20]);
        assert_ne!(before[20], after[20]);
    }

    #[test]
    fn samples_that_were_filled_in_do_not_count() {
        let (mut path, mut gap) = (line(30), [false; 30]);
        let clean = smooth(&path, &gap, 0.1, PathSmoothing::Centred, 5);
        (path[12], gap[12]) = ([1e6, -1e6, 1e6], true);
        let found = smooth(&path, &gap, 0.1, PathSmoothing::Centred, 5);
        for (point, expected) in found.iter().zip(&clean) {
            // As above: both are the line.
            assert!((0..3).all(|c| (point.position[c] - expected.position[c]).abs() < 1e-12));
        }
    }
}
