//! The run of `study force`.

use std::path::Path;

use hysteron_virtual_rig::virtual_arm::VirtualArm;
use hysteron_workflow::shared::outputs::Outputs;
use hysteron_workflow::{Context, WorkflowError};
use serde::Serialize;

use super::cells::{ForceStudy, force_study};
use super::data::{NadFiles, TRAINING, recorded};
use super::{options::Options, outcome::Outcome, page};
use crate::runner;

/// Virtual arm of the study.
const ARM: &str = "open-manipulator-x";

/// Source of the recordings, as cells are stamped with it.
#[derive(Serialize)]
#[serde(untagged)]
enum Source {
    /// Files of NAD, by their hash.
    Files { files: String, training: usize },
    /// Individuals of a virtual arm, by the hash of its description.
    Virtual { arm: String, training: usize },
}

/// Runs the study on as many individual arms as there are seeds, or on recordings of NAD.
///
/// # Errors
/// Cells of another study, recordings without what is needed, files that cannot be written, an interruption.
pub fn run(options: &Options, context: &Context) -> Result<Outcome, WorkflowError> {
    let compute = |cells: &Path, listener: runner::Listener<'_>| study(options, cells, listener, context);
    runner::run(&options.out, Outputs::default(), context, compute, |study| {
        let about = match &options.data {
            Some(folder) => format!("Recordings below {}.", folder.display()),
            None => format!(
                "Virtual arm in place of NAD: {} individual arms, whose physics share neither code nor parameters with \
                 the estimators (docs/virtual-arm.md).",
                study.cells.len()
            ),
        };
        let outcome = Outcome::new(&study, about, context);
        page::write(&options.out, &study, &outcome)?;
        Ok(outcome)
    })
}

fn study(
    options: &Options,
    cells: &Path,
    listener: runner::Listener<'_>,
    context: &Context,
) -> anyhow::Result<Option<ForceStudy>> {
    if let Some(folder) = &options.data {
        let files = NadFiles::below(folder)?;
        let source = Source::Files { files: files.digest()?, training: TRAINING };
        return Ok(force_study(cells, &[0], &source, &mut |_| files.read().map(Some), listener)?);
    }
    let general = VirtualArm::preset(ARM)?;
    let seeds: Vec<u64> = (1..=options.seeds as u64).collect();
    let source = Source::Virtual { arm: general.hash.clone(), training: TRAINING };
    let mut data =
        |seed: u64| if context.is_cancelled() { Ok(None) } else { recorded(&general, seed).map(Some) };
    Ok(force_study(cells, &seeds, &source, &mut data, listener)?)
}
