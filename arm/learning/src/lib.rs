//! Dynamics of robot arms learned from recordings: Lagrangian networks, neural actuators, the simple models that they
//! have to beat, and public data sets.
//!
//! The equations are in `docs/lagrangian.md` and `docs/neural-actuator.md`.

// Units are in brackets in the comments, [m] and [N], which rustdoc takes for links.
#![allow(rustdoc::broken_intra_doc_links)]

pub mod baselines;
pub mod datasets;
pub mod lagrangian;
pub mod neural;
