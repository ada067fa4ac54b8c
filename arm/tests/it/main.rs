//! The arm compared with reference values, complex steps and dual numbers, and what is no arm.

#![allow(clippy::unwrap_used)] // a test may stop where it stands

mod adjoint;
mod allocations;
mod bad_models;
mod balances;
mod batches;
mod damaged;
mod data_sets;
mod derivatives;
mod detection;
mod drawn_mjcf;
mod drawn_robots;
mod excite;
mod export;
mod identify;
mod import;
mod learned;
mod learned_body;
mod measured_servo;
mod mjcf;
mod mjcf_masses;
mod models;
mod motion;
mod numbers;
mod observers;
mod recorded;
mod reference;
mod robot_files;
mod robots;
mod rollouts;
mod xacro;
