//! Recording on the virtual rig in this process: all trajectories at once, each on a rig of its own that was
//! calibrated once.

use std::path::Path;
use std::sync::Mutex;

use hysteron_base::{Metadata, parallel};
use hysteron_rig::Hardware;
use hysteron_rig::calibration::{RigCalibration, calibrate};
use hysteron_rig::session::{RecordOptions, RigRecorder, RigSession, journal_path};
use hysteron_virtual_rig::virtual_rig::{ExternalForceHandle, SimulatedRig};

use super::jobs::Job;
use super::partial_files::ended;
use super::source::{self, Source};
use super::summary::Summary;
use super::tip_force::TipForce;
use crate::Context;
use crate::tendon::sense::live::{LiveSensing, SensingMode};

/// A simulated calibration has no date; the same seed must give the same bytes.
const DATE: &str = "simulated";

/// A virtual rig, and what pushes its tip.
pub struct Simulation<'a> {
    pub source: &'a Source,
    pub seed: u64,
    pub tip_force: Option<&'a TipForce>,
    pub sensing: Option<&'a LiveSensing>,
}

impl Simulation<'_> {
    pub fn record(
        &self,
        jobs: &[Job],
        (given, folder): (Option<RigCalibration>, Option<&Path>),
        meta: &(dyn Fn(&Job, &RigCalibration) -> Metadata + Sync),
        summary: &mut Summary,
        context: &Context,
    ) -> anyhow::Result<()> {
        let Source::Virtual { rig, robot, .. } = self.source else { return Ok(()) };
        let mut fresh = SimulatedRig::new(robot, rig, self.seed);
        if let Some(calibration) = &given {
            calibration.check(rig, &fresh.clone().prepare()?)?;
        }
        // Also a robot whose calibration is given has been calibrated once: a new one that never moved rests elsewhere.
        let mut log = |line: &str| tracing::debug!("{line}");
        let found = calibrate(&mut fresh, rig, DATE.to_owned(), &|| context.is_cancelled(), &mut log)?;
        let calibration = given.unwrap_or(found);
        if let Some(folder) = folder {
            source::keep_calibration(folder, &calibration)?;
        }
        let bar = context.progress("samples", jobs.iter().map(|job| job.commands.n_samples()).sum(), 0);
        let collected = Mutex::new(summary);
        let recorded = parallel::try_map(jobs, |job| {
            let mut hardware: SimulatedRig = fresh.clone();
            // The same rig on another day: its noise is another.
            hardware.world_mut().reseed(self.seed, &job.name);
            let hand = self.tip_force.map(|force| (ExternalForceHandle::default(), force));
            let push = |row: usize| {
                hand.iter().for_each(|(hand, force)| hand.push(force.at(row as f64 / job.rate_hz)));
            };
            if let Some((hand, _)) = &hand {
                hardware.give_to(hand.clone());
                push(0);
            }
            let mut options = RecordOptions::new(job.out.clone(), meta(job, &calibration));
            options.instruments = hardware.instruments();
            let journal = journal_path(&job.out);
            if journal.exists() {
                // A simulation can be repeated.
                std::fs::remove_file(&journal)?;
            }
            let mut recorder = RigRecorder::begin(rig, &calibration, options)?;
            if let Some(sensing) = self.sensing {
                recorder = sensing.follow(recorder, &calibration, &job.commands, SensingMode::Blocking)?;
            }
            if let Some(feedback) = &job.feedback {
                recorder = recorder.with_feedback(feedback.clone());
            }
            let session = RigSession::start(&mut hardware, rig, &calibration, job.rate_hz)?;
            let mut progress = |row: usize| {
                bar.inc(1);
                push(row);
            };
            let outcome = recorder.run(session, &job.commands, &|| context.is_cancelled(), &mut progress)?;
            ended(&outcome, job)?;
            if let Ok(mut summary) = collected.lock() {
                summary.add(job, &outcome);
            }
            Ok(())
        });
        bar.finish();
        recorded.map(|_| ())
    }
}
