//! Identified model of an arm, as estimators take it.

use hysteron_actuator::law::{Law, PiecewiseLinear};

use hysteron_arm_dynamics::Model;
use hysteron_arm_estimation::identify::{BodyFit, JointTerm};
use hysteron_arm_estimation::observer::{FrictionModel, LowSpeed};

/// The terms of a joint that are identified next to its body.
pub const TERMS: [JointTerm; 4] =
    [JointTerm::Armature, JointTerm::Coulomb, JointTerm::Viscous, JointTerm::Offset];

/// Bodies and friction of an arm.
#[derive(Debug, Clone)]
pub struct KnownArm {
    /// With its bodies and armature.
    pub model: Model,
    /// Friction, with each direction's own size.
    pub friction: FrictionModel,
    /// Root mean square of what the identification left, joint by joint [N m].
    pub rms: Vec<f64>,
}

impl KnownArm {
    /// From an identification with [`TERMS`]: the offset of a torque counts as friction that differs by direction. Below `width`
    /// [rad/s] friction is a line through zero.
    pub fn of(fit: &BodyFit, width: f64) -> Self {
        let n = fit.model.n_joints();
        let value = |name: String| {
            fit.estimates.iter().find(|estimate| estimate.name == name).map_or(0.0, |estimate| estimate.value)
        };
        // A line over speed beyond the width: two knots, held beyond the second, which no joint reaches.
        let knots = [width, FASTEST];
        let laws = (0..n).map(|j| {
            let [coulomb, viscous, offset] =
                [JointTerm::Coulomb, JointTerm::Viscous, JointTerm::Offset].map(|term| value(term.name(j)));
            let side = |sign: f64| knots.map(|v| (coulomb + viscous * v + sign * offset).max(0.0));
            (
                Law::PiecewiseLinear(PiecewiseLinear { knots: knots.to_vec() }),
                [side(1.0), side(-1.0)].concat(),
            )
        });
        Self {
            friction: FrictionModel::new(laws.collect(), LowSpeed::Linear(width)),
            model: fit.model.clone(),
            rms: fit.rms.clone(),
        }
    }
}

/// Speed that no joint exceeds [rad/s].
const FASTEST: f64 = 20.0;
