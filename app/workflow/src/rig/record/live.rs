//! Recording on a rig's ports, in real time, one trajectory after the other.

use hysteron_base::Metadata;
use hysteron_rig::calibration::RigCalibration;
use hysteron_rig::config::RigConfig;
use hysteron_rig::session::{Outcome, RecordOptions, RigRecorder, RigSession};
use hysteron_rig::{Hardware, LiveRig};

use super::jobs::Job;
use super::options::Options;
use super::partial_files::{ended, keep_partial};
use super::source::Source;
use super::summary::Summary;
use crate::Context;
use crate::shared::watchdog::WatchdogGuard;
use crate::tendon::sense::live::{LiveSensing, SensingMode};

/// Recording jobs and their options.
pub struct Work<'a> {
    pub options: &'a Options,
    pub jobs: &'a [Job],
    pub sensing: Option<&'a LiveSensing>,
}

pub fn record(
    source: &Source,
    Work { options, jobs, sensing }: &Work,
    calibration: &RigCalibration,
    meta: &dyn Fn(&Job, &RigCalibration) -> Metadata,
    summary: &mut Summary,
    context: &Context,
) -> anyhow::Result<()> {
    let rig = source.rig();
    for job in *jobs {
        keep_partial(&job.out)?;
    }
    if calibration.registers.is_empty() {
        tracing::warn!(
            "the calibration of {} has no record of the servos' registers: they are compared with the factory's values; \
             calibrate again to store them",
            calibration.date
        );
    }
    let mut hardware = LiveRig::open(rig)?.expecting(calibration.register_baseline());
    let servos = hardware.prepare()?;
    calibration.check(rig, &servos)?;
    let mut hardware = WatchdogGuard::new(hardware, &options.rig, context)?;
    let run = Run { rig, calibration, meta, sensing: *sensing };
    let (ended, is_torque_settled) = run.all(&mut hardware, jobs, summary, context);
    if is_torque_settled {
        hardware.close();
    }
    ended
}

/// Settings common to all trajectories of a run.
struct Run<'a> {
    rig: &'a RigConfig,
    calibration: &'a RigCalibration,
    meta: &'a dyn Fn(&Job, &RigCalibration) -> Metadata,
    sensing: Option<&'a LiveSensing>,
}

impl Run<'_> {
    /// Records one after the other. Also returns whether the torque is known to be as it shall be.
    fn all(
        &self,
        hardware: &mut LiveRig,
        jobs: &[Job],
        summary: &mut Summary,
        context: &Context,
    ) -> (anyhow::Result<()>, bool) {
        let bar = context.progress("samples", jobs.iter().map(|job| job.commands.n_samples()).sum(), 0);
        let mut before = 0;
        let mut end = (Ok(()), true);
        for job in jobs {
            end = match self.one(hardware, job, &mut |row| bar.set_position((before + row) as u64), context) {
                Ok(outcome) => {
                    let ended = ended(&outcome, job);
                    if ended.is_ok() {
                        summary.add(job, &outcome);
                    }
                    (ended, outcome.is_torque_settled)
                }
                Err(error) => (Err(error), false),
            };
            before += job.commands.n_samples();
            if end.0.is_err() {
                break;
            }
        }
        bar.finish();
        end
    }

    fn one(
        &self,
        hardware: &mut LiveRig,
        job: &Job,
        progress: &mut dyn FnMut(usize),
        context: &Context,
    ) -> anyhow::Result<Outcome> {
        let options = RecordOptions::new(job.out.clone(), (self.meta)(job, self.calibration));
        let mut recorder = RigRecorder::begin(self.rig, self.calibration, options)?;
        if let Some(sensing) = self.sensing {
            recorder = sensing.follow(recorder, self.calibration, &job.commands, SensingMode::RealTime)?;
        }
        if let Some(feedback) = &job.feedback {
            recorder = recorder.with_feedback(feedback.clone());
        }
        let session = RigSession::start(hardware, self.rig, self.calibration, job.rate_hz)?;
        Ok(recorder.run(session, &job.commands, &|| context.is_cancelled(), progress)?)
    }
}
