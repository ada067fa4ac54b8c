//! The recording that a run goes through, and what the robot does with its samples.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use hysteron_base::{BadInput, Metadata, Recording, Scene, file};
use hysteron_twin::Twin;
use hysteron_twin::command::{Command, Goals};

use crate::{COMMIT, Context};

/// Task of the robot for the samples of a recording.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Task {
    /// It follows their strokes or tensions.
    Simulate,
    /// Its tip goes to their tip positions, within the tolerance [m].
    Reach(f64),
}

impl Task {
    /// Title of the run, for a reader.
    pub fn title(self) -> &'static str {
        match self {
            Self::Simulate => "simulation",
            Self::Reach(_) => "strokes to reach goals",
        }
    }

    /// Key of the recording's hash in the metadata: `strokes_sha256` or `goals_sha256`.
    fn hash_key(self) -> String {
        match self {
            Self::Simulate => "strokes_sha256".to_owned(),
            Self::Reach(_) => "goals_sha256".to_owned(),
        }
    }
}

/// A recording with the task that its samples set.
#[derive(Debug)]
pub struct RunInput {
    /// Task of the robot.
    pub task: Task,
    /// File of the recording.
    pub path: PathBuf,
    /// The recording.
    pub samples: Recording,
    /// SHA-256 of the file.
    sha256: String,
}

impl RunInput {
    /// Reads a recording.
    ///
    /// # Errors
    /// Those of reading it.
    pub fn read(task: Task, path: &Path) -> anyhow::Result<Self> {
        let samples = Recording::read(path)?;
        let sha256 = file::sha256_of(path)?;
        Ok(Self { task, path: path.to_owned(), samples, sha256 })
    }

    /// Targets of all tendons of `twin`, sample by sample.
    ///
    /// # Errors
    /// `BadInput` where a channel is missing or a value out of its bounds.
    pub fn command(&self, twin: &Twin) -> Result<Command<'_>, BadInput> {
        let Self { task, path, samples, .. } = self;
        match *task {
            Task::Simulate => Command::new(twin, samples, path),
            Task::Reach(tolerance) => {
                Command::with_free_strokes(twin, samples, path, Goals::new(samples, path, tolerance)?)
            }
        }
    }

    /// Duration of a sample [s], all the same.
    ///
    /// # Errors
    /// `BadInput` where the steps are uneven.
    pub fn sample_duration(&self) -> Result<f64, BadInput> {
        sample_duration(&self.samples, &self.path)
    }

    /// Tip that was measured under the same strokes, if it was: x, y and z (n_samples each) [m].
    pub fn measured(&self) -> Option<[&[f64]; 3]> {
        self.samples.tip().filter(|_| self.task == Task::Simulate)
    }

    /// Metadata of the run's recording: its provenance.
    pub fn provenance(&self, scene: &Scene, context: &Context) -> Metadata {
        let path = self.path.display();
        let mut extra = BTreeMap::from([(self.task.hash_key(), self.sha256.clone())]);
        let source = match self.task {
            Task::Simulate => format!("simulation of {} with strokes from {path}", scene.name),
            Task::Reach(tolerance) => {
                extra.insert("tolerance_m".to_owned(), tolerance.to_string());
                format!("strokes of {} for the tip positions in {path}", scene.name)
            }
        };
        Metadata {
            scene_hash: scene.hash.clone(),
            seed: Some(scene.seed),
            commit: COMMIT.to_owned(),
            source,
            command: context.command.clone(),
            extra,
        }
    }

    /// Warns where the samples are not evenly apart.
    pub fn warn(&self) {
        if self.samples.n_samples() >= 3 && self.samples.rate_hz().is_none() {
            tracing::warn!("{}: the time steps differ by more than 1 %", self.path.display());
        }
    }
}

/// Duration of a sample of a recording read from `path` [s], all the same.
///
/// # Errors
/// `BadInput` where the steps are uneven.
pub fn sample_duration(samples: &Recording, path: &Path) -> Result<f64, BadInput> {
    samples.rate_hz().map(f64::recip).ok_or_else(|| {
        BadInput::new(format!("{}: time_s", path.display()), "a fixed rate, for the network", "uneven steps")
            .hint("resample the commands")
    })
}
