//! Elements: from node positions to nodal forces, energy and stiffness blocks.
//!
//! Linear and quadratic tetrahedra share one kernel: at every quadrature point the deformation gradient
//! is F = Σ (x_a - x_0) ⊗ ∇N_a, a [`law`] turns F into a stress, and f_a = Σ w P ∇N_a. Eight elements are
//! processed at a time ([`crate::simd`]).

mod batch;
mod kernels;
pub(crate) mod law;
mod shape;
mod tensor;

pub(crate) use batch::{ElementBatch, PairMap, first_inverted};
pub(crate) use kernels::{energy, force_into, stiffness_into};
pub use law::Tangent;
pub(crate) use shape::{shape_derivatives, shape_values};
