//! `hysteron arm excite`: motions that make parameters visible.

use std::path::PathBuf;

use hysteron_arm::{
    ExcitationOptions, Law, LimitOptions, Motion, MotionLimits, PointToPoint, exciting_trajectory, states_of,
};
use hysteron_base::{BadInput, Metadata};

use serde_json::Value;

use crate::shared::error::Cancelled;
use crate::{Context, excitation_figures};

/// Shape of a motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum Shape {
    /// Fourier series of least condition number
    Fourier,
    /// Polynomial of fifth order from rest to rest
    Quintic,
    /// Sinusoidal acceleration from rest to rest
    Cycloid,
}

/// Design a motion that shows the parameters of an arm
#[derive(Debug, Clone)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct Options {
    /// File of URDF or MJCF, or name of a built-in robot
    pub model: String,
    /// How the robot is read
    #[cfg_attr(feature = "clap", command(flatten))]
    pub robot_options: super::RobotOptions,
    /// Where the motion goes, .csv or .parquet
    #[cfg_attr(feature = "clap", arg(long, value_name = "REC"))]
    pub out: PathBuf,
    /// Shape of the motion
    #[cfg_attr(feature = "clap", arg(long, value_enum, default_value = "fourier"))]
    pub shape: Shape,
    /// Duration [default: 10 of a Fourier series, else as fast as limits allow]
    #[cfg_attr(feature = "clap", arg(long, value_name = "S", allow_negative_numbers = true))]
    pub duration_s: Option<f64>,
    /// Harmonics of the series
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", default_value = "5", value_parser = clap::value_parser!(u16).range(2..=20)))]
    pub harmonics: u16,
    /// Most generations of the search
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", default_value = "150", value_parser = clap::value_parser!(u32).range(1..=100_000)))]
    pub generations: u32,
    /// Seed of the search
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", default_value = "1"))]
    pub seed: u64,
    /// Coordinates at the start, in rad or m
    #[cfg_attr(
        feature = "clap",
        arg(long, value_name = "Q,...", value_delimiter = ',', allow_negative_numbers = true)
    )]
    pub from: Vec<f64>,
    /// Coordinates at the end, in rad or m
    #[cfg_attr(
        feature = "clap",
        arg(long, value_name = "Q,...", value_delimiter = ',', allow_negative_numbers = true)
    )]
    pub to: Vec<f64>,
    /// Part of every limit that is used
    #[cfg_attr(
        feature = "clap",
        arg(long, value_name = "PART", default_value = "0.9", allow_negative_numbers = true)
    )]
    pub limits: f64,
    /// Greatest speed of joints whose file says none, in rad/s or m/s
    #[cfg_attr(feature = "clap", arg(long, value_name = "SPEED", allow_negative_numbers = true))]
    pub speed_limit: Option<f64>,
    /// Greatest acceleration of all joints, in rad/s^2 or m/s^2
    #[cfg_attr(feature = "clap", arg(long, value_name = "ACCELERATION", allow_negative_numbers = true))]
    pub acceleration_limit: Option<f64>,
    /// Rate of the rows
    #[cfg_attr(
        feature = "clap",
        arg(long, value_name = "HZ", default_value = "100", allow_negative_numbers = true)
    )]
    pub rate: f64,
    /// Folder for figures, report.html and metrics.json
    #[cfg_attr(feature = "clap", arg(long, value_name = "DIR"))]
    pub figures: Option<PathBuf>,
    /// Write each figure as .png too
    #[cfg_attr(feature = "clap", arg(long, requires = "figures"))]
    pub png: bool,
}

/// Carries out the verb.
///
/// # Errors
/// Bad input; files that cannot be written.
pub fn run(options: &Options, context: &Context) -> anyhow::Result<Value> {
    if options.shape == Shape::Fourier && !(options.from.is_empty() && options.to.is_empty()) {
        let option = if options.from.is_empty() { "--to" } else { "--from" };
        let bad = BadInput::new(option, "--shape quintic or cycloid with it", "a Fourier series");
        return Err(bad.hint("a Fourier series begins and ends where its search finds best").into());
    }
    let model = options.robot_options.model(&options.model, context)?;
    let wanted = LimitOptions {
        part: options.limits,
        speed: options.speed_limit,
        acceleration: options.acceleration_limit,
    };
    let limits = MotionLimits::of(&model, wanted)?;
    let outputs = super::reads(&options.model).recording("--out", &options.out);
    let _claim = outputs.report("--figures", options.figures.as_deref()).check(context)?;
    let mut meta = super::meta(context, "designed motion of an arm");
    let states = match law(options.shape) {
        Some(law) => {
            let ends = [&options.from[..], &options.to];
            let motion = PointToPoint::new(&model, ends, options.duration_s, law, &limits)
                .map_err(|bad| BadInput { place: format!("--{}", bad.place), ..bad })?;
            context.print(format_args!("{:.3} s from rest to rest", motion.duration()));
            states_of(&model, &motion, options.rate, meta)?
        }
        None => {
            let motion = fourier(options, &model, (&limits, context), &mut meta)?;
            states_of(&model, &motion, options.rate, meta)?
        }
    };
    states.write(&options.out)?;
    let value = match &options.figures {
        Some(folder) => excitation_figures::write(folder, &model, &states, options.png)?,
        None => excitation_figures::summarise(&model, &states)?,
    };
    context.print(format_args!("{} rows: {}", states.n_samples(), options.out.display()));
    Ok(value)
}

fn law(shape: Shape) -> Option<Law> {
    match shape {
        Shape::Fourier => None,
        Shape::Quintic => Some(Law::Quintic),
        Shape::Cycloid => Some(Law::Cycloid),
    }
}

fn fourier(
    options: &Options,
    model: &hysteron_arm::Model,
    (limits, context): (&MotionLimits, &Context),
    meta: &mut Metadata,
) -> anyhow::Result<hysteron_arm::Fourier> {
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
    Ok(found.motion)
}
