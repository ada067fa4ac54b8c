//! `arm identify payload`: what an arm carries.

use std::path::PathBuf;

use hysteron_arm::identify::{BodyOptions, identify_bodies, identify_payload};
use hysteron_base::json;
use hysteron_report::verdict::{Criterion, Verdict};
use serde_json::Value;

use super::{MotionOptions, Results, Row, Summary, TERMS, rows_json, say_rows};
use crate::figures::arm_identification as figures;
use crate::shared::robot_file::{self, Part};
use crate::shared::verdict::ratio;
use crate::{Context, arm};

/// What an arm carries
#[derive(Debug, Clone)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct Options {
    /// File of URDF or MJCF, or name of a built-in robot
    pub model: String,
    /// How the robot is read
    #[cfg_attr(feature = "clap", command(flatten))]
    pub robot_options: crate::arm::RobotOptions,
    /// Recordings with the payload
    #[cfg_attr(feature = "clap", arg(required = true, value_name = "REC"))]
    pub recordings: Vec<PathBuf>,
    /// Recordings without
    #[cfg_attr(feature = "clap", arg(long, required = true, value_name = "REC", num_args = 1..))]
    pub bare: Vec<PathBuf>,
    /// Frame that holds the payload [default: the robot's last]
    #[cfg_attr(feature = "clap", arg(long, value_name = "NAME"))]
    pub frame: Option<String>,
    /// File for the robot as identified: .urdf, .xml (MJCF) or .csv (parameters)
    #[cfg_attr(feature = "clap", arg(long, value_name = "FILE"))]
    pub robot: Option<PathBuf>,
    /// How they are read.
    #[cfg_attr(feature = "clap", command(flatten))]
    pub motion: MotionOptions,
    /// Where the results go.
    #[cfg_attr(feature = "clap", command(flatten))]
    pub results: Results,
}

/// Carries out the verb.
///
/// # Errors
/// `BadInput` for whatever is wrong with options or recordings.
pub fn run(options: &Options, context: &Context) -> anyhow::Result<Value> {
    let model = &options.motion.model(&options.model, (&options.robot_options, context))?;
    let inputs = arm::reads(&options.model).and(&options.bare).and(&options.recordings);
    let inputs = options.robot.iter().fold(inputs, |all, path| all.file("--robot", path));
    let _claim = options.results.claim(inputs, context)?;
    if let Some(path) = &options.robot {
        robot_file::check("--robot", path, Part::Whole)?;
    }
    options.motion.check()?;
    let last = model.frames().last().map_or("", |frame| frame.name.as_str());
    let frame = options.frame.as_deref().unwrap_or(last);
    model.frame(frame)?;
    let findings = super::checked(&[&options.bare[..], &options.recordings].concat(), Some(model))?;
    let bare = options.motion.read_all(&options.bare, model)?;
    let loaded = options.motion.read_all(&options.recordings, model)?;
    let known = identify_bodies(
        model,
        &bare,
        &BodyOptions { terms: &TERMS, width: options.motion.width, prior: 1.0 },
    )?;
    let found = identify_payload(&known, frame, &loaded)?;
    let rows: Vec<Row> = found.estimates.iter().map(Row::of_term).collect();
    context.print(format_args!("payload at {frame}, in its axes:"));
    say_rows(&rows, context);
    context.print(format_args!("error of the torques without it, RMS by joint [N m]: {:.4?}", found.rms[0]));
    context.print(format_args!("with it: {:.4?}", found.rms[1]));
    context.print(format_args!("of the bare arm: {:.4?}", known.rms));
    let numbers = json!({
        "robot": model.name(), "frame": frame, "estimates": rows_json(&rows), "rms_without_n_m": found.rms[0],
        "rms_with_n_m": found.rms[1], "rms_bare_n_m": known.rms, "samples": loaded.n_samples(),
        "cutoff_hz": options.motion.cutoff, "verdict": verdict(&rows, &found.rms),
    });
    let summary = Summary::new(numbers, findings, context);
    if let Some(folder) = &options.results.figures {
        let page = figures::payload::Shown {
            model,
            frame,
            rows: &rows,
            rms: [&known.rms, &found.rms[0], &found.rms[1]],
        };
        figures::payload::write(folder, &page, &summary, options.results.png, context)?;
    }
    if let Some(path) = &options.robot {
        robot_file::write(&found.model, path, Part::Whole, context)?;
        context.wrote(path);
    }
    options.results.write(summary, context)
}

/// Whether the payload can be used: errors of the torques without and with it, by joint [N m].
fn verdict(rows: &[Row], rms: &[Vec<f64>; 2]) -> Verdict {
    let size = |errors: &[f64]| errors.iter().map(|e| e * e).sum::<f64>().sqrt();
    let (without, with) = (size(&rms[0]), size(&rms[1]));
    // The mass comes first.
    let mass = rows.first();
    let claim = mass.map_or_else(String::new, |row| format!("{} is {:.4}", row.name, row.value));
    let relative = mass.and_then(|row| Some(row.standard_error? / row.value.abs()));
    Verdict::on(claim)
        .because(
            Criterion::ErrorOverBaseline,
            ratio(with, without),
            format!("the torques are off by {with:.4} N m with the payload, {without:.4} N m without"),
        )
        .because_of(Criterion::RelativeStandardError, relative, |error| {
            format!("the mass has a standard error of {:.0} % of its value", 100.0 * error)
        })
        .verdict()
}
