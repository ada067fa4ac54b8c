//! The QP of one sample (eqs. 7, 8): which auxiliary strokes bring the tip closest to its goal.
//!
//! Unknowns are the tension increments λ of all cables at an equilibrium, where δ = W λ. The tip rows give the
//! objective ½ |goal - tip - W_e λ|² + γ/2 |s|²; the strokes of taut primary tendons are equalities, tensions of
//! slack ones stay; auxiliary strokes s = c T are boxes: stroke, tension, and rate.

use hysteron_base::Bounds;
use nalgebra::{DMatrix, DVector};

use super::Auxiliary;
use crate::model::Twin;
use crate::projection::Projection;
use crate::qp::RowQp;
use crate::state::TwinState;

/// A bound that an auxiliary stroke can stand at.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Bound {
    /// Smallest stroke or tension.
    Lower,
    /// Largest stroke or tension.
    Upper,
    /// Fastest change.
    Rate,
}

/// Stroke that counts as none, relative to the length unit of the problem.
const NEGLIGIBLE: f64 = 1e-6;

/// The tip and the cables at an equilibrium, linearised.
#[derive(Debug, Clone)]
pub(super) struct Linearised {
    /// Delassus operator of all cables, row-major n × n [m/N].
    delassus: Vec<f64>,
    /// Rows of the tip: displacement, and rotation times its weight where asked for (n each) [m/N].
    tip: Vec<Vec<f64>>,
    /// Cables whose stroke is held: not auxiliary, and not slack.
    held: Vec<usize>,
}

impl Linearised {
    pub fn new(twin: &Twin, projection: &Projection, state: &TwinState, orientation: Option<f64>) -> Self {
        let mut tip: Vec<Vec<f64>> = twin.tip_displacement_rows(projection).into();
        if let Some(weight) = orientation {
            let rows = twin.tip_rotation_rows(projection, state);
            tip.extend(rows.into_iter().map(|row| row.iter().map(|turn| weight * turn).collect()));
        }
        let is_held = |&j: &usize| {
            let Bounds { min, max } = twin.tendons[j].tension;
            state.tensions[j] > min && state.tensions[j] < max
        };
        let held = (0..twin.n_primary).filter(is_held).collect();
        Self { delassus: projection.delassus.clone(), tip, held }
    }

    fn w(&self, i: usize, j: usize) -> f64 {
        self.delassus[i * self.tip[0].len() + j]
    }

    /// What a change of the auxiliary strokes does to the tip while held strokes stay, ∂y/∂s: one row per tip
    /// row (n_aux each) [-], and [rad/m] times the weight.
    ///
    /// `None` where held tendons pull the same way.
    pub fn sensitivity(&self, twin: &Twin, auxiliary: &Auxiliary) -> Option<Vec<Vec<f64>>> {
        let n = self.held.len();
        let among = DMatrix::from_fn(n, n, |a, b| self.w(self.held[a], self.held[b]));
        let factor = among.cholesky()?;
        let row = |row: &Vec<f64>| {
            let reaction = factor.solve(&DVector::from_fn(n, |a, _| row[self.held[a]]));
            let by = |k: usize| {
                let j = twin.n_primary + k;
                let held: f64 = (0..n).map(|a| reaction[a] * self.w(self.held[a], j)).sum();
                (row[j] - held) / auxiliary.compliances[k]
            };
            (0..auxiliary.len()).map(by).collect()
        };
        Some(self.tip.iter().map(row).collect())
    }
}

/// What a QP is posed from, beside the linearised twin.
pub(super) struct Sample<'a> {
    /// From the tip to its goal, as the tip rows [m].
    pub error: &'a [f64],
    /// How far the primary strokes have still to go (n_primary) [m].
    pub missing: &'a [f64],
    /// Auxiliary strokes now (n_aux) [m].
    pub strokes: &'a [f64],
    /// Auxiliary strokes allowed (n_aux) [m].
    pub allowed: &'a [Bounds],
    /// γ, relative to the mean squared sensitivity of the tip [-].
    pub regularisation: f64,
    /// Unit of length that makes the QP dimensionless [m].
    pub length: f64,
}

/// Poses the QP. Its variables are, for every cable, the stroke change that its tension increment alone would
/// make, over `length`.
pub(super) fn pose(twin: &Twin, auxiliary: &Auxiliary, at: &Linearised, sample: &Sample) -> RowQp {
    let n = at.tip[0].len();
    let is_auxiliary = |j: usize| (twin.n_primary..twin.tendons.len()).contains(&j);
    let compliance =
        |j: usize| if is_auxiliary(j) { auxiliary.compliances[j - twin.n_primary] } else { at.w(j, j) };
    let gain: Vec<Vec<f64>> =
        at.tip.iter().map(|row| (0..n).map(|j| row[j] / compliance(j)).collect()).collect();
    let squares = gain.iter().flat_map(|row| &row[twin.n_primary..twin.tendons.len()]).map(|g| g * g);
    let gamma = sample.regularisation * squares.sum::<f64>() / auxiliary.len() as f64;
    let mut qp = RowQp {
        hessian: vec![0.0; n * n],
        linear: vec![0.0; n],
        bounds: vec![[0.0; 2]; n],
        rows: Vec::new(),
        row_bounds: Vec::new(),
    };
    for (row, error) in gain.iter().zip(sample.error) {
        for i in 0..n {
            qp.linear[i] -= row[i] * error / sample.length;
            for j in 0..n {
                qp.hessian[i * n + j] += row[i] * row[j];
            }
        }
    }
    for (k, (stroke, allowed)) in sample.strokes.iter().zip(sample.allowed).enumerate() {
        let j = twin.n_primary + k;
        qp.hessian[j * (n + 1)] += gamma;
        qp.linear[j] += gamma * stroke / sample.length;
        qp.bounds[j] = [allowed.min, allowed.max].map(|bound| (bound - stroke) / sample.length);
    }
    for &i in &at.held {
        qp.bounds[i] = [f64::NEG_INFINITY, f64::INFINITY];
        qp.rows.push((0..n).map(|j| at.w(i, j) / compliance(j)).collect());
        qp.row_bounds.push([sample.missing[i] / sample.length; 2]);
    }
    qp
}

/// Strokes that the answer of a QP means, within what is allowed.
pub(super) fn strokes_of(twin: &Twin, sample: &Sample, answer: &[f64]) -> Vec<f64> {
    let changes = &answer[twin.n_primary..twin.tendons.len()];
    let moved = sample.strokes.iter().zip(changes).map(|(stroke, change)| stroke + change * sample.length);
    moved.zip(sample.allowed).map(|(stroke, allowed)| allowed.clamp(stroke)).collect()
}

/// Strokes allowed `duration` [s] after they were `before`, within `bounds` and the rate.
pub(crate) fn allowed(auxiliary: &Auxiliary, before: &[f64], duration: f64) -> Vec<Bounds> {
    let reach = auxiliary.rate * duration;
    let of = |(bounds, &stroke): (&Bounds, &f64)| Bounds {
        min: bounds.clamp(stroke - reach),
        max: bounds.clamp(stroke + reach),
    };
    auxiliary.bounds.iter().zip(before).map(of).collect()
}

/// The bound that a stroke stands at, if any.
pub(super) fn bound_of(stroke: f64, allowed: &Bounds, whole: &Bounds, length: f64) -> Option<Bound> {
    let near = |a: f64, b: f64| (a - b).abs() <= NEGLIGIBLE * length;
    if near(stroke, whole.min) {
        Some(Bound::Lower)
    } else if near(stroke, whole.max) {
        Some(Bound::Upper)
    } else if near(stroke, allowed.min) || near(stroke, allowed.max) {
        Some(Bound::Rate)
    } else {
        None
    }
}
