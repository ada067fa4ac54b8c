//! Runs the stages of a study, one after the other, each as a process of its own.

use std::fs::{File, TryLockError};
use std::path::Path;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use anyhow::{Context as _, bail};
use hysteron_base::{BadInput, file};
use hysteron_studies::chain::{OnRefusal, Stage, StageStatus, Stamp, Step, clear_outputs};
use hysteron_workflow::Context;
use hysteron_workflow::shared::outputs;

use crate::failure::CommandFailed;
use crate::invocation::Relaunch;
use crate::progress::duration;
use crate::{interrupt, terminal};

/// A stage that works is looked after so often.
const LOOK_EVERY: Duration = Duration::from_millis(20);

/// See the module.
pub struct Runner<'a> {
    out: &'a Path,
    relaunch: &'a Relaunch,
    context: &'a Context<'a>,
    /// Held while the study runs, by the running stage too: it is released when the last of them ends,
    /// however it ends.
    lock: File,
    /// Guessed and measured time of the stages done in this run [s].
    pace: [f64; 2],
}

impl<'a> Runner<'a> {
    /// Takes hold of the folder of the study `name`; waits for a stage that an earlier run has left behind.
    ///
    /// # Errors
    /// `BadInput` if the folder is that of another study, or if a report is there which no study wrote.
    pub fn new(
        out: &'a Path,
        name: &str,
        (relaunch, context): (&'a Relaunch, &'a Context<'a>),
    ) -> anyhow::Result<Self> {
        outputs::check_report("--out", out)?;
        let place = out.join("stages").join("lock");
        check_name(out, name)?;
        file::write_bytes(&out.join("stages").join("README"), README)?;
        let lock = File::options().create(true).truncate(false).write(true).read(true).open(&place)?;
        match lock.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => {
                tracing::warn!(
                    "another run of this study, or its last stage, is still at work in {}; waiting for its end",
                    out.display()
                );
                lock.lock()?;
            }
            Err(TryLockError::Error(error)) => return Err(error).context(place.display().to_string()),
        }
        // Another study may have come first.
        check_name(out, name)?;
        file::write_bytes(&out.join(NAME), name)?;
        file::clear_temporary(out);
        file::clear_temporary(&out.join("stages"));
        Ok(Self { out, relaunch, context, lock, pace: [0.0; 2] })
    }

    /// Brings all stages to their end.
    pub fn run(mut self, stages: &[Stage]) -> anyhow::Result<()> {
        interrupt::count();
        for (k, stage) in stages.iter().enumerate() {
            let of = format!("[{}/{}] {}", k + 1, stages.len(), stage.name);
            if self.context.is_cancelled() {
                bail!("{of}: interrupted; the same command resumes");
            }
            let stamp = Stamp::begun(stage)?;
            let earlier = Stamp::read(self.out, stage);
            let status = stamp.status(earlier.as_ref(), self.out, stage)?;
            if status == StageStatus::Done {
                self.context.print(format_args!("{of}: unchanged"));
                continue;
            }
            self.context.print(format_args!("{of}: {}{}", stage.about, why(&status)));
            self.context.print(format_args!("      about {} left", duration(self.left(&stages[k..]))));
            clear_outputs(self.out, stage, &status, earlier.as_ref())?;
            stamp.write(self.out, stage)?;
            let stamp = self.run_stage(stage, stamp).with_context(|| of.clone())?;
            self.context.print(format_args!("      done in {}", duration(stamp.seconds)));
            self.pace[0] += stage.guess;
            self.pace[1] += stamp.seconds;
            stamp.write(self.out, stage)?;
        }
        Ok(())
    }

    /// Runs all commands of a stage; its stamp then lists their outputs.
    fn run_stage(&self, stage: &Stage, mut stamp: Stamp) -> anyhow::Result<Stamp> {
        let start = Instant::now();
        for step in &stage.steps {
            self.context.print(format_args!("      {}", step.shown()));
            let status = self.status_of(step)?;
            if self.context.is_cancelled() {
                match status.code() {
                    Some(0) | None => bail!("interrupted; the same command resumes"),
                    Some(_) => return Err(CommandFailed::Interrupted.into()),
                }
            }
            if status.success() {
                continue;
            }
            match &step.on_refusal {
                OnRefusal::NoteWith(strokes) if status.code().is_some() && strokes.exists() => {
                    tracing::warn!("the rig stopped before the end of these strokes; the report lists it");
                }
                _ => {
                    let failed = status.code().map_or(CommandFailed::Killed, CommandFailed::Ended);
                    return Err(failed.into());
                }
            }
        }
        stamp.seconds = start.elapsed().as_secs_f64();
        stamp.finished(self.out, stage)
    }

    /// Runs a command to its end. Ctrl-C is passed on to it, each as often as it comes.
    fn status_of(&self, step: &Step) -> anyhow::Result<ExitStatus> {
        let (program, before) = self.relaunch.program.split_first().context("how this program is started")?;
        let mut command = Command::new(program);
        // Existing files belong to the study, with any options.
        command
            .args(before)
            .arg("--overwrite")
            .args(&self.relaunch.options)
            .args(step.arguments.iter().map(|argument| &argument.typed));
        // Nobody reads from it; it holds the lock.
        command.stdin(self.lock.try_clone()?);
        if terminal::is_json() {
            // The summary is that of the study.
            command.stdout(Stdio::null());
        }
        apart(&mut command);
        let mut child = command.spawn().with_context(|| program.display().to_string())?;
        let mut passed_on = 0;
        loop {
            if let Some(status) = child.try_wait()? {
                return Ok(status);
            }
            // A caller's cancellation is one request, a person's Ctrl-C comes as often as it is pressed.
            while passed_on < interrupt::n_requests().max(usize::from(self.context.is_cancelled())) {
                ask_to_stop(&mut child)?;
                passed_on += 1;
            }
            std::thread::sleep(LOOK_EVERY);
        }
    }

    /// Time that the stages from here on will take [s]: as long as last time, or as guessed and paced by those done.
    fn left(&self, stages: &[Stage]) -> f64 {
        let pace = if self.pace[0] > 0.0 { self.pace[1] / self.pace[0] } else { 1.0 };
        let of = |stage: &Stage| match Stamp::read(self.out, stage).filter(|stamp| stamp.is_finished()) {
            Some(stamp) => stamp.seconds,
            None => pace * stage.guess,
        };
        stages.iter().map(of).sum()
    }
}

/// Refuses the folder of a study with another name.
fn check_name(out: &Path, name: &str) -> anyhow::Result<()> {
    let place = out.join(NAME);
    if !place.exists() {
        return Ok(());
    }
    let found = file::read_text(&place)?;
    if found == name {
        return Ok(());
    }
    let found = format!("{}, that of \"{found}\"", out.display());
    Err(BadInput::new("--out", format!("a new folder, or that of the study \"{name}\""), found)
        .hint("choose another --out")
        .into())
}

/// Ctrl-C in the terminal reaches this program alone, which passes it on.
#[cfg(unix)]
fn apart(command: &mut Command) {
    use std::os::unix::process::CommandExt;
    command.process_group(0);
}

#[cfg(not(unix))]
fn apart(_: &mut Command) {}

#[cfg(unix)]
fn ask_to_stop(child: &mut Child) -> anyhow::Result<()> {
    Ok(rustix::process::kill_process(rustix::process::Pid::from_child(child), rustix::process::Signal::INT)?)
}

#[cfg(not(unix))]
fn ask_to_stop(child: &mut Child) -> anyhow::Result<()> {
    Ok(child.kill()?)
}

/// Why a stage is done that was done before.
fn why(status: &StageStatus) -> String {
    match status {
        StageStatus::Done | StageStatus::New => String::new(),
        StageStatus::Begun => " (resumed)".to_owned(),
        StageStatus::Damaged(files) => format!(" (again: {} is gone or was changed)", files.join(", ")),
        StageStatus::Outdated(what) => format!(" (again: {what} changed)"),
    }
}

/// File in the folder of a study with its name.
const NAME: &str = "stages/study";

const README: &str = "\
Stamps of the stages of a study: what each was made from and what it wrote. Remove one, and its stage is done again.\n";
