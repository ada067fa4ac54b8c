//! Whether the twin finds strokes better than the controllers that learned from it, and then its files for the checkpoint.

use hysteron_base::file;
use hysteron_control::inverse::{Axes, LeadingTwin};

use super::compared::SAME;
use super::judge::Judge;
use super::options::Options;
use crate::shared::paths::seen_from;

/// The twin for the checkpoint: where it leads the tip closer than the best controller, whose error is `tip_mm`, and `command` can
/// steer it.
///
/// # Errors
/// Files that cannot be read.
pub(super) fn leading_twin(
    options: &Options,
    judge: Option<&Judge>,
    tip_mm: Option<f64>,
    own_mm: Option<f64>,
) -> anyhow::Result<Option<LeadingTwin>> {
    let (Some(scene), Some(judge), Some(tip_mm), Some(own_mm)) = (&options.scene, judge, tip_mm, own_mm)
    else {
        return Ok(None);
    };
    // `command` has neither the reduced body of an option nor a twin in space.
    let is_usable = options.body.reduced.is_none() && judge.axes == Axes::Planar;
    if !is_usable || (1.0 + SAME) * own_mm >= tip_mm {
        return Ok(None);
    }
    let folder = file::folder_of(&options.out);
    let residual = options.residual.as_deref();
    Ok(Some(LeadingTwin {
        scene: seen_from(folder, scene)?,
        scene_sha256: judge.scene_hash.clone(),
        residual: residual.map(|path| seen_from(folder, path)).transpose()?,
        residual_sha256: residual.map(file::sha256_of).transpose()?,
        tip_rmse_mm: own_mm,
    }))
}
