//! `hysteron target`: a path for the tip, sampled; and whether a robot reaches it.

pub mod reach;

use std::path::PathBuf;

use anyhow::Context;
use hysteron_base::{Metadata, Recording, Scene};
use hysteron_control::TargetPath;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::figures;
use crate::outcome::MetricsFormat;
use crate::outputs::Outputs;
use crate::paths;
use crate::{COMMIT, Caller};
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
    #[cfg_attr(feature = "clap", arg(long, value_name = "MM", default_value_t = 0.1, requires = "scene", value_parser = crate::number::length_mm))]
    pub tolerance_mm: f64,
    /// Folder for the figure, report.html and metrics.json
    #[cfg_attr(feature = "clap", arg(long, value_name = "DIR"))]
    pub figures: Option<PathBuf>,
    /// Write the figure as .png too
    #[cfg_attr(feature = "clap", arg(long, requires = "figures"))]
    pub png: bool,
}

/// The outcome of `target`.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct Outcome {
    /// Format of the file.
    pub format: MetricsFormat,
    /// Its version.
    pub version: u32,
    /// Name of the target.
    pub name: String,
    /// Family of its curve.
    pub family: String,
    /// SHA-256 of what it was made from.
    pub target_sha256: String,
    /// Rate [Hz].
    pub rate_hz: f64,
    /// Number of samples.
    pub samples: usize,
    /// Time from the first to the last sample [s].
    pub duration_s: f64,
    /// Length of a lap [m].
    pub length_m: f64,
    /// Laps.
    pub laps: usize,
    /// Times at which the curve begins and ends [s].
    pub curve_s: [f64; 2],
    /// Whether a robot reaches it, where a scene was given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reach: Option<Reach>,
    /// The command that made this.
    pub command: String,
    /// Commit of the program.
    pub commit: String,
}

impl crate::outcome::Outcome for Outcome {}

impl Outcome {
    fn new(target: &TargetPath, reach: Option<Reach>, caller: &Caller) -> Self {
        let n = target.points().len();
        Self {
            format: MetricsFormat,
            version: 1,
            name: target.name.clone(),
            family: target.family.clone(),
            target_sha256: target.hash.clone(),
            rate_hz: target.rate_hz,
            samples: n,
            duration_s: target.time(n - 1),
            length_m: target.outline.length(),
            laps: target.laps().count(),
            curve_s: [target.time(*target.curve().start()), target.time(*target.curve().end())],
            reach,
            command: caller.command.clone(),
            commit: COMMIT.to_owned(),
        }
    }
}

/// Carries out the verb.
pub fn run(options: &Options, caller: &Caller) -> anyhow::Result<Outcome> {
    paths::check_recording(&options.out)?;
    let target = TargetPath::open(&options.target)?;
    let scene = options.scene.as_deref().map(Scene::read).transpose()?;
    let outputs = Outputs::default().target(&options.target)?.file("--out", &options.out);
    let mut outputs = outputs.report("--figures", options.figures.as_deref());
    if let (Some(path), Some(scene)) = (&options.scene, &scene) {
        outputs = outputs.scene(path, scene);
    }
    let _claim = outputs.check(caller)?;
    let reach = match &scene {
        Some(scene) => Some(Reach::of(&target, scene, 1e-3 * options.tolerance_mm, caller)?),
        None => None,
    };
    let outcome = Outcome::new(&target, reach.clone(), caller);
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
        command: caller.command.clone(),
        scene_hash: scene.map_or_else(String::new, |scene| scene.hash),
        ..recording.meta().clone()
    };
    let recording = Recording::new(recording.time().to_vec(), recording.channels().to_vec(), vec![], meta)?;
    recording.write(&options.out)?;
    caller.wrote(&options.out);
    Ok(outcome)
}
