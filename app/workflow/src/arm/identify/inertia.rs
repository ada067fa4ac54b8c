//! `arm identify inertia`: bodies, rotors and friction of all joints.

use std::path::PathBuf;

use hysteron_arm::identify::{BodyFit, BodyOptions, JointMotion, JointTerm, TorqueResponse, identify_bodies};
use hysteron_base::{BadInput, json};
use hysteron_report::verdict::{Criterion, Verdict};
use serde_json::Value;

use super::{
    MotionOptions, Results, Row, Summary, TERMS, joined, positive, rows_json, say_rows, worst_joint,
};
use crate::figures::arm_identification as figures;
use crate::shared::robot_file::{self, Part};
use crate::{Context, arm};

/// Bodies, rotors and friction of all joints
#[derive(Debug, Clone)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct Options {
    /// File of URDF or MJCF, or name of a built-in robot
    pub model: String,
    /// How the robot is read
    #[cfg_attr(feature = "clap", command(flatten))]
    pub robot_options: crate::arm::RobotOptions,
    /// Recordings to fit
    #[cfg_attr(feature = "clap", arg(required = true, value_name = "REC"))]
    pub recordings: Vec<PathBuf>,
    /// Recording that is not fitted, to test on
    #[cfg_attr(feature = "clap", arg(long, value_name = "REC"))]
    pub test: Option<PathBuf>,
    /// Last part of the recordings that is not fitted, to test on
    #[cfg_attr(
        feature = "clap",
        arg(long, value_name = "PART", default_value_t = 0.0, allow_negative_numbers = true)
    )]
    pub hold_out: f64,
    /// Weight of the bodies in the robot's file, in samples
    #[cfg_attr(
        feature = "clap",
        arg(long, value_name = "N", default_value_t = 1.0, allow_negative_numbers = true)
    )]
    pub prior: f64,
    /// Finds by how much measured torques lead or lag those of the rigid arm, and how they change with the frequency
    #[cfg_attr(feature = "clap", arg(long))]
    pub response: bool,
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
    let inputs = arm::reads(&options.model).and(&options.recordings).and(&options.test);
    let inputs = options.robot.iter().fold(inputs, |all, path| all.file("--robot", path));
    let _claim = options.results.claim(inputs, context)?;
    if let Some(path) = &options.robot {
        robot_file::check("--robot", path, Part::Whole)?;
    }
    options.motion.check()?;
    positive("--prior", options.prior)?;
    if !(0.0..=0.9).contains(&options.hold_out) {
        return Err(BadInput::new("--hold-out", "a part from 0 to 0.9", options.hold_out.to_string()).into());
    }
    if options.test.is_some() && options.hold_out > 0.0 {
        return Err(BadInput::new("--hold-out", "this or --test", "both").into());
    }
    let findings = super::checked(&options.recordings, Some(model))?;
    let recorded = options.motion.read_each(&options.recordings, model)?;
    let (fitted, mut held) = split(recorded, options.hold_out);
    if let Some(path) = &options.test {
        held.push(options.motion.read(path, model)?);
    }
    let motion = joined(&fitted)?;
    let test = if held.is_empty() { None } else { Some(joined(&held)?) };
    let body_options = BodyOptions { terms: &TERMS, width: options.motion.width, prior: options.prior };
    let fit = identify_bodies(model, &motion, &body_options)?;
    let rows: Vec<Row> = fit.estimates.iter().map(Row::of_term).collect();
    say_rows(&rows, context);
    let tested = test.as_ref().map(|test| fit.rms_on(test));
    context.print(format_args!("error of the torques, RMS by joint [N m]: {:.4?}", fit.rms));
    if let Some(tested) = &tested {
        context.print(format_args!("on what was not fitted: {tested:.4?}"));
    }
    context
        .print(format_args!("{} combinations determined, condition {:.0}", fit.n_determined, fit.condition));
    fit.warnings.iter().for_each(|warning| context.print(warning));
    let responds = if options.response { Some(responds(&fit, [&fitted, &held], context)?) } else { None };
    let numbers = json!({
        "robot": model.name(), "estimates": rows_json(&rows), "rms_n_m": fit.rms, "test_rms_n_m": tested,
        "n_determined": fit.n_determined, "condition": fit.condition, "warnings": fit.warnings,
        "least_pseudo_inertias": fit.least_pseudo_inertias(), "samples": motion.n_samples(),
        "cutoff_hz": options.motion.cutoff, "response": responds,
        "verdict": verdict(&fit, &motion, test.as_ref().zip(tested.as_deref())),
    });
    let summary = Summary::new(numbers, findings, context);
    if let Some(folder) = &options.results.figures {
        let shown = test.as_ref().unwrap_or(&motion);
        let page = figures::bodies::Shown {
            model,
            joints: joints(&fit, shown, options.motion.width),
            rows: &rows,
            rms: &fit.rms,
            tested: tested.as_deref(),
            warnings: &fit.warnings,
            summary: &summary,
        };
        figures::bodies::write(folder, &page, options.results.png, context)?;
    }
    if let Some(path) = &options.robot {
        robot_file::write(&fit.model, path, Part::Whole, context)?;
        context.wrote(path);
    }
    options.results.write(summary, context)
}

/// Whether the bodies give the torques: of the fitted motion, and of one that was not fitted with its errors by joint [N m].
fn verdict(fit: &BodyFit, motion: &JointMotion, test: Option<(&JointMotion, &[f64])>) -> Verdict {
    let (errors, shown, which) = match test {
        Some((motion, errors)) => (errors, motion, "on what was not fitted"),
        None => (&fit.rms[..], motion, "on what was fitted"),
    };
    let (share, joint) = worst_joint(errors, &shown.tau);
    let worst = |of: &[f64]| of.iter().zip(&fit.rms).map(|(a, b)| a / b).fold(0.0, f64::max);
    let least = fit.least_pseudo_inertias().into_iter().fold(f64::INFINITY, f64::min);
    Verdict::on(format!(
        "the identified arm gives the torques of every joint within {:.0} % of their deviation",
        100.0 * share
    ))
    .because(
        Criterion::ErrorOverSpread,
        share,
        format!(
            "{which} the error of joint {joint} is {:.0} % of the deviation of its torques",
            100.0 * share
        ),
    )
    .because_of(Criterion::HeldOutOverFitted, test.map(|(_, errors)| worst(errors)), |ratio| {
        format!("what was not fitted errs up to {ratio:.1} times as much as what was")
    })
    .because(
        Criterion::ConditionNumber,
        fit.condition,
        format!("the condition number of the combinations of parameters is {:.0}", fit.condition),
    )
    .because(
        Criterion::NotConverged,
        if least > 0.0 { 0.0 } else { 1.0 },
        if least > 0.0 { "every body is physically possible" } else { "a body is not physically possible" },
    )
    .verdict()
}

/// The first samples of all motions together, and the part that is held out.
fn split(motions: Vec<JointMotion>, hold_out: f64) -> (Vec<JointMotion>, Vec<JointMotion>) {
    let all: usize = motions.iter().map(JointMotion::n_samples).sum();
    let mut left = (all as f64 * (1.0 - hold_out)) as usize;
    let [mut fitted, mut held] = [Vec::new(), Vec::new()];
    for motion in motions {
        let (n, cut) = (motion.n_samples(), left.min(motion.n_samples()));
        left -= cut;
        for (parts, range) in [(&mut fitted, 0..cut), (&mut held, cut..n)] {
            if !range.is_empty() {
                parts.push(motion.part(range));
            }
        }
    }
    (fitted, held)
}

/// The response of measured torques, and what is left with it.
fn responds(
    fit: &BodyFit,
    [fitted, held]: [&Vec<JointMotion>; 2],
    context: &Context,
) -> anyhow::Result<Value> {
    let [fitted, held]: [Vec<&JointMotion>; 2] = [fitted.iter().collect(), held.iter().collect()];
    let response = TorqueResponse::identify(fit, &fitted)?;
    let left = response.rms_on(fit, &fitted);
    let tested = if held.is_empty() { None } else { Some(response.rms_on(fit, &held)) };
    let lead_ms: Vec<f64> = response.lead.iter().map(|lead| 1e3 * lead).collect();
    context.print(format_args!("measured torques lead by joint [ms]: {lead_ms:.2?}"));
    context.print(format_args!("error with this response [N m]: {left:.4?}"));
    if let Some(tested) = &tested {
        context.print(format_args!("on what was not fitted: {tested:.4?}"));
    }
    Ok(json!({
        "lead_s": response.lead, "second_s2": response.second, "rms_n_m": left, "test_rms_n_m": tested,
    }))
}

/// Series of every joint for the figures.
fn joints(fit: &BodyFit, motion: &JointMotion, width: f64) -> Vec<figures::JointSeries> {
    let n = motion.n_joints;
    let torques = fit.torques(motion);
    let column = |rows: &[f64], j: usize| -> Vec<f64> { rows.iter().skip(j).step_by(n).copied().collect() };
    let term = |term: JointTerm, j: usize| {
        let name = term.name(j);
        fit.estimates.iter().find(|estimate| estimate.name == name).map_or(0.0, |estimate| estimate.value)
    };
    let joint = |j: usize| {
        let (coulomb, viscous) = (term(JointTerm::Coulomb, j), term(JointTerm::Viscous, j));
        figures::JointSeries::new(
            fit.model.joints()[j].name.clone(),
            [column(&motion.dq, j), column(&motion.tau, j), column(&torques, j)],
            &|v| coulomb * (v / width).tanh() + viscous * v,
        )
    };
    (0..n).map(joint).collect()
}
