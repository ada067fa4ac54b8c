//! `hysteron target`: a path for the tip, sampled; and whether a robot reaches it.

mod outcome;
pub mod reach;

use std::path::PathBuf;

use anyhow::Context as _;
use hysteron_base::{Metadata, Recording, Scene};
use hysteron_control::TargetPath;

use crate::figures;
use crate::shared::outputs::Outputs;
use crate::shared::paths;
use crate::{COMMIT, Context};
pub use outcome::Outcome;
use reach::Reach;

/// Sample a path for the tip, and check that a robot reaches it
#[derive(Debug, Clone)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct Options {
    /// Target: FAMILY:SIZE_MM, or a file (.toml, .svg, .csv, .parquet)
    #[cfg_attr(feature = "clap", arg(value_name = "PATH"))]
    pub target: String,
    /// Recording to write, .parquet or .csv
    #[cfg_attr(feature = "clap", arg(long, value_name = "REC"))]
    pub out: PathBuf,
    /// Scene of a robot whose twin must reach it
    #[cfg_attr(feature = "clap", arg(long, value_name = "SCENE"))]
    pub scene: Option<PathBuf>,
    /// Distance that counts as reached
    #[cfg_attr(feature = "clap", arg(long, value_name = "MM", default_value_t = 0.1, requires = "scene", value_parser = crate::shared::number::length_mm))]
    pub tolerance_mm: f64,
    /// Folder for the figure, report.html and metrics.json
    #[cfg_attr(feature = "clap", arg(long, value_name = "DIR"))]
    pub figures: Option<PathBuf>,
    /// Write the figure as .png too
    #[cfg_attr(feature = "clap", arg(long, requires = "figures"))]
    pub png: bool,
}

/// Carries out the verb.
pub fn run(options: &Options, context: &Context) -> anyhow::Result<Outcome> {
    paths::check_recording(&options.out)?;
    let target = TargetPath::open(&options.target)?;
    let scene = options.scene.as_deref().map(Scene::read).transpose()?;
    let outputs = Outputs::default().target(&options.target)?.file("--out", &options.out);
    let mut outputs = outputs.report("--figures", options.figures.as_deref());
    if let (Some(path), Some(scene)) = (&options.scene, &scene) {
        outputs = outputs.scene(path, scene);
    }
    let _claim = outputs.check(context)?;
    let reach = match &scene {
        Some(scene) => Some(Reach::of(&target, scene, 1e-3 * options.tolerance_mm, context)?),
        None => None,
    };
    let outcome = Outcome::new(&target, reach.clone(), context);
    if let Some(folder) = &options.figures {
        figures::target::write(folder, &target, reach.as_ref(), &outcome, options.png)
            .with_context(|| format!("writing figures to {}", folder.display()))?;
    }
    if let Some(reach) = &reach {
        let hint = match &options.figures {
            Some(folder) => format!("{} shows where", folder.join("target.svg").display()),
            None => "a smaller size_mm; --figures DIR shows where".to_owned(),
        };
        reach.check(&target, hint)?;
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
