//! `hysteron rig`: everything that concerns servos and tracker, real or emulated.

pub mod calibrate;
pub mod check;
pub mod emulate;
pub mod recover;
