//! One sample, linearised (eqs. 7, 8): which auxiliary strokes bring the tip closest to its goal.
//!
//! At an equilibrium the tensions of auxiliary tendons are given, and those of all other cables follow from the
//! conditions of a step: a primary tendon is held at its stroke or slack, a friction point sticks or slips. As long
//! as none of them changes its place, the tip is a linear function of the auxiliary strokes, y(s + ds) = y + d + G
//! ds, and the problem min ½ |goal - y(s + ds)|² + γ/2 |s + ds|² has only boxes: stroke, tension, and rate. Its
//! answer gives the positions of the others; if these change, the problem is posed again from there.

use hysteron_base::Bounds;
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use super::AuxiliaryLimits;
use crate::model::Twin;
use crate::solver::TensionResponse;
use crate::stepper::LinearisedStep;
use hysteron_fit::qp::{Activity, BoxQp, BoxedRows, QpStatus};

/// A bound of an auxiliary stroke that can be active.
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

/// Times a problem is posed again because tendons or friction points have changed the active set.
const MAX_CONTACTS: usize = 8;
/// Smallest step length towards a solution, where longer steps lead no nearer [-].
const SMALLEST_PART: f64 = 1.0 / 16.0;

/// The tip and the cables at an equilibrium, linearised.
#[derive(Debug, Clone)]
pub(super) struct LinearisedTip {
    /// W of the cables that are not auxiliary, in their order [m/N].
    among: DMatrix<f64>,
    /// Their strokes by auxiliary strokes (n_others × n_aux) [-].
    coupling: DMatrix<f64>,
    /// The tip by their tensions (rows × n_others) [m/N].
    by_others: DMatrix<f64>,
    /// The tip by auxiliary strokes, other tensions unchanged (rows × n_aux) [-].
    by_strokes: DMatrix<f64>,
}

/// The tip as a linear function of the changes of auxiliary strokes.
pub(super) struct StrokeResponse {
    /// d: where the tip goes without a change (rows) [m].
    pub offset: DVector<f64>,
    /// G (rows × n_aux) [-].
    pub gain: DMatrix<f64>,
}

/// Effect of a change of the auxiliary strokes.
struct Follow {
    /// The change (n_aux) [m].
    change: DVector<f64>,
    /// Strokes of the other cables then (n_others).
    active_set: Vec<Activity>,
    /// Displacement of the tip (rows) [m].
    tip: DVector<f64>,
}

/// |goal - tip|² + γ |s|²: twice what is minimised.
struct Cost {
    /// From the tip to its goal (rows) [m].
    error: DVector<f64>,
    /// Auxiliary strokes before the change (n_aux) [m].
    strokes: DVector<f64>,
    /// γ [-].
    gamma: f64,
}

impl Cost {
    fn of(&self, follow: &Follow) -> f64 {
        (&self.error - &follow.tip).norm_squared()
            + self.gamma * (&self.strokes + &follow.change).norm_squared()
    }
}

impl LinearisedTip {
    /// The tip's rows are its displacement, and where `orientation` gives the weight of a turn [m], its turn too.
    pub fn new(
        twin: &Twin,
        auxiliary: &AuxiliaryLimits,
        response: &TensionResponse,
        orientation: Option<f64>,
    ) -> Self {
        let mut tip: Vec<Vec<f64>> = response.tip.to_vec();
        if let Some((weight, turn)) = orientation.zip(response.turn.as_ref()) {
            tip.extend(turn.iter().map(|row| row.iter().map(|turn| weight * turn).collect()));
        }
        let (n, first) = (twin.cables.len(), twin.n_primary);
        let others: Vec<usize> = others(twin).collect();
        let w = |i: usize, j: usize| response.delassus[i * n + j];
        let (n_others, n_aux) = (others.len(), auxiliary.len());
        let by_stroke = |k: usize| 1.0 / auxiliary.compliances[k];
        Self {
            among: DMatrix::from_fn(n_others, n_others, |a, b| w(others[a], others[b])),
            coupling: DMatrix::from_fn(n_others, n_aux, |a, k| w(others[a], first + k) * by_stroke(k)),
            by_others: DMatrix::from_fn(tip.len(), n_others, |c, a| tip[c][others[a]]),
            by_strokes: DMatrix::from_fn(tip.len(), n_aux, |c, k| tip[c][first + k] * by_stroke(k)),
        }
    }

    /// Response of the tip to strokes while the cables `held` keep theirs, up to their stroke residual, and
    /// the tensions of the others change by `increments`. `None` where held cables pull the same way.
    pub fn response(
        &self,
        held: &[usize],
        stroke_residual: &[f64],
        increments: &DVector<f64>,
    ) -> Option<StrokeResponse> {
        let among = self.among.select_rows(held);
        let factor: Cholesky<f64, Dyn> = among.select_columns(held).cholesky()?;
        let left = DVector::from_fn(held.len(), |a, _| stroke_residual[held[a]]) - &among * increments;
        let tip = self.by_others.select_columns(held);
        Some(StrokeResponse {
            offset: &self.by_others * increments + &tip * factor.solve(&left),
            gain: &self.by_strokes - &tip * factor.solve(&self.coupling.select_rows(held)),
        })
    }
}

/// Cables that are not auxiliary: primary tendons, then friction points.
pub(super) fn others(twin: &Twin) -> impl Iterator<Item = usize> {
    (0..twin.n_primary).chain(twin.tendons.len()..twin.cables.len())
}

/// Goal, strokes and weights of a sample, next to the linearised twin.
pub(super) struct WeightedSample<'a> {
    /// From the tip to its goal, as the tip rows [m].
    pub error: &'a [f64],
    /// Auxiliary strokes now (n_aux) [m].
    pub strokes: &'a [f64],
    /// Auxiliary strokes allowed (n_aux) [m].
    pub allowed: &'a [Bounds],
    /// γ, relative to the mean squared sensitivity of the tip [-].
    pub regularisation: f64,
    /// Unit of length that makes the QP dimensionless [m].
    pub length: f64,
}

/// Solution of a sample.
pub(super) struct SampleSolution {
    /// Auxiliary strokes, within what is allowed (n_aux) [m].
    pub strokes: Vec<f64>,
    /// How far the tip will be from its goal then, as the tip rows [m].
    pub left: DVector<f64>,
    pub status: QpStatus,
}

/// Solves samples; scratch.
#[derive(Debug, Clone)]
pub(super) struct AuxiliaryProblem {
    /// Tensions of the other cables under given auxiliary strokes.
    contact: BoxQp,
    /// The QP of the strokes that was solved last.
    pub last: Option<BoxedRows>,
    /// Stroke residual of each of the other cables [m], and bounds of its tension increment [N].
    stroke_residual: Vec<f64>,
    lower: Vec<f64>,
    upper: Vec<f64>,
    /// Tension increments of the other cables [N].
    increments: Vec<f64>,
}

impl AuxiliaryProblem {
    pub fn new(twin: &Twin) -> Self {
        let n = others(twin).count();
        Self {
            contact: BoxQp::new(n),
            last: None,
            stroke_residual: vec![0.0; n],
            lower: vec![0.0; n],
            upper: vec![0.0; n],
            increments: vec![0.0; n],
        }
    }

    /// Takes over what the other cables have to meet.
    pub fn set_conditions(&mut self, twin: &Twin, conditions: &LinearisedStep) {
        let state = conditions.state;
        for (a, j) in others(twin).enumerate() {
            self.stroke_residual[a] = conditions.stroke_residual[j];
            self.lower[a] = conditions.lower[j] - state.tensions[j];
            self.upper[a] = conditions.upper[j] - state.tensions[j];
        }
    }

    /// The best auxiliary strokes, within what is allowed; `None` where held cables pull the same way.
    pub fn solve(&mut self, at: &LinearisedTip, sample: &WeightedSample) -> Option<SampleSolution> {
        self.contact.set_matrix(at.among.as_slice());
        let n_aux = sample.strokes.len();
        let cost = Cost {
            error: DVector::from_column_slice(sample.error),
            strokes: DVector::from_column_slice(sample.strokes),
            gamma: sample.regularisation * at.by_strokes.norm_squared() / n_aux as f64,
        };
        let mut follow = self.follow(at, DVector::zeros(n_aux))?;
        let mut status = QpStatus::Solved;
        for _ in 0..MAX_CONTACTS {
            let response = self.response(at, &follow.active_set)?;
            let answer;
            (answer, status) = self.solve_strokes(response, &cost, sample);
            if status != QpStatus::Solved {
                break;
            }
            let next = self.follow(at, answer)?;
            let is_done = next.active_set == follow.active_set;
            let Some(nearer) = self.nearer(at, &cost, &follow, next) else { break };
            follow = nearer;
            if is_done {
                break;
            }
        }
        let moved = (&cost.strokes + &follow.change)
            .iter()
            .zip(sample.allowed)
            .map(|(s, allowed)| allowed.clamp(*s))
            .collect();
        Some(SampleSolution { strokes: moved, left: cost.error - follow.tip, status })
    }

    /// `next`, or where it has another active set than `now` and costs more, a point on the way there that costs less than
    /// `now`.
    fn nearer(&mut self, at: &LinearisedTip, cost: &Cost, now: &Follow, next: Follow) -> Option<Follow> {
        if next.active_set == now.active_set || cost.of(&next) < cost.of(now) {
            return Some(next);
        }
        let way = &next.change - &now.change;
        let mut part = 0.5;
        while part >= SMALLEST_PART {
            let between = self.follow(at, &now.change + part * &way)?;
            if cost.of(&between) < cost.of(now) {
                return Some(between);
            }
            part *= 0.5;
        }
        None
    }

    /// Strokes of the other cables, and motion of the tip, when the auxiliary strokes change.
    fn follow(&mut self, at: &LinearisedTip, change: DVector<f64>) -> Option<Follow> {
        let pulled = &at.coupling * &change;
        let stroke_residual: Vec<f64> =
            self.stroke_residual.iter().zip(pulled.iter()).map(|(all, made)| all - made).collect();
        let (status, _) =
            self.contact.solve(&stroke_residual, &self.lower, &self.upper, &mut self.increments);
        let increments = DVector::from_column_slice(&self.increments);
        (status == QpStatus::Solved).then(|| Follow {
            active_set: self.contact.active_set().to_vec(),
            tip: &at.by_strokes * &change + &at.by_others * increments,
            change,
        })
    }

    /// The tip while the other cables stay in `active_set`.
    fn response(&self, at: &LinearisedTip, active_set: &[Activity]) -> Option<StrokeResponse> {
        let held: Vec<usize> = (0..active_set.len()).filter(|&a| active_set[a] == Activity::Free).collect();
        let increments = DVector::from_fn(active_set.len(), |a, _| match active_set[a] {
            Activity::Free => 0.0,
            Activity::AtLower => self.lower[a],
            Activity::AtUpper => self.upper[a],
        });
        at.response(&held, &self.stroke_residual, &increments)
    }

    /// Solves the QP of the changes of the auxiliary strokes, over `length`.
    fn solve_strokes(
        &mut self,
        response: StrokeResponse,
        cost: &Cost,
        sample: &WeightedSample,
    ) -> (DVector<f64>, QpStatus) {
        let over = |value: f64| value / sample.length;
        let bounds = sample.allowed.iter().zip(sample.strokes);
        let qp = BoxedRows {
            error: (&cost.error - &response.offset).map(over),
            gain: response.gain,
            gamma: cost.gamma,
            before: cost.strokes.map(over),
            bounds: bounds.map(|(allowed, s)| [over(allowed.min - s), over(allowed.max - s)]).collect(),
        };
        let (answer, status) = qp.solve();
        self.last = Some(qp);
        (sample.length * answer, status)
    }
}

/// Strokes allowed `duration` [s] after they were `before`, within `bounds` and the rate.
pub(crate) fn allowed(auxiliary: &AuxiliaryLimits, before: &[f64], duration: f64) -> Vec<Bounds> {
    let reach = auxiliary.rate * duration;
    let of = |(bounds, &stroke): (&Bounds, &f64)| Bounds {
        min: bounds.clamp(stroke - reach),
        max: bounds.clamp(stroke + reach),
    };
    auxiliary.bounds.iter().zip(before).map(of).collect()
}

/// The active bound of a stroke, if any.
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
