//! Identifies what an arm carries, from recordings with and without it.

use hysteron_arm_estimation::identify::{BodyOptions, identify_bodies, identify_payload};
use hysteron_report::folder::ReportFolder;
use hysteron_report::verdict::{Criterion, Verdict};

use super::{Options, Outcome, page};
use crate::arm::identify::motion::TERMS;
use crate::arm::identify::recordings;
use crate::arm::{self, robot::held_joints};
use crate::shared::identification::{IdentificationFormat, Row, estimates, print_rows};
use crate::shared::robot_file::{self, Part};
use crate::shared::verdict::ratio;
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
    let inputs = arm::reads(&options.model).and(&options.bare).and(&options.recordings);
    let inputs = options.robot.iter().fold(inputs, |all, path| all.file("--robot", path));
    let _lock = options.results.lock(inputs, context)?;
    if let Some(path) = &options.robot {
        robot_file::check("--robot", path, Part::Whole)?;
    }
    options.motion.check()?;
    let last = model.frames().last().map_or("", |frame| frame.name.as_str());
    let frame = options.frame.as_deref().unwrap_or(last);
    model.frame(frame)?;
    let findings = recordings::checked(&[&options.bare[..], &options.recordings].concat(), Some(model))?;
    let bare = options.motion.read_all(&options.bare, model)?;
    let loaded = options.motion.read_all(&options.recordings, model)?;
    let known = identify_bodies(
        model,
        &bare,
        &BodyOptions { terms: &TERMS, width: options.motion.width, prior: 1.0 },
    )?;
    let found = identify_payload(&known, frame, &loaded)?;
    let rows: Vec<Row> = found.estimates.iter().map(Row::of_term).collect();
    context.print(format_args!("payload at {frame}, in its axes:"));
    print_rows(&rows, context);
    context.print(format_args!("error of the torques without it, RMS by joint [N m]: {:.4?}", found.rms[0]));
    context.print(format_args!("with it: {:.4?}", found.rms[1]));
    context.print(format_args!("of the bare arm: {:.4?}", known.rms));
    let [without, with] = &found.rms;
    let outcome = Outcome {
        format: IdentificationFormat::Metrics,
        version: 1,
        robot: model.name().to_owned(),
        frame: frame.to_owned(),
        estimates: estimates(&rows),
        rms_without_n_m: without.clone(),
        rms_with_n_m: with.clone(),
        rms_bare_n_m: known.rms,
        samples: loaded.n_samples(),
        cutoff_hz: options.motion.cutoff,
        verdict: verdict(&rows, &found.rms),
        recording_warnings: findings.into_warnings(),
        held_joints: held_joints(model),
        command: context.command.clone(),
        commit: COMMIT.to_owned(),
    };
    if let Some(folder) = &options.results.figures {
        let folder = ReportFolder { path: folder, png: options.results.png };
        page::write(&folder, model, &outcome)?;
    }
    if let Some(path) = &options.robot {
        robot_file::write(&found.model, path, Part::Whole, context)?;
        context.wrote(path);
    }
    let file = Outcome { format: IdentificationFormat::Identification, ..outcome.clone() };
    options.results.write(&file, context)?;
    Ok(outcome)
}

/// Whether the payload can be used: errors of the torques without and with it, by joint [N m].
fn verdict(rows: &[Row], rms: &[Vec<f64>; 2]) -> Verdict {
    let size = |errors: &[f64]| errors.iter().map(|e| e * e).sum::<f64>().sqrt();
    let (without, with) = (size(&rms[0]), size(&rms[1]));
    // The mass comes first.
    let mass = rows.first();
    let claim = mass.map_or_else(String::new, |row| format!("{} is {:.4}", row.name, row.value));
    let relative = mass.and_then(|row| Some(row.standard_error? / row.value.abs()));
    Verdict::on(claim)
        .because(
            Criterion::ErrorOverBaseline,
            ratio(with, without),
            format!("the torques are off by {with:.4} N m with the payload, {without:.4} N m without"),
        )
        .because_of(Criterion::RelativeStandardError, relative, |error| {
            format!("the mass has a standard error of {:.0} % of its value", 100.0 * error)
        })
        .verdict()
}
