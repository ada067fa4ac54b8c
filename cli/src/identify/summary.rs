//! What identifications came to, for the terminal.

use std::path::Path;

use anyhow::Context;
use hysteron_base::Recording;
use hysteron_twin::coreact::Summary;
use serde::Serialize;

use crate::terminal;

/// One recording.
#[derive(Debug, Serialize)]
pub struct Row {
    /// Its name.
    pub name: String,
    /// What it came to.
    #[serde(flatten)]
    pub summary: Summary,
}

impl Row {
    /// Out of a recording that was identified earlier.
    pub fn read(path: &Path) -> anyhow::Result<Self> {
        let recording = Recording::read(path)?;
        let text = recording.meta().extra.get("identify.summary").context("no summary")?;
        let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        Ok(Self { name, summary: serde_json::from_str(text)? })
    }
}

/// Prints one line per recording.
pub fn print(rows: &[Row]) {
    for Row { name, summary: s } in rows {
        let mm = |m: f64| format!("{:.3}", 1e3 * m);
        terminal::say(format_args!(
            "{name}: {} samples; before {} mm median, {} p99; after {} median, {} p99, {} max; at bounds {:.2} {:.2} {:.2} %; gaps {}; qps {:?}",
            s.samples,
            mm(s.before.median_m),
            mm(s.before.p99_m),
            mm(s.after.median_m),
            mm(s.after.p99_m),
            mm(s.after.max_m),
            100.0 * s.share_at_bound[0],
            100.0 * s.share_at_bound[1],
            100.0 * s.share_at_bound[2],
            s.gaps,
            s.qps
        ));
    }
}
