//! `hysteron demo`: a small study whose files are part of the program.

use std::path::{Path, PathBuf};

use hysteron_base::{BadInput, file};

use super::carry_out;

/// The files of the study, by their path in its folder.
const FILES: [(&str, &[u8]); 5] = [
    (STUDY, include_bytes!("../../studies/demo/study.toml")),
    ("plan.toml", include_bytes!("../../studies/demo/plan.toml")),
    ("more.toml", include_bytes!("../../studies/demo/more.toml")),
    ("robot/scene.toml", include_bytes!("../../../meshes/tpu80/scene-typical-friction.toml")),
    ("robot/tpu80.msh", include_bytes!("../../../meshes/tpu80/tpu80.msh")),
];
const STUDY: &str = "study.toml";

const HELP: &str = "\
Needs nothing: robot, plan and study are part of the program and are written to DIR first; the rig is a virtual one, with \
physics of its own. It is recorded, its twin is fitted to it and learns its hysteresis, and strokes found with the \
twin and with a network lead its tip along paths that nobody has learned, beside those of a twin that has learned \
nothing.

Writes DIR/report.html, to open in a browser, DIR/metrics.json, and what every stage wrote. Ctrl-C at any time: the same \
command goes on.

Examples, in any folder; the second after you have changed a number in the study:
  hysteron demo
  hysteron run out/demo/study.toml

Exit codes: 0 done, 1 failed or interrupted (run it again to go on), 2 bad input.";

/// See the whole chain in some minutes: a virtual robot is recorded, learned and led along paths
#[derive(Debug, clap::Args)]
#[command(after_help = HELP)]
pub struct Arguments {
    /// Folder to write to
    #[arg(long, value_name = "DIR", default_value = "out/demo")]
    out: PathBuf,
}

/// Carries out the verb.
pub fn run(arguments: &Arguments, passed_on: &[String]) -> anyhow::Result<()> {
    for (name, bytes) in FILES {
        write_once(&arguments.out.join(name), bytes)?;
    }
    carry_out(&arguments.out.join(STUDY), Some(&arguments.out), passed_on)
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
        .hint("hysteron run carries out a study of your own; or choose another --out")
        .into())
}
