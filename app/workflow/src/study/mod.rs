//! A study: the whole chain from a recording to a tracked path, stage by stage.
//!
//! A stage is this program, started again with the arguments that a person would type. What it was made from stands
//! in its stamp, so that a stage is done once, and again only when something that it reads has changed.

mod convert;
mod definition;
#[cfg(test)]
mod fuzz;
mod method;
mod schema;
mod stage;
mod stages;
mod stamp;

use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::Context;
use crate::figures;
pub use definition::{PlanChoice, Rig, SceneChoice, Study, Target, Track};
pub use method::Method;
pub use stage::{OnRefusal, Stage, Step};
pub use stages::{DATA, PREDICTED, STROKES, folder, repeat};
pub use stamp::{StageStatus, Stamp, clear_outputs};

/// Carry out a study: record, calibrate, identify, learn, track, evaluate; ends in one report
#[derive(Debug, Clone)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct Options {
    /// Study file, .toml
    pub study: PathBuf,
    /// Folder to write to [default: out/NAME]
    #[cfg_attr(feature = "clap", arg(long, value_name = "DIR"))]
    pub out: Option<PathBuf>,
}

/// Reads and checks a study and all that it names, and carries it out: `carry_out` is given the folder, the study
/// and its stages, and brings these to their end. Then writes the report.
///
/// # Errors
/// `BadInput` naming what is wrong, and whatever comes of `carry_out`.
pub fn run(
    options: &Options,
    carry_out: impl FnOnce(&Path, &Study, &[Stage]) -> anyhow::Result<()>,
    context: &Context,
) -> anyhow::Result<Value> {
    let study = Study::read(&options.study)?;
    let out = options.out.clone().unwrap_or_else(|| Path::new("out").join(&study.name));
    let stages = stages::stages(&study, &out);
    carry_out(&out, &study, &stages)?;
    let value = figures::study::write(&out, &study, &stages, context)?;
    context.reported(&out);
    Ok(value)
}
