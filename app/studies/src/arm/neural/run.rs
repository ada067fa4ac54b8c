//! The run of `study neural` and `study neural-networks`.

use std::path::Path;

use hysteron_arm_dynamics::Model;
use hysteron_virtual_rig::virtual_arm::VirtualArm;
use hysteron_workflow::shared::outputs::Outputs;
use hysteron_workflow::{Context, WorkflowError};
use serde::Serialize;

use super::data::{INDIVIDUAL, data, read, recorded};
use super::study::{NeuralStudy, neural_study};
use super::{NeuralScope, NeuralSize, options::Options, outcome::Outcome, page};
use crate::runner::{self, Listener};

/// Virtual arm of the study, and its model.
const ARM: &str = "open-manipulator-x";

/// Source of the recordings, as cells are stamped with it.
#[derive(Serialize)]
#[serde(untagged)]
enum Source {
    /// Files of NAD, by their hash.
    Files { files: String },
    /// An individual of a virtual arm, by the hash of its description.
    Virtual { arm: String, seed: u64 },
}

/// Runs the study with these seeds of networks.
///
/// # Errors
/// Cells of another study, recordings without what is needed, files that cannot be written, an interruption.
pub fn run(options: &Options, scope: NeuralScope, context: &Context) -> Result<Outcome, WorkflowError> {
    let size = if options.quick { NeuralSize::Quick } else { NeuralSize::Full };
    let compute =
        |cells: &Path, listener: Listener<'_>| study(options, (size, scope), cells, listener, context);
    runner::run(&options.out, Outputs::default(), context, compute, |study| {
        let outcome = Outcome::new(&study, about(options, size), context);
        page::write(&options.out, &study, &outcome)?;
        Ok(outcome)
    })
}

fn study(
    options: &Options,
    (size, scope): (NeuralSize, NeuralScope),
    cells: &Path,
    listener: Listener<'_>,
    context: &Context,
) -> anyhow::Result<Option<NeuralStudy>> {
    let first = u64::from(options.first_seed);
    let seeds = first..first + if options.quick { 1 } else { options.seeds as u64 };
    let (recordings, source) = match &options.data {
        Some(folder) => {
            let (recordings, files) = read(folder)?;
            (recordings, Source::Files { files })
        }
        None => {
            let general = VirtualArm::preset(ARM)?;
            (recorded(&general)?, Source::Virtual { arm: general.hash, seed: INDIVIDUAL })
        }
    };
    if context.is_cancelled() {
        return Ok(None);
    }
    let (model, data) = (Model::builtin(ARM)?, data(&recordings)?);
    Ok(neural_study(cells, (&model, &data, &source), (size, scope, seeds), listener)?)
}

/// Describes the arm and the size of the networks.
fn about(options: &Options, size: NeuralSize) -> String {
    let source = match &options.data {
        Some(folder) => format!("Recordings below {}.", folder.display()),
        None => "Virtual arm in place of NAD, whose physics share neither code nor parameters with what is learned and identified \
                 (docs/virtual-arm.md). Published figures are of the real arm."
            .to_owned(),
    };
    let amount = match size {
        NeuralSize::Quick => {
            " Quick: networks of a few minutes, to check that the study runs; its results mean nothing."
        }
        NeuralSize::Full => "",
    };
    format!("{source}{amount}")
}
