//! `hysteron track`: a path, its strokes, the rig, and how closely the tip followed; open loop.

use std::path::{Path, PathBuf};

use hysteron_base::{BadInput, Recording};
use hysteron_control::path::is_recording;
use serde_json::json;

use crate::command::{Given, Way};
use crate::evaluate::{self, Commanded};
use crate::record::{self, source::Source};
use crate::{number, terminal};

const HELP: &str = "\
`hysteron command`, `hysteron record` and `hysteron evaluate` in one: finds the strokes for a path, within the limits of \
the rig, carries them out, and measures how closely the tip followed. The tip sensor only watches; nothing is fed back. \
The strokes come from a network (a checkpoint by `hysteron train`), or, with --scene, from the robot's twin (with a \
checkpoint by `hysteron fit-residual`, or the twin of the scene \
without one; with --nominal, without what is fitted of that scene).

PATH is a target (`hysteron target --help`: circle:40, a .toml, an .svg) or a recording of where a tip went.

Writes to DIR strokes.parquet, a recording of every repeat, repeat-1.parquet, ..., and for a target report.html, \
metrics.json and an overlay of target and tip; they say for how much of the path a network was outside its training, and a limit \
held a stroke back. What is recorded is never repeated or overwritten: the same command goes \
on where an earlier one was cut short.

Examples, from the root of the repository:
  hysteron track --rig virtual:typical --scene meshes/tpu80/scene.toml --nominal \\
      --target circle:30 --out out/nominal
  hysteron track --rig virtual:typical out/quick/inverse.safetensors --target circle:30 \\
      --repeats 5 --out out/network
  hysteron track --rig virtual:typical out/quick/residual.safetensors \\
      --scene meshes/tpu80/scene-typical.toml \\
      --target circle:40 --out out/calibrated

Exit codes: 0 done, 1 failed, stopped or a limit was passed (what was measured is kept), 2 bad input.";

/// More than anybody measures in a day.
const MOST_REPEATS: usize = 100;

/// Follow a path open loop on a rig, and measure it
#[derive(Debug, clap::Args)]
#[command(after_help = HELP)]
pub struct Arguments {
    #[command(flatten)]
    way: Way,
    /// Rig file, or virtual:PRESET
    #[arg(long, value_name = "RIG")]
    rig: PathBuf,
    /// Folder to write to
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// How often the strokes are carried out
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = number::count::<MOST_REPEATS>)]
    repeats: usize,
    /// Calibration [default: the file that the rig file names; a virtual rig calibrates itself]
    #[arg(long, value_name = "FILE")]
    calibration: Option<PathBuf>,
    /// Seed of a virtual rig's noise; every repeat has the next one
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Write each figure as .png too
    #[arg(long)]
    png: bool,
}

/// Carries out the verb.
pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let rig = Source::read(&arguments.rig)?;
    let limits = &rig.rig().limits;
    let given = Given {
        stroke: [Some(limits.stroke_min), Some(limits.stroke_max)],
        rate: Some(limits.stroke_rate_max),
    };
    let strokes = arguments.out.join("strokes.parquet");
    let repeat = |k: usize| arguments.out.join(format!("repeat-{}.parquet", k + 1));
    let outputs = arguments.way.reads()?.and(Some(&arguments.rig)).and(&arguments.calibration);
    let outputs = outputs.report("--out", Some(&arguments.out));
    let _claim = outputs.file("--out", &strokes).check()?;
    let commanded = arguments.way.strokes(&given)?;
    write_strokes(&commanded, &strokes, (0..arguments.repeats).map(repeat))?;
    let mut tips = Vec::new();
    for k in 0..arguments.repeats {
        let out = repeat(k);
        record::run(&record::Arguments::of_strokes(
            &arguments.rig,
            &strokes,
            &out,
            arguments.calibration.clone(),
            arguments.seed.wrapping_add(k as u64),
        ))?;
        tips.push(out);
    }
    let target = &arguments.way.target;
    if is_recording(target.as_ref())? {
        terminal::say(arguments.out.display());
        return terminal::summarise(&json!({ "out": arguments.out, "repeats": tips }));
    }
    let arguments_of = evaluate::Arguments::of(target, tips, &arguments.out, arguments.png);
    evaluate::run_commanded(&arguments_of, Some(&Commanded::of(&commanded)))?;
    terminal::say(format_args!("report: {}", arguments.out.join("report.html").display()));
    Ok(())
}

/// Writes the strokes; not over others that were carried out.
fn write_strokes(
    found: &Recording,
    path: &Path,
    mut repeats: impl Iterator<Item = PathBuf>,
) -> anyhow::Result<()> {
    let is_there = path.exists();
    if is_there && Recording::read(path)?.channels() == found.channels() {
        return Ok(());
    }
    match repeats.find(|repeat| is_there && repeat.exists()) {
        None => Ok(found.write(path)?),
        Some(repeat) => {
            let expected = format!("the strokes that {} was measured with", repeat.display());
            Err(BadInput::new(
                path.display().to_string(),
                expected,
                "others, for what they are found with has changed",
            )
            .hint("choose another --out")
            .into())
        }
    }
}
