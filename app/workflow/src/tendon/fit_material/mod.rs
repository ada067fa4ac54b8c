//! `hysteron fit-material`: the physical parameters of a scene from recordings of its robot.

mod outcome;
mod quantities;
mod scene_file;

use std::path::PathBuf;
use std::time::Instant;

use anyhow::Context as _;
use hysteron_base::checks::Purpose;
use hysteron_base::{BadInput, Recording, Scene};
use hysteron_twin::fit::{Fit, FitParameter, MaterialOptions, Stepping, TipFrame, fit_material, select};
use hysteron_twin::{Motion, Twin};

use serde_json::Value;

use crate::figures::fit as report;
use crate::shared::error::Cancelled;
use crate::shared::outputs::Outputs;
use crate::{Context, shared::inputs, shared::locking, shared::recording_checks};
pub(crate) use outcome::Outcome;
pub use outcome::{digits, standing};

/// More than any set of recordings has.
pub const MAX_STEPS: usize = 10_000_000;

/// Fit modulus, zero offsets and the like to recordings
///
/// Finds the parameters with which the twin's tip comes nearest to the measured one, with standard errors.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct Options {
    /// Scene file of the robot (scene.toml)
    pub scene: PathBuf,
    /// Recordings with commands and tip, or folders of them
    #[cfg_attr(feature = "clap", arg(required = true, value_name = "REC"))]
    pub recordings: Vec<PathBuf>,
    /// Scene file to write
    #[cfg_attr(feature = "clap", arg(long, value_name = "SCENE"))]
    pub out: PathBuf,
    /// Folder for figures, report.html and metrics.json
    #[cfg_attr(feature = "clap", arg(long, value_name = "DIR"))]
    pub figures: Option<PathBuf>,
    /// Write each figure as .png too
    #[cfg_attr(feature = "clap", arg(long, requires = "figures"))]
    pub png: bool,
    /// What to fit, by name
    #[cfg_attr(feature = "clap", arg(long, value_name = "NAME,...", value_delimiter = ',', default_values_t = default_names()))]
    pub fit: Vec<String>,
    /// File with what to fit and its bounds, in place of --fit
    #[cfg_attr(feature = "clap", arg(long, value_name = "TOML", conflicts_with = "fit"))]
    pub fit_file: Option<PathBuf>,
    /// Take only recordings made for this: training, validation or test
    #[cfg_attr(feature = "clap", arg(long, value_name = "ROLE"))]
    pub role: Option<String>,
    /// Step through samples between which a stroke (or, under tension, the tip) moves at most so far; samples where a
    /// stroke turns back are among them
    #[cfg_attr(feature = "clap", arg(long, value_name = "MM", default_value_t = 0.3, value_parser = crate::shared::number::length_mm))]
    pub step_mm: f64,
    /// Compare the tip where a stroke has moved so far since it was compared last
    #[cfg_attr(feature = "clap", arg(long, value_name = "MM", default_value_t = 0.2, value_parser = crate::shared::number::length_mm))]
    pub every_mm: f64,
    /// Most steps of an evaluation, shared evenly by the recordings: of each, the beginning
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", default_value_t = 2000, value_parser = crate::shared::number::count::<MAX_STEPS>))]
    pub steps: usize,
    /// Largest tension that the drives can make [default: tension_max_n of the scene]; what needs more than four
    /// fifths of it fits the worse
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", value_parser = crate::shared::number::weight))]
    pub tension_max_n: Option<f64>,
    /// Error of a coordinate from which on it counts linearly rather than squared
    #[cfg_attr(feature = "clap", arg(long, value_name = "MM", value_parser = crate::shared::number::length_mm))]
    pub huber_mm: Option<f64>,
    /// Frame of the measured tip: the scene's (a tip that rests elsewhere is refused), the scene's wherever the tip
    /// rests, or one to be found
    #[cfg_attr(feature = "clap", arg(long, value_enum, default_value_t = FrameChoice::Scene))]
    pub frame: FrameChoice,
}

/// How the frame of the recordings stands to that of gravity.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum FrameChoice {
    /// As in the scene, and checked
    Scene,
    /// As in the scene
    Trust,
    /// Fitted
    Fit,
}

impl From<FrameChoice> for TipFrame {
    fn from(choice: FrameChoice) -> Self {
        match choice {
            FrameChoice::Scene => Self::Checked,
            FrameChoice::Trust => Self::Trusted,
            FrameChoice::Fit => Self::Fitted,
        }
    }
}

#[cfg(feature = "clap")]
fn default_names() -> Vec<String> {
    ["youngs_modulus", "zero", "compliance"].map(str::to_owned).to_vec()
}

/// Carries out the verb.
pub fn run(options: &Options, context: &Context) -> anyhow::Result<Value> {
    check_arguments(options)?;
    let scene = Scene::read(&options.scene)?;
    let names = match &options.fit_file {
        Some(path) => quantities::read(path)?,
        None => options.fit.iter().map(FitParameter::named).collect(),
    };
    let selected = select(&scene, &names)?;
    let files = inputs::files(&options.recordings)?;
    let outputs = Outputs::reading(&files).scene(&options.scene, &scene).and(&options.fit_file);
    let outputs = outputs.file("--out", &options.out).report("--figures", options.figures.as_deref());
    let _claim = outputs.check(context)?;
    let mesh = hysteron_fem::read_mesh(&scene.mesh_path, scene.mesh_unit.to_m())?;
    let twin = Twin::new(&scene, &mesh)?;
    let findings = recording_checks::of_files(&files, &recording_checks::context_of(&twin, Purpose::Fit))?;
    locking::warn_before_fit(&scene)?;
    let motions = motions(&files, options.role.as_deref(), &twin)?;
    let n_other_role = files.len() - motions.len();
    tracing::info!(
        "{}: {} parameters, {} recordings, {} samples; {n_other_role} recordings of another role left out",
        scene.name,
        selected.len(),
        motions.len(),
        motions.iter().map(|motion| motion.len()).sum::<usize>(),
    );

    context.listen();
    let bar = context.progress("steps of the twin", 0, 0);
    let settings = MaterialOptions {
        frame: options.frame.into(),
        stepping: Stepping {
            step: 1e-3 * options.step_mm,
            every: 1e-3 * options.every_mm,
            most: options.steps,
        },
        huber: options.huber_mm.map(|mm| 1e-3 * mm),
        tension_max: options.tension_max_n,
        watch: &|progress| {
            bar.set_position(progress.steps as u64);
            bar.set_message(format!("RMSE {:.3} mm per coordinate", 1e3 * progress.rms));
            !context.is_cancelled()
        },
    };
    let start = Instant::now();
    let found = fit_material(&scene, &mesh, &motions, &selected, &settings)?;
    bar.finish();
    if context.is_cancelled() {
        return Err(Cancelled::new("; nothing is written").into());
    }
    let outcome = Outcome {
        scene: &scene,
        motions: &motions,
        selected: &selected,
        found: &found,
        findings: &findings,
        wall_s: start.elapsed().as_secs_f64(),
        n_other_role,
        tension_max: scene
            .tendons
            .iter()
            .map(|tendon| options.tension_max_n.map_or(tendon.tension.max, |n| n.min(tendon.tension.max)))
            .collect(),
    };
    tell(&outcome, context);
    scene_file::write(&options.scene, &scene, &found.scene, &options.out, context)?;
    let value = match &options.figures {
        Some(folder) => {
            let value = report::write(folder, &outcome, options.png, context)
                .with_context(|| format!("writing figures to {}", folder.display()))?;
            context.reported(folder);
            value
        }
        None => report::summarise(&outcome, context)?,
    };
    context.wrote(&options.out);
    Ok(value)
}

/// The motions in recordings of this role.
fn motions(paths: &[PathBuf], role: Option<&str>, twin: &Twin) -> anyhow::Result<Vec<Motion>> {
    let mut motions = Vec::new();
    for path in paths {
        let recording = Recording::read(path)?;
        if role.is_some_and(|role| inputs::role(recording.meta()) != role) {
            continue;
        }
        let motion = Motion::new(twin, &recording, &path.display().to_string())?;
        for (axis, is_used) in ["x", "y", "z"].iter().zip(motion.axes) {
            if !is_used {
                tracing::warn!("{}: tip_{axis} never changes and is left out", path.display());
            }
        }
        motions.push(motion);
    }
    if motions.is_empty() {
        let found = format!("none of {}", paths.len());
        return Err(BadInput::new("--role", "the role of at least one recording", found).into());
    }
    Ok(motions)
}

fn check_arguments(options: &Options) -> Result<(), BadInput> {
    let shown = options.out.display().to_string();
    if options.out.extension().is_none_or(|extension| extension != "toml") {
        return Err(BadInput::new("--out", "a name ending in .toml", shown));
    }
    Ok(())
}

/// Prints the parameters and the errors.
fn tell(outcome: &Outcome, context: &Context) {
    let found = outcome.found;
    context.print(format_args!(
        "{:<26}{:>12}{:>12}{:>12}   {}",
        "parameter", "scene", "fitted", "± s.e.", "standing"
    ));
    for (selected, estimate) in outcome.selected.iter().zip(&found.fit.estimates) {
        let (factor, unit) = (selected.quantity.key.1, selected.quantity.unit());
        context.print(format_args!(
            "{:<26}{:>12}{:>12}{:>12}   {}",
            if unit.is_empty() { estimate.name.clone() } else { format!("{} [{unit}]", estimate.name) },
            digits(factor * estimate.start),
            digits(factor * estimate.value),
            estimate.standard_error.map_or("-".into(), |error| digits(factor * error)),
            standing(&estimate.standing),
        ));
    }
    for (name, errors) in ["scene", "fitted"].iter().zip(&found.errors) {
        let [x, y, z] = errors.axes.map(|error| 1e3 * error);
        let distance = 1e3 * errors.distance;
        context.print(format_args!(
            "RMSE of the tip, {name}: x {x:.3}, y {y:.3}, z {z:.3}, distance {distance:.3} mm"
        ));
    }
    let fit = &found.fit;
    if outcome.selected.iter().any(|selected| selected.quantity.name == "gravity") {
        let [x, y, z] = found.scene.gravity;
        context.print(format_args!("gravity: ({x:.3}, {y:.3}, {z:.3}) m/s²"));
    }
    tell_collinear(fit, context);
    outcome.doubts().iter().for_each(|doubt| context.print(doubt));
    tracing::info!(
        "{} in {:.1} s: {} iterations, {} evaluations of {} steps; {} residuals worth {:.0} independent ones",
        fit.ended,
        outcome.wall_s,
        fit.iterations,
        fit.evaluations,
        found.courses.iter().map(|course| course.samples.len()).sum::<usize>(),
        fit.n_residuals,
        fit.n_effective,
    );
    if !fit.is_converged {
        tracing::warn!("the search did not converge: {}", fit.ended);
    }
}

/// Correlation from which on two parameters are said to be told apart badly.
const CORRELATED: f64 = 0.9;

/// Prints which parameters the recordings hardly tell apart.
fn tell_collinear(fit: &Fit, context: &Context) {
    context.print(format_args!("condition number of the Jacobian, columns normalised: {:.1}", fit.condition));
    let names = fit.estimates.iter().map(|estimate| &estimate.name);
    for (k, (name, row)) in names.clone().zip(&fit.correlation).enumerate() {
        for (other, value) in names.clone().zip(row).take(k).filter(|(_, value)| value.abs() > CORRELATED) {
            context.print(format_args!("hardly distinguishable: {other} and {name}, correlation {value:.2}"));
        }
    }
}
