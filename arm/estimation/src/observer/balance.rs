//! Estimates without accelerations: the torque of the motor, and what gravity and friction explain of it.

use hysteron_actuator::law::Sliding;

use super::{ArmSample, Dynamics, FrictionModel, Observer};

/// Terms subtracted from the torque of the motor.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Terms {
    /// Nothing: τ_ext = −τ_m. Row I of Saadatzi et al. (2019), table 4.
    Torque,
    /// Gravity: τ_ext = g − τ_m. Row G.
    Gravity,
    /// Gravity and friction: τ_ext = g + τ_f − τ_m. Row G+Fri.
    GravityAndFriction,
}

/// Static balance of torques, without memory.
#[derive(Debug, Clone)]
pub struct StaticResidual<D> {
    dynamics: D,
    friction: FrictionModel,
    terms: Terms,
}

impl<D: Dynamics> StaticResidual<D> {
    /// `friction` counts if `terms` includes it.
    pub fn new(dynamics: D, friction: FrictionModel, terms: Terms) -> Self {
        assert_eq!(dynamics.n_joints(), friction.n_joints());
        Self { dynamics, friction, terms }
    }
}

impl<D: Dynamics> Observer for StaticResidual<D> {
    fn update(&mut self, sample: &ArmSample, external: &mut [f64]) {
        external.fill(0.0);
        if self.terms != Terms::Torque {
            self.dynamics.gravity(sample.position, external);
        }
        for (joint, external) in external.iter_mut().enumerate() {
            let motor = sample.torque[joint];
            let required = motor - *external;
            if self.terms == Terms::GravityAndFriction {
                let at = Sliding {
                    velocity: sample.velocity[joint],
                    motor_torque: motor,
                    load_torque: -*external,
                };
                *external += self.friction.follow(joint, &at, [required; 2]);
            }
            *external -= motor;
        }
    }

    fn reset(&mut self) {
        self.friction.reset();
    }
}
