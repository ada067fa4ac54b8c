//! Recordings as demonstrations.

use hysteron_control::inverse::{Axes, DataOrigin, Demonstration, TipPosition};

use crate::tendon::ftdcr::{N_TENDONS, Pattern};

/// Nominal duration of a sample of the trunk, and of the three-segment robot [s].
pub(super) const TRUNK_STEP: f64 = 0.01;
pub(super) const FTDCR_STEP: f64 = 0.58;
pub(super) const N_MOTORS: usize = 6;
/// An angle replaces a stroke: one degree for this many metres, so that values in millimetres are in degrees.
pub(super) const DEGREE: f64 = 1e-3;
/// A block of the trunk's run, and every how many of them one is to stop by, and the next to test on.
const BLOCK_S: f64 = 10.0;
pub(super) const TURNS: usize = 5;

/// Blocks of the trunk's run, in order; the tip from where it was in the first second of the run.
pub(super) fn blocks(angles: &[Vec<f64>], tips: &[Vec<f64>], name: &str) -> Vec<Demonstration> {
    let n = angles.len().min(tips.len());
    let n_rest = (1.0 / TRUNK_STEP) as usize;
    let rest: Vec<f64> = (0..3).map(|c| mean(tips[..n_rest.min(n)].iter().map(|tip| tip[c]))).collect();
    let size = (BLOCK_S / TRUNK_STEP) as usize;
    let block = |k: usize| {
        let samples = k * size..(k + 1) * size;
        let tip = samples.clone().map(|i| std::array::from_fn(|c| tips[i][c] - rest[c])).collect();
        let strokes = samples.flat_map(|i| &angles[i]).map(|angle| DEGREE * angle).collect();
        demonstration(format!("{name}-{k}"), TRUNK_STEP, tip, N_MOTORS, strokes)
    };
    (0..n / size).map(block).collect()
}

pub(super) fn demonstration(
    name: String,
    step: f64,
    tip: Vec<TipPosition>,
    n_tendons: usize,
    strokes: Vec<f64>,
) -> Demonstration {
    Demonstration {
        name,
        hash: String::new(),
        origin: DataOrigin::Real,
        robot: String::new(),
        family: String::new(),
        step,
        axes: Axes::Spatial,
        gap: vec![false; tip.len()],
        tip,
        n_tendons,
        strokes,
        jacobian: Vec::new(),
    }
}

/// A pattern of the three-segment robot.
pub(super) fn pattern(pattern: &Pattern) -> Demonstration {
    let (tip, strokes) =
        pattern.rows.iter().map(|row| (row.tip, row.strokes)).unzip::<_, _, Vec<_>, Vec<_>>();
    demonstration(pattern.label.clone(), FTDCR_STEP, tip, N_TENDONS, strokes.concat())
}

fn mean(values: impl ExactSizeIterator<Item = f64>) -> f64 {
    let n = values.len().max(1) as f64;
    values.sum::<f64>() / n
}
