//! `hysteron arm excite`: motions that make parameters visible.

use std::path::PathBuf;

use hysteron_arm::{
    ExcitationOptions, Law, LimitOptions, Motion, MotionLimits, PointToPoint, exciting_trajectory, states_of,
};
use hysteron_base::{BadInput, Metadata};

use hysteron_workflow::{Caller, excitation_figures};
use serde_json::{Value, json};

use crate::terminal::say;

const HELP: &str = "\
Writes a recording with q_k, dq_k and ddq_k of every joint, which `hysteron arm dynamics --states` reads.

fourier is a finite Fourier series that begins and ends at rest, whose regressor has the smallest condition number that a seeded \
particle swarm finds: of all bodies' parameters, armatures, viscous and dry frictions that torques can tell apart. quintic and \
cycloid move from rest at --from to rest at --to, as fast as limits allow or in --duration.

Limits are those of the robot's file: range, speed, torque (with its damping and dry friction). The arm's own shape and what stands \
around it are not known: look at the figures before a robot follows it.

Examples:
  hysteron arm excite three-link --out out/arm/exciting.csv --figures out/arm/exciting
  hysteron arm excite three-link --shape quintic --from 0,0,0 --to 1,-0.5,0.8 --out out/arm/move.csv

Exit codes: 0 done, 1 failed or interrupted, 2 bad input (nothing is written).";

/// Shape of a motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Shape {
    /// Fourier series of least condition number
    Fourier,
    /// Polynomial of fifth order from rest to rest
    Quintic,
    /// Sinusoidal acceleration from rest to rest
    Cycloid,
}

/// Design a motion that shows the parameters of an arm
#[derive(Debug, clap::Args)]
#[command(after_help = HELP)]
pub struct Arguments {
    /// File of URDF or MJCF, or name of a built-in robot
    model: String,
    /// Where the motion goes, .csv or .parquet
    #[arg(long, value_name = "REC")]
    out: PathBuf,
    /// Shape of the motion
    #[arg(long, value_enum, default_value = "fourier")]
    shape: Shape,
    /// Duration [default: 10 of a Fourier series, else as fast as limits allow]
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    duration_s: Option<f64>,
    /// Harmonics of the series
    #[arg(long, value_name = "N", default_value = "5", value_parser = clap::value_parser!(u16).range(2..=20))]
    harmonics: u16,
    /// Most generations of the search
    #[arg(long, value_name = "N", default_value = "150", value_parser = clap::value_parser!(u32).range(1..=100_000))]
    generations: u32,
    /// Seed of the search
    #[arg(long, value_name = "N", default_value = "1")]
    seed: u64,
    /// Coordinates at the start, in rad or m
    #[arg(long, value_name = "Q,...", value_delimiter = ',', allow_negative_numbers = true)]
    from: Vec<f64>,
    /// Coordinates at the end, in rad or m
    #[arg(long, value_name = "Q,...", value_delimiter = ',', allow_negative_numbers = true)]
    to: Vec<f64>,
    /// Part of every limit that is used
    #[arg(long, value_name = "PART", default_value = "0.9", allow_negative_numbers = true)]
    limits: f64,
    /// Greatest speed of joints whose file says none, in rad/s or m/s
    #[arg(long, value_name = "SPEED", allow_negative_numbers = true)]
    speed_limit: Option<f64>,
    /// Greatest acceleration of all joints, in rad/s^2 or m/s^2
    #[arg(long, value_name = "ACCELERATION", allow_negative_numbers = true)]
    acceleration_limit: Option<f64>,
    /// Rate of the rows
    #[arg(long, value_name = "HZ", default_value = "100", allow_negative_numbers = true)]
    rate: f64,
    /// Folder for figures, report.html and metrics.json
    #[arg(long, value_name = "DIR")]
    figures: Option<PathBuf>,
    /// Write each figure as .png too
    #[arg(long, requires = "figures")]
    png: bool,
}

/// Carries out the verb.
pub fn run(arguments: &Arguments, caller: &Caller) -> anyhow::Result<Value> {
    let model = super::model(&arguments.model)?;
    let options = LimitOptions {
        part: arguments.limits,
        speed: arguments.speed_limit,
        acceleration: arguments.acceleration_limit,
    };
    let limits = MotionLimits::of(&model, options)?;
    let outputs = super::reads(&arguments.model).file("--out", &arguments.out);
    let _claim = outputs.report("--figures", arguments.figures.as_deref()).check(caller)?;
    let mut meta = super::meta("designed motion of an arm");
    let states = match law(arguments.shape) {
        Some(law) => {
            let ends = [&arguments.from[..], &arguments.to];
            let motion = PointToPoint::new(&model, ends, arguments.duration_s, law, &limits)
                .map_err(|bad| BadInput { place: format!("--{}", bad.place), ..bad })?;
            say(format_args!("{:.3} s from rest to rest", motion.duration()));
            states_of(&model, &motion, arguments.rate, meta)?
        }
        None => {
            let motion = fourier(arguments, &model, (&limits, caller), &mut meta)?;
            states_of(&model, &motion, arguments.rate, meta)?
        }
    };
    states.write(&arguments.out)?;
    if let Some(folder) = &arguments.figures {
        excitation_figures::write(folder, &model, &states, arguments.png)?;
    }
    say(format_args!("{} rows: {}", states.n_samples(), arguments.out.display()));
    let number = |key: &str| states.meta().extra.get(key).and_then(|text| text.parse::<f64>().ok());
    Ok(json!({
        "duration_s": states.time()[states.n_samples() - 1], "samples": states.n_samples(),
        "condition_number": number("condition_number"), "condition_number_before": number("condition_number_before"),
    }))
}

fn law(shape: Shape) -> Option<Law> {
    match shape {
        Shape::Fourier => None,
        Shape::Quintic => Some(Law::Quintic),
        Shape::Cycloid => Some(Law::Cycloid),
    }
}

fn fourier(
    arguments: &Arguments,
    model: &hysteron_arm::Model,
    (limits, caller): (&MotionLimits, &Caller),
    meta: &mut Metadata,
) -> anyhow::Result<hysteron_arm::Fourier> {
    caller.listen()?;
    let bar = caller.progress("generations", arguments.generations as usize, 0);
    let watch = |_: usize, _: f64| {
        bar.inc(1);
        !caller.is_cancelled()
    };
    let options = ExcitationOptions {
        period: arguments.duration_s.unwrap_or(10.0),
        harmonics: usize::from(arguments.harmonics),
        generations: arguments.generations as usize,
        seed: arguments.seed,
        watch: &watch,
    };
    let found = exciting_trajectory(model, limits, &options)?;
    bar.finish();
    if caller.is_cancelled() {
        anyhow::bail!("interrupted; nothing was written");
    }
    say(format_args!(
        "{} parameters, condition number {:.1}; {:.1} of a drawn series within the same limits",
        found.n_parameters, found.condition, found.condition_before
    ));
    meta.seed = Some(arguments.seed);
    for (key, value) in [
        ("base_parameters", found.n_parameters.to_string()),
        ("condition_number", found.condition.to_string()),
        ("condition_number_before", found.condition_before.to_string()),
    ] {
        meta.extra.insert(key.to_owned(), value);
    }
    Ok(found.motion)
}
