//! `arm identify`: bodies, friction, drives and payloads of arms from recordings of them.

pub mod friction;
pub mod inertia;
pub mod payload;
pub mod servo;

use std::path::{Path, PathBuf};

use hysteron_arm::identify::{JointMotion, JointTerm};
use hysteron_arm::{ImportOptions, Model, Recorded, import};
use hysteron_base::checks::{CheckContext, Purpose};
use hysteron_base::{BadInput, Metadata, Recording, file, json};
use hysteron_fit::Standing;
use serde_json::Value;

use crate::shared::outputs::Outputs;
use crate::shared::recording_checks::{self, Findings};
use crate::shared::verdict::{Judged, Kind};
use crate::{COMMIT, Context, arm};

/// Order of the low pass of motions.
const ORDER: usize = 4;

/// Parameters of every joint in addition to those of its body.
pub const TERMS: [JointTerm; 5] =
    [JointTerm::Armature, JointTerm::Coulomb, JointTerm::Viscous, JointTerm::Offset, JointTerm::Spring];

/// Where results go.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct Results {
    /// File of JSON to write
    #[cfg_attr(feature = "clap", arg(long, value_name = "FILE"))]
    pub out: PathBuf,
    /// Folder for figures, report.html and metrics.json
    #[cfg_attr(feature = "clap", arg(long, value_name = "DIR"))]
    pub figures: Option<PathBuf>,
    /// Write each figure as .png too
    #[cfg_attr(feature = "clap", arg(long, requires = "figures"))]
    pub png: bool,
}

impl Results {
    pub(crate) fn claim(
        &self,
        outputs: Outputs,
        context: &Context,
    ) -> anyhow::Result<crate::shared::outputs::Claim> {
        outputs.file("--out", &self.out).report("--figures", self.figures.as_deref()).check(context)
    }

    /// Writes the file of what was found, and gives the result of the verb back.
    pub(crate) fn write(&self, summary: Summary, context: &Context) -> anyhow::Result<Value> {
        let mut found = summary.value.clone();
        found["format"] = json!(IDENTIFICATION);
        file::write_bytes(&self.out, json::to_text(&found)?)?;
        if let Some(folder) = &self.figures {
            context.reported(folder);
        }
        Ok(summary.value)
    }
}

/// Result of an identification, and the warnings of its recordings.
pub(crate) struct Summary {
    /// Every number, the doubts among them: `metrics.json`.
    pub value: Value,
    /// The doubts.
    pub findings: Findings,
}

impl Summary {
    /// Of these numbers, signed.
    pub fn new(mut value: Value, findings: Findings, context: &Context) -> Self {
        value["recording_warnings"] = json!(findings);
        value["format"] = json!("hysteron-metrics");
        value["version"] = json!(1);
        value["command"] = json!(context.command);
        value["commit"] = json!(COMMIT);
        Self { value, findings }
    }
}

/// Name of a servo's torque at full load, as it is found where tensions are known.
pub(crate) const LOAD_SCALE: &str = "load_scale_n_m";
/// Format name in such a file.
pub(crate) const IDENTIFICATION: &str = "hysteron-identification";

/// A number that was found.
#[derive(Debug, Clone)]
pub(crate) struct Row {
    /// Name with its unit.
    pub name: String,
    /// Value.
    pub value: f64,
    /// Standard error, where there is one.
    pub standard_error: Option<f64>,
    /// Note on its identifiability; empty where there is nothing to note.
    pub note: String,
    /// The same as a fit has it.
    pub standing: Standing,
}

impl Row {
    /// Of a fit by least squares.
    pub(crate) fn of_estimate(estimate: &hysteron_fit::Estimate) -> Self {
        let note = match &estimate.standing {
            Standing::Fitted => String::new(),
            Standing::AtBound => "at its bound".into(),
            Standing::Vague => "vague".into(),
            Standing::Undetermined(others) if others.is_empty() => "not determined: held".into(),
            Standing::Undetermined(others) => format!("held: cannot be told from {}", others.join(", ")),
        };
        Self {
            name: estimate.name.clone(),
            value: estimate.value,
            standard_error: estimate.standard_error,
            note,
            standing: estimate.standing.clone(),
        }
    }

    /// Of a regression of bodies.
    fn of_term(term: &hysteron_arm::identify::TermEstimate) -> Self {
        let is_shared = term.determined == hysteron_arm::identify::Determined::Together;
        let note = if is_shared { "only together with others" } else { "" }.to_owned();
        Self {
            name: term.name.clone(),
            value: term.value,
            standard_error: Some(term.standard_error),
            note,
            standing: Standing::Fitted,
        }
    }

    fn json(&self) -> Value {
        json!({"name": self.name, "value": self.value, "standard_error": self.standard_error, "note": self.note})
    }

    /// As cells of a table.
    pub fn cells(&self) -> Vec<String> {
        let error = self.standard_error.map_or_else(|| "-".to_owned(), |error| format!("{error:.2e}"));
        let value = if self.value.is_nan() { "-".to_owned() } else { format!("{:.5}", self.value) };
        vec![self.name.clone(), value, error, self.note.clone()]
    }
}

/// As a verdict asks for them; an offset is none of the sizes that zero would abolish.
pub(crate) fn judged<'a>(rows: &'a [Row], consequence: Option<&'static str>) -> Vec<Judged<'a>> {
    let judged = |row: &'a Row| Judged {
        name: row.name.clone(),
        value: row.value,
        standard_error: row.standard_error,
        standing: &row.standing,
        kind: if row.name.contains("offset") { Kind::Place } else { Kind::Size },
        consequence,
    };
    rows.iter().map(judged).collect()
}

/// Standard deviation, which a prediction by the mean is off by.
pub(crate) fn deviation(values: &[f64]) -> f64 {
    let n = values.len().max(1) as f64;
    let mean = values.iter().sum::<f64>() / n;
    (values.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / n).sqrt()
}

/// The largest error of a joint over the deviation of its torques, columns of `torques` with as many joints as errors; with the
/// number of that joint, from 1.
pub(crate) fn worst_joint(errors: &[f64], torques: &[f64]) -> (f64, usize) {
    let n = errors.len();
    let share = |j: usize| {
        let column: Vec<f64> = torques.iter().skip(j).step_by(n).copied().collect();
        (errors[j] / deviation(&column), j + 1)
    };
    (0..n).map(share).max_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or((f64::NAN, 0))
}

pub(crate) fn rows_json(rows: &[Row]) -> Value {
    rows.iter().map(Row::json).collect()
}

/// Prints them.
pub(crate) fn say_rows(rows: &[Row], context: &Context) {
    context.print("number                                          value      standard error");
    for row in rows {
        let [name, value, error, note] = <[String; 4]>::try_from(row.cells()).unwrap_or_default();
        context.print(format_args!("{name:<40} {value:>12} {error:>14}   {note}").to_string().trim_end());
    }
}

/// A recording of this program, or a log of bam.
fn read(path: &Path) -> anyhow::Result<Recording> {
    match path.extension().and_then(|ending| ending.to_str()) {
        Some("json") => Ok(import(path, &ImportOptions::default(), Metadata::default())?.recording),
        _ => Ok(Recording::read(path)?),
    }
}

/// Checks the recordings in `paths` before anything is fitted to them.
///
/// # Errors
/// Those of reading, and findings that cannot be right.
pub(crate) fn checked(paths: &[PathBuf], model: Option<&Model>) -> anyhow::Result<Findings> {
    let recordings = paths.iter().map(|path| read(path)).collect::<anyhow::Result<Vec<_>>>()?;
    let names: Vec<String> = paths.iter().map(|path| recording_checks::name_of(path)).collect();
    let named: Vec<(&str, &Recording)> = names.iter().map(String::as_str).zip(&recordings).collect();
    let ranges = model.map_or_else(Vec::new, recording_checks::joint_ranges);
    let checks = CheckContext { joint_ranges: &ranges, ..CheckContext::new(Purpose::Fit) };
    recording_checks::of_named(&named, &checks)
}

/// How motions of an arm are read.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct MotionOptions {
    /// What is faster counts as noise
    #[cfg_attr(
        feature = "clap",
        arg(long, value_name = "HZ", default_value_t = 8.0, allow_negative_numbers = true)
    )]
    pub cutoff: f64,
    /// Torque for a current in every joint, where the recordings have currents
    #[cfg_attr(
        feature = "clap",
        arg(long, value_name = "N_M_PER_A,...", value_delimiter = ',', allow_negative_numbers = true)
    )]
    pub torque_constants: Vec<f64>,
    /// Speed within which Coulomb friction changes its sign
    #[cfg_attr(
        feature = "clap",
        arg(long, value_name = "RAD_S", default_value_t = 0.05, allow_negative_numbers = true)
    )]
    pub width: f64,
    /// Joint of the robot that the recordings leave out, at zero or at a coordinate
    #[cfg_attr(feature = "clap", arg(long, value_name = "NAME[=Q]"))]
    pub lock: Vec<String>,
}

/// Refuses a number of an option that is not above 0.
pub(crate) fn positive(option: &str, value: f64) -> Result<(), BadInput> {
    let holds = value.is_finite() && value > 0.0;
    if holds { Ok(()) } else { Err(BadInput::new(option, "a finite number > 0", value.to_string())) }
}

/// Motions of one arm, one after the other.
fn joined(motions: &[JointMotion]) -> Result<JointMotion, BadInput> {
    let Some((first, rest)) = motions.split_first() else {
        return Err(BadInput::new("recordings", "one or more", "none"));
    };
    let mut all = first.clone();
    rest.iter().for_each(|motion| all.extend(motion));
    Ok(all)
}

impl MotionOptions {
    /// The robot that `name` says, with joints locked at zero or where `NAME=Q` says [rad or m].
    fn model(&self, name: &str, (robot, context): (&arm::RobotOptions, &Context)) -> anyhow::Result<Model> {
        let model = robot.model(name, context)?;
        if self.lock.is_empty() {
            return Ok(model);
        }
        let place = |text: &String| -> Result<(String, f64), BadInput> {
            match text.split_once('=') {
                None => Ok((text.clone(), 0.0)),
                Some((name, q)) => {
                    let bad = || BadInput::new("--lock", "NAME or NAME=COORDINATE", format!("{text:?}"));
                    Ok((name.to_owned(), q.trim().parse().map_err(|_| bad())?))
                }
            }
        };
        let places = self.lock.iter().map(place).collect::<Result<Vec<_>, _>>()?;
        let places: Vec<(&str, f64)> = places.iter().map(|(name, q)| (name.as_str(), *q)).collect();
        Ok(model.with_locked(&places)?)
    }

    fn check(&self) -> Result<(), BadInput> {
        positive("--cutoff", self.cutoff).and_then(|()| positive("--width", self.width))
    }

    /// The motion of an arm of `model` in one file.
    fn read(&self, path: &Path, model: &Model) -> anyhow::Result<JointMotion> {
        let recording = read(path)?;
        let within = |bad: BadInput| bad.within(path.display());
        let recorded = Recorded::of(&recording).map_err(within)?;
        if recorded.joints.len() != model.n_joints() {
            let names: Vec<&str> = model.joints().iter().map(|joint| joint.name.as_str()).collect();
            let expected = format!("{} joints, those of the robot: {}", model.n_joints(), names.join(", "));
            let bad = BadInput::new("recording", expected, format!("{} joints", recorded.joints.len()))
                .hint("--lock NAME leaves a joint of the robot out");
            return Err(within(bad).into());
        }
        let motion = JointMotion::of_recording(&recorded, &self.torque_constants, ORDER, self.cutoff);
        Ok(motion.map_err(within)?)
    }

    /// The motions of several files.
    fn read_each(&self, paths: &[PathBuf], model: &Model) -> anyhow::Result<Vec<JointMotion>> {
        paths.iter().map(|path| self.read(path, model)).collect()
    }

    /// The motions of several files, one after the other.
    fn read_all(&self, paths: &[PathBuf], model: &Model) -> anyhow::Result<JointMotion> {
        Ok(joined(&self.read_each(paths, model)?)?)
    }
}
