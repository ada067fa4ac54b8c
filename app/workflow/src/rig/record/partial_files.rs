//! Outcome of a trajectory, and partial files of earlier runs.

use std::path::Path;

use hysteron_base::{Journal, Recording};
use hysteron_rig::session::{Outcome, Stop, free_name, journal_path, recover};

use super::jobs::Job;
use crate::shared::error::Cancelled;

/// Whether a trajectory came to its end; if not, why not, and where what was recorded is.
pub fn ended(outcome: &Outcome, job: &Job) -> anyhow::Result<()> {
    let name = &job.name;
    if let Some(trouble) = outcome.torque_trouble.as_deref().filter(|_| outcome.stopped.is_some()) {
        tracing::error!("{name}: {trouble}");
    }
    match &outcome.stopped {
        None if outcome.is_torque_settled => Ok(()),
        None => {
            let trouble = outcome.torque_trouble.as_deref().unwrap_or("the torque is not known to be off");
            Err(anyhow::anyhow!("{name}: {trouble}"))
        }
        Some(stop) => {
            let kept = match outcome.n_rows {
                0 => "nothing was recorded yet".to_owned(),
                n_rows => format!("{n_rows} rows are in {}", outcome.out.display()),
            };
            Err(match stop {
                Stop::Asked => anyhow::Error::new(Cancelled::new(format!(" ({kept})"))).context(name.clone()),
                _ => anyhow::anyhow!("{name}: {stop} ({kept})"),
            })
        }
    }
}

/// Opens what a crashed run has left, under a name of its own.
pub fn keep_partial(out: &Path) -> anyhow::Result<()> {
    let journal = journal_path(out);
    if !journal.exists() {
        return Ok(());
    }
    let rescued = free_name(out, "crashed");
    match recover(&journal, &rescued) {
        Ok((n_rows, _)) => {
            tracing::warn!("an earlier run crashed; its {n_rows} rows are in {}", rescued.display());
        }
        // Not even one row.
        Err(error) if error.bad_input().is_some() => tracing::warn!("{error}; it is discarded"),
        Err(error) => return Err(error.into()),
    }
    Ok(std::fs::remove_file(&journal)?)
}

/// Removes the journal of a recording that is there: its run was killed between the two. Rows of any other run are
/// kept.
pub fn clear_journal(out: &Path, recording: &Recording) -> anyhow::Result<()> {
    let journal = journal_path(out);
    let has_same_rows =
        |found: &Recording| found.time() == recording.time() && found.channels() == recording.channels();
    match Journal::read(&journal) {
        Ok(found) if has_same_rows(&found.recording) => Ok(std::fs::remove_file(&journal)?),
        _ => keep_partial(out),
    }
}
