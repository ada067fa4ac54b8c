//! How a trajectory ended. A recording that is not complete gets a name of its own: nothing partial stands under the final
//! one.

use std::path::{Path, PathBuf};

use hysteron_rig::session::{Outcome, events_path};

use super::Job;

/// Whether a trajectory came to its end; if not, why not, and where what was recorded is.
pub fn ended(outcome: &Outcome, job: &Job) -> anyhow::Result<()> {
    let name = &job.name;
    match &outcome.stopped {
        None if outcome.is_torque_settled => Ok(()),
        None => Err(anyhow::anyhow!("{name}: the torque could not be dealt with; switch the supply off")),
        Some(stop) => Err(anyhow::anyhow!("{name}: {stop} ({})", set_aside(&job.out, outcome)?)),
    }
}

/// Gives a recording that is not complete a name of its own, so that the same command can go on; says where it is.
fn set_aside(out: &Path, outcome: &Outcome) -> anyhow::Result<String> {
    if outcome.n_rows == 0 {
        return Ok("nothing was recorded yet".to_owned());
    }
    let (aside, log) = free_name(out, "partial");
    std::fs::rename(out, &aside)?;
    std::fs::rename(events_path(out), log)?;
    Ok(format!("{} rows are in {}", outcome.n_rows, aside.display()))
}

/// `NAME.kind-1.parquet`, or with the first number that is free, and the log beside it.
pub fn free_name(out: &Path, kind: &str) -> (PathBuf, PathBuf) {
    let ending = out.extension().unwrap_or_default().to_string_lossy().into_owned();
    let mut number = 1;
    loop {
        let named = out.with_extension(format!("{kind}-{number}.{ending}"));
        if !named.exists() {
            let log = events_path(&named);
            return (named, log);
        }
        number += 1;
    }
}
