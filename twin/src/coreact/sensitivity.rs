//! What auxiliary strokes do to the tip.

use super::Auxiliary;
use super::problem::{Linearised, others};
use crate::TwinState;
use crate::model::Twin;
use crate::step::Stepper;

/// What friction points do when a sensitivity is asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FrictionPoints {
    /// Those that stick go on sticking: the derivative, for changes that make none of them slip.
    AsTheyAre,
    /// All keep their jump: for changes beyond the band of friction.
    Slipping,
}

/// ∂tip/∂s where the last step of `stepper` ended (3 × n_aux, row by row) [-], tendons that are taut held at their strokes;
/// `None` where held cables pull the same way.
pub(crate) fn sensitivity(
    stepper: &mut Stepper,
    twin: &Twin,
    auxiliary: &Auxiliary,
    state: &TwinState,
    friction: FrictionPoints,
) -> Option<[Vec<f64>; 3]> {
    let n_counted = match friction {
        FrictionPoints::AsTheyAre => twin.cables.len(),
        FrictionPoints::Slipping => twin.n_primary,
    };
    let held = |(_, j): &(usize, usize)| *j < n_counted && stepper.is_held(*j, state);
    let held: Vec<usize> = others(twin).enumerate().filter(held).map(|(a, _)| a).collect();
    let projection = stepper.projection(twin, state)?;
    let gain = Linearised::new(twin, auxiliary, projection, state, None).gain(&held)?;
    Some(std::array::from_fn(|c| gain.row(c).iter().copied().collect()))
}
