//! The run of `study run`.

use std::path::Path;

use hysteron_workflow::{Context, WorkflowError};

use super::definition::Study;
use super::options::Options;
use super::outcome::Outcome;
use super::stage::Stage;
use super::stages::stages;
use super::{outcome, page};

/// Reads and checks a study and all that it names, and runs it: `run_stages` is given the folder, the study
/// and its stages, and brings these to their end. Then writes the report.
///
/// # Errors
/// `BadInput` for an invalid study, and errors of the stages.
pub fn run(
    options: &Options,
    run_stages: impl FnOnce(&Path, &Study, &[Stage]) -> anyhow::Result<()>,
    context: &Context,
) -> Result<Outcome, WorkflowError> {
    let study = Study::read(&options.study)?;
    let out = options.out.clone().unwrap_or_else(|| Path::new("out").join(&study.name));
    let stages = stages(&study, &out);
    run_stages(&out, &study, &stages)?;
    let (outcome, rows) = outcome::read(&out, &study, &stages, context)?;
    page::write(&out, &study, &stages, (&outcome, &rows))?;
    context.reported(&out);
    Ok(outcome)
}
