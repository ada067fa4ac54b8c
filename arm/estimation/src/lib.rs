//! Estimation on robot arms: excitation, identification of bodies, observers of external torque and force, detection of
//! contact, and recordings of arms in one form.
//!
//! Models and their algorithms are those of [`hysteron_arm_dynamics`]; the equations are in `docs/observers.md` and
//! `docs/actuator.md`.

// Units are in brackets in the comments, [m] and [N], which rustdoc takes for links.
#![allow(rustdoc::broken_intra_doc_links)]

mod computed_torque;
pub mod detection;
mod excite;
pub mod identify;
mod import;
mod joint_series;
pub mod observer;
mod recorded;
pub mod servo_force;

pub use computed_torque::ComputedTorque;
pub use excite::{
    Excitation, ExcitationOptions, Fourier, Information, LimitOptions, Motion, MotionLaw, MotionLimits,
    PointToPoint, exciting_trajectory, states_of,
};
pub use import::{
    ArmImport, ArmProperties, BadRows, CURRENTS_BY, ColumnMap, ImportOptions, POSITION_GAIN, UnitCheck,
    import, position_gain, with_arm,
};
pub use joint_series::{ArmRecording, ForceSeries, RecordedJoint};
pub use recorded::{
    DynamicsOutput, JointQuantityKind, channel_name, columns_of_dynamics, dynamics_of_rows, joint_rows,
    motion_under_torques,
};
