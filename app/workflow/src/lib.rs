//! The verbs of hysteron, one function each: plain options in, an outcome out.
//!
//! [`Context`] belongs to the caller of a verb; its [`ProgressSink`] receives progress and may cancel it. An [`outcome::Outcome`] is a struct of
//! every number that is shown, the same as in `metrics.json` where a verb writes one. Every verb writes whole files and
//! replaces nothing that it would not itself have made from the same options.
//!
//! ```
//! use hysteron_workflow::{Context, tendon::target};
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
//! let result = target::run(&circle, &Context::silent("my program"))?;
//! println!("a lap is {} m long", result.length_m);
//! assert!(circle.out.exists());
//! # Ok(())
//! # }
//! ```

pub mod arm;
pub mod import;
pub mod rig;
pub mod shared;
pub mod tendon;

pub use shared::context::{Context, Progress, ProgressSink, Silent};
pub use shared::error::{Cancelled, WorkflowError, is_bad_input};

/// Commit that the program was built from; empty where git does not know.
pub const COMMIT: &str = env!("HYSTERON_COMMIT");
