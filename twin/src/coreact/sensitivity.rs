//! Sensitivity of the tip to auxiliary strokes.

use super::AuxiliaryLimits;
use super::problem::others;
use crate::friction_points::FrictionPoints;
use crate::model::Twin;
use crate::step::Stepper;

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
    let adjoints = stepper.tip_adjoints(twin, &held)?;
    let mut shape = twin.cables.shape();
    twin.cables.measure(&stepper.state().positions, &mut shape);
    Some(adjoints.map(|adjoint| {
        let of_stroke = |(k, compliance): (usize, &f64)| {
            twin.cables.row_times(&shape, twin.n_primary + k, &adjoint.of_force) / compliance
        };
        auxiliary.compliances.iter().enumerate().map(of_stroke).collect()
    }))
}
