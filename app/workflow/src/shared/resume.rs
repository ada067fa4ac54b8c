//! Files that an interrupted training leaves next to its checkpoint.

use crate::Context;
use crate::shared::error::Cancelled;
use std::path::{Path, PathBuf};

/// A checkpoint, and the files from which its training resumes.
pub struct Unfinished {
    out: PathBuf,
    /// One for each network; none where nothing can be resumed.
    pub files: Vec<PathBuf>,
}

impl Unfinished {
    /// Says so where an earlier run has left some of `files`.
    pub fn new(out: &Path, files: Vec<PathBuf>) -> Self {
        for file in files.iter().filter(|file| file.exists()) {
            tracing::info!("going on from {}", file.display());
        }
        Self { out: out.to_owned(), files }
    }

    /// Error of a training that ended before there was a checkpoint to write.
    pub fn nothing_written(&self) -> anyhow::Error {
        let then = self.then();
        Cancelled::new(format!("; nothing is written but the files of the training; the same command {then}"))
            .into()
    }

    /// Description of the next step of the same command.
    fn then(&self) -> String {
        let there = self.files.iter().filter(|file| file.exists());
        let names: Vec<String> = there.map(|file| file.display().to_string()).collect();
        if names.is_empty() {
            "begins again".to_owned()
        } else {
            format!("goes on from {}", names.join(", "))
        }
    }

    /// The checkpoint is written. A training that is finished needs its files no more; one that is not has failed.
    pub fn end(&self, is_finished: bool, context: &Context) -> anyhow::Result<()> {
        let out = self.out.display();
        if !is_finished {
            let then = self.then();
            return Err(Cancelled::new(format!(
                "; the best weights so far are in {out}; the same command {then}"
            ))
            .into());
        }
        for file in self.files.iter().filter(|file| file.exists()) {
            std::fs::remove_file(file)?;
        }
        context.print(out);
        Ok(())
    }
}
