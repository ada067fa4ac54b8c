//! Where friction acts on the tendons, what it does while the body moves a little, and how much each part of a tendon stretches.

use std::ops::Range;

use hysteron_actuator::capstan_bound;
use hysteron_base::{Friction, Tendon};

use crate::cable::Cables;

/// A point at which friction acts on a tendon. Its cable follows those of all tendons, in the order of the points.
#[derive(Debug, Clone, PartialEq)]
pub struct FrictionPoint {
    /// The tendon.
    pub tendon: usize,
    /// Point of the tendon at which the tension jumps; zero for the sheath before the body.
    pub first: usize,
    /// Points of the tendon whose wrap angles count here.
    pub points: Range<usize>,
    /// Additional wrap angle, independent of the shape [rad].
    pub wrap_angle: f64,
    /// Coefficient of friction μ [-].
    pub coefficient: f64,
    /// Friction without tension [N].
    pub constant: f64,
}

/// Behaviour of friction points in a sensitivity.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FrictionPoints {
    /// Those that stick continue to stick: the derivative, for changes that make none of them slip.
    AsTheyAre,
    /// All keep their jump: for changes beyond the band of friction.
    Slipping,
}

impl FrictionPoint {
    /// Largest jump where the tendon has the tensions `before` and `after`, capstan and constant [N].
    pub(crate) fn bound(&self, wrap_angle: f64, before: f64, after: f64) -> f64 {
        capstan_bound(
            self.coefficient,
            wrap_angle + self.wrap_angle,
            self.constant,
            before.max(0.0),
            after.max(0.0),
        )
    }
}

/// The friction points of `tendons`, tendon by tendon, from the pulled end to the tip: one for the sheath, whose
/// exponent is a coefficient for a wrap angle of one; then the inner points of the tendon, shared evenly among at most
/// `friction.points`, each at the middle of its share.
pub(crate) fn friction_points(tendons: &[Tendon], friction: &Friction) -> Vec<FrictionPoint> {
    let mut points = Vec::new();
    for (tendon, spec) in tendons.iter().enumerate() {
        if friction.sheath_exponent > 0.0 || friction.sheath_coulomb > 0.0 {
            points.push(FrictionPoint {
                tendon,
                first: 0,
                points: 0..0,
                wrap_angle: 1.0,
                coefficient: friction.sheath_exponent,
                constant: friction.sheath_coulomb,
            });
        }
        let n_inner = spec.points.len() - 2;
        let n_points = friction.points.min(n_inner);
        for k in 0..n_points {
            let inner = 1 + k * n_inner / n_points..1 + (k + 1) * n_inner / n_points;
            points.push(FrictionPoint {
                tendon,
                first: (inner.start + inner.end) / 2,
                points: inner,
                wrap_angle: 0.0,
                coefficient: friction.coefficient,
                constant: friction.coulomb / n_points as f64,
            });
        }
    }
    points
}

/// Writes C for tendons that stretch: the sheath's share of a tendon's compliance lies before the sheath's point, the rest
/// evenly along its way through the body. Cables of the same tendon stretch together where both pull.
pub(crate) fn set_compliance(
    cables: &mut Cables,
    tendons: &[Tendon],
    points: &[FrictionPoint],
    friction: Option<&Friction>,
) {
    let sheath_share = friction.map_or(0.0, |friction| friction.sheath_compliance_share);
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
