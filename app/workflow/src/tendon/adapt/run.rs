//! The adaptation: checkpoint and recordings, the fit, the checkpoint with what is kept.

use hysteron_base::checks::Purpose;
use hysteron_report::page::write_metrics;
use hysteron_twin::residual::{AdaptMotions, AdaptOptions, AdaptedParts, adapt, n_samples};
use hysteron_twin::{RobotMotion, Twin};

use super::options::Options;
use super::outcome::{HeldOutError, Outcome, words};
use crate::shared::error::Cancelled;
use crate::shared::inputs::Input;
use crate::shared::network::Network;
use crate::shared::outputs::Outputs;
use crate::shared::{inputs, paths, recording_checks};
use crate::{Context, WorkflowError};

/// Runs the verb.
///
/// # Errors
/// Bad input; a rollout of the twin that fails; files that cannot be written.
pub fn run(options: &Options, context: &Context) -> Result<Outcome, WorkflowError> {
    Ok(adapt_network(options, context)?)
}

fn adapt_network(options: &Options, context: &Context) -> anyhow::Result<Outcome> {
    paths::check_checkpoint(&options.out)?;
    let scene = options.body.scene(&options.scene)?;
    let inputs = inputs::read(&options.recordings)?;
    let before = if options.reference.is_empty() { Vec::new() } else { inputs::read(&options.reference)? };
    let read = inputs.iter().chain(&before).map(|input| &input.path);
    let outputs = Outputs::reading(read).and([&options.checkpoint]);
    let folder = paths::report_folder(&options.out, options.figures.as_deref());
    let outputs = outputs.scene(&options.scene, &scene).file("--out", &options.out);
    let _lock = outputs.report("--figures", Some(&folder)).check(context)?;
    let twin = Twin::from_scene(&scene)?;
    let findings = recording_checks::of_inputs(&inputs, &recording_checks::context_of(&twin, Purpose::Fit))?;
    recording_checks::of_inputs(&before, &recording_checks::context_of(&twin, Purpose::Fit))?;
    let motions_of = |inputs: &[Input]| {
        let motion = |input: &Input| {
            RobotMotion::identifiable(&twin, &input.recording, &input.path.display().to_string())
        };
        inputs.iter().map(motion).collect::<Result<Vec<_>, _>>()
    };
    let (now, before) = (motions_of(&inputs)?, motions_of(&before)?);
    // From here on the stiffness is factorised.
    let network = Network::read(&options.checkpoint, &scene, &twin)?;
    for motion in now.iter().chain(&before) {
        motion.check_registration(&twin)?;
        network.rollout(&twin, motion.step).map_err(|bad| bad.within(&motion.name))?;
    }
    let motions = AdaptMotions { now: &now, before: &before };
    context.listen();
    let bar = context.progress("samples", n_samples(&twin, motions), 0);
    let on_sample = || {
        bar.inc(1);
        !context.is_cancelled()
    };
    let settings = AdaptOptions { memory_s: options.memory_s, ..AdaptOptions::default() };
    let adapted = adapt(&twin, network.auxiliary(), network.model(), motions, &settings, &on_sample)?;
    bar.finish();
    let Some(mut adapted) = adapted else { return Err(Cancelled::new("; nothing is written").into()) };
    let training = &mut adapted.model.training;
    training.adapted_to = inputs.iter().map(|input| (input.name.clone(), input.hash.clone())).collect();
    training.adapted_kept = Some(adapted.kept);
    if adapted.kept != AdaptedParts::Nothing {
        // What was left out in learning was of the robot as it was.
        training.tip_band = None;
    }
    training.provenance = Some(context.provenance());
    adapted.model.write(&options.out)?;
    let outcome = Outcome::new(&adapted, &settings, &findings, context);
    write_metrics(&folder, &outcome)?;
    print(&outcome, context);
    context.wrote(&options.out);
    Ok(outcome)
}

/// Prints errors held out, the decision, what was found and errors along the recordings.
fn print(outcome: &Outcome, context: &Context) {
    for HeldOutError { kept, rms_m } in &outcome.held_out {
        context.print(format_args!("held out, with {}: tip {:.3} mm off (rms)", words(*kept), 1e3 * rms_m));
    }
    if let Some(known) = outcome.known_error_m {
        context.print(format_args!("on the robot as it was: tip {:.3} mm off (rms)", 1e3 * known));
    }
    context.print(format_args!("kept: {}", words(outcome.kept)));
    let zeros: Vec<String> = outcome.found.zeros_m.iter().map(|zero| format!("{:.2}", 1e3 * zero)).collect();
    context.print(format_args!(
        "found: zeros {} mm, play {:.2} mm more, friction times {:.2}",
        zeros.join(", "),
        1e3 * outcome.found.play_m,
        outcome.found.friction_ratio
    ));
    for motion in &outcome.recordings {
        let outside = match motion.extrapolating {
            0.0 => String::new(),
            part => format!("; {:.0} % of it outside the network's training, not learned from", 100.0 * part),
        };
        context.print(format_args!(
            "{}: tip off by {:.3} mm (rms) before, {:.3} mm after{outside}",
            motion.name,
            1e3 * motion.before_m,
            1e3 * motion.after_m
        ));
    }
}
