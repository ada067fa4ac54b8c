//! The virtual arm that a person names.

use std::path::Path;

use hysteron_base::file;
use hysteron_virtual_rig::virtual_arm::VirtualArm;

/// The arm and the text of its file.
pub(super) fn read_arm(named: &str) -> anyhow::Result<(VirtualArm, String)> {
    if let Some(text) = VirtualArm::preset_text(named) {
        return Ok((VirtualArm::preset(named)?, text.to_owned()));
    }
    if !named.contains(['.', '/']) && !Path::new(named).exists() {
        VirtualArm::preset(named)?;
    }
    let text = file::read_text(Path::new(named))?;
    Ok((VirtualArm::from_toml(&text, named)?, text))
}
