//! `arm identify payload`: what an arm carries.

use std::path::PathBuf;

use hysteron_arm::Model;
use hysteron_arm::identify::{BodyOptions, identify_bodies, identify_payload};
use serde_json::{Value, json};

use super::{MotionOptions, Results, Row, inertia::TERMS, rows_json, say_rows};
use crate::Caller;
use crate::figures::arm_identification as figures;
use crate::outputs::Outputs;
use crate::robot_file::{self, Part};

/// What is identified from what.
#[derive(Debug, Clone)]
pub struct Options {
    /// The robot without payload, with its locked joints locked.
    pub model: Model,
    /// The file that it came from, if any.
    pub model_file: Option<PathBuf>,
    /// Recordings without the payload: they identify the arm.
    pub bare: Vec<PathBuf>,
    /// Recordings with it.
    pub loaded: Vec<PathBuf>,
    /// Frame that holds it; the robot's last one without.
    pub frame: Option<String>,
    /// How they are read.
    pub motion: MotionOptions,
    /// File of URDF, MJCF or parameters for the robot as identified, if any.
    pub robot: Option<PathBuf>,
    /// Where the results go.
    pub results: Results,
}

/// Carries out the verb.
///
/// # Errors
/// `BadInput` for whatever is wrong with options or recordings.
pub fn run(options: &Options, caller: &Caller) -> anyhow::Result<Value> {
    let inputs = Outputs::reading(&options.model_file).and(&options.bare).and(&options.loaded);
    let inputs = options.robot.iter().fold(inputs, |all, path| all.file("--robot", path));
    let _claim = options.results.claim(inputs, caller)?;
    if let Some(path) = &options.robot {
        robot_file::check("--robot", path, Part::Whole)?;
    }
    options.motion.check()?;
    let model = &options.model;
    let last = model.frames().last().map_or("", |frame| frame.name.as_str());
    let frame = options.frame.as_deref().unwrap_or(last);
    model.frame(frame)?;
    let bare = options.motion.read_all(&options.bare, model)?;
    let loaded = options.motion.read_all(&options.loaded, model)?;
    let known = identify_bodies(
        model,
        &bare,
        &BodyOptions { terms: &TERMS, width: options.motion.width, prior: 1.0 },
    )?;
    let found = identify_payload(&known, frame, &loaded)?;
    let rows: Vec<Row> = found.estimates.iter().map(Row::of_term).collect();
    caller.say(format_args!("payload at {frame}, in its axes:"));
    say_rows(&rows, caller);
    caller.say(format_args!("error of the torques without it, RMS by joint [N m]: {:.4?}", found.rms[0]));
    caller.say(format_args!("with it: {:.4?}", found.rms[1]));
    caller.say(format_args!("of the bare arm: {:.4?}", known.rms));
    let summary = json!({
        "robot": model.name(), "frame": frame, "estimates": rows_json(&rows), "rms_without_n_m": found.rms[0],
        "rms_with_n_m": found.rms[1], "rms_bare_n_m": known.rms, "samples": loaded.n_samples(),
        "cutoff_hz": options.motion.cutoff,
    });
    if let Some(folder) = &options.results.figures {
        let page = figures::payload::Shown {
            model,
            frame,
            rows: &rows,
            rms: [&known.rms, &found.rms[0], &found.rms[1]],
        };
        figures::payload::write(folder, &page, &summary, options.results.png, caller)?;
    }
    if let Some(path) = &options.robot {
        robot_file::write(&found.model, path, Part::Whole, caller)?;
        caller.wrote(path);
    }
    options.results.write(summary, caller)
}
