//! The algorithms as kernels of a [`crate::Batch`].

use crate::batch::StateKernel;
use crate::{
    Data, Model, Scalar, forward_dynamics, forward_dynamics_derivatives, inverse_dynamics, mass_matrix,
};

/// (q, q̇, q̈) to τ.
#[derive(Debug, Clone, Copy)]
pub struct InverseDynamicsKernel;

/// (q, q̇, τ) to q̈.
#[derive(Debug, Clone, Copy)]
pub struct ForwardDynamics;

/// q to M (n × n, row by row).
#[derive(Debug, Clone, Copy)]
pub struct MassMatrix;

/// (q, q̇, τ) to q̈, ∂q̈/∂q, ∂q̈/∂q̇ and M⁻¹ (n × n, row by row).
#[derive(Debug, Clone, Copy)]
pub struct ForwardDerivatives;

impl StateKernel for InverseDynamicsKernel {
    #[inline(always)]
    fn run<T: Scalar>(&self, model: &Model, data: &mut Data<T>, inputs: &[&[T]], outputs: &mut [&mut [T]]) {
        inverse_dynamics(model, data, [inputs[0], inputs[1], inputs[2]], &[], outputs[0]);
    }
}

impl StateKernel for ForwardDynamics {
    #[inline(always)]
    fn run<T: Scalar>(&self, model: &Model, data: &mut Data<T>, inputs: &[&[T]], outputs: &mut [&mut [T]]) {
        forward_dynamics(model, data, [inputs[0], inputs[1], inputs[2]], &[], outputs[0]);
    }
}

impl StateKernel for MassMatrix {
    fn inputs(&self, model: &Model) -> Vec<usize> {
        vec![model.n_joints()]
    }

    fn outputs(&self, model: &Model) -> Vec<usize> {
        vec![model.n_joints() * model.n_joints()]
    }

    #[inline(always)]
    fn run<T: Scalar>(&self, model: &Model, data: &mut Data<T>, inputs: &[&[T]], outputs: &mut [&mut [T]]) {
        mass_matrix(model, data, inputs[0], outputs[0]);
    }
}

impl StateKernel for ForwardDerivatives {
    fn outputs(&self, model: &Model) -> Vec<usize> {
        let n = model.n_joints();
        vec![n, n * n, n * n, n * n]
    }

    #[inline(always)]
    fn run<T: Scalar>(&self, model: &Model, data: &mut Data<T>, inputs: &[&[T]], outputs: &mut [&mut [T]]) {
        let [ddq, by_q, by_dq, by_tau] = outputs else { unreachable!("four outputs") };
        let at = [inputs[0], inputs[1], inputs[2]];
        forward_dynamics_derivatives(model, data, at, &[], ddq, [by_q, by_dq, by_tau]);
    }
}
