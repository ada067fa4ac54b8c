//! Regenerates the keys in `docs/outcomes.md` from the types.

use std::path::Path;

use hysteron_studies::outcomes;
use hysteron_workflow::shared::outcome::MARK;

fn main() -> anyhow::Result<()> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/outcomes.md");
    let text = std::fs::read_to_string(&path)?;
    let head = text.split_once(MARK).map_or(text.as_str(), |(head, _)| head);
    hysteron_base::file::write_bytes(
        &path,
        format!("{}\n\n{MARK}{}", head.trim_end(), outcomes::document()),
    )?;
    Ok(())
}
