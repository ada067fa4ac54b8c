//! Designs a motion, by a search or from rest to rest, and writes its states.

use hysteron_arm_dynamics::Model;
use hysteron_arm_estimation::{
    Excitation, ExcitationOptions, LimitOptions, Motion, MotionLaw, MotionLimits, PointToPoint,
    exciting_trajectory, states_of,
};
use hysteron_base::{BadInput, Metadata};
use hysteron_report::folder::ReportFolder;

use super::options::Shape;
use super::{Options, Outcome, page};
use crate::shared::error::Cancelled;
use crate::{Context, WorkflowError, arm};

/// Runs the verb.
///
/// # Errors
/// Bad input; files that cannot be written.
pub fn run(options: &Options, context: &Context) -> Result<Outcome, WorkflowError> {
    Ok(excite(options, context)?)
}

fn excite(options: &Options, context: &Context) -> anyhow::Result<Outcome> {
    if options.shape == Shape::Fourier && !(options.from.is_empty() && options.to.is_empty()) {
        let option = if options.from.is_empty() { "--to" } else { "--from" };
        let bad = BadInput::new(option, "--shape quintic or cycloid with it", "a Fourier series");
        return Err(bad.hint("a Fourier series begins and ends where its search finds best").into());
    }
    let model = options.robot_options.model(&options.model, context)?;
    let requested = LimitOptions {
        part: options.limits,
        speed: options.speed_limit,
        acceleration: options.acceleration_limit,
    };
    let limits = MotionLimits::of(&model, requested)?;
    let outputs = arm::reads(&options.model).recording("--out", &options.out);
    let _lock = outputs.report("--figures", options.figures.as_deref()).check(context)?;
    let mut meta = arm::meta(context, "designed motion of an arm");
    let (states, found) = match law(options.shape) {
        Some(law) => {
            let ends = [&options.from[..], &options.to];
            let motion = PointToPoint::new(&model, ends, options.duration_s, law, &limits)
                .map_err(|bad| BadInput { place: format!("--{}", bad.place), ..bad })?;
            context.print(format_args!("{:.3} s from rest to rest", motion.duration()));
            (states_of(&model, &motion, options.rate, meta)?, None)
        }
        None => {
            let found = fourier(options, &model, (&limits, context), &mut meta)?;
            (states_of(&model, &found.motion, options.rate, meta)?, Some(found))
        }
    };
    states.write(&options.out)?;
    let outcome = Outcome::new(&model, &states, found.as_ref());
    if let Some(folder) = &options.figures {
        let folder = ReportFolder { path: folder, png: options.png };
        page::write(&folder, (&model, &states), &outcome)?;
    }
    context.print(format_args!("{} rows: {}", states.n_samples(), options.out.display()));
    Ok(outcome)
}

fn law(shape: Shape) -> Option<MotionLaw> {
    match shape {
        Shape::Fourier => None,
        Shape::Quintic => Some(MotionLaw::Quintic),
        Shape::Cycloid => Some(MotionLaw::Cycloid),
    }
}

fn fourier(
    options: &Options,
    model: &Model,
    (limits, context): (&MotionLimits, &Context),
    meta: &mut Metadata,
) -> anyhow::Result<Excitation> {
    context.listen();
    let bar = context.progress("generations", options.generations as usize, 0);
    let watch = |_: usize, _: f64| {
        bar.inc(1);
        !context.is_cancelled()
    };
    let search = ExcitationOptions {
        period: options.duration_s.unwrap_or(10.0),
        harmonics: usize::from(options.harmonics),
        generations: options.generations as usize,
        seed: options.seed,
        watch: &watch,
    };
    let found = exciting_trajectory(model, limits, &search)?;
    bar.finish();
    if context.is_cancelled() {
        return Err(Cancelled::new("; nothing was written").into());
    }
    context.print(format_args!(
        "{} parameters, condition number {:.1}; {:.1} of a drawn series within the same limits",
        found.n_parameters, found.condition, found.condition_before
    ));
    meta.seed = Some(options.seed);
    for (key, value) in [
        ("base_parameters", found.n_parameters.to_string()),
        ("condition_number", found.condition.to_string()),
        ("condition_number_before", found.condition_before.to_string()),
    ] {
        meta.extra.insert(key.to_owned(), value);
    }
    Ok(found)
}
