//! `hysteron rig`: everything that concerns servos and tracker, real or emulated.

pub mod calibrate;
pub mod check;
pub mod emulate;
pub mod identify_servo;
pub mod record;
pub mod recover;

use std::path::Path;

use hysteron_base::file;
use hysteron_rig::teleoperation::ArmsConfig;

/// Whether a file is one of two arms.
pub(crate) fn is_of_arms(path: &Path) -> anyhow::Result<bool> {
    #[derive(serde::Deserialize)]
    struct Head {
        format: String,
    }
    let head: Head =
        hysteron_base::schema::parse(&file::read_text(path)?).map_err(|bad| bad.within(path.display()))?;
    Ok(head.format == ArmsConfig::FORMAT)
}
