//! The identification: servos in their recordings, a fit of each, file, page.

use hysteron_actuator::identify::{
    Backlash, PulleyFit, PulleyRecord, PulleyServo, SteadySamples, finest_speed, identify_backlash,
    identify_pulley,
};
use hysteron_actuator::law::Law;
use hysteron_base::BadInput;
use hysteron_base::checks::{CheckContext, Purpose};
use hysteron_fit::Identifiability;
use hysteron_report::folder::ReportFolder;

use super::found::{IdentifiedPulley, rms, verdict};
use super::options::Options;
use super::outcome::Outcome;
use super::page;
use super::servos::{RecordedServo, common_period, servos};
use crate::shared::error::Cancelled;
use crate::shared::identification::{IdentificationFormat, LOAD_SCALE, Row, print_rows};
use crate::shared::outputs::Outputs;
use crate::shared::{inputs, recording_checks};
use crate::{COMMIT, Context, WorkflowError};

/// Slowest steady motion at any rate [rad/s].
const SLOWEST: f64 = 0.03;

/// Runs the verb.
///
/// # Errors
/// Bad input; recordings from which nothing can be estimated of any servo; an interruption.
pub fn run(options: &Options, context: &Context) -> Result<Outcome, WorkflowError> {
    Ok(identify_servos(options, context)?)
}

fn identify_servos(options: &Options, context: &Context) -> anyhow::Result<Outcome> {
    options.check()?;
    let files = inputs::read(&options.recordings)?;
    let _lock = options.results.lock(Outputs::reading(files.iter().map(|input| &input.path)), context)?;
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
        // No servo was identified: the error of the first servo is that of the recording.
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
        servos: found.iter().map(IdentifiedPulley::estimates).collect(),
        verdict: verdict(&found),
        recording_warnings: findings.into_warnings(),
        command: context.command.clone(),
        commit: COMMIT.to_owned(),
    };
    if let Some(path) = &options.results.figures {
        let folder = ReportFolder { path, png: options.results.png };
        page::write(&folder, &found, &outcome)?;
    }
    let file = Outcome { format: IdentificationFormat::Identification, ..outcome.clone() };
    options.results.write(&file, context)?;
    context.wrote(&options.results.out);
    Ok(outcome)
}

fn slowest(period: f64) -> f64 {
    finest_speed(period).max(SLOWEST)
}

fn identify(servo: &RecordedServo, options: &Options, period: f64) -> IdentifiedPulley {
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
    IdentifiedPulley { number: servo.number, radius: servo.radius, law, pulley, backlash, has_tension, rows }
}

/// Everything that was estimated; for the rest, what to record.
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
                note: "as given: loads alone do not determine it; record tension_k_n".into(),
                identifiability: Identifiability::Undetermined(Vec::new()),
            });
        }
        let finest = finest_speed(period);
        let is_speed = |name: &str| name.starts_with("stribeck_velocity");
        let is_blurred =
            found.fit.estimates.iter().any(|estimate| is_speed(&estimate.name) && estimate.value < finest);
        rows.extend(found.fit.estimates.iter().map(|estimate| {
            let mut row = Row::of_estimate(estimate);
            let is_of_low_speed = is_speed(&row.name) || row.name.starts_with("breakaway_excess");
            let is_held = matches!(estimate.identifiability, Identifiability::Undetermined(_));
            if is_of_low_speed && (is_blurred || is_held) {
                row.note = format!("cannot be estimated: below {finest:.2} rad/s a servo moves tick by tick");
                (row.value, row.standard_error) = (f64::NAN, None);
                row.identifiability = Identifiability::Undetermined(Vec::new());
            } else if is_held {
                row.note =
                    "cannot be estimated: record slower and faster motion of a tendon pulled more and less"
                        .into();
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
            identifiability: Identifiability::Fitted,
        }),
        Err(bad) => rows.push(Row {
            name: "backlash_mm".into(),
            value: f64::NAN,
            standard_error: None,
            note: format!("cannot be estimated: {bad}"),
            identifiability: Identifiability::Undetermined(Vec::new()),
        }),
    }
    rows
}

fn print(found: &IdentifiedPulley, context: &Context) {
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
        Err(bad) => {
            context.print(format_args!("servo {}: friction cannot be estimated: {bad}", found.number))
        }
    }
    print_rows(&found.rows, context);
}
