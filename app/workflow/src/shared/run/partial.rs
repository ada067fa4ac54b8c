//! Partial files of a run that does not come to its end, and resuming from them.

use std::path::{Path, PathBuf};

use anyhow::Context as _;
use hysteron_base::{BadInput, Metadata, Recording};
use hysteron_twin::command::Command;
use hysteron_twin::{Twin, TwinState};

use super::rollout::{RunEnd, RunState, describe_sample};
use super::trace::Trace;
use crate::shared::error::Cancelled;
use crate::shared::paths;

/// Files of a run that stopped: `OUT.partial.EXT`, and next to it `OUT.state`.
#[derive(Debug)]
pub struct Partial {
    /// The samples that were done.
    pub recording: PathBuf,
    /// The equilibrium of the last one.
    pub state: PathBuf,
}

impl Partial {
    /// Partial files of a recording that will be written; its name is checked.
    ///
    /// # Errors
    /// `BadInput` for a name that a recording must not have.
    pub fn of(out: &Path) -> Result<Self, BadInput> {
        let extension = paths::check_recording(out)?;
        let recording = out.with_extension(format!("partial.{extension}"));
        Ok(Self { recording, state: out.with_extension("state") })
    }

    /// Both files.
    pub fn files(&self) -> [&PathBuf; 2] {
        [&self.recording, &self.state]
    }

    /// Reads where an earlier run stopped that was made from the same things.
    ///
    /// # Errors
    /// `BadInput` where nothing is there, or something of another run.
    pub fn resume(
        &self,
        twin: &Twin,
        provenance: &Metadata,
        command: &Command,
        mut trace: Trace,
    ) -> anyhow::Result<RunState> {
        let place = self.recording.display();
        if !self.recording.exists() {
            return Err(BadInput::new(
                place.to_string(),
                "the partial recording of an earlier run with the same --out",
                "nothing there",
            )
            .hint("leave out --resume to start anew")
            .into());
        }
        let earlier = Recording::read(&self.recording)?;
        let bad = |what: &str, expected: &str, found: &str| {
            BadInput::new(format!("{place}: {what}"), expected, found)
                .hint("leave out --resume to start anew")
        };
        let scene_hash = &provenance.scene_hash;
        if earlier.meta().scene_hash != *scene_hash {
            return Err(bad("scene_hash", scene_hash, &earlier.meta().scene_hash).into());
        }
        for (key, expected) in &provenance.extra {
            let found = earlier.meta().extra.get(key).map_or("", String::as_str);
            if found != expected {
                return Err(bad(key, expected, found).into());
            }
        }
        if !command.time.starts_with(earlier.time()) {
            return Err(bad("time_s", "the first times of the recording to follow", "others").into());
        }
        let state = TwinState::read(&self.state, twin, scene_hash)?;
        trace.extend(&earlier).map_err(|error| error.within(place))?;
        Ok(RunState::new(state, trace))
    }

    /// The error of a run that stopped after `n_done` samples, all of which are in these files.
    pub fn stopped(&self, end: RunEnd, n_done: usize, twin: &Twin, command: &Command) -> anyhow::Error {
        let [recording, state] = self.files().map(|path| path.display());
        let kept = if n_done == 0 {
            format!("the last equilibrium is in {state}")
        } else {
            let n = command.time.len();
            format!("{n_done} of {n} samples are in {recording}, the last equilibrium in {state}")
        };
        match end {
            RunEnd::Failed(error) => {
                anyhow::anyhow!("{}: {error:#}; {kept}", describe_sample(twin, command, n_done))
            }
            _ => Cancelled::new(format!("; {kept}; add --resume to continue")).into(),
        }
    }

    /// Removes both files, but for one that a state was saved to.
    ///
    /// # Errors
    /// A file that cannot be removed.
    pub fn remove(&self, saved: Option<&PathBuf>) -> anyhow::Result<()> {
        for path in self.files().into_iter().filter(|path| saved != Some(*path)) {
            std::fs::remove_file(path).with_context(|| format!("removing {}", path.display()))?;
        }
        Ok(())
    }
}
