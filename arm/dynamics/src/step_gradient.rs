//! The gradient of a step by everything but the state.

use crate::adjoint::parameter_adjoint;
use crate::{Cotangent, Data, Model, Scalar};

/// Gradients that [`crate::ArmStepper::step_back`] returns in addition to that by the state.
#[derive(Debug, Clone)]
pub struct StepGradient<T> {
    /// By the torques of this step.
    pub tau: Vec<T>,
    /// By force and torque of the external forces of this step.
    pub external: Vec<[[T; 3]; 2]>,
    /// By the inertial parameters; every step adds to it.
    pub inertias: Vec<[T; 10]>,
    /// By the armatures; every step adds to it.
    pub armature: Vec<T>,
    /// By the damping; every step adds to it.
    pub damping: Vec<T>,
    /// By the dry friction; every step adds to it.
    pub dry_friction: Vec<T>,
    /// By the dry friction per torque through the gear; every step adds to it.
    pub load_friction: Vec<T>,
}

impl<T: Scalar> StepGradient<T> {
    /// Zeros for `model` with `n_external` external forces, of numbers like `like`.
    pub fn new(model: &Model, n_external: usize, like: T) -> Self {
        let Cotangent { tau, inertias, armature, external, .. } = Cotangent::new(model, n_external, like);
        let [damping, dry_friction, load_friction] = [(); 3].map(|()| tau.clone());
        Self { damping, dry_friction, load_friction, tau, external, inertias, armature }
    }

    /// Adds what a substep gives, with `acceleration` and the scratch of its adjoint.
    #[inline(always)]
    pub(crate) fn add(&mut self, data: &Data<T>, acceleration: &[T], cotangent: &mut Cotangent<T>) {
        for (sum, part) in self.tau.iter_mut().zip(&cotangent.tau) {
            *sum = *sum + *part;
        }
        self.add_parameters(data, acceleration, cotangent);
    }

    /// [`Self::add`] without the torques.
    #[inline(always)]
    pub(crate) fn add_parameters(
        &mut self,
        data: &Data<T>,
        acceleration: &[T],
        cotangent: &mut Cotangent<T>,
    ) {
        parameter_adjoint(data, acceleration, cotangent);
        let Cotangent { inertias, armature, external, .. } = cotangent;
        for (sum, part) in self.armature.iter_mut().zip(armature) {
            *sum = *sum + *part;
        }
        let bodies = self.inertias.iter_mut().flatten().zip(inertias.iter().flatten());
        let forces = self.external.iter_mut().flatten().flatten().zip(external.iter().flatten().flatten());
        for (sum, part) in bodies.chain(forces) {
            *sum = *sum + *part;
        }
    }
}
