//! `hysteron record`: a plan becomes recordings.

mod aside;
pub mod jobs;
mod live;
mod simulated;
pub mod source;
mod summary;

use std::path::{Path, PathBuf};

use hysteron_base::{Lock, Metadata};
use hysteron_rig::calibration::Calibration;

use crate::figures::data_set::{self, DataSet};
use crate::{interrupt, terminal};
use jobs::{Job, is_folder, split_done};
use source::Source;
pub use summary::Row;
use summary::Summary;

const HELP: &str = "\
RIG is a rig file, for a rig on its ports, real or emulated (`hysteron rig emulate`); it must be calibrated \
(`hysteron rig calibrate`). Or it is a virtual rig in this process, much faster than real time: virtual:mild, \
virtual:typical, virtual:harsh, virtual:ROBOT.toml (a copy of a file in rig/presets), and virtual:typical/7 for member \
7 of its population; virtual:wide/7 is one of a wide population (docs/virtual-rig.md). docs/rig.md is the guide for real ones.

PLAN is a plan file (control/README.md), or the name of one that is built in: quick (a minute: sinusoid, diagonal, \
circle, square, ellipse) or paper (18 trajectories with 258 000 samples, and three to check with: 50 minutes). The \
whole plan is checked against the rig's limits before anything moves. So are strokes of your own (--strokes): those of \
`hysteron command` or `hysteron reach`, or any recording with stroke_1_mm, .. that begins and ends at rest.

Writes one recording per trajectory: commanded strokes, positions, loads, the tip in the robot's frame, at the plan's \
rate on one clock; rows that were filled in are marked. Beside them the log of events, and for a folder the plan, the \
rig, the calibration and a report; a folder of another rig, plan or seed is refused, and so is one that another \
command is writing. While a run lasts, its rows are in a .journal that survives a crash; \
`hysteron rig recover` opens it. Run the command again to go on: trajectories that are there are not repeated, and \
the rows of one that was cut short are kept beside it as NAME.partial-1.parquet.

However a run ends, by limit, error, Ctrl-C, SIGTERM or kill, the torque is switched off; motion.at_end = \"hold\" \
leaves it on after a run that came to its end. Only where the servos cannot be reached, because the USB cable is out or the computer is off, they stop and hold: switch \
the supply off.

Examples, from the root of the repository:
  hysteron record --rig virtual:typical --plan quick --out out/quick
  hysteron record --rig virtual:typical --plan paper --out out/paper --figures out/paper/figures
  hysteron rig emulate --preset typical --dir out/rig &
  hysteron rig calibrate --rig out/rig/rig.toml
  hysteron record --rig out/rig/rig.toml --plan quick --only circle --out out/circle.parquet

Exit codes: 0 done, 1 failed, stopped or a limit was passed (what was measured is kept), 2 bad input.";

/// Carry out a plan on a rig and record what happens
#[derive(Debug, clap::Args)]
#[command(after_help = HELP)]
pub struct Arguments {
    /// Rig file, or virtual:PRESET
    #[arg(long, value_name = "RIG")]
    rig: PathBuf,
    /// Plan file (.toml), or the name of a built-in plan
    #[arg(long, value_name = "PLAN", required_unless_present = "strokes")]
    plan: Option<String>,
    /// Strokes to carry out instead of a plan: recordings with stroke_1_m, .., or folders of them
    #[arg(long, value_name = "REC", num_args = 1.., conflicts_with_all = ["plan", "only"])]
    strokes: Vec<PathBuf>,
    /// Folder for the recordings; for a single trajectory also a file, .parquet or .csv
    #[arg(long, value_name = "OUT")]
    out: PathBuf,
    /// Only these trajectories of the plan, by name
    #[arg(long, value_name = "NAME,...", value_delimiter = ',')]
    only: Vec<String>,
    /// Calibration [default: the file that the rig file names; a virtual rig calibrates itself]
    #[arg(long, value_name = "FILE")]
    calibration: Option<PathBuf>,
    /// Seed of a virtual rig's noise and of where its servos wake up
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Folder for figures, report.html and metrics.json [default: OUT, where it is a folder]
    #[arg(long, value_name = "DIR")]
    figures: Option<PathBuf>,
    /// Write each figure as .png too
    #[arg(long)]
    png: bool,
}

impl Arguments {
    /// Strokes of one recording, on a rig, into one file.
    pub fn of_strokes(
        rig: &Path,
        strokes: &Path,
        out: &Path,
        calibration: Option<PathBuf>,
        seed: u64,
    ) -> Self {
        Self {
            rig: rig.to_owned(),
            plan: None,
            strokes: vec![strokes.to_owned()],
            out: out.to_owned(),
            only: Vec::new(),
            calibration,
            seed,
            figures: None,
            png: false,
        }
    }
}

/// Carries out the verb.
pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let source = Source::read(&arguments.rig)?;
    let work = match &arguments.plan {
        Some(plan) => jobs::of_plan(plan, arguments, &source)?,
        None => jobs::of_strokes(arguments, &source)?,
    };
    let folder = is_folder(&arguments.out).then_some(arguments.out.as_path());
    let calibration = source.calibration(arguments.calibration.as_ref())?;
    // Until all is done: the folder, and each file for those who name it alone.
    let _folder = folder.map(Lock::folder).transpose()?;
    let _files = work.jobs.iter().map(|job| Lock::file(&job.out)).collect::<Result<Vec<_>, _>>()?;
    let mut description = source.description_files();
    description.extend(work.plan_text.map(|text| ("plan.toml", text)));
    let (there, missing) = split_done(work.jobs, &source.identity(arguments.seed, calibration.as_ref()))?;
    if let Some(folder) = folder {
        source::check_description(folder, &description)?;
    }
    for (job, recording) in &there {
        aside::clear_journal(&job.out, recording)?;
    }
    tracing::info!(
        "{}: {} trajectories, {} samples, {:.0} s; {} are there already",
        work.name,
        there.len() + missing.len(),
        missing.iter().map(|job| job.commands.n_samples()).sum::<usize>(),
        missing.iter().map(|job| job.commands.n_samples() as f64 / job.rate_hz).sum::<f64>(),
        there.len(),
    );
    interrupt::listen()?;
    let mut summary = Summary::default();
    for (job, recording) in &there {
        summary.add_there(job, recording);
    }
    let ended = if missing.is_empty() {
        Ok(())
    } else {
        let meta = |job: &Job, calibration: &Calibration| metadata(&source, arguments, job, calibration);
        match (&source, calibration) {
            (Source::Live { .. }, Some(calibration)) => {
                if let Some(folder) = folder {
                    source::keep_calibration(folder, &calibration)?;
                }
                live::record(&source, arguments, &missing, &calibration, &meta, &mut summary)
            }
            (_, given) => {
                simulated::record(&source, arguments, &missing, (given, folder), &meta, &mut summary)
            }
        }
    };
    if let Some(folder) = folder.filter(|_| summary.n_rows() > 0) {
        source::write_description(folder, &description)?;
    }
    summary.sort();
    summary.print();
    if let Some(figures) = arguments.figures.as_deref().or(folder).filter(|_| summary.n_rows() > 0) {
        let recordings = summary.recordings()?;
        let angles: Vec<f64> = source.rig().tendons.iter().map(|tendon| tendon.angle).collect();
        let title = format!("{}: {}", source.description(), work.name);
        let data = DataSet { title: &title, angles: &angles, rows: summary.rows(), recordings: &recordings };
        data_set::write(figures, &data, arguments.png)?;
        terminal::say(format_args!("report: {}", figures.join("report.html").display()));
    }
    ended
}

/// Provenance of a recording.
fn metadata(source: &Source, arguments: &Arguments, job: &Job, calibration: &Calibration) -> Metadata {
    let mut meta = job.commands.meta().clone();
    meta.scene_hash = String::new();
    meta.source = format!("{}, {}", source.description(), job.commands.meta().source);
    meta.commit = env!("HYSTERON_COMMIT").to_owned();
    meta.command = terminal::command_line();
    let mut say = |key: &str, value: String| meta.extra.insert(key.to_owned(), value);
    say("rig.name", source.rig().name.clone());
    say("calibration.date", calibration.date.clone());
    if let Source::Virtual { name, .. } = source {
        say("virtual.robot", name.clone());
    }
    for (key, value) in source.identity(arguments.seed, Some(calibration)) {
        say(key, value);
    }
    meta
}
