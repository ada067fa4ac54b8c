//! Compensatory residual actuation (CoReAct, CoReAct paper section IV-B): auxiliary tendons that bring the twin's
//! tip to where the robot's tip was measured.
//!
//! The paper enforces the strokes of all auxiliary tendons as equalities. Held at zero they would clamp the body:
//! S(u, 0) would not be the uncorrected twin of its eq. 5. So a stroke s_j is here the one that the tendon's
//! tension alone makes on the straight body, T_j = s_j / c_j: zero does nothing, and the bounds on stroke, rate
//! and tension (eqs. 15-17) are all boxes of one variable.

mod auxiliary;
mod identify;
mod problem;
mod sensitivity;
mod summary;

pub use auxiliary::AuxiliaryLimits;
pub(crate) use identify::distance;
pub use identify::{
    AuxiliaryIdentification, AuxiliaryPolicy, IdentifiedSample, Identifier, IdentifyOptions, TipMeasurement,
    identify,
};
pub use problem::Bound;
pub(crate) use problem::allowed as allowed_strokes;
pub(crate) use sensitivity::sensitivity;
pub use summary::{DistanceSummary, IdentificationSummary};
