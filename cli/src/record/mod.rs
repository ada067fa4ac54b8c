//! `hysteron record`: a plan becomes recordings.

mod live;
mod simulated;
pub mod source;
mod summary;

use std::path::{Path, PathBuf};

use hysteron_base::{BadInput, Metadata, Recording, file};
use hysteron_control::{Limits, Plan, Trajectory};
use hysteron_rig::calibration::Calibration;
use hysteron_rig::config::RigConfig;

use crate::figures::data_set::{self, DataSet};
use crate::{interrupt, terminal};
use source::Source;
pub use summary::Row;
use summary::Summary;

const HELP: &str = "\
RIG is a rig file, for a rig on its ports, real or emulated (`hysteron rig emulate`); it must be calibrated \
(`hysteron rig calibrate`). Or it is a virtual rig in this process, much faster than real time: virtual:mild, \
virtual:typical, virtual:harsh, virtual:ROBOT.toml (a copy of a file in rig/presets), and virtual:typical/7 for member \
7 of its population. docs/rig.md is the guide for real ones.

PLAN is a plan file (control/README.md), or the name of one that is built in: quick (a minute: sinusoid, diagonal, \
circle, square, ellipse) or paper (18 trajectories with 258 000 samples, and three to check with: 50 minutes). The \
whole plan is checked against the rig's limits before anything moves.

Writes one recording per trajectory: commanded strokes, positions, loads, the tip in the robot's frame, at the plan's \
rate on one clock; rows that were filled in are marked. Beside them the log of events, and for a folder the plan, the \
rig, the calibration and a report. While a run lasts, its rows are in a .journal that survives a crash; \
`hysteron rig recover` opens it. Run the command again to go on: trajectories that are there are not repeated, and \
the rows of one that was cut short are kept beside it as NAME.partial-1.parquet.

However a run ends, the torque is switched off (or held, motion.at_end): by limit, error, Ctrl-C, SIGTERM or kill. Only \
where the servos cannot be reached, because the USB cable is out or the computer is off, they stop and hold: switch \
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
    #[arg(long, value_name = "PLAN")]
    plan: String,
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

/// Angles of tendons that differ by less than this are meant to be the same [rad].
const SAME_ANGLE: f64 = 1e-3;

/// One trajectory and where its recording goes.
struct Job<'a> {
    /// Place in the plan.
    order: usize,
    trajectory: &'a Trajectory,
    commands: Recording,
    out: PathBuf,
}

/// A trajectory whose recording is there.
type Done<'a> = (Job<'a>, Recording);

/// Carries out the verb.
pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let source = Source::read(&arguments.rig)?;
    let (plan, plan_text) = read_plan(&arguments.plan)?;
    check_against_rig(&plan, &source)?;
    let jobs = jobs(arguments, &plan)?;
    let folder = is_folder(&arguments.out).then_some(arguments.out.as_path());
    let (there, missing) = split_done(jobs)?;
    let n_samples: usize = missing.iter().map(|job| job.trajectory.n_samples()).sum();
    tracing::info!(
        "plan {}: {} trajectories, {} samples, {:.0} s; {} are there already",
        plan.name,
        there.len() + missing.len(),
        n_samples,
        missing.iter().map(|job| job.trajectory.duration()).sum::<f64>(),
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
        let meta = |job: &Job<'_>, calibration: &Calibration| metadata(&source, arguments, job, calibration);
        match &source {
            Source::Live { .. } => live::record(&source, arguments, &missing, folder, &meta, &mut summary),
            Source::Virtual { .. } => {
                simulated::record(&source, arguments, &missing, folder, &meta, &mut summary)
            }
        }
    };
    if let Some(folder) = folder.filter(|_| summary.n_rows() > 0) {
        source.write_description(folder)?;
        file::write_bytes(&folder.join("plan.toml"), plan_text)?;
    }
    summary.sort();
    summary.print();
    if let Some(figures) = arguments.figures.as_deref().or(folder).filter(|_| summary.n_rows() > 0) {
        let recordings = summary.recordings()?;
        let angles: Vec<f64> = source.rig().tendons.iter().map(|tendon| tendon.angle).collect();
        let title = format!("{}: plan {}", source.description(), plan.name);
        let data = DataSet { title: &title, angles: &angles, rows: summary.rows(), recordings: &recordings };
        data_set::write(figures, &data, arguments.png)?;
        terminal::say(format_args!("report: {}", figures.join("report.html").display()));
    }
    ended
}

/// A plan and its text, which goes beside the data: what was carried out, whatever becomes of the file meanwhile.
fn read_plan(named: &str) -> anyhow::Result<(Plan, String)> {
    if Path::new(named).extension().is_some() {
        let text = file::read_text(Path::new(named))?;
        return Ok((Plan::from_toml(&text, named)?, text));
    }
    let plan = Plan::named(named)?;
    Ok((plan, Plan::text(named).unwrap_or_default().to_owned()))
}

/// Refuses a plan that would pass a limit of the rig, before anything moves.
fn check_against_rig(plan: &Plan, source: &Source) -> anyhow::Result<()> {
    let rig = source.rig();
    let n = plan.trajectories().first().map_or(0, |trajectory| trajectory.tendons.angles.len());
    if n != rig.tendons.len() {
        return Err(BadInput::new(
            format!("plan {}: tendon_angles_deg", plan.name),
            format!("{} tendons, as rig \"{}\" has", rig.tendons.len(), rig.name),
            n.to_string(),
        )
        .into());
    }
    check_angles(plan, rig)?;
    let limits = Limits {
        stroke: hysteron_base::Bounds { min: rig.limits.stroke_min, max: rig.limits.stroke_max },
        stroke_rate: rig.limits.stroke_rate_max,
    };
    plan.check(&limits).map_err(|error| {
        anyhow::Error::new(error.within(format!("plan {} on rig \"{}\"", plan.name, rig.name)))
    })
}

/// Refuses a plan made for tendons that run elsewhere.
fn check_angles(plan: &Plan, rig: &RigConfig) -> Result<(), BadInput> {
    let Some(trajectory) = plan.trajectories().first() else { return Ok(()) };
    let angles = trajectory.tendons.angles.iter().zip(&rig.tendons).enumerate();
    for (k, (planned, tendon)) in angles {
        let apart = (planned - tendon.angle).sin().hypot((planned - tendon.angle).cos() - 1.0);
        if apart > SAME_ANGLE {
            return Err(BadInput::new(
                format!("plan {}: tendon_angles_deg[{k}]", plan.name),
                format!(
                    "{:.1}, as tendon[{}].angle_deg of rig \"{}\"",
                    tendon.angle.to_degrees(),
                    k + 1,
                    rig.name
                ),
                format!("{:.1}", planned.to_degrees()),
            ));
        }
    }
    Ok(())
}

fn jobs<'a>(arguments: &Arguments, plan: &'a Plan) -> anyhow::Result<Vec<Job<'a>>> {
    let all = plan.trajectories();
    if let Some(unknown) = arguments.only.iter().find(|name| all.iter().all(|t| t.name != **name)) {
        let names: Vec<&str> = all.iter().map(|trajectory| trajectory.name.as_str()).collect();
        return Err(
            BadInput::new("--only", format!("of {}", names.join(", ")), format!("\"{unknown}\"")).into()
        );
    }
    let chosen: Vec<(usize, &Trajectory)> = all
        .iter()
        .enumerate()
        .filter(|(_, t)| arguments.only.is_empty() || arguments.only.contains(&t.name))
        .collect();
    let to_folder = is_folder(&arguments.out);
    if !to_folder && chosen.len() != 1 {
        return Err(BadInput::new(
            format!("--out {}", arguments.out.display()),
            format!("a folder, for {} trajectories", chosen.len()),
            "a file",
        )
        .hint("or choose one of them with --only")
        .into());
    }
    chosen
        .into_iter()
        .map(|(order, trajectory)| {
            let out = if to_folder {
                arguments.out.join(format!("{}.parquet", trajectory.name))
            } else {
                arguments.out.clone()
            };
            Ok(Job { order, trajectory, commands: trajectory.commands()?, out })
        })
        .collect()
}

fn is_folder(out: &Path) -> bool {
    !matches!(out.extension().and_then(|ending| ending.to_str()), Some("parquet" | "csv"))
}

/// Separates the trajectories whose recordings are there from those that are missing.
fn split_done(jobs: Vec<Job<'_>>) -> anyhow::Result<(Vec<Done<'_>>, Vec<Job<'_>>)> {
    let (mut there, mut missing) = (Vec::new(), Vec::new());
    for job in jobs {
        if !job.out.exists() {
            missing.push(job);
            continue;
        }
        let recording = Recording::read(&job.out)?;
        let key = "plan.sha256";
        let (found, expected) = (recording.meta().extra.get(key), job.commands.meta().extra.get(key));
        if found != expected || recording.n_samples() < job.commands.n_samples() {
            let found = if found == expected { "an incomplete one" } else { "one of another plan" };
            return Err(BadInput::new(job.out.display().to_string(), "a recording of this plan", found)
                .hint("a measurement is never overwritten; move it away or choose another --out")
                .into());
        }
        there.push((job, recording));
    }
    Ok((there, missing))
}

/// Provenance of a recording.
fn metadata(source: &Source, arguments: &Arguments, job: &Job<'_>, calibration: &Calibration) -> Metadata {
    let mut meta = job.commands.meta().clone();
    meta.scene_hash = String::new();
    meta.source = format!("{}, {}", source.description(), job.commands.meta().source);
    meta.commit = env!("HYSTERON_COMMIT").to_owned();
    meta.command = terminal::command_line();
    let mut say = |key: &str, value: String| meta.extra.insert(key.to_owned(), value);
    say("rig.name", source.rig().name.clone());
    say("rig.sha256", source.rig().hash.clone());
    say("calibration.date", calibration.date.clone());
    say("calibration.sha256", file::sha256_hex(calibration.to_toml().as_bytes()));
    if let Source::Virtual { name, .. } = source {
        say("virtual.robot", name.clone());
        say("virtual.seed", arguments.seed.to_string());
    }
    meta
}
