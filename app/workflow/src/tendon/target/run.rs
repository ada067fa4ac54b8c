//! The recipe: a path for the tip, sampled, and whether a robot reaches it.

use anyhow::Context as _;
use hysteron_base::{Metadata, Recording, Scene};
use hysteron_control::TargetPath;
use hysteron_report::folder::ReportFolder;
use hysteron_twin::{CurveGoals, Reach};

use super::options::Options;
use super::outcome::Outcome;
use super::page;
use crate::shared::error::Cancelled;
use crate::shared::outputs::Outputs;
use crate::shared::paths;
use crate::{COMMIT, Context, WorkflowError};

/// Smallest distance of the goals along the curve [m]; larger on a long curve, which then has so many goals.
const SPACING: f64 = 1e-3;
const MAX_GOALS: f64 = 150.0;

/// Runs the verb.
///
/// # Errors
/// Bad input, a target out of reach among it; files that cannot be written.
pub fn run(options: &Options, context: &Context) -> Result<Outcome, WorkflowError> {
    Ok(sample(options, context)?)
}

/// Samples the path, tries it on the twin, and writes recording and report.
fn sample(options: &Options, context: &Context) -> anyhow::Result<Outcome> {
    paths::check_recording(&options.out)?;
    let target = TargetPath::open(&options.target)?;
    let scene = options.scene.as_deref().map(Scene::read).transpose()?;
    let outputs = Outputs::default().target(&options.target)?.file("--out", &options.out);
    let mut outputs = outputs.report("--figures", options.figures.as_deref());
    if let (Some(path), Some(scene)) = (&options.scene, &scene) {
        outputs = outputs.scene(path, scene);
    }
    let _lock = outputs.check(context)?;
    let reach = match &scene {
        Some(scene) => Some(reach_of(&target, scene, 1e-3 * options.tolerance_mm, context)?),
        None => None,
    };
    let outcome = Outcome::new(&target, reach.clone(), context);
    if let Some(folder) = &options.figures {
        let report = ReportFolder { path: folder, png: options.png };
        page::write(&report, &target, reach.as_ref(), &outcome)
            .with_context(|| format!("writing figures to {}", folder.display()))?;
    }
    if let Some(reach) = &reach {
        let hint = match &options.figures {
            Some(folder) => format!("{} shows where", folder.join("target.svg").display()),
            None => "a smaller size_mm; --figures DIR shows where".to_owned(),
        };
        reach.check(&target.name, hint)?;
        tracing::info!(
            "{}: {} points within {} mm, the farthest off by {:.3} mm, tensions up to {:.1} N",
            reach.scene,
            reach.goals,
            options.tolerance_mm,
            1e3 * reach.largest_distance_m,
            reach.tension_max_n
        );
    }
    let recording = target.recording()?;
    let meta = Metadata {
        commit: COMMIT.to_owned(),
        command: context.command.clone(),
        scene_hash: scene.map_or_else(String::new, |scene| scene.hash),
        ..recording.meta().clone()
    };
    let recording = Recording::new(recording.time().to_vec(), recording.channels().to_vec(), vec![], meta)?;
    recording.write(&options.out)?;
    context.wrote(&options.out);
    Ok(outcome)
}

/// The reach of the target's curve; x and y count, and z where the target gives it.
fn reach_of(target: &TargetPath, scene: &Scene, tolerance: f64, context: &Context) -> anyhow::Result<Reach> {
    let spacing = SPACING.max(target.outline.length() / MAX_GOALS);
    let points = target.outline.evenly(spacing);
    let curve = CurveGoals { points: &points, spacing, n_axes: if target.is_planar { 2 } else { 3 } };
    context.listen();
    let mut bar = None;
    let reach = Reach::of(scene, &curve, tolerance, &mut |done, n| {
        bar.get_or_insert_with(|| context.progress("goals", n, 0)).set_position(done as u64);
        !context.is_cancelled()
    })?;
    if let Some(bar) = bar {
        bar.finish();
    }
    Ok(reach.ok_or_else(|| Cancelled::new("; nothing was written"))?)
}
