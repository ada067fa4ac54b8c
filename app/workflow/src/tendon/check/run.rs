//! The recipe: scene or recordings, whichever the files are.

use std::path::{Path, PathBuf};

use hysteron_base::BadInput;

use super::options::Options;
use super::outcome::Outcome;
use super::{recordings, scene};
use crate::{Context, WorkflowError};

/// Runs the verb.
///
/// # Errors
/// Bad input; [`super::Refused`].
pub fn run(options: &Options, context: &Context) -> Result<Outcome, WorkflowError> {
    Ok(check(options, context)?)
}

/// Checks a scene, recordings, or recordings against their scene.
fn check(options: &Options, context: &Context) -> anyhow::Result<Outcome> {
    let (scenes, others): (Vec<&PathBuf>, Vec<&PathBuf>) =
        options.files.iter().partition(|path| is_scene(path));
    match (&scenes[..], &others[..]) {
        ([scene], []) => Ok(Outcome::Scene(scene::check(scene, context)?.0)),
        ([], _) => recordings::check(&others, (None, None), context),
        ([scene], _) => {
            let (outcome, length) = scene::check(scene, context)?;
            context.print("");
            recordings::check(&others, (Some(outcome), Some(length)), context)
        }
        _ => {
            let found = scenes.iter().map(|path| path.display().to_string()).collect::<Vec<_>>().join(", ");
            Err(BadInput::new("FILE", "one scene at most", found)
                .hint("check them one after the other")
                .into())
        }
    }
}

/// True for what is no recording by its ending, and no folder.
fn is_scene(path: &Path) -> bool {
    let ending = path.extension().and_then(|ending| ending.to_str());
    !path.is_dir() && !matches!(ending, Some("parquet" | "csv" | "journal"))
}
