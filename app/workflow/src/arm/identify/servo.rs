//! `arm identify servo`: motor, supply, heat and friction of a servo that swings a weight, by rollout.

use std::path::{Path, PathBuf};

use hysteron_actuator::CatalogueDrive;
use hysteron_actuator::identify::{
    DriveFitOptions, Pendulum, PendulumRun, QUANTITIES, identify_drive, mean_error, rollout,
};
use hysteron_actuator::law::{JointFriction, Law};
use hysteron_arm::{POSITION_GAIN, Quantity, Recorded};
use hysteron_base::{BadInput, Recording, file, json};
use hysteron_report::maker::MADE_BY;
use hysteron_report::verdict::{Criterion, Verdict};
use serde_json::Value;

use super::{Results, Row, Summary, deviation, judged as judged_rows, positive, read, rows_json, say_rows};
use crate::figures::arm_identification as figures;
use crate::shared::error::Cancelled;
use crate::shared::outputs::Outputs;
use crate::shared::verdict::parameters;
use crate::{Context, arm};

/// Motor, supply, heat and friction of a servo that swings a weight
#[derive(Debug, Clone)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct Options {
    /// Recordings to fit
    #[cfg_attr(feature = "clap", arg(required = true, value_name = "REC"))]
    pub recordings: Vec<PathBuf>,
    /// Recordings that are not fitted, to test on
    #[cfg_attr(feature = "clap", arg(long, value_name = "REC", num_args = 1..))]
    pub test: Vec<PathBuf>,
    /// Name of a drive, or a file of TOML
    #[cfg_attr(feature = "clap", arg(long, value_name = "DRIVE", default_value = "xl330-m288"))]
    pub drive: String,
    /// Law of friction: coulomb-viscous, stribeck, directed-stribeck, m1 to m6 [default: the drive's]
    #[cfg_attr(feature = "clap", arg(long, value_name = "NAME"))]
    pub law: Option<String>,
    /// Mass of the weight [default: the recordings say]
    #[cfg_attr(feature = "clap", arg(long, value_name = "KG", allow_negative_numbers = true))]
    pub mass_kg: Option<f64>,
    /// Distance of the weight from the axis [default: the recordings say]
    #[cfg_attr(feature = "clap", arg(long, value_name = "M", allow_negative_numbers = true))]
    pub length_m: Option<f64>,
    /// Proportional gain as the register has it [default: the recordings say]
    #[cfg_attr(feature = "clap", arg(long, value_name = "P", allow_negative_numbers = true))]
    pub gain: Option<f64>,
    /// Longest step of the simulation
    #[cfg_attr(
        feature = "clap",
        arg(long, value_name = "S", default_value_t = 1e-3, allow_negative_numbers = true)
    )]
    pub step: f64,
    /// The drive with what was found, a file for --drive of this and other verbs
    #[cfg_attr(feature = "clap", arg(long, value_name = "FILE"))]
    pub drive_out: Option<PathBuf>,
    /// Where the results go.
    #[cfg_attr(feature = "clap", command(flatten))]
    pub results: Results,
}

/// Error of position from which on a sample counts linearly [rad].
const HUBER: f64 = 0.03;
/// Shares of its bounds from which friction starts.
const STARTS: [f64; 3] = [0.05, 0.15, 0.3];

/// Carries out the verb.
///
/// # Errors
/// `BadInput` for whatever is wrong with options or recordings; where it was interrupted.
pub fn run(options: &Options, context: &Context) -> anyhow::Result<Value> {
    let mut outputs =
        Outputs::reading(&options.recordings).and(&options.test).and(arm::file_of(&options.drive));
    if let Some(path) = &options.drive_out {
        outputs = outputs.file("--drive-out", path);
    }
    let _claim = options.results.claim(outputs, context)?;
    if !(1e-5..=0.02).contains(&options.step) {
        return Err(BadInput::new("--step", "0.00001 to 0.02 s", options.step.to_string()).into());
    }
    let mut entry = arm::drive(&options.drive)?;
    if let Some(name) = &options.law {
        let law = Law::named(name).map_err(|bad| BadInput { place: "--law".into(), ..bad })?;
        let friction = vec![0.0; law.parameters().len()];
        (entry.drive.gear.law, entry.drive.gear.friction) = (law, friction);
    }
    let findings = super::checked(&[&options.recordings[..], &options.test].concat(), None)?;
    let runs =
        options.recordings.iter().map(|path| run_of(path, options)).collect::<anyhow::Result<Vec<_>>>()?;
    let test = options.test.iter().map(|path| run_of(path, options)).collect::<anyhow::Result<Vec<_>>>()?;
    if let Some(voltage) = runs.first().and_then(|run| run.voltage) {
        entry.drive.supply.voltage = voltage;
    }
    let [runs, test] = [runs, test].map(|all| all.into_iter().map(|run| run.run).collect::<Vec<_>>());
    let is_there = |value: f64| value.is_finite() && value > 0.0;
    let quantities: Vec<&str> =
        QUANTITIES.iter().filter(|q| is_there((q.get)(&entry.drive))).map(|q| q.name).collect();
    context.listen();
    let bar = context.progress("evaluations", 0, 0);
    let watch = |evaluations: usize, error: f64| {
        bar.set_position(evaluations as u64);
        bar.set_message(format!("error {error:.4} rad"));
        !context.is_cancelled()
    };
    let fit_options = DriveFitOptions {
        quantities: &quantities,
        longest_step: options.step,
        huber: HUBER,
        starts: &STARTS,
        watch: &watch,
    };
    let found = identify_drive(&entry.drive, &runs, &fit_options)?;
    bar.finish();
    if context.is_cancelled() {
        return Err(Cancelled::new("; nothing was written").into());
    }
    let rows: Vec<Row> = found.fit.estimates.iter().map(Row::of_estimate).collect();
    let error = |runs: &[PendulumRun]| mean_error(&found.drive, found.offset, runs, options.step);
    let (fitted, tested) = (error(&runs), (!test.is_empty()).then(|| error(&test)));
    say_rows(&rows, context);
    context.print(format_args!("mean error of the angle over the recordings, open loop: {fitted:.4} rad"));
    if let Some(tested) = tested {
        context.print(format_args!("on recordings that were not fitted: {tested:.4} rad"));
    }
    if !found.fit.is_converged {
        context.print(format_args!("the search ended before a minimum: {}", found.fit.ended));
    }
    let numbers = json!({
        "drive": entry.name, "law": found.drive.gear.law.name(), "estimates": rows_json(&rows),
        "correlation": found.fit.correlation, "condition": found.fit.condition, "error_rad": fitted,
        "test_error_rad": tested, "supply_v": entry.drive.supply.voltage, "evaluations": found.fit.evaluations,
        "converged": found.fit.is_converged,
        "verdict": verdict(&rows, &found.fit, (if test.is_empty() { &runs } else { &test }, tested.unwrap_or(fitted)), tested.map(|tested| tested / fitted)),
    });
    let summary = Summary::new(numbers, findings, context);
    if let Some(path) = &options.drive_out {
        let source = format!("{}, from that of: {}", context.command, entry.source);
        let drive = CatalogueDrive { drive: found.drive.clone(), source, ..entry.clone() };
        file::write_bytes(path, format!("{MADE_BY}{}\n{}", context.command, String::from(drive)))?;
        context.wrote(path);
    }
    if let Some(folder) = &options.results.figures {
        let shown = if test.is_empty() { &runs } else { &test };
        let simulated: Vec<_> =
            shown.iter().map(|run| rollout(&found.drive, found.offset, run, options.step)).collect();
        let page = figures::servo::Shown {
            name: &entry.name,
            drive: &found.drive,
            runs: shown,
            simulated: &simulated,
            rows: &rows,
        };
        figures::servo::write(folder, &page, &summary, options.results.png, context)?;
    }
    options.results.write(summary, context)
}

/// Whether the drive can stand in for the servo: mean error of the angle over these runs [rad], and how many times that of the
/// fit it is where they were not fitted.
fn verdict(
    rows: &[Row],
    fit: &hysteron_fit::Fit,
    (runs, error): (&[PendulumRun], f64),
    held_out: Option<f64>,
) -> Verdict {
    let angles: Vec<f64> = runs.iter().flat_map(|run| run.position.iter().copied()).collect();
    let spread = deviation(&angles);
    let judged =
        Verdict::on(format!("the simulated servo follows the measured one within {error:.4} rad open loop"))
            .because(
                Criterion::ErrorOverSpread,
                error / spread,
                format!("the mean error is {error:.4} rad, the deviation of the angles {spread:.4} rad"),
            );
    parameters(judged, &judged_rows(rows, None))
        .because_of(Criterion::HeldOutOverFitted, held_out, |ratio| {
            format!("recordings that were not fitted err {ratio:.1} times as much as those that were")
        })
        .because(
            Criterion::ConditionNumber,
            fit.condition,
            format!("the condition number of the parameters is {:.0}", fit.condition),
        )
        .because(
            Criterion::NotConverged,
            if fit.is_converged { 0.0 } else { 1.0 },
            if fit.is_converged {
                "the search ended at a minimum"
            } else {
                "the search ended before a minimum"
            },
        )
        .verdict()
}

/// A recorded motion, and the supply's voltage at its start.
struct Run {
    run: PendulumRun,
    voltage: Option<f64>,
}

fn run_of(path: &Path, options: &Options) -> anyhow::Result<Run> {
    let recording = read(path)?;
    let within = |bad: BadInput| bad.within(path.display());
    Ok(of_recording(&recording, options, path.display().to_string()).map_err(within)?)
}

fn of_recording(recording: &Recording, options: &Options, name: String) -> Result<Run, BadInput> {
    let recorded = Recorded::of(recording)?;
    if recorded.joints.len() != 1 {
        return Err(BadInput::new("recording", "one joint", recorded.joints.len().to_string()));
    }
    let need = |quantity| recorded.require(quantity).map(|columns| columns[0].to_vec());
    let noted = |key: &str, option: &str, given: Option<f64>| {
        let noted = recording.meta().extra.get(key).and_then(|text| text.parse::<f64>().ok());
        let value = given.or(noted).ok_or_else(|| {
            BadInput::new(option, "this option, for the recording does not say it", "nothing")
        })?;
        positive(option, value).map(|()| value)
    };
    let first = |quantity| recorded.require(quantity).ok().and_then(|columns| columns[0].first().copied());
    let torque_on = recording.channel("torque_on_1_ratio").map_or_else(
        || vec![true; recording.n_samples()],
        |flags| flags.iter().map(|flag| *flag >= 0.5).collect(),
    );
    let run = PendulumRun {
        // Messages name the file anyway.
        name: "recording".into(),
        time: recorded.time.to_vec(),
        goal: need(Quantity::Goal)?,
        position: need(Quantity::Position)?,
        torque_on,
        temperature: first(Quantity::Temperature).unwrap_or(ROOM),
        gain: noted(POSITION_GAIN, "--gain", options.gain)?,
        pendulum: Pendulum {
            mass: noted("mass_kg", "--mass-kg", options.mass_kg)?,
            length: noted("length_m", "--length-m", options.length_m)?,
            offset: 0.0,
        },
    };
    Ok(Run { run: PendulumRun { name, ..run.checked()? }, voltage: first(Quantity::Voltage) })
}

/// Where the recording does not say how warm the servo is [°C].
const ROOM: f64 = 25.0;
