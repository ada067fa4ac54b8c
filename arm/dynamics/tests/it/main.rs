//! Rigid-body dynamics compared with reference values, complex steps and dual numbers, and what is no arm.

#![allow(clippy::unwrap_used)] // a test may stop where it stands

mod adjoint;
mod allocations;
mod bad_models;
mod balances;
mod batches;
mod derivatives;
mod drawn_mjcf;
mod drawn_robots;
mod export;
mod mjcf;
mod mjcf_masses;
mod models;
mod motion;
mod reference;
mod robot_files;
mod rollouts;
mod xacro;
