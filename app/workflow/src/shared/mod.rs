//! Rooms that several verbs use.

pub mod body;
pub mod command_line;
pub(crate) mod context;
pub mod error;
pub(crate) mod health;
pub(crate) mod identification;
pub(crate) mod identification_page;
pub mod inputs;
#[cfg(test)]
mod json_fuzz;
pub(crate) mod locking;
pub(crate) mod memory;
pub(crate) mod network;
pub mod number;
pub(crate) mod object_store;
pub mod outcome;
pub mod outputs;
pub(crate) mod paper_design;
pub mod paths;
pub mod plan;
pub(crate) mod recording_checks;
pub(crate) mod resume;
pub mod robot_file;
pub(crate) mod run;
pub(crate) mod shapes;
pub(crate) mod training;
pub mod verdict;
pub mod watchdog;
