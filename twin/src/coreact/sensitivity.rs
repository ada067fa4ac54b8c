//! Sensitivity of the tip to auxiliary strokes.

use super::AuxiliaryLimits;
use super::problem::others;
use crate::friction_points::FrictionPoints;
use crate::model::Twin;
use crate::stepper::Stepper;

/// ∂tip/∂s where the last step of `stepper` ended (3 × n_aux, row by row) [-], tendons that are taut held at their
/// strokes, by the exact tangent;
/// `None` where held cables pull the same way.
pub(crate) fn sensitivity(
    stepper: &mut Stepper,
    twin: &Twin,
    auxiliary: &AuxiliaryLimits,
    friction: FrictionPoints,
) -> Option<[Vec<f64>; 3]> {
    let n_counted = match friction {
        FrictionPoints::AsTheyAre => twin.cables.len(),
        FrictionPoints::Slipping => twin.n_primary,
    };
    let held: Vec<usize> = others(twin).filter(|&j| j < n_counted && stepper.is_held(j)).collect();
    let derivatives = stepper.tip_derivatives(twin, &held)?;
    Some(derivatives.per_tension.map(|row| {
        let of_auxiliary = row[twin.n_primary..].iter().zip(&auxiliary.compliances);
        of_auxiliary.map(|(per_tension, compliance)| per_tension / compliance).collect()
    }))
}
