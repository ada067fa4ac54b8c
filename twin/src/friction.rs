//! Friction with memory along the tendons, and backlash before them.
//!
//! Where friction acts on a tendon, its tension jumps by q, at most a bound b. Such a point is one more cable: the tendon's rest
//! from there to its end, whose tension is the jump, whose stroke is how much of the tendon has slid past the point,
//! and whose commanded stroke is its memory. So it is the clutch that every tendon is: between its bounds the point
//! sticks and the slide stays, at a bound it slips, and after the step the memory moves to where the tendon has slid.
//! The bounds are those of the equilibrium before: in every step the friction is known, and the QP stays symmetric.
//!
//! # Reference
//! Euler (1762), Remarques sur l'effet du frottement dans l'equilibre (capstan equation).

use std::ops::Range;

use hysteron_actuator::{Play, capstan_bound};
use hysteron_base::{Friction, Tendon};

use crate::TwinState;
use crate::balance::Control;
use crate::cable::{CableShape, Cables};
use crate::model::{Target, Twin};

/// A point at which friction acts on a tendon. Its cable follows those of all tendons, in the order of the points.
#[derive(Debug, Clone, PartialEq)]
pub struct FrictionPoint {
    /// The tendon.
    pub tendon: usize,
    /// Point of the tendon at which the tension jumps; zero for the sheath before the body.
    pub first: usize,
    /// Points of the tendon whose turns count here.
    pub turns: Range<usize>,
    /// Turn besides, whatever the shape [rad].
    pub wrap: f64,
    /// Coefficient of friction μ [-].
    pub coefficient: f64,
    /// Friction without tension [N].
    pub constant: f64,
}

impl FrictionPoint {
    /// Largest jump where the tendon has the tensions `before` and `after`, capstan and constant [N].
    fn bound(&self, turn: f64, before: f64, after: f64) -> f64 {
        capstan_bound(self.coefficient, turn + self.wrap, self.constant, before.max(0.0), after.max(0.0))
    }
}

/// The friction points of `tendons`, tendon by tendon, from the pulled end to the tip: one for the sheath, whose
/// exponent stands as a coefficient for a turn of one; then the inner points of the tendon, shared evenly among at most
/// `friction.points`, each at the middle of its share.
pub(crate) fn friction_points(tendons: &[Tendon], friction: &Friction) -> Vec<FrictionPoint> {
    let mut points = Vec::new();
    for (tendon, spec) in tendons.iter().enumerate() {
        if friction.sheath_exponent > 0.0 || friction.sheath_coulomb > 0.0 {
            points.push(FrictionPoint {
                tendon,
                first: 0,
                turns: 0..0,
                wrap: 1.0,
                coefficient: friction.sheath_exponent,
                constant: friction.sheath_coulomb,
            });
        }
        let n_inner = spec.points.len() - 2;
        let n_points = friction.points.min(n_inner);
        for k in 0..n_points {
            let turns = 1 + k * n_inner / n_points..1 + (k + 1) * n_inner / n_points;
            points.push(FrictionPoint {
                tendon,
                first: (turns.start + turns.end) / 2,
                turns,
                wrap: 0.0,
                coefficient: friction.coefficient,
                constant: friction.coulomb / n_points as f64,
            });
        }
    }
    points
}

/// Writes C for tendons that stretch: `sheath_share` of a tendon's compliance lies before the sheath's point, the rest
/// evenly along its way through the body. Cables of the same tendon stretch together where both pull.
pub(crate) fn set_compliance(
    cables: &mut Cables,
    tendons: &[Tendon],
    points: &[FrictionPoint],
    sheath_share: f64,
) {
    for (j, tendon) in tendons.iter().enumerate().filter(|(_, tendon)| tendon.compliance > 0.0) {
        // Of each cable of this tendon, the compliance of all that it pulls.
        let mut pulled = vec![(j, tendon.compliance)];
        for (i, _) in points.iter().enumerate().filter(|(_, point)| point.tendon == j) {
            let row = tendons.len() + i;
            let share = (1.0 - sheath_share) * cables.rest_lengths[row] / cables.rest_lengths[j];
            pulled.push((row, share * tendon.compliance));
        }
        for &(row, own) in &pulled {
            cables.compliance[row] = pulled.iter().map(|&(other, also)| (other, own.min(also))).collect();
        }
    }
}

/// Writes the largest jump at every friction point [N] for the shape and the tensions of an equilibrium.
pub(crate) fn bounds_into(twin: &Twin, shape: &CableShape, tensions: &[f64], bounds: &mut [f64]) {
    let (of_tendons, jumps) = tensions.split_at(twin.tendons.len());
    let mut before = 0.0;
    for (i, point) in twin.friction.iter().enumerate() {
        if i == 0 || twin.friction[i - 1].tendon != point.tendon {
            before = of_tendons[point.tendon];
        }
        let after = before + jumps[i];
        let turn = twin.cables.turn(shape, point.tendon, point.turns.clone());
        bounds[i] = point.bound(turn, before, after);
        before = after;
    }
}

/// Lets the friction points stick at their slip within `bounds` [N].
pub(crate) fn stick(twin: &Twin, slip: &[f64], bounds: &[f64], control: &mut Control) {
    let first = twin.tendons.len();
    for (i, (slide, bound)) in slip.iter().zip(bounds).enumerate() {
        control.strokes[first + i] = *slide;
        control.lowest[first + i] = -bound;
        control.highest[first + i] = *bound;
    }
}

/// Largest change from the bounds that `control` has to `bounds`, over the largest of these [-].
pub(crate) fn change_of_bounds(twin: &Twin, bounds: &[f64], control: &Control) -> f64 {
    let held = &control.highest[twin.tendons.len()..];
    let largest = bounds.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
    bounds.iter().zip(held).map(|(now, then)| (now - then).abs()).fold(0.0, f64::max) / largest
}

/// Commits the slip of all points that do under `control` to where their tendons have slid in `shape`.
pub(crate) fn commit_slip(twin: &Twin, control: &Control, shape: &CableShape, state: &mut TwinState) {
    let first = twin.tendons.len();
    for i in 0..state.slip.len() {
        let (row, jump) = (first + i, state.tensions[first + i]);
        if jump == control.lowest[row] || jump == control.highest[row] {
            state.slip[i] = shape.strokes[row] + twin.cables.stretch(row, &state.tensions);
        }
    }
}

/// Moves the plays of stroke-driven tendons to their targets, and commands what comes through.
pub(crate) fn follow_backlash(twin: &Twin, targets: &[Target], plays: &mut [f64], control: &mut Control) {
    for (j, output) in plays.iter_mut().enumerate() {
        if let Target::Stroke(stroke) = targets[j] {
            *output = Play { width: twin.backlash, output: *output }.follow(stroke);
            control.strokes[j] = *output + twin.tendons[j].zero;
        }
    }
}
