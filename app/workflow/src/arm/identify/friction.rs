//! `arm identify friction`: a law of friction of one joint.

use std::path::{Path, PathBuf};

use hysteron_actuator::identify::{FrictionFit, FrictionMethod, identify_friction, identify_friction_by};
use hysteron_actuator::law::{JointFriction, LAW_NAMES, LEARNED_MAP, Law, RISING_MAP, Sliding};
use hysteron_arm::{Quantity, Recorded};
use hysteron_base::{BadInput, json};
use hysteron_fit::{Standing, folds};
use hysteron_report::verdict::{Criterion, Verdict};
use serde_json::Value;

use super::{Results, Row, Summary, deviation, judged, positive, read, rows_json, say_rows};
use crate::Context;
use crate::figures::arm_identification as figures;
use crate::shared::outputs::Outputs;
use crate::shared::verdict::parameters;

/// Laws that need no torques through the gear.
const LAWS_OF_SPEED: usize = 3;

/// A law of friction of one joint
#[derive(Debug, Clone)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct Options {
    /// Recordings to fit
    #[cfg_attr(feature = "clap", arg(required = true, value_name = "REC"))]
    pub recordings: Vec<PathBuf>,
    /// Number of the joint, from 1
    #[cfg_attr(feature = "clap", arg(long, value_name = "K", default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=64)))]
    pub joint: u16,
    /// coulomb-viscous, stribeck, directed-stribeck, learned-map: a curve of any shape, or rising-map: one that does not fall
    #[cfg_attr(feature = "clap", arg(long, value_name = "NAME", default_value = "stribeck"))]
    pub law: String,
    /// least-squares, pso, de, anfis or fnn
    #[cfg_attr(feature = "clap", arg(long, value_name = "NAME", default_value = "least-squares"))]
    pub method: String,
    /// Parts of the recordings of which each is left out once
    #[cfg_attr(feature = "clap", arg(long, value_name = "N"))]
    pub folds: Option<usize>,
    /// Error from which on a sample counts linearly rather than squared
    #[cfg_attr(feature = "clap", arg(long, value_name = "N_M", allow_negative_numbers = true))]
    pub huber: Option<f64>,
    /// Seed of populations
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", default_value_t = 1))]
    pub seed: u64,
    /// Where the results go.
    #[cfg_attr(feature = "clap", command(flatten))]
    pub results: Results,
}

/// Speeds and torques of a joint in one recording.
struct Series {
    velocity: Vec<f64>,
    torque: Vec<f64>,
}

/// Carries out the verb.
///
/// # Errors
/// `BadInput` for whatever is wrong with options or recordings.
pub fn run(options: &Options, context: &Context) -> anyhow::Result<Value> {
    let method = checked(options)?;
    let _claim = options.results.claim(Outputs::reading(&options.recordings), context)?;
    let findings = super::checked(&options.recordings, None)?;
    let series = options
        .recordings
        .iter()
        .map(|path| of_joint(path, usize::from(options.joint)))
        .collect::<Result<Vec<_>, _>>()?;
    let [velocity, torque] = joined(series.iter());
    let law = Law::for_speeds(&options.law, &velocity)?;
    let (found, rows, condition) = match method {
        FrictionMethod::LeastSquares => {
            let FrictionFit { parameters, offset, fit } =
                identify_friction(&law, &velocity, &torque, options.huber)?;
            let rows: Vec<Row> = fit.estimates.iter().map(Row::of_estimate).collect();
            ((parameters, offset), rows, Some((fit.condition, fit.correlation)))
        }
        _ => {
            let found = identify_friction_by(method, &law, &velocity, &torque, options.seed)?;
            let rows = named(&law, &found.parameters, found.offset);
            ((found.parameters, found.offset), rows, None)
        }
    };
    let curve = |v: f64| law.torque(&found.0, &Sliding::at(v)) + found.1;
    let errors: Vec<f64> = velocity.iter().zip(&torque).map(|(v, tau)| curve(*v) - tau).collect();
    let rms = rms(&errors);
    say_rows(&rows, context);
    context.print(format_args!("error {rms:.4} N m RMS in {} samples", velocity.len()));
    let left_out = options.folds.map(|k| validated(&law, method, &series, k, options.seed)).transpose()?;
    if let Some(left_out) = &left_out {
        context.print(format_args!("on recordings that were left out, by fold [N m]: {left_out:.4?}"));
    }
    let warnings = warnings(&velocity, &torque, &rows);
    warnings.iter().for_each(|warning| context.print(warning));
    let numbers = json!({
        "law": options.law, "method": options.method, "joint": options.joint, "estimates": rows_json(&rows),
        "correlation": condition.as_ref().map(|(_, correlation)| correlation),
        "condition": condition.as_ref().map(|(condition, _)| condition), "rms_n_m": rms, "folds_rms_n_m": left_out,
        "samples": velocity.len(), "seed": options.seed, "warnings": warnings,
        "verdict": verdict(&rows, (rms, deviation(&torque)), condition.as_ref().map(|it| it.0), left_out.as_deref()),
    });
    let summary = Summary::new(numbers, findings, context);
    if let Some(folder) = &options.results.figures {
        let predicted = velocity.iter().map(|v| curve(*v)).collect();
        let joint = figures::JointSeries::new(
            format!("joint {}", options.joint),
            [velocity, torque, predicted],
            &curve,
        );
        figures::friction::write(
            folder,
            &options.law,
            &joint,
            &rows,
            &summary,
            options.results.png,
            context,
        )?;
    }
    options.results.write(summary, context)
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
    let judged = Verdict::on(claim).because(Criterion::ErrorOverSpread, rms / deviation, statement);
    let worst = left_out.and_then(|errors| errors.iter().copied().max_by(f64::total_cmp));
    parameters(judged, &judged_rows(rows))
        .because_of(Criterion::ConditionNumber, condition, |condition| {
            format!("the condition number of the parameters is {condition:.0}")
        })
        .because_of(Criterion::HeldOutOverFitted, worst.map(|worst| worst / rms), |ratio| {
            format!("on recordings that were left out the error is up to {ratio:.1} times as large")
        })
        .verdict()
}

fn judged_rows(rows: &[Row]) -> Vec<crate::shared::verdict::Judged<'_>> {
    judged(rows, Some("it was held where it began, so friction there is assumed"))
}

fn checked(options: &Options) -> anyhow::Result<FrictionMethod> {
    let laws = [&LAW_NAMES[..LAWS_OF_SPEED], &[LEARNED_MAP, RISING_MAP]].concat();
    if !laws.contains(&options.law.as_str()) {
        let expected = format!("one of {}", laws.join(", "));
        return Err(BadInput::new("--law", expected, format!("{:?}", options.law)).into());
    }
    if let Some(huber) = options.huber {
        positive("--huber", huber)?;
    }
    let n = options.recordings.len();
    if let Some(k) = options.folds.filter(|k| !(2..=n).contains(k)) {
        let expected = match n {
            1 => "two or more recordings with it".to_owned(),
            _ => format!("2 to {n}, the number of recordings"),
        };
        return Err(BadInput::new("--folds", expected, k.to_string()).into());
    }
    let method =
        FrictionMethod::named(&options.method).map_err(|bad| BadInput { place: "--method".into(), ..bad })?;
    if options.huber.is_some() && method != FrictionMethod::LeastSquares {
        return Err(BadInput::new("--huber", "--method least-squares with it", options.method.clone()).into());
    }
    Ok(method)
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
                "only {moving} of {n} samples move {direction}: friction and offset cannot be told apart; record both directions"
            ));
        }
    }
    if rows.iter().any(|row| row.note.starts_with("held") || row.note.starts_with("not determined")) {
        warnings.push(
            "held numbers were not seen in these motions: record steady speeds from far below the Stribeck speed to the fastest".into(),
        );
    }
    warnings
}

/// Share of samples at the very same extreme from which on a torque may be saturated, and of a direction that is hardly there.
const SATURATED: f64 = 0.02;
const ONE_SIDED: f64 = 0.05;

fn of_joint(path: &Path, joint: usize) -> anyhow::Result<Series> {
    let recording = read(path)?;
    let within = |bad: BadInput| bad.within(path.display());
    let recorded = Recorded::of(&recording).map_err(within)?;
    let column = |quantity| -> Result<Vec<f64>, BadInput> {
        let columns = recorded.require(quantity)?;
        let column = columns
            .get(joint - 1)
            .ok_or_else(|| BadInput::new("--joint", format!("1 to {}", columns.len()), joint.to_string()))?;
        // What was filled in is no measurement.
        let measured = column.iter().zip(recorded.gap).filter(|(_, gap)| !**gap);
        Ok(measured.map(|(x, _)| *x).collect())
    };
    Ok(Series {
        velocity: column(Quantity::Velocity).map_err(within)?,
        torque: column(Quantity::Torque).map_err(within)?,
    })
}

fn joined<'a>(series: impl Iterator<Item = &'a Series>) -> [Vec<f64>; 2] {
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
        standing: Standing::Fitted,
    };
    names.zip(parameters.iter().chain([&offset])).map(row).collect()
}

/// Error on the recordings that each fold leaves out [N m].
fn validated(
    law: &Law,
    method: FrictionMethod,
    series: &[Series],
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
