//! Identifies a law of friction of one joint.

use std::path::Path;

use hysteron_actuator::identify::{FrictionFit, FrictionMethod, identify_friction, identify_friction_by};
use hysteron_actuator::law::{JointFriction, Law, Sliding};
use hysteron_arm_estimation::{ArmRecording, JointQuantityKind};
use hysteron_base::BadInput;
use hysteron_fit::{Identifiability, folds};
use hysteron_report::folder::ReportFolder;
use hysteron_report::verdict::{Criterion, Verdict};

use super::{Options, Outcome, page};
use crate::arm::identify::recordings::{self, read};
use crate::shared::identification::{IdentificationFormat, Row, assessed, deviation, estimates, print_rows};
use crate::shared::identification_page::JointSeries;
use crate::shared::outputs::Outputs;
use crate::shared::verdict::{AssessedParameter, parameters};
use crate::{COMMIT, Context, WorkflowError};

/// Speeds and torques of a joint in one recording.
struct FrictionSeries {
    velocity: Vec<f64>,
    torque: Vec<f64>,
}

/// Runs the verb.
///
/// # Errors
/// `BadInput` for invalid options or recordings.
pub fn run(options: &Options, context: &Context) -> Result<Outcome, WorkflowError> {
    Ok(identify(options, context)?)
}

fn identify(options: &Options, context: &Context) -> anyhow::Result<Outcome> {
    let method = options.method()?;
    let _lock = options.results.lock(Outputs::reading(&options.recordings), context)?;
    let findings = recordings::checked(&options.recordings, None)?;
    let series = options
        .recordings
        .iter()
        .map(|path| of_joint(path, usize::from(options.joint)))
        .collect::<Result<Vec<_>, _>>()?;
    let [velocity, torque] = joined(series.iter());
    let law = Law::for_speeds(&options.law, &velocity)?;
    let JointFrictionFit { parameters, offset, rows, condition, correlation } =
        fit(&law, method, [&velocity, &torque], options)?;
    let curve = |v: f64| law.torque(&parameters, &Sliding::at(v)) + offset;
    let errors: Vec<f64> = velocity.iter().zip(&torque).map(|(v, tau)| curve(*v) - tau).collect();
    let rms = rms(&errors);
    print_rows(&rows, context);
    context.print(format_args!("error {rms:.4} N m RMS in {} samples", velocity.len()));
    let left_out = options.folds.map(|k| validated(&law, method, &series, k, options.seed)).transpose()?;
    if let Some(left_out) = &left_out {
        context.print(format_args!("on test recordings, by fold [N m]: {left_out:.4?}"));
    }
    let warnings = warnings(&velocity, &torque, &rows);
    warnings.iter().for_each(|warning| context.print(warning));
    let outcome = Outcome {
        format: IdentificationFormat::Metrics,
        version: 1,
        law: options.law.clone(),
        method: options.method.clone(),
        joint: options.joint,
        estimates: estimates(&rows),
        correlation,
        condition,
        rms_n_m: rms,
        verdict: verdict(&rows, (rms, deviation(&torque)), condition, left_out.as_deref()),
        folds_rms_n_m: left_out,
        samples: velocity.len(),
        seed: options.seed,
        warnings,
        recording_warnings: findings.into_warnings(),
        command: context.command.clone(),
        commit: COMMIT.to_owned(),
    };
    if let Some(folder) = &options.results.figures {
        let predicted = velocity.iter().map(|v| curve(*v)).collect();
        let name = format!("joint {}", options.joint);
        let joint = JointSeries::new(name, [velocity, torque, predicted], &curve);
        let folder = ReportFolder { path: folder, png: options.results.png };
        page::write(&folder, &joint, &outcome)?;
    }
    let file = Outcome { format: IdentificationFormat::Identification, ..outcome.clone() };
    options.results.write(&file, context)?;
    Ok(outcome)
}

/// A law with its parameters.
struct JointFrictionFit {
    parameters: Vec<f64>,
    offset: f64,
    rows: Vec<Row>,
    /// Of least squares alone.
    condition: Option<f64>,
    correlation: Option<Vec<Vec<f64>>>,
}

fn fit(
    law: &Law,
    method: FrictionMethod,
    [velocity, torque]: [&[f64]; 2],
    options: &Options,
) -> anyhow::Result<JointFrictionFit> {
    if method == FrictionMethod::LeastSquares {
        let FrictionFit { parameters, offset, fit } =
            identify_friction(law, velocity, torque, options.huber)?;
        let rows = fit.estimates.iter().map(Row::of_estimate).collect();
        let (condition, correlation) = (Some(fit.condition), Some(fit.correlation));
        return Ok(JointFrictionFit { parameters, offset, rows, condition, correlation });
    }
    let found = identify_friction_by(method, law, velocity, torque, options.seed)?;
    let rows = named(law, &found.parameters, found.offset);
    let (parameters, offset) = (found.parameters, found.offset);
    Ok(JointFrictionFit { parameters, offset, rows, condition: None, correlation: None })
}

/// Whether the law can be used: error and deviation of the torques [N m], condition number, errors of the folds [N m].
fn verdict(
    rows: &[Row],
    (rms, deviation): (f64, f64),
    condition: Option<f64>,
    left_out: Option<&[f64]>,
) -> Verdict {
    let claim = format!("the law gives the torque within {rms:.4} N m (RMS)");
    let statement = format!(
        "the error is {rms:.4} N m, {:.0} % of the deviation of the torques ({deviation:.4} N m)",
        100.0 * rms / deviation
    );
    let assessed = Verdict::on(claim).because(Criterion::ErrorOverSpread, rms / deviation, statement);
    let worst = left_out.and_then(|errors| errors.iter().copied().max_by(f64::total_cmp));
    parameters(assessed, &assessed_rows(rows))
        .because_of(Criterion::ConditionNumber, condition, |condition| {
            format!("the condition number of the parameters is {condition:.0}")
        })
        .because_of(Criterion::HeldOutOverFitted, worst.map(|worst| worst / rms), |ratio| {
            format!("on test recordings the error is up to {ratio:.1} times as large")
        })
        .verdict()
}

fn assessed_rows(rows: &[Row]) -> Vec<AssessedParameter<'_>> {
    assessed(rows, Some("it was held where it began, so friction there is assumed"))
}

/// Warnings about the recordings, with advice on what to record instead.
fn warnings(velocity: &[f64], torque: &[f64], rows: &[Row]) -> Vec<String> {
    let n = velocity.len() as f64;
    let mut warnings = Vec::new();
    let largest = torque.iter().fold(0.0, |most: f64, tau| most.max(tau.abs()));
    let at_largest = torque.iter().filter(|tau| tau.abs() >= largest * (1.0 - 1e-12)).count();
    if at_largest > 10 && at_largest as f64 > SATURATED * n {
        warnings.push(format!(
            "{at_largest} of {n} torques are at the largest size, {largest} N m: if the sensor or the drive was at its limit there, record \
             slower motions"
        ));
    }
    for (sign, direction) in [(1.0, "forwards"), (-1.0, "backwards")] {
        let moving = velocity.iter().filter(|v| sign * **v > 0.0).count();
        if (moving as f64) < ONE_SIDED * n {
            warnings.push(format!(
                "only {moving} of {n} samples move {direction}: friction and offset cannot be separated; record both directions"
            ));
        }
    }
    if rows.iter().any(|row| row.note.starts_with("held") || row.note.starts_with("not determined")) {
        warnings.push(
            "these motions do not excite the held parameters: record steady speeds from far below the Stribeck speed to the fastest".into(),
        );
    }
    warnings
}

/// Share of samples at the very same extreme from which on a torque may be saturated, and of a direction that is hardly there.
const SATURATED: f64 = 0.02;
const ONE_SIDED: f64 = 0.05;

fn of_joint(path: &Path, joint: usize) -> anyhow::Result<FrictionSeries> {
    let recording = read(path)?;
    let within = |bad: BadInput| bad.within(path.display());
    let recorded = ArmRecording::of(&recording).map_err(within)?;
    let column = |quantity| -> Result<Vec<f64>, BadInput> {
        let columns = recorded.require(quantity)?;
        let column = columns
            .get(joint - 1)
            .ok_or_else(|| BadInput::new("--joint", format!("1 to {}", columns.len()), joint.to_string()))?;
        // What was filled in is no measurement.
        let measured = column.iter().zip(recorded.gap).filter(|(_, gap)| !**gap);
        Ok(measured.map(|(x, _)| *x).collect())
    };
    Ok(FrictionSeries {
        velocity: column(JointQuantityKind::Velocity).map_err(within)?,
        torque: column(JointQuantityKind::Torque).map_err(within)?,
    })
}

fn joined<'a>(series: impl Iterator<Item = &'a FrictionSeries>) -> [Vec<f64>; 2] {
    let mut all = [Vec::new(), Vec::new()];
    for one in series {
        all[0].extend_from_slice(&one.velocity);
        all[1].extend_from_slice(&one.torque);
    }
    all
}

fn named(law: &Law, parameters: &[f64], offset: f64) -> Vec<Row> {
    let names = law.parameters().into_iter().map(|p| p.name.into_owned()).chain(["offset_n_m".to_owned()]);
    let row = |(name, value): (String, &f64)| Row {
        name,
        value: *value,
        standard_error: None,
        note: String::new(),
        identifiability: Identifiability::Fitted,
    };
    names.zip(parameters.iter().chain([&offset])).map(row).collect()
}

/// Error on the test recordings of each fold [N m].
fn validated(
    law: &Law,
    method: FrictionMethod,
    series: &[FrictionSeries],
    k: usize,
    seed: u64,
) -> anyhow::Result<Vec<f64>> {
    let folds = folds(series.len(), k).map_err(|bad| BadInput { place: "--folds".into(), ..bad })?;
    let left = |fold: &hysteron_fit::Fold| -> anyhow::Result<f64> {
        let [velocity, torque] = joined(fold.training.iter().map(|g| &series[*g]));
        let found = identify_friction_by(method, law, &velocity, &torque, seed)?;
        let [velocity, torque] = joined(fold.test.iter().map(|g| &series[*g]));
        let errors: Vec<f64> = velocity
            .iter()
            .zip(&torque)
            .map(|(v, tau)| law.torque(&found.parameters, &Sliding::at(*v)) + found.offset - tau)
            .collect();
        Ok(rms(&errors))
    };
    folds.iter().map(left).collect()
}

fn rms(errors: &[f64]) -> f64 {
    (errors.iter().map(|e| e * e).sum::<f64>() / errors.len().max(1) as f64).sqrt()
}
