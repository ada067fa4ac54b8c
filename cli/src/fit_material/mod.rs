//! `hysteron fit-material`: the physical parameters of a scene from recordings of its robot.

mod inputs;
mod scene_file;

use std::path::PathBuf;
use std::time::Instant;

use anyhow::Context;
use hysteron_base::{BadInput, Scene};
use hysteron_twin::fit::{
    Fit, Frame, MaterialFit, MaterialOptions, Selected, Standing, Stepping, Wanted, fit_material, select,
};
use hysteron_twin::{Motion, Twin};

use crate::figures::fit as report;
use crate::outputs::Outputs;
use crate::terminal::{self, say};
use crate::{interrupt, number};

const HELP: &str = "\
Needs a scene and recordings of its robot (.parquet, .csv or .journal) in slow motion or at rest: the strokes or \
tensions that drive the scene's tendons, and the tip (tip_x_mm, tip_y_mm, tip_z_mm). Samples marked as gaps are passed \
through but not compared. Where the recordings have the tensions of tendons that strokes drive (tension_1_n, ..), they \
count too: a tenth of the largest as much as 2 % of the tip's motion.

What can be fitted, by name: youngs_modulus, poisson_ratio, density, zero (how far each tendon is already pulled at \
stroke zero), common_zero (the same for all), compliance (of all tendons); gravity (its direction: every axis of the scene \
is tried, and how it leans from the best), tracker (turn and shift of the tracker's frame, or tracker_turn and \
tracker_shift alone); and of a scene that has [friction], coefficient and coulomb (in the body), sheath_exponent, \
sheath_coulomb, sheath_compliance_share, backlash. \
Every value is believed to be the scene's, give or take a width: the modulus within a factor of 2, the density of 1.3, \
Poisson's ratio 0.05, zeros 1 mm, compliance 0.05 mm/N, coefficient 0.2, Coulomb forces 1 N, exponent 0.4, share 0.3, \
backlash 0.3 mm, the tracker 5 deg and 2 mm. A file gives bounds of your own, and widths, in the unit of the key:
  format = \"hysteron-fit\"
  version = 1
  [fit]
  youngs_modulus_mpa = [5.0, 60.0]
  zero_mm = [-1.0, 1.0, 0.2]      # the last one is the width
  compliance_mm_per_n = []        # bounds and width of the program

Writes a scene with the fitted values in place of the old ones, comments kept, and with --figures report.html and \
metrics.json. What the recordings do not determine is held at the value of the scene, and the table says so: without \
gravity and friction, strokes alone say nothing about the modulus. A value with a large error is held too, unless the \
scene's fits worse than noise allows; then it is called vague. It also says which parameters the tip hardly tells \
apart (mostly coefficient from coulomb, in the body as in the sheath), which tendon would need more than it can pull, and \
what else would explain the errors that are left: another direction of gravity, a tilted tracker, zeros, friction.

Examples, from the root of the repository:
  hysteron record --rig virtual:typical --plan quick --out out/quick
  hysteron fit-material meshes/tpu80/scene.toml out/quick/*.parquet --role training \\
      --out out/fitted/scene.toml --figures out/fitted
  hysteron fit-material meshes/tpu80/scene.toml out/quick/circle.parquet \\
      --fit zero --frame fit --out out/fitted/scene.toml

Exit codes: 0 done, 1 failed or interrupted, 2 bad input (nothing is written).";

/// More than any set of recordings has.
pub const MOST_STEPS: usize = 10_000_000;

/// Fit modulus, zero offsets and the like to recordings
///
/// Finds the parameters with which the twin's tip comes nearest to the measured one, with standard errors.
#[derive(Debug, clap::Args)]
#[command(after_help = HELP)]
pub struct Arguments {
    /// Scene file of the robot (scene.toml)
    scene: PathBuf,
    /// Recordings with commands and tip
    #[arg(required = true, value_name = "REC")]
    recordings: Vec<PathBuf>,
    /// Scene file to write
    #[arg(long, value_name = "SCENE")]
    out: PathBuf,
    /// Folder for figures, report.html and metrics.json
    #[arg(long, value_name = "DIR")]
    figures: Option<PathBuf>,
    /// Write each figure as .png too
    #[arg(long, requires = "figures")]
    png: bool,
    /// What to fit, by name
    #[arg(long, value_name = "NAME,...", value_delimiter = ',', default_values_t = default_names())]
    fit: Vec<String>,
    /// File with what to fit and its bounds, in place of --fit
    #[arg(long, value_name = "TOML", conflicts_with = "fit")]
    fit_file: Option<PathBuf>,
    /// Take only recordings made for this: training, validation or test
    #[arg(long, value_name = "ROLE")]
    role: Option<String>,
    /// Step through samples between which a stroke (or, under tension, the tip) moves at most so far; samples where a
    /// stroke turns back are among them
    #[arg(long, value_name = "MM", default_value_t = 0.3, value_parser = number::length_mm)]
    step_mm: f64,
    /// Compare the tip where a stroke has moved so far since it was compared last
    #[arg(long, value_name = "MM", default_value_t = 0.2, value_parser = number::length_mm)]
    every_mm: f64,
    /// Most steps of an evaluation, shared evenly by the recordings: of each, the beginning
    #[arg(long, value_name = "N", default_value_t = 2000, value_parser = number::count::<MOST_STEPS>)]
    steps: usize,
    /// Largest tension that the drives can make [default: tension_max_n of the scene]; what needs more than four fifths of
    /// it fits the worse
    #[arg(long, value_name = "N", value_parser = number::weight)]
    tension_max_n: Option<f64>,
    /// Error of a coordinate from which on it counts linearly rather than squared
    #[arg(long, value_name = "MM", value_parser = number::length_mm)]
    huber_mm: Option<f64>,
    /// Frame of the measured tip: the scene's (a tip that rests elsewhere is refused), the scene's wherever the tip
    /// rests, or one to be found
    #[arg(long, value_enum, default_value_t = FrameChoice::Scene)]
    frame: FrameChoice,
}

#[derive(Debug, Clone, Copy, PartialEq, clap::ValueEnum)]
enum FrameChoice {
    Scene,
    Trust,
    Fit,
}

impl From<FrameChoice> for Frame {
    fn from(choice: FrameChoice) -> Self {
        match choice {
            FrameChoice::Scene => Self::Checked,
            FrameChoice::Trust => Self::Trusted,
            FrameChoice::Fit => Self::Fitted,
        }
    }
}

/// Length of the bar.
const WHOLE: f64 = 1000.0;

fn default_names() -> Vec<String> {
    ["youngs_modulus", "zero", "compliance"].map(str::to_owned).to_vec()
}

/// Everything a report may show.
pub struct Outcome<'a> {
    /// The scene as given.
    pub scene: &'a Scene,
    /// What was compared.
    pub motions: &'a [Motion],
    /// What was fitted.
    pub selected: &'a [Selected],
    /// The outcome.
    pub found: &'a MaterialFit,
    /// Time it took [s].
    pub wall_s: f64,
    /// Recordings left out for their role.
    pub n_other_role: usize,
    /// Largest tension that each tendon can be pulled with [N].
    pub tension_max: Vec<f64>,
}

/// Part of the largest tension allowed from which on a tendon is said to need too much.
const STRAINED: f64 = 0.8;

impl Outcome<'_> {
    /// What speaks against the outcome, and what else would explain the errors that are left.
    pub fn doubts(&self) -> Vec<String> {
        let mut doubts = Vec::new();
        let at_bound = |estimate: &&hysteron_twin::fit::Estimate| estimate.standing == Standing::AtBound;
        for estimate in self.found.fit.estimates.iter().filter(at_bound) {
            doubts
                .push(format!("{} ended at a bound: an assumption of the scene may be wrong", estimate.name));
        }
        for ((tendon, tension), most) in
            self.scene.tendons.iter().zip(&self.found.tensions).zip(&self.tension_max)
        {
            if *tension > STRAINED * most {
                let name = &tendon.name;
                doubts.push(format!("{name} would need {tension:.1} N of the {most:.1} N that it can pull"));
            }
        }
        for hint in &self.found.hints {
            let [now, then] = hint.rms.map(|rms| 1e3 * rms);
            let how = if hint.fit.is_empty() { String::new() } else { format!(" (--fit {})", hint.fit) };
            let what = &hint.instead;
            doubts
                .push(format!("would explain errors: {what}, {now:.3} -> {then:.3} mm per coordinate{how}"));
        }
        doubts
    }
}

/// Carries out the verb.
pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    check_arguments(arguments)?;
    let scene = Scene::read(&arguments.scene)?;
    let names = match &arguments.fit_file {
        Some(path) => inputs::read_names(path)?,
        None => arguments.fit.iter().map(Wanted::named).collect(),
    };
    let selected = select(&scene, &names)?;
    let outputs =
        Outputs::reading(&arguments.recordings).scene(&arguments.scene, &scene).and(&arguments.fit_file);
    let outputs = outputs.file("--out", &arguments.out).report("--figures", arguments.figures.as_deref());
    let _claim = outputs.check()?;
    let mesh = hysteron_fem::read_mesh(&scene.mesh_path, scene.mesh_unit.to_m())?;
    let twin = Twin::new(&scene, &mesh)?;
    let motions = inputs::read_motions(&arguments.recordings, arguments.role.as_deref(), &twin)?;
    let n_other_role = arguments.recordings.len() - motions.len();
    tracing::info!(
        "{}: {} parameters, {} recordings, {} samples; {n_other_role} recordings of another role left out",
        scene.name,
        selected.len(),
        motions.len(),
        motions.iter().map(|motion| motion.len()).sum::<usize>(),
    );

    interrupt::listen()?;
    let bar = terminal::progress("per mille", WHOLE as usize, 0);
    let options = MaterialOptions {
        frame: arguments.frame.into(),
        stepping: Stepping {
            step: 1e-3 * arguments.step_mm,
            every: 1e-3 * arguments.every_mm,
            most: arguments.steps,
        },
        huber: arguments.huber_mm.map(|mm| 1e-3 * mm),
        tension_max: arguments.tension_max_n,
        watch: &|progress| {
            bar.set_position((WHOLE * progress.done) as u64);
            bar.set_message(format!("RMSE {:.3} mm per coordinate", 1e3 * progress.rms));
            !interrupt::is_asked()
        },
    };
    let start = Instant::now();
    let found = fit_material(&scene, &mesh, &motions, &selected, &options)?;
    bar.finish_and_clear();
    if interrupt::is_asked() {
        anyhow::bail!("interrupted; nothing is written");
    }
    let outcome = Outcome {
        scene: &scene,
        motions: &motions,
        selected: &selected,
        found: &found,
        wall_s: start.elapsed().as_secs_f64(),
        n_other_role,
        tension_max: scene
            .tendons
            .iter()
            .map(|tendon| arguments.tension_max_n.map_or(tendon.tension.max, |n| n.min(tendon.tension.max)))
            .collect(),
    };
    tell(&outcome);
    report::summarise(&outcome)?;
    scene_file::write(&arguments.scene, &scene, &found.scene, &arguments.out)?;
    if let Some(folder) = &arguments.figures {
        report::write(folder, &outcome, arguments.png)
            .with_context(|| format!("writing figures to {}", folder.display()))?;
    }
    say(arguments.out.display());
    Ok(())
}

fn check_arguments(arguments: &Arguments) -> Result<(), BadInput> {
    let shown = arguments.out.display().to_string();
    if arguments.out.extension().is_none_or(|extension| extension != "toml") {
        return Err(BadInput::new("--out", "a name ending in .toml", shown));
    }
    Ok(())
}

/// Prints the parameters and the errors.
fn tell(outcome: &Outcome) {
    let found = outcome.found;
    say(format_args!("{:<26}{:>12}{:>12}{:>12}   {}", "parameter", "scene", "fitted", "± s.e.", "standing"));
    for (selected, estimate) in outcome.selected.iter().zip(&found.fit.estimates) {
        let (key, factor) = selected.quantity.key;
        let unit = key.trim_start_matches(selected.quantity.name).trim_start_matches('_');
        say(format_args!(
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
        say(format_args!("RMSE of the tip, {name}: x {x:.3}, y {y:.3}, z {z:.3}, distance {distance:.3} mm"));
    }
    let fit = &found.fit;
    if outcome.selected.iter().any(|selected| selected.quantity.name == "gravity") {
        let [x, y, z] = found.scene.gravity;
        say(format_args!("gravity: ({x:.3}, {y:.3}, {z:.3}) m/s²"));
    }
    tell_collinear(fit);
    outcome.doubts().iter().for_each(say);
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
fn tell_collinear(fit: &Fit) {
    say(format_args!("condition of the Jacobian, columns of length one: {:.1}", fit.condition));
    let names = fit.estimates.iter().map(|estimate| &estimate.name);
    for (k, (name, row)) in names.clone().zip(&fit.correlation).enumerate() {
        for (other, value) in names.clone().zip(row).take(k).filter(|(_, value)| value.abs() > CORRELATED) {
            say(format_args!("hardly told apart: {other} and {name}, correlation {value:.2}"));
        }
    }
}

/// A number of four digits.
pub fn digits(value: f64) -> String {
    if value == 0.0 {
        return "0".into();
    }
    let decimals = (3 - value.abs().log10().floor() as i32).clamp(0, 9) as usize;
    format!("{value:.decimals$}")
}

/// What became of a parameter, for a reader.
pub fn standing(standing: &Standing) -> String {
    match standing {
        Standing::Fitted => "fitted".into(),
        Standing::AtBound => "at a bound".into(),
        Standing::Vague => "vague, but the scene's value fits worse".into(),
        Standing::Undetermined(with) if with.is_empty() => "not determined by the data, held".into(),
        Standing::Undetermined(with) => format!("determined only together with {}, held", with.join(", ")),
    }
}
