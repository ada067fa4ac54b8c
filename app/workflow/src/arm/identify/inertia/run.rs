//! Identifies the bodies, rotors and friction of all joints.

use hysteron_arm_estimation::identify::{
    BodyFit, BodyOptions, JointMotion, JointTerm, TorqueResponse, identify_bodies,
};
use hysteron_report::folder::ReportFolder;
use hysteron_report::verdict::{Criterion, Verdict};

use super::outcome::ResponseEstimate;
use super::{Options, Outcome, page};
use crate::arm::identify::motion::{TERMS, joined};
use crate::arm::identify::recordings;
use crate::arm::{self, robot::held_joints};
use crate::shared::identification::{IdentificationFormat, Row, estimates, print_rows, worst_joint};
use crate::shared::identification_page::JointSeries;
use crate::shared::robot_file::{self, Part};
use crate::{COMMIT, Context, WorkflowError};

/// Runs the verb.
///
/// # Errors
/// `BadInput` for invalid options or recordings.
pub fn run(options: &Options, context: &Context) -> Result<Outcome, WorkflowError> {
    Ok(identify(options, context)?)
}

fn identify(options: &Options, context: &Context) -> anyhow::Result<Outcome> {
    let model = &options.motion.model(&options.model, (&options.robot_options, context))?;
    let inputs = arm::reads(&options.model).and(&options.recordings).and(&options.test);
    let inputs = options.robot.iter().fold(inputs, |all, path| all.file("--robot", path));
    let _lock = options.results.lock(inputs, context)?;
    if let Some(path) = &options.robot {
        robot_file::check("--robot", path, Part::Whole)?;
    }
    options.check()?;
    let findings = recordings::checked(&options.recordings, Some(model))?;
    let recorded = options.motion.read_each(&options.recordings, model)?;
    let (fitted, mut held_out) = split(recorded, options.hold_out);
    if let Some(path) = &options.test {
        held_out.push(options.motion.read(path, model)?);
    }
    let motion = joined(&fitted)?;
    let test = if held_out.is_empty() { None } else { Some(joined(&held_out)?) };
    let body_options = BodyOptions { terms: &TERMS, width: options.motion.width, prior: options.prior };
    let fit = identify_bodies(model, &motion, &body_options)?;
    let rows: Vec<Row> = fit.estimates.iter().map(Row::of_term).collect();
    let tested = test.as_ref().map(|test| fit.rms_on(test));
    print_rows(&rows, context);
    print_errors(&fit, tested.as_deref(), context);
    let responds = if options.response { Some(responds(&fit, [&fitted, &held_out], context)?) } else { None };
    let outcome = Outcome {
        format: IdentificationFormat::Metrics,
        version: 1,
        robot: model.name().to_owned(),
        estimates: estimates(&rows),
        rms_n_m: fit.rms.clone(),
        verdict: verdict(&fit, &motion, test.as_ref().zip(tested.as_deref())),
        test_rms_n_m: tested,
        n_determined: fit.n_determined,
        condition: fit.condition,
        warnings: fit.warnings.clone(),
        least_pseudo_inertias: fit.least_pseudo_inertias(),
        samples: motion.n_samples(),
        cutoff_hz: options.motion.cutoff,
        response: responds,
        recording_warnings: findings.into_warnings(),
        held_joints: held_joints(model),
        command: context.command.clone(),
        commit: COMMIT.to_owned(),
    };
    if let Some(folder) = &options.results.figures {
        let joints = joints(&fit, test.as_ref().unwrap_or(&motion), options.motion.width);
        let folder = ReportFolder { path: folder, png: options.results.png };
        page::write(&folder, &joints, &outcome)?;
    }
    if let Some(path) = &options.robot {
        robot_file::write(&fit.model, path, Part::Whole, context)?;
        context.wrote(path);
    }
    let file = Outcome { format: IdentificationFormat::Identification, ..outcome.clone() };
    options.results.write(&file, context)?;
    Ok(outcome)
}

/// Prints the errors of the fit, and those on what was not fitted [N m].
fn print_errors(fit: &BodyFit, tested: Option<&[f64]>, context: &Context) {
    context.print(format_args!("error of the torques, RMS by joint [N m]: {:.4?}", fit.rms));
    if let Some(tested) = tested {
        context.print(format_args!("on test data: {tested:.4?}"));
    }
    context
        .print(format_args!("{} combinations determined, condition {:.0}", fit.n_determined, fit.condition));
    fit.warnings.iter().for_each(|warning| context.print(warning));
}

/// Whether the bodies give the torques: of the fitted motion, and of one that was not fitted with its errors by joint [N m].
fn verdict(fit: &BodyFit, motion: &JointMotion, test: Option<(&JointMotion, &[f64])>) -> Verdict {
    let (errors, shown, which) = match test {
        Some((motion, errors)) => (errors, motion, "on test data"),
        None => (&fit.rms[..], motion, "on fitted data"),
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
        format!("errors on test data are up to {ratio:.1} times those on fitted data")
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
    let [mut fitted, mut held_out] = [Vec::new(), Vec::new()];
    for motion in motions {
        let (n, cut) = (motion.n_samples(), left.min(motion.n_samples()));
        left -= cut;
        for (parts, range) in [(&mut fitted, 0..cut), (&mut held_out, cut..n)] {
            if !range.is_empty() {
                parts.push(motion.part(range));
            }
        }
    }
    (fitted, held_out)
}

/// The response of measured torques, and what is left with it.
fn responds(
    fit: &BodyFit,
    [fitted, held_out]: [&Vec<JointMotion>; 2],
    context: &Context,
) -> anyhow::Result<ResponseEstimate> {
    let [fitted, held_out]: [Vec<&JointMotion>; 2] = [fitted.iter().collect(), held_out.iter().collect()];
    let response = TorqueResponse::identify(fit, &fitted)?;
    let left = response.rms_on(fit, &fitted);
    let tested = if held_out.is_empty() { None } else { Some(response.rms_on(fit, &held_out)) };
    let lead_ms: Vec<f64> = response.lead.iter().map(|lead| 1e3 * lead).collect();
    context.print(format_args!("measured torques lead by joint [ms]: {lead_ms:.2?}"));
    context.print(format_args!("error with this response [N m]: {left:.4?}"));
    if let Some(tested) = &tested {
        context.print(format_args!("on test data: {tested:.4?}"));
    }
    Ok(ResponseEstimate {
        lead_s: response.lead,
        second_s2: response.second,
        rms_n_m: left,
        test_rms_n_m: tested,
    })
}

/// Series of every joint for the figures.
fn joints(fit: &BodyFit, motion: &JointMotion, width: f64) -> Vec<JointSeries> {
    let n = motion.n_joints;
    let torques = fit.torques(motion);
    let column = |rows: &[f64], j: usize| -> Vec<f64> { rows.iter().skip(j).step_by(n).copied().collect() };
    let term = |term: JointTerm, j: usize| {
        let name = term.name(j);
        fit.estimates.iter().find(|estimate| estimate.name == name).map_or(0.0, |estimate| estimate.value)
    };
    let joint = |j: usize| {
        let (coulomb, viscous) = (term(JointTerm::Coulomb, j), term(JointTerm::Viscous, j));
        JointSeries::new(
            fit.model.joints()[j].name.clone(),
            [column(&motion.dq, j), column(&motion.tau, j), column(&torques, j)],
            &|v| coulomb * (v / width).tanh() + viscous * v,
        )
    };
    (0..n).map(joint).collect()
}
