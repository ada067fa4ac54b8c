//! Friction with memory along the tendons, and backlash before them.
//!
//! Where friction acts on a tendon, its tension jumps by q, at most a bound b. Such a point is one more cable: the tendon's rest
//! from there to its end, whose tension is the jump, whose stroke is how much of the tendon has slid past the point,
//! and whose commanded stroke is its memory. Like every tendon it is a stroke penalty: between its bounds the
//! point sticks and the slide stays, at a bound it slips, and after the step the memory moves to where the
//! tendon has slid. The bounds are those of the equilibrium before: in every step the friction is known, and
//! the QP stays symmetric.
//!
//! # Reference
//! Euler (1762), Remarques sur l'effet du frottement dans l'equilibre (capstan equation).

use hysteron_actuator::Play;

use crate::cable::{CableShape, Cables};
use crate::equilibrium_residual::StepTargets;
use crate::model::{Target, Twin};

/// Writes the largest jump at every friction point [N] for the shape and the tensions of an equilibrium.
pub(crate) fn bounds_into(twin: &Twin, shape: &CableShape, tensions: &[f64], bounds: &mut [f64]) {
    let (of_tendons, jumps) = tensions.split_at(twin.tendons.len());
    let mut before = 0.0;
    for (i, point) in twin.friction.iter().enumerate() {
        if i == 0 || twin.friction[i - 1].tendon != point.tendon {
            before = of_tendons[point.tendon];
        }
        let after = before + jumps[i];
        let wrap_angle = twin.cables.wrap_angle(shape, point.tendon, point.points.clone());
        bounds[i] = point.bound(wrap_angle, before, after);
        before = after;
    }
}

/// Lets the friction points stick at their slip within `bounds` [N].
pub(crate) fn stick(twin: &Twin, slip: &[f64], bounds: &[f64], control: &mut StepTargets) {
    let first = twin.tendons.len();
    for (i, (value, bound)) in slip.iter().zip(bounds).enumerate() {
        control.strokes[first + i] = *value;
        control.lower[first + i] = -bound;
        control.upper[first + i] = *bound;
    }
}

/// Largest change from the bounds that `control` has to `bounds`, over the largest of these [-].
pub(crate) fn change_of_bounds(twin: &Twin, bounds: &[f64], control: &StepTargets) -> f64 {
    let held = &control.upper[twin.tendons.len()..];
    let largest = bounds.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
    bounds.iter().zip(held).map(|(now, then)| (now - then).abs()).fold(0.0, f64::max) / largest
}

/// Commits the slip of all points that do under `control` to where their tendons have slid in `shape`: `slip`, one number for
/// each of the last `cables`.
pub(crate) fn commit_slip(
    cables: &Cables,
    control: &StepTargets,
    shape: &CableShape,
    tensions: &[f64],
    slip: &mut [f64],
) {
    let first = cables.len() - slip.len();
    for (i, slip) in slip.iter_mut().enumerate() {
        let (row, jump) = (first + i, tensions[first + i]);
        if jump == control.lower[row] || jump == control.upper[row] {
            *slip = cables.pulled(shape, row, tensions);
        }
    }
}

/// Moves the plays of stroke-driven tendons to their targets, and commands what comes through.
pub(crate) fn follow_backlash(
    twin: &Twin,
    targets: &[Target],
    backlash: &mut [f64],
    control: &mut StepTargets,
) {
    for (j, output) in backlash.iter_mut().enumerate() {
        if let Target::Stroke(stroke) = targets[j] {
            *output = Play { width: twin.backlash, output: *output }.follow(stroke);
            control.strokes[j] = *output + twin.tendons[j].zero;
        }
    }
}
