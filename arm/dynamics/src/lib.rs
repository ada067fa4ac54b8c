//! Rigid-body dynamics of robot arms, its derivatives, and differentiable simulation.
//!
//! A [`Model`] never changes; a [`Data`] next to it is scratch, allocated once. Every algorithm is written
//! once over
//! [`Scalar`]. All spatial quantities are taken about the origin of the base and in its axes, so that contributions of
//! bodies add without transforms. The equations are in `docs/arm.md`.
//!
//! ```
//! use hysteron_arm_dynamics::{Data, Model, forward_dynamics, gravity_torque};
//!
//! let panda = Model::builtin("panda")?;
//! let n = panda.n_joints();
//! let (q, still) = (vec![0.3; n], vec![0.0; n]);
//! let (mut data, mut torque, mut acceleration) = (Data::new(&panda, 0.0), vec![0.0; n], vec![0.0_f64; n]);
//! gravity_torque(&panda, &mut data, &q, &mut torque);
//! // Held against its weight, it stays where it is.
//! forward_dynamics(&panda, &mut data, [&q, &still, &torque], &[], &mut acceleration);
//! assert!(acceleration.iter().all(|a| a.abs() < 1e-9));
//! # Ok::<(), hysteron_base::BadInput>(())
//! ```

// Units are in brackets in the comments, [m] and [N], which rustdoc takes for links.
#![allow(rustdoc::broken_intra_doc_links)]

mod aba;
mod adjoint;
mod batch;
mod box_qp;
mod coriolis;
mod crba;
mod data;
pub mod dense;
mod derivatives;
mod energy;
mod external;
mod followers;
mod friction_step;
pub mod kernels;
mod kinematics;
mod lanes;
mod model;
mod momentum;
mod regressor;
mod rnea;
mod rollouts;
mod scalar;
mod simulator;
pub mod spatial;
mod step_gradient;
mod stepper;

pub use aba::{forward_dynamics, solve_mass};
pub use adjoint::{Cotangent, forward_dynamics_adjoint, parameter_adjoint};
pub use batch::{Batch, StateKernel};
pub use coriolis::coriolis_matrix;
pub use crba::mass_matrix;
pub use data::Data;
pub use derivatives::{forward_dynamics_derivatives, inverse_dynamics_derivatives};
pub use energy::{kinetic_energy, momentum, potential_energy};
pub use external::ExternalForce;
pub use friction_step::EndStops;
pub use kinematics::{forward_kinematics, frame_jacobian, frame_pose, skeleton};
pub use model::{
    Arguments, Base, Follower, Frame, FreeJoint, Joint, JointKind, JointLimits, MAX_JOINTS, Masses, Model,
    Notes, ReadOptions, Weightless,
};
pub use momentum::generalized_momentum;
pub use regressor::regressor;
pub use rnea::{bias_torque, coriolis_torque, gravity_torque, inverse_dynamics};
pub use rollouts::{ArmRollouts, RolloutGradient, RolloutInputs};
pub use scalar::Scalar;
pub use simulator::Simulator;
pub use step_gradient::StepGradient;
pub use stepper::{ArmStepper, Integrator};
