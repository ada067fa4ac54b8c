//! The finder of strokes: the network of a checkpoint, or a twin that the options or the checkpoint name.

use std::path::{Path, PathBuf};

use hysteron_base::{BadInput, Scene, file};
use hysteron_control::inverse::{InverseModel, LeadingTwin};

use super::options::Way;
use super::twin_strokes::{SteeredTwin, Twins};

/// A method that finds strokes, with its files read.
pub(super) enum Finder {
    /// An inverse controller.
    Network(Box<InverseModel>),
    /// A twin.
    Twin(SteeredTwin),
}

impl Finder {
    /// The twin of the scene that was named, or the controller of the checkpoint, or the twin that this names as better.
    ///
    /// # Errors
    /// Files that cannot be read, or that are not those which the checkpoint names.
    pub(super) fn of(way: &Way) -> anyhow::Result<Self> {
        let checkpoint = way.checkpoint.as_deref();
        if let Some(scene) = &way.scene {
            let twins = if way.nominal { Twins::Nominal } else { Twins::OfScene };
            return Ok(Self::Twin(SteeredTwin {
                scene: scene.clone(),
                twins,
                residual: checkpoint.map(Path::to_owned),
                limits: None,
            }));
        }
        let path = checkpoint.unwrap_or(Path::new(""));
        let model = InverseModel::read(path)?;
        match &model.training.twin {
            Some(twin) if !way.network => {
                let found = steered(path, twin).map_err(|bad| {
                    bad.hint(
                        "with --network the network finds the strokes; with --scene a twin that you name",
                    )
                })?;
                Ok(Self::Twin(SteeredTwin { limits: Some(model.limits), ..found }))
            }
            _ => Ok(Self::Network(Box::new(model))),
        }
    }

    /// The files that it reads, apart from the checkpoint of the options.
    pub(super) fn scene_and_residual(&self) -> Option<(&Path, Option<&Path>)> {
        match self {
            Self::Network(_) => None,
            Self::Twin(twin) => Some((&twin.scene, twin.residual.as_deref())),
        }
    }
}

/// The twin that a checkpoint names, if its files are still what they were.
fn steered(checkpoint: &Path, twin: &LeadingTwin) -> Result<SteeredTwin, BadInput> {
    let folder = file::folder_of(checkpoint);
    let check = |key: &str, path: &PathBuf, expected: &str, found: hysteron_base::Result<String>| {
        let place = || format!("{}: training.twin.{key}: {}", checkpoint.display(), path.display());
        match found {
            Ok(found) if found == expected => Ok(()),
            Ok(found) => Err(BadInput::new(place(), format!("the file with the hash {expected}"), found)),
            Err(error) => {
                Err(BadInput::new(place(), "the file that the twin was made from", error.to_string()))
            }
        }
    };
    let scene = folder.join(&twin.scene);
    check("scene", &scene, &twin.scene_sha256, Scene::read(&scene).map(|scene| scene.hash))?;
    let residual = twin.residual.as_ref().map(|path| folder.join(path));
    if let (Some(path), Some(expected)) = (&residual, &twin.residual_sha256) {
        check("residual", path, expected, file::sha256_of(path))?;
    }
    Ok(SteeredTwin { scene, twins: Twins::OfScene, residual, limits: None })
}
