//! The verbs of hysteron, one function each: plain options in, an outcome out.
//!
//! [`Caller`] says who runs a verb; its [`Monitor`] hears how far it is and may stop it. An [`outcome::Outcome`] is a struct of
//! every number that is shown, the same that stands in `metrics.json` where a verb writes one. Every verb writes whole files and
//! replaces nothing that it would not itself have made from the same options.
//!
//! ```
//! use hysteron_workflow::{Caller, target};
//!
//! # fn main() -> anyhow::Result<()> {
//! # let folder = tempfile::tempdir()?;
//! let circle = target::Options {
//!     target: "circle:30".to_owned(),
//!     out: folder.path().join("circle.parquet"),
//!     scene: None,
//!     tolerance_mm: 0.1,
//!     figures: None,
//!     png: false,
//! };
//! let result = target::run(&circle, &Caller::silent("my program"))?;
//! println!("a lap is {} m long", result.length_m);
//! assert!(circle.out.exists());
//! # Ok(())
//! # }
//! ```

mod caller;
pub mod command_line;
mod failure;
mod figures;
mod health;
mod inputs;
#[cfg(test)]
mod json_fuzz;
mod learned_dynamics;
mod locking;
mod network;
pub mod number;
pub mod outcome;
pub mod outputs;
mod paper_design;
mod paths;
mod plan;
mod recording_checks;
mod resume;
mod run;

pub mod adapt;
pub mod arm;
pub mod arm_fit;
pub mod arm_identify;
pub mod arm_study;
pub mod check;
pub mod command;
pub mod evaluate;
pub mod fit_material;
pub mod fit_residual;
pub mod generate;
pub mod identify;
pub mod identify_servo;
pub mod import;
pub mod mesh;
pub mod reach;
pub mod record;
pub mod rig;
pub mod robot_file;
pub mod sense;
pub mod simulate;
pub mod study;
pub mod target;
pub mod track;
pub mod train;
pub mod verdict;
pub mod watchdog;

pub use caller::{Caller, Monitor, Progress, Silent};
pub use failure::is_bad_input;
pub use figures::{
    arm as arm_figures, arm_estimation as arm_estimation_figures,
    arm_identification::study as identification_study_figures, arm_neural as arm_neural_figures,
    arm_study as arm_study_figures, excitation as excitation_figures,
};

/// Commit that the program was built from; empty where git does not know.
pub const COMMIT: &str = env!("HYSTERON_COMMIT");
