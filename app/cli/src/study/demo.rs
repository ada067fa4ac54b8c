//! `hysteron demo`: a small study whose files are part of the program.

use std::path::{Path, PathBuf};

use hysteron_base::{BadInput, file};
use hysteron_studies::chain::{Options, Outcome};
use hysteron_workflow::{Context, shared::outputs};

use crate::invocation::Relaunch;

/// The files of the study, by their path in its folder.
const FILES: [(&str, &[u8]); 5] = [
    (STUDY, include_bytes!("../../studies/demo/study.toml")),
    ("plan.toml", include_bytes!("../../studies/demo/plan.toml")),
    ("more.toml", include_bytes!("../../studies/demo/more.toml")),
    ("robot/scene.toml", include_bytes!("../../studies/demo/scene.toml")),
    ("robot/tpu80.msh", include_bytes!("../../studies/demo/tpu80.msh")),
];
const STUDY: &str = "study.toml";

/// See the whole chain in some minutes: a virtual robot is recorded, learned and led along paths
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Folder to write to
    #[arg(long, value_name = "DIR", default_value = "out/demo")]
    pub out: PathBuf,
}

/// Runs the verb.
pub fn run(arguments: &Arguments, relaunch: &Relaunch, context: &Context) -> anyhow::Result<Outcome> {
    outputs::check_report("--out", &arguments.out)?;
    for (name, bytes) in FILES {
        write_once(&arguments.out.join(name), bytes)?;
    }
    let options = Options { study: arguments.out.join(STUDY), out: Some(arguments.out.clone()) };
    super::run(&options, relaunch, context)
}

/// Writes a file unless it is there; a person's own is not overwritten.
fn write_once(path: &Path, bytes: &[u8]) -> anyhow::Result<()> {
    if !path.exists() {
        return Ok(file::write_bytes(path, bytes)?);
    }
    if file::read_bytes(path)? == bytes {
        return Ok(());
    }
    let place = path.display().to_string();
    Err(BadInput::new(place, "the file of the demo", "another one")
        .hint("hysteron study run carries out a study of your own; or choose another --out")
        .into())
}
