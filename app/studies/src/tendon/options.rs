//! Options that studies of tendon robots share.

use std::path::{Path, PathBuf};

use hysteron_base::BadInput;

/// Output folder and size of a study.
#[derive(Debug, Clone, clap::Args)]
pub struct Options {
    /// Folder to write to; studies of the virtual robot typical share their recordings in the folder typical next to it
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// A small, fast version, to check that it runs
    #[arg(long)]
    pub quick: bool,
    /// Root of a checkout of the project, whose meshes and reference curves are read
    #[arg(long, value_name = "DIR", default_value = ".")]
    pub repository: PathBuf,
}

/// Options of a study of recordings that are not part of the project.
#[derive(Debug, Clone, clap::Args)]
pub struct DataOptions {
    /// Folder of the recordings [default: HYSTERON_DATA, or ../shared/data]
    #[arg(long, value_name = "DIR")]
    pub data: Option<PathBuf>,
    /// As of all studies of tendon robots.
    #[command(flatten)]
    pub shared: Options,
}

/// Options of the study of a population.
#[derive(Debug, Clone, clap::Args)]
pub struct PopulationOptions {
    /// How many robots of the population [default: all that are left]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    pub robots: Option<u64>,
    /// The first robot of the population: machines can share it
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u64).range(1..))]
    pub first: u64,
    /// As of all studies of tendon robots.
    #[command(flatten)]
    pub shared: Options,
}

impl DataOptions {
    /// A file or folder of the recordings; none where it is not there.
    pub(super) fn find(&self, name: &str) -> Option<PathBuf> {
        Some(self.path(name)).filter(|path| path.exists())
    }

    /// A file or folder of the recordings that must be there.
    ///
    /// # Errors
    /// `BadInput` where it is not.
    pub(super) fn require(&self, name: &str) -> Result<PathBuf, BadInput> {
        self.find(name).ok_or_else(|| missing(&self.path(name)))
    }

    fn path(&self, name: &str) -> PathBuf {
        let folder = self.data.clone().or_else(|| std::env::var_os("HYSTERON_DATA").map(PathBuf::from));
        folder.unwrap_or_else(|| PathBuf::from("../shared/data")).join(name)
    }
}

/// The error where recordings are missing.
pub(super) fn missing(path: &Path) -> BadInput {
    let found = format!("no {}", path.display());
    BadInput::new("--data", "the folder of the recordings", found).hint("bench/README.md names their sources")
}
