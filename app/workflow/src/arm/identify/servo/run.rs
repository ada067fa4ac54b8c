//! Identifies motor, supply, heat and friction of a servo that swings a weight, by rollout.

use std::path::Path;

use hysteron_actuator::identify::{
    DriveFit, DriveFitOptions, PendulumRun, QUANTITIES, identify_drive, mean_error, rollout,
};
use hysteron_actuator::law::{JointFriction, Law};
use hysteron_actuator::{CatalogueDrive, Drive};
use hysteron_base::{BadInput, file};
use hysteron_report::folder::ReportFolder;
use hysteron_report::maker::MADE_BY;
use hysteron_report::verdict::{Criterion, Verdict};

use super::recordings::run_of;
use super::{Options, Outcome, page};
use crate::arm::identify::recordings;
use crate::shared::error::Cancelled;
use crate::shared::identification::{IdentificationFormat, Row, assessed, deviation, estimates, print_rows};
use crate::shared::outputs::Outputs;
use crate::shared::verdict::parameters;
use crate::{COMMIT, Context, WorkflowError, arm};

/// Error of position from which on a sample counts linearly [rad].
const HUBER: f64 = 0.03;
/// Shares of its bounds from which friction starts.
const STARTS: [f64; 3] = [0.05, 0.15, 0.3];

/// Runs the verb.
///
/// # Errors
/// `BadInput` for invalid options or recordings; an interruption.
pub fn run(options: &Options, context: &Context) -> Result<Outcome, WorkflowError> {
    Ok(identify(options, context)?)
}

fn identify(options: &Options, context: &Context) -> anyhow::Result<Outcome> {
    let mut outputs =
        Outputs::reading(&options.recordings).and(&options.test).and(arm::file_of(&options.drive));
    if let Some(path) = &options.drive_out {
        outputs = outputs.file("--drive-out", path);
    }
    let _lock = options.results.lock(outputs, context)?;
    if !(1e-5..=0.02).contains(&options.step) {
        return Err(BadInput::new("--step", "0.00001 to 0.02 s", options.step.to_string()).into());
    }
    let mut entry = known_drive(options)?;
    let findings = recordings::checked(&[&options.recordings[..], &options.test].concat(), None)?;
    let runs =
        options.recordings.iter().map(|path| run_of(path, options)).collect::<anyhow::Result<Vec<_>>>()?;
    let test = options.test.iter().map(|path| run_of(path, options)).collect::<anyhow::Result<Vec<_>>>()?;
    if let Some(voltage) = runs.first().and_then(|run| run.voltage) {
        entry.drive.supply.voltage = voltage;
    }
    let [runs, test] = [runs, test].map(|all| all.into_iter().map(|run| run.run).collect::<Vec<_>>());
    let found = fit(&entry.drive, &runs, options.step, context)?;
    let rows: Vec<Row> = found.fit.estimates.iter().map(Row::of_estimate).collect();
    let error = |runs: &[PendulumRun]| mean_error(&found.drive, found.offset, runs, options.step);
    let (fitted, tested) = (error(&runs), (!test.is_empty()).then(|| error(&test)));
    print_rows(&rows, context);
    context.print(format_args!("mean error of the angle over the recordings, open loop: {fitted:.4} rad"));
    if let Some(tested) = tested {
        context.print(format_args!("on recordings that were not fitted: {tested:.4} rad"));
    }
    if !found.fit.is_converged {
        context.print(format_args!("the search ended before a minimum: {}", found.fit.ended));
    }
    let shown = if test.is_empty() { &runs } else { &test };
    let held_out = tested.map(|tested| tested / fitted);
    let outcome = Outcome {
        format: IdentificationFormat::Metrics,
        version: 1,
        drive: entry.name.to_string(),
        law: found.drive.gear.law.name().to_string(),
        estimates: estimates(&rows),
        verdict: verdict(&rows, &found.fit, (shown, tested.unwrap_or(fitted)), held_out),
        correlation: found.fit.correlation,
        condition: found.fit.condition,
        error_rad: fitted,
        test_error_rad: tested,
        supply_v: entry.drive.supply.voltage,
        evaluations: found.fit.evaluations,
        converged: found.fit.is_converged,
        recording_warnings: findings.into_warnings(),
        command: context.command.clone(),
        commit: COMMIT.to_owned(),
    };
    if let Some(path) = &options.drive_out {
        write_drive(path, &found.drive, &entry, context)?;
    }
    if let Some(folder) = &options.results.figures {
        let simulated: Vec<_> =
            shown.iter().map(|run| rollout(&found.drive, found.offset, run, options.step)).collect();
        let motions = page::Motions { drive: &found.drive, runs: shown, simulated: &simulated };
        let folder = ReportFolder { path: folder, png: options.results.png };
        page::write(&folder, &motions, &outcome)?;
    }
    let file = Outcome { format: IdentificationFormat::Identification, ..outcome.clone() };
    options.results.write(&file, context)?;
    Ok(outcome)
}

/// The drive that is named, with another law of friction where one is asked for.
fn known_drive(options: &Options) -> anyhow::Result<CatalogueDrive> {
    let mut entry = arm::drive(&options.drive)?;
    if let Some(name) = &options.law {
        let law = Law::named(name).map_err(|bad| BadInput { place: "--law".into(), ..bad })?;
        let friction = vec![0.0; law.parameters().len()];
        (entry.drive.gear.law, entry.drive.gear.friction) = (law, friction);
    }
    Ok(entry)
}

/// Fits the drive to the motions, with steps of the simulation of at most `step` [s].
fn fit(drive: &Drive, runs: &[PendulumRun], step: f64, context: &Context) -> anyhow::Result<DriveFit> {
    let is_there = |value: f64| value.is_finite() && value > 0.0;
    let quantities: Vec<&str> =
        QUANTITIES.iter().filter(|q| is_there((q.get)(drive))).map(|q| q.name).collect();
    context.listen();
    let bar = context.progress("evaluations", 0, 0);
    let watch = |evaluations: usize, error: f64| {
        bar.set_position(evaluations as u64);
        bar.set_message(format!("error {error:.4} rad"));
        !context.is_cancelled()
    };
    let fit_options = DriveFitOptions {
        quantities: &quantities,
        longest_step: step,
        huber: HUBER,
        starts: &STARTS,
        watch: &watch,
    };
    let found = identify_drive(drive, runs, &fit_options)?;
    bar.finish();
    if context.is_cancelled() {
        return Err(Cancelled::new("; nothing was written").into());
    }
    Ok(found)
}

/// Writes the drive as identified, with the source of what was not.
fn write_drive(path: &Path, found: &Drive, known: &CatalogueDrive, context: &Context) -> anyhow::Result<()> {
    let source = format!("{}, from that of: {}", context.command, known.source);
    let drive = CatalogueDrive { drive: found.clone(), source, ..known.clone() };
    file::write_bytes(path, format!("{MADE_BY}{}\n{}", context.command, String::from(drive)))?;
    context.wrote(path);
    Ok(())
}

/// Whether the drive can replace the servo: mean error of the angle over these runs [rad], and how many times that of the
/// fit it is where they were not fitted.
fn verdict(
    rows: &[Row],
    fit: &hysteron_fit::Fit,
    (runs, error): (&[PendulumRun], f64),
    held_out: Option<f64>,
) -> Verdict {
    let angles: Vec<f64> = runs.iter().flat_map(|run| run.position.iter().copied()).collect();
    let spread = deviation(&angles);
    let assessment =
        Verdict::on(format!("the simulated servo follows the measured one within {error:.4} rad open loop"))
            .because(
                Criterion::ErrorOverSpread,
                error / spread,
                format!("the mean error is {error:.4} rad, the deviation of the angles {spread:.4} rad"),
            );
    parameters(assessment, &assessed(rows, None))
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
