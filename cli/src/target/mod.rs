//! `hysteron target`: a path for the tip, sampled; and whether a robot reaches it.

pub mod reach;

use std::path::PathBuf;

use anyhow::Context;
use hysteron_base::{BadInput, Metadata, Recording, Scene};
use hysteron_control::TargetPath;

use crate::outputs::Outputs;
use crate::{figures, number, terminal};
use reach::Reach;

const HELP: &str = "\
PATH is one of
  a curve with its size in mm: circle:40 (diameter), diamond:60 (diagonal), square:50 (side), lissajous:56 (height; \
width 0.9 of it, x to y as 1 to 2), figure_eight:60 (width), ellipse:40 (length; height 0.6 of it), rose:40 (outer \
diameter, 4 petals), spiral:40 (outer diameter, 3 turns)
  a target file, .toml: the same with timing, place and rotation, and polylines (docs/control.md has all keys)
  an outline of your own, .csv with the columns x_mm,y_mm (or _m; z too), or .svg with one shape: its width in mm, cm, \
in, pt or pc over the width of its viewBox is a unit of the drawing
  a recording that this verb wrote, .parquet or .csv

The path begins and ends where the tip rests, at (0, 0): rest, a smooth way to the curve, the curve at one speed with \
smooth start and end, and back. x and y count; z is free unless given. Curves without a target file run at 10 mm/s and \
100 Hz, with 1 s of rest, 3 s for the way and ramps of 1 s.

Writes a recording: time_s, tip_x_m, tip_y_m (and tip_z_m), relative to rest; its metadata say when the curve begins \
and ends, which is what `hysteron evaluate` measures. With --scene, the twin of that robot is first taken along the \
curve, a goal every millimetre or 150 in all, within the bounds of stroke and tension, and fewer once one is out of reach; \
the error then says how much, --figures shows where, and no recording is written.

Example, from the root of the repository
  hysteron target circle:40 --out out/reached40.parquet \\
      --scene meshes/tpu80/scene.toml --figures out/circle40

Exit codes: 0 done, 1 failed or interrupted, 2 bad input, or a target out of reach.";

/// Sample a path for the tip, and check that a robot reaches it
#[derive(Debug, clap::Args)]
#[command(after_help = HELP)]
pub struct Arguments {
    /// Target: FAMILY:SIZE_MM, or a file (.toml, .svg, .csv, .parquet)
    #[arg(value_name = "PATH")]
    target: String,
    /// Recording to write, .parquet or .csv
    #[arg(long, value_name = "REC")]
    out: PathBuf,
    /// Scene of a robot whose twin must reach it
    #[arg(long, value_name = "SCENE")]
    scene: Option<PathBuf>,
    /// Distance that counts as reached
    #[arg(long, value_name = "MM", default_value_t = 0.1, requires = "scene", value_parser = number::length_mm)]
    tolerance_mm: f64,
    /// Folder for the figure, report.html and metrics.json
    #[arg(long, value_name = "DIR")]
    figures: Option<PathBuf>,
    /// Write the figure as .png too
    #[arg(long, requires = "figures")]
    png: bool,
}

/// Carries out the verb.
pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    check_arguments(arguments)?;
    let target = TargetPath::open(&arguments.target)?;
    let scene = arguments.scene.as_deref().map(Scene::read).transpose()?;
    let outputs = Outputs::default().target(&arguments.target)?.file("--out", &arguments.out);
    let mut outputs = outputs.report("--figures", arguments.figures.as_deref());
    if let (Some(path), Some(scene)) = (&arguments.scene, &scene) {
        outputs = outputs.scene(path, scene);
    }
    let _claim = outputs.check()?;
    let reach = match &scene {
        Some(scene) => Some(Reach::of(&target, scene, 1e-3 * arguments.tolerance_mm)?),
        None => None,
    };
    figures::target::summarise(&target, reach.as_ref())?;
    if let Some(folder) = &arguments.figures {
        figures::target::write(folder, &target, reach.as_ref(), arguments.png)
            .with_context(|| format!("writing figures to {}", folder.display()))?;
    }
    if let Some(reach) = &reach {
        let hint = match &arguments.figures {
            Some(folder) => format!("{} shows where", folder.join("target.svg").display()),
            None => "a smaller size_mm; --figures DIR shows where".to_owned(),
        };
        reach.check(&target, hint)?;
        tracing::info!(
            "{}: {} points within {} mm, the farthest off by {:.3} mm, tensions up to {:.1} N",
            reach.scene,
            reach.goals,
            arguments.tolerance_mm,
            1e3 * reach.largest_distance_m,
            reach.tension_max_n
        );
    }
    let recording = target.recording()?;
    let meta = Metadata {
        commit: env!("HYSTERON_COMMIT").to_owned(),
        command: terminal::command_line(),
        scene_hash: scene.map_or_else(String::new, |scene| scene.hash),
        ..recording.meta().clone()
    };
    let recording = Recording::new(recording.time().to_vec(), recording.channels().to_vec(), vec![], meta)?;
    recording.write(&arguments.out)?;
    terminal::say(arguments.out.display());
    Ok(())
}

fn check_arguments(arguments: &Arguments) -> Result<(), BadInput> {
    match arguments.out.extension().and_then(|ending| ending.to_str()) {
        Some("csv" | "parquet") => Ok(()),
        _ => Err(BadInput::new(
            "--out",
            "a name ending in .parquet or .csv",
            arguments.out.display().to_string(),
        )),
    }
}
