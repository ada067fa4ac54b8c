//! `hysteron identify-servo`: friction, backlash and load scale of a rig's servos from recordings of it.

mod found;
mod outcome;

use std::f64::consts::TAU;
use std::path::PathBuf;

use hysteron_actuator::TICKS_PER_TURN;
use hysteron_actuator::identify::{
    Backlash, PulleyFit, PulleyRecord, PulleyServo, SteadySamples, finest_speed, identify_backlash,
    identify_pulley,
};
use hysteron_actuator::law::{LEARNED_MAP, Law, RISING_MAP};
use hysteron_base::checks::{CheckContext, Purpose};
use hysteron_base::{BadInput, Recording};
use hysteron_fit::Identifiability;
use hysteron_report::folder::ReportFolder;

use crate::figures::identify_servo as figures;
use crate::shared::error::Cancelled;
use crate::shared::identification::{IdentificationFormat, LOAD_SCALE, Results, Row, positive, print_rows};
use crate::shared::inputs::{self, Input};
use crate::shared::outputs::Outputs;
use crate::shared::recording_checks;
use crate::tendon::sense::stroke_per_tick;
use crate::{COMMIT, Context, WorkflowError};
pub(crate) use found::Found;
use found::rms;
pub use outcome::{Outcome, ServoEstimates};

/// Laws that need nothing but the speed.
const LAWS: [&str; 5] = ["stribeck", "coulomb-viscous", "directed-stribeck", LEARNED_MAP, RISING_MAP];
/// Slowest steady motion whatever the rate [rad/s].
const SLOWEST: f64 = 0.03;

/// Find friction, backlash and load scale of a rig's servos in recordings
#[derive(Debug, Clone)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct Options {
    /// Recordings of the rig with tick_goal_k, tick_present_k and load_k, or folders of them; tension_k_n beside them gives the
    /// scale of the loads and the backlash
    #[cfg_attr(feature = "clap", arg(required = true, value_name = "REC"))]
    pub recordings: Vec<PathBuf>,
    /// Torque of the stalled motor at full load, where no tensions give the scale of the loads [default: an XL430-W250's]
    #[cfg_attr(
        feature = "clap",
        arg(long, value_name = "N_M", default_value_t = 1.4, allow_negative_numbers = true)
    )]
    pub stall_torque: f64,
    /// stribeck, coulomb-viscous, directed-stribeck, learned-map or rising-map
    #[cfg_attr(feature = "clap", arg(long, value_name = "NAME", default_value = "stribeck"))]
    pub law: String,
    /// Only these servos, by number from 1
    #[cfg_attr(feature = "clap", arg(long, value_name = "K,...", value_delimiter = ',', value_parser = crate::shared::number::count::<64>))]
    pub servos: Vec<usize>,
    /// Where the results go.
    #[cfg_attr(feature = "clap", command(flatten))]
    pub results: Results,
}

/// Motion of one servo in one recording, positive where it pulls.
struct Course {
    angle: Vec<f64>,
    load: Vec<f64>,
    tension: Option<Vec<f64>>,
}

/// One servo of a rig in all recordings.
struct Servo {
    /// Number, from 1.
    number: usize,
    /// Radius of its pulley, as strokes over ticks have it [m].
    radius: f64,
    courses: Vec<Course>,
}

/// Carries out the verb.
///
/// # Errors
/// Bad input; recordings from which nothing can be told of any servo.
pub fn run(options: &Options, context: &Context) -> Result<Outcome, WorkflowError> {
    Ok(identify_all(options, context)?)
}

fn identify_all(options: &Options, context: &Context) -> anyhow::Result<Outcome> {
    positive("--stall-torque", options.stall_torque)?;
    if !LAWS.contains(&options.law.as_str()) {
        let expected = format!("one of {}", LAWS.join(", "));
        return Err(BadInput::new("--law", expected, format!("{:?}", options.law)).into());
    }
    let files = inputs::read(&options.recordings)?;
    let _claim = options.results.claim(Outputs::reading(files.iter().map(|input| &input.path)), context)?;
    let findings = recording_checks::of_inputs(&files, &CheckContext::new(Purpose::Fit))?;
    let period = common_period(&files)?;
    let servos = servos(&files, &options.servos)?;
    context.listen();
    let bar = context.progress("servos", servos.len(), 0);
    let mut found = Vec::new();
    for servo in &servos {
        if context.is_cancelled() {
            return Err(Cancelled::new("; nothing is written").into());
        }
        found.push(identify(servo, options, period));
        bar.inc(1);
    }
    bar.finish();
    if let Some(bad) = found.iter().map(|found| found.pulley.as_ref().err()).collect::<Option<Vec<_>>>() {
        // Of no servo anything: the recording is to blame, as its first servo says.
        return Err(anyhow::Error::from(bad[0].clone().within(format!("servo {}", found[0].number))));
    }
    found.iter().for_each(|found| print(found, context));
    let outcome = Outcome {
        format: IdentificationFormat::Metrics,
        version: 1,
        law: options.law.clone(),
        slowest_rad_s: slowest(period),
        period_s: period,
        recordings: files.iter().map(|input| [input.name.clone(), input.hash.clone()]).collect(),
        servos: found.iter().map(Found::estimates).collect(),
        verdict: found::verdict(&found),
        recording_warnings: findings.into_warnings(),
        command: context.command.clone(),
        commit: COMMIT.to_owned(),
    };
    if let Some(path) = &options.results.figures {
        let folder = ReportFolder { path, png: options.results.png };
        figures::write(&folder, &found, &outcome)?;
    }
    let file = Outcome { format: IdentificationFormat::Identification, ..outcome.clone() };
    options.results.write(&file, context)?;
    context.wrote(&options.results.out);
    Ok(outcome)
}

fn slowest(period: f64) -> f64 {
    finest_speed(period).max(SLOWEST)
}

/// Recordings of one rate, within 1 %.
fn common_period(files: &[Input]) -> anyhow::Result<f64> {
    let mut first = None;
    for input in files {
        let place = format!("{}: time_s", input.path.display());
        let rate = input.recording.rate_hz().ok_or_else(|| {
            BadInput::new(&place, "equal time steps, within 1 %", "unequal ones")
                .hint("resample the recording")
        })?;
        let expected: f64 = *first.get_or_insert(rate);
        if (rate / expected - 1.0).abs() > 0.01 {
            let expected = format!("{expected:.2} samples a second, as in {}", files[0].path.display());
            return Err(BadInput::new(place, expected, format!("{rate:.2}")).into());
        }
    }
    first.map(f64::recip).ok_or_else(|| BadInput::new("recordings", "one or more", "none").into())
}

/// The channels of one recording.
struct Channels<'a> {
    goals: Vec<&'a [f64]>,
    present: Vec<&'a [f64]>,
    loads: Vec<&'a [f64]>,
    strokes: Vec<&'a [f64]>,
    tensions: Option<Vec<&'a [f64]>>,
}

impl<'a> Channels<'a> {
    fn of(recording: &'a Recording) -> Result<Self, BadInput> {
        recording.require("tick_present_1")?;
        let n = recording.numbered("tick_present", "").len();
        let all = |stem: &str, unit: &str| -> Result<Vec<&'a [f64]>, BadInput> {
            let name =
                |k: usize| if unit.is_empty() { format!("{stem}_{k}") } else { format!("{stem}_{k}_{unit}") };
            (1..=n).map(|k| recording.require(&name(k))).collect()
        };
        let measured = |stem: &str| !recording.numbered(stem, "n").is_empty();
        let tensions = ["tension", "true_tension"].into_iter().find(|stem| measured(stem));
        Ok(Self {
            goals: all("tick_goal", "")?,
            present: all("tick_present", "")?,
            loads: all("load", "")?,
            strokes: all("stroke", "m")?,
            tensions: tensions.map(|stem| all(stem, "n")).transpose()?,
        })
    }
}

/// Servos of the rig, those of the numbers in `wanted` or all; strokes and goals say how each winds.
fn servos(files: &[Input], wanted: &[usize]) -> anyhow::Result<Vec<Servo>> {
    let channels = files
        .iter()
        .map(|input| Channels::of(&input.recording).map_err(|bad| bad.within(input.path.display())))
        .collect::<Result<Vec<_>, _>>()?;
    let n = channels.first().map_or(0, |channels| channels.present.len());
    if let Some(k) = channels.iter().position(|channels| channels.present.len() != n) {
        let expected = format!("{n} servos, as in {}", files[0].path.display());
        let found = channels[k].present.len().to_string();
        return Err(BadInput::new(files[k].path.display().to_string(), expected, found).into());
    }
    if let Some(k) = wanted.iter().find(|k| **k > n) {
        return Err(BadInput::new("--servos", format!("1 to {n}"), k.to_string()).into());
    }
    let numbers = (1..=n).filter(|k| wanted.is_empty() || wanted.contains(k));
    Ok(numbers.map(|number| servo(&channels, number)).collect::<Result<_, _>>()?)
}

fn servo(channels: &[Channels], number: usize) -> Result<Servo, BadInput> {
    let k = number - 1;
    let per_tick: Vec<f64> = channels
        .iter()
        .filter_map(|channels| stroke_per_tick(channels.goals[k], channels.strokes[k]))
        .collect();
    let place = format!("tick_goal_{number}");
    if per_tick.is_empty() {
        return Err(BadInput::new(place, "goals that change", "a servo that rests throughout")
            .hint(format!("record motion of tendon {number}, or leave it out with --servos")));
    }
    let mean = per_tick.iter().sum::<f64>() / per_tick.len() as f64;
    if per_tick.iter().any(|slope| (slope / mean - 1.0).abs() > 0.05) {
        let found =
            per_tick.iter().map(|slope| format!("{:.3} µm", 1e6 * slope)).collect::<Vec<_>>().join(", ");
        return Err(BadInput::new(place, "the same stroke for a tick in all recordings", found)
            .hint("are all of them of one rig, with one calibration?"));
    }
    let sign = mean.signum();
    let course = |channels: &Channels| Course {
        angle: channels.present[k].iter().map(|ticks| sign * ticks * TAU / TICKS_PER_TURN).collect(),
        load: channels.loads[k].iter().map(|load| sign * load).collect(),
        tension: channels.tensions.as_ref().map(|tensions| tensions[k].to_vec()),
    };
    let radius = mean.abs() * TICKS_PER_TURN / TAU;
    Ok(Servo { number, radius, courses: channels.iter().map(course).collect() })
}

fn identify(servo: &Servo, options: &Options, period: f64) -> Found {
    let courses = servo.courses.iter();
    let records: Vec<PulleyRecord> = courses
        .map(|course| PulleyRecord {
            angle: &course.angle,
            load: &course.load,
            tension: course.tension.as_deref(),
        })
        .collect();
    let known = PulleyServo { stall_torque: options.stall_torque, radius: servo.radius };
    let mut law = None;
    let pulley = SteadySamples::of(&records, period, slowest(period)).and_then(|samples| {
        let chosen = Law::for_speeds(&options.law, &samples.velocity)?;
        let found = identify_pulley(&samples, &chosen, &known)?;
        law = Some(chosen);
        Ok(found)
    });
    let backlash = identify_backlash(&records);
    let has_tension = records.iter().any(|record| record.tension.is_some());
    let rows = rows(&pulley, &backlash, (options.stall_torque, servo.radius, has_tension), period);
    Found { number: servo.number, radius: servo.radius, law, pulley, backlash, has_tension, rows }
}

/// Everything that was told, and what was not with what to record.
fn rows(
    pulley: &Result<PulleyFit, BadInput>,
    backlash: &Result<Backlash, BadInput>,
    (stall_torque, radius, has_tension): (f64, f64, bool),
    period: f64,
) -> Vec<Row> {
    let mut rows = Vec::new();
    if let Ok(found) = pulley {
        if !has_tension {
            rows.push(Row {
                name: LOAD_SCALE.into(),
                value: stall_torque,
                standard_error: None,
                note: "as given: loads alone cannot tell it; record tension_k_n".into(),
                standing: Identifiability::Undetermined(Vec::new()),
            });
        }
        let finest = finest_speed(period);
        let is_speed = |name: &str| name.starts_with("stribeck_velocity");
        let is_blurred =
            found.fit.estimates.iter().any(|estimate| is_speed(&estimate.name) && estimate.value < finest);
        rows.extend(found.fit.estimates.iter().map(|estimate| {
            let mut row = Row::of_estimate(estimate);
            let is_of_low_speed = is_speed(&row.name) || row.name.starts_with("breakaway_excess");
            let is_held = matches!(estimate.standing, Identifiability::Undetermined(_));
            if is_of_low_speed && (is_blurred || is_held) {
                row.note = format!("cannot be told: below {finest:.2} rad/s a servo moves tick by tick");
                (row.value, row.standard_error) = (f64::NAN, None);
                row.standing = Identifiability::Undetermined(Vec::new());
            } else if is_held {
                row.note =
                    "cannot be told: record slower and faster motion of a tendon pulled more and less".into();
                row.value = f64::NAN;
            }
            row
        }));
    }
    match backlash {
        Ok(found) => rows.push(Row {
            name: "backlash_mm".into(),
            value: 1e3 * radius * found.width,
            standard_error: Some(1e3 * radius * found.standard_error),
            note: format!("{} reversals", found.reversals.len()),
            standing: Identifiability::Fitted,
        }),
        Err(bad) => rows.push(Row {
            name: "backlash_mm".into(),
            value: f64::NAN,
            standard_error: None,
            note: format!("cannot be told: {bad}"),
            standing: Identifiability::Undetermined(Vec::new()),
        }),
    }
    rows
}

fn print(found: &Found, context: &Context) {
    match &found.pulley {
        Ok(pulley) => {
            let source = if found.has_tension { "with measured tensions" } else { "of a slack tendon" };
            context.print(format_args!(
                "servo {}: {} samples of steady motion {source}, error {:.4} N m RMS",
                found.number,
                pulley.samples.len(),
                rms(&pulley.residuals)
            ));
        }
        Err(bad) => context.print(format_args!("servo {}: friction cannot be told: {bad}", found.number)),
    }
    print_rows(&found.rows, context);
}
