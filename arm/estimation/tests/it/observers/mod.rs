//! Observers of external torques compared with closed forms.

mod closed_forms;
mod friction;
mod motion;
mod streaming;
mod tip_force;
