//! Recording on a rig's ports, in real time, one trajectory after the other.

use std::path::Path;

use hysteron_base::{Metadata, file};
use hysteron_rig::calibration::Calibration;
use hysteron_rig::session::{RecordOptions, Session, Stop, journal_path, record as record_one, recover};
use hysteron_rig::{Hardware, LiveRig};

use super::source::{Source, calibration_path};
use super::summary::Summary;
use super::{Arguments, Job};
use crate::watchman::Watchman;
use crate::{interrupt, terminal};

pub fn record(
    source: &Source,
    arguments: &Arguments,
    jobs: &[Job<'_>],
    folder: Option<&Path>,
    meta: &dyn Fn(&Job<'_>, &Calibration) -> Metadata,
    summary: &mut Summary,
) -> anyhow::Result<()> {
    let rig = source.rig();
    let calibration = Calibration::read(&calibration_path(rig, arguments.calibration.as_ref()), rig)?;
    for job in jobs {
        rescue(&job.out)?;
    }
    let mut hardware = LiveRig::open(rig)?;
    let servos = hardware.prepare()?;
    calibration.check(rig, &servos)?;
    if let Some(folder) = folder {
        file::write_bytes(&folder.join("calibration.toml"), calibration.to_toml())?;
    }
    let watchman = Watchman::start(&arguments.rig, rig)?;
    let bar = terminal::progress(jobs.iter().map(|job| job.trajectory.n_samples()).sum(), 0);
    let mut before = 0;
    let mut ended = Ok(());
    for job in jobs {
        let options = RecordOptions { out: job.out.clone(), meta: meta(job, &calibration) };
        let session = Session::start(&mut hardware, rig, &calibration, job.trajectory.rate_hz)?;
        let outcome = record_one(session, &job.commands, &options, &interrupt::is_asked, &mut |row| {
            bar.set_position((before + row) as u64);
        })?;
        before += job.trajectory.n_samples();
        ended = match &outcome.stopped {
            None => Ok(()),
            Some(Stop::Asked) => Err(anyhow::anyhow!("stopped on request")),
            Some(Stop::Limit(violation)) => {
                Err(anyhow::anyhow!("{}", describe(violation, &job.trajectory.name)))
            }
            Some(Stop::Failed(error)) => Err(anyhow::anyhow!("{}: {error}", job.trajectory.name)),
        };
        if outcome.n_rows > 0 {
            summary.add(job, &outcome);
        }
        if ended.is_err() {
            break;
        }
    }
    bar.finish_and_clear();
    if let Some(watchman) = watchman {
        watchman.dismiss();
    }
    ended
}

fn describe(violation: &hysteron_rig::Violation, trajectory: &str) -> String {
    let tendon = violation.tendon.map_or_else(String::new, |k| format!("tendon {}: ", k + 1));
    format!("{trajectory}: limit passed: {tendon}{}", violation.message)
}

/// Opens what a crashed run has left, under a name of its own.
fn rescue(out: &Path) -> anyhow::Result<()> {
    let journal = journal_path(out);
    if !journal.exists() {
        return Ok(());
    }
    let free = (1..).map(|i| out.with_extension(format!("crashed-{i}.parquet"))).find(|path| !path.exists());
    let Some(rescued) = free else { return Ok(()) };
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
