//! Rigid-body dynamics of robot arms, its derivatives, and differentiable simulation.
//!
//! A [`Model`] never changes; a [`Data`] next to it is scratch, allocated once. Every algorithm is written
//! once over
//! [`Scalar`]. All spatial quantities are taken about the origin of the base and in its axes, so that contributions of
//! bodies add without transforms. The equations stand in `docs/arm.md`.
//!
//! ```
//! use hysteron_arm::{Data, Model, forward_dynamics, gravity_torque};
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

// Units stand in brackets in the comments, [m] and [N], which rustdoc takes for links.
#![allow(rustdoc::broken_intra_doc_links)]

// What tests share with another crate names this one as that does.
#[cfg(test)]
extern crate self as hysteron_arm;

mod aba;
mod adjoint;
pub mod baselines;
mod batch;
mod box_qp;
mod computed_torque;
mod coriolis;
mod crba;
mod data;
pub mod datasets;
mod dense;
mod derivatives;
pub mod detection;
mod energy;
mod excite;
mod external;
mod followers;
mod friction_step;
pub mod identify;
mod import;
mod joint_series;
pub mod kernels;
mod kinematics;
pub mod lagrangian;
mod lanes;
mod model;
mod momentum;
pub mod neural;
pub mod observer;
mod recorded;
mod regressor;
mod rnea;
mod rollouts;
mod scalar;
pub mod servo_force;
mod simulator;
pub mod spatial;
mod step_gradient;
mod stepper;

pub use aba::{forward_dynamics, solve_mass};
pub use adjoint::{Cotangent, forward_dynamics_adjoint, parameter_adjoint};
pub use batch::{Batch, Kernel};
pub use computed_torque::ComputedTorque;
pub use coriolis::coriolis_matrix;
pub use crba::mass_matrix;
pub use data::Data;
pub use derivatives::{forward_dynamics_derivatives, inverse_dynamics_derivatives};
pub use energy::{centre_of_mass, kinetic_energy, momentum, potential_energy};
pub use excite::{
    Excitation, ExcitationOptions, Fourier, Information, Law, LimitOptions, Motion, MotionLimits,
    PointToPoint, exciting_trajectory, states_of,
};
pub use external::ExternalForce;
pub use friction_step::Stops;
pub use import::{
    ArmKnown, BadRows, CURRENTS_BY, ColumnMap, ImportOptions, Imported, POSITION_GAIN, UnitCheck, import,
    with_arm,
};
pub use joint_series::{ForceSeries, JointSeries, Recorded};
pub use kinematics::{
    forward_kinematics, forward_velocities, frame_jacobian, frame_jacobian_rate, frame_pose, frame_velocity,
    skeleton,
};
pub use model::{
    Arguments, Base, Drive, Follower, Frame, FreeJoint, Joint, JointKind, MAX_JOINTS, Masses, Model, Notes,
    ReadOptions, Weightless,
};
pub use momentum::generalized_momentum;
pub use recorded::{
    Quantity, Wanted, channel_name, columns_of_dynamics, dynamics_of_rows, joint_rows, motion_under_torques,
};
pub use regressor::regressor;
pub use rnea::{bias_torque, coriolis_torque, gravity_torque, inverse_dynamics};
pub use rollouts::{RolloutGradient, RolloutInputs, Rollouts};
pub use scalar::Scalar;
pub use simulator::Simulator;
pub use step_gradient::StepGradient;
pub use stepper::{Integrator, Stepper};
