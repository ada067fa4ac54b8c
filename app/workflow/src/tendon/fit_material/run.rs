//! The fit: scene and recordings, the search, the fitted scene, page.

use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::Context as _;
use hysteron_base::checks::Purpose;
use hysteron_base::number::significant;
use hysteron_base::{BadInput, Recording, Scene};
use hysteron_report::folder::ReportFolder;
use hysteron_twin::fit::{
    Fit, FitBody, FitParameter, MaterialFit, MaterialOptions, Selected, Stepping, fit_material, select,
};
use hysteron_twin::{RobotMotion, Twin};

use super::options::Options;
use super::outcome::{N_DIGITS, Outcome, identifiability};
use super::verdict::FinishedFit;
use super::{page, quantities, scene_file};
use crate::shared::error::Cancelled;
use crate::shared::outputs::Outputs;
use crate::shared::{inputs, locking, memory, recording_checks};
use crate::{Context, WorkflowError};

/// Runs the verb.
///
/// # Errors
/// Bad input; a twin that cannot be stepped with the scene as given; an interruption; files that cannot be written.
pub fn run(options: &Options, context: &Context) -> Result<Outcome, WorkflowError> {
    Ok(fit(options, context)?)
}

fn fit(options: &Options, context: &Context) -> anyhow::Result<Outcome> {
    options.check()?;
    let scene = options.body.scene(&options.scene)?;
    let names = match &options.fit_file {
        Some(path) => quantities::read(path)?,
        None => options.fit.iter().map(FitParameter::named).collect(),
    };
    let selected = select(&scene, &names)?;
    check_body(&scene, &selected)?;
    let files = inputs::files(&options.recordings)?;
    let outputs = Outputs::reading(&files).scene(&options.scene, &scene).and(&options.fit_file);
    let outputs = outputs.file("--out", &options.out).report("--figures", options.figures.as_deref());
    let _lock = outputs.check(context)?;
    let recordings = files.iter().map(Recording::read).collect::<Result<Vec<_>, _>>()?;
    memory::check_copies("recordings", &recordings)?;
    let chosen = of_role(&files, &recordings, options.role.as_deref())?;
    let mesh = hysteron_fem::read_mesh(&scene.mesh_path, scene.mesh_unit.to_m())?;
    let twin = Twin::new(&scene, &mesh)?.with_body_of(&scene)?;
    let body = FitBody { mesh: &mesh, chain: twin.chain.as_deref() };
    let checks = recording_checks::context_of(&twin, Purpose::Fit);
    let findings = recording_checks::of_recordings(&files, &recordings, &checks)?;
    let motions = motions(&chosen, &twin)?;
    drop(recordings);
    locking::warn_before_fit(&scene)?;
    let n_other_role = files.len() - motions.len();
    tracing::info!(
        "{}: {} parameters, {} recordings, {} samples; {n_other_role} recordings of another role skipped",
        scene.name,
        selected.len(),
        motions.len(),
        motions.iter().map(|motion| motion.len()).sum::<usize>(),
    );

    context.listen();
    let start = Instant::now();
    let found = search(options, (&scene, body), &motions, &selected, context)?;
    if context.is_cancelled() {
        return Err(Cancelled::new("; nothing is written").into());
    }
    let finished = FinishedFit {
        scene: &scene,
        motions: &motions,
        selected: &selected,
        found: &found,
        findings: &findings,
        wall_s: start.elapsed().as_secs_f64(),
        n_other_role,
        tension_max: tension_max(options, &scene),
    };
    let outcome = Outcome::new(&finished, context);
    print(&finished, &outcome, context);
    scene_file::write(&options.scene, &scene, &found.scene, &options.out, context)?;
    if let Some(folder) = &options.figures {
        page::write(&ReportFolder { path: folder, png: options.png }, &outcome, &finished)
            .with_context(|| format!("writing figures to {}", folder.display()))?;
        context.reported(folder);
    }
    context.wrote(&options.out);
    Ok(outcome)
}

/// Refuses a parameter that a chain of sections does not follow.
fn check_body(scene: &Scene, selected: &[Selected]) -> Result<(), BadInput> {
    let fixed = |selected: &&Selected| selected.quantity.name == "poisson_ratio";
    match selected.iter().find(fixed).filter(|_| scene.reduced_path.is_some()) {
        Some(selected) => {
            Err(BadInput::new("--fit", "what the reduced body follows", selected.quantity.name)
                .hint("a chain is made for one Poisson's ratio; fit it with the mesh, or leave it out"))
        }
        None => Ok(()),
    }
}

/// Searches for the parameters.
fn search(
    options: &Options,
    (scene, body): (&Scene, FitBody),
    motions: &[RobotMotion],
    selected: &[Selected],
    context: &Context,
) -> anyhow::Result<MaterialFit> {
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
    let found = fit_material(scene, body, motions, selected, &settings)?;
    bar.finish();
    Ok(found)
}

/// Largest tension that each tendon can be pulled with [N].
fn tension_max(options: &Options, scene: &Scene) -> Vec<f64> {
    let drives = options.tension_max_n.unwrap_or(f64::INFINITY);
    scene.tendons.iter().map(|tendon| drives.min(tendon.tension.max)).collect()
}

/// The recordings of this role, and their files.
fn of_role<'a>(
    paths: &'a [PathBuf],
    recordings: &'a [Recording],
    role: Option<&str>,
) -> Result<Vec<(&'a Path, &'a Recording)>, BadInput> {
    let named = paths.iter().map(PathBuf::as_path).zip(recordings);
    let is_chosen =
        |(_, recording): &(&Path, &Recording)| role.is_none_or(|role| inputs::role(recording.meta()) == role);
    let chosen: Vec<_> = named.filter(is_chosen).collect();
    if chosen.is_empty() {
        let found = format!("none of {}", paths.len());
        return Err(BadInput::new("--role", "the role of at least one recording", found));
    }
    Ok(chosen)
}

/// The motions in recordings.
fn motions(recordings: &[(&Path, &Recording)], twin: &Twin) -> anyhow::Result<Vec<RobotMotion>> {
    let mut motions = Vec::new();
    for (path, recording) in recordings {
        let motion = RobotMotion::new(twin, recording, &path.display().to_string())?;
        for (axis, is_used) in ["x", "y", "z"].iter().zip(motion.axes) {
            if !is_used {
                tracing::warn!("{}: tip_{axis} never changes and is skipped", path.display());
            }
        }
        motions.push(motion);
    }
    Ok(motions)
}

/// Prints the parameters and the errors.
fn print(finished: &FinishedFit, outcome: &Outcome, context: &Context) {
    let found = finished.found;
    context.print(format_args!(
        "{:<26}{:>12}{:>12}{:>12}   {}",
        "parameter", "scene", "fitted", "± s.e.", "identifiability"
    ));
    for (selected, estimate) in finished.selected.iter().zip(&found.fit.estimates) {
        let (factor, unit) = (selected.quantity.key.1, selected.quantity.unit());
        context.print(format_args!(
            "{:<26}{:>12}{:>12}{:>12}   {}",
            if unit.is_empty() { estimate.name.clone() } else { format!("{} [{unit}]", estimate.name) },
            significant(factor * estimate.start, N_DIGITS),
            significant(factor * estimate.value, N_DIGITS),
            estimate.standard_error.map_or("-".into(), |error| significant(factor * error, N_DIGITS)),
            identifiability(&estimate.identifiability),
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
    if finished.selected.iter().any(|selected| selected.quantity.name == "gravity") {
        let [x, y, z] = found.scene.gravity;
        context.print(format_args!("gravity: ({x:.3}, {y:.3}, {z:.3}) m/s²"));
    }
    print_collinear(fit, context);
    outcome.warnings.iter().for_each(|warning| context.print(warning));
    tracing::info!(
        "{} in {:.1} s: {} iterations, {} evaluations of {} steps; {} residuals worth {:.0} independent ones",
        fit.ended,
        finished.wall_s,
        fit.iterations,
        fit.evaluations,
        outcome.steps,
        fit.n_residuals,
        fit.n_effective,
    );
    if !fit.is_converged {
        tracing::warn!("the search did not converge: {}", fit.ended);
    }
}

/// Correlation from which on two parameters are reported as hardly distinguishable.
const CORRELATED: f64 = 0.9;

/// Prints which parameters the recordings hardly distinguish.
fn print_collinear(fit: &Fit, context: &Context) {
    context.print(format_args!("condition number of the Jacobian, columns normalised: {:.1}", fit.condition));
    let names = fit.estimates.iter().map(|estimate| &estimate.name);
    for (k, (name, row)) in names.clone().zip(&fit.correlation).enumerate() {
        for (other, value) in names.clone().zip(row).take(k).filter(|(_, value)| value.abs() > CORRELATED) {
            context.print(format_args!("hardly distinguishable: {other} and {name}, correlation {value:.2}"));
        }
    }
}
