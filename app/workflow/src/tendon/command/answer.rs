//! Limits and target of a command, and the strokes that answer it.

use hysteron_control::inverse::{Axes, TipPosition};

/// Limits that replace those of a training [m, m/s].
#[derive(Debug, Clone, Copy, Default)]
pub struct LimitOverrides {
    /// Smallest and largest stroke.
    pub stroke: [Option<f64>; 2],
    /// Fastest change of a stroke.
    pub rate: Option<f64>,
}

/// Where the tip shall go.
#[derive(Debug, Clone)]
pub struct Target {
    /// Times (n_samples) [s].
    pub time: Vec<f64>,
    /// Duration of a sample [s].
    pub step: f64,
    /// Tips (n_samples) [m].
    pub path: Vec<TipPosition>,
    /// Whether these have a z.
    pub axes: Axes,
}

/// Strokes for a path, and the other recorded channels, with an approach before the path and a return after it.
pub(super) struct Answer {
    /// Samples before the path's first.
    pub(super) approach: usize,
    /// By tendon, then by sample [m].
    pub(super) strokes: Vec<Vec<f64>>,
    /// Tip of the twin, if it was asked: x, y and z [m].
    pub(super) twin: Option<[Vec<f64>; 3]>,
    /// 1 where a limit reduced a stroke.
    pub(super) limited: Vec<f64>,
    /// 1 where a network left its training range.
    pub(super) extrapolating: Vec<f64>,
    /// Radius of the band about the twin's tip [m]; empty without one.
    pub(super) tip_band: Vec<f64>,
}
