//! `hysteron check`: is a scene fit to be simulated, and what will it cost? Can recordings be true?

mod recordings;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use hysteron_base::{BadInput, PrescribedQuantity, Scene};
use hysteron_fem::{FactorKind, Stiffness, StiffnessFactor, Tangent};
use hysteron_twin::Twin;

use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, Serialize};

use crate::Context;
use crate::shared::locking::{Estimator, LockingEstimate};
use crate::shared::outcome::{self, Printed};
use crate::shared::recording_checks::body_length;
use crate::tendon::mesh::{MeshSummary, print_quality};
pub use recordings::{Described, RecordingFindings};

/// Check a scene with its mesh, or recordings
///
/// Of a scene: the quality of the mesh, every tendon with its length and how far its points lie outside the body, and
/// the size of the equations. Of recordings: one table of what is doubtful or cannot be right, as units, frozen or copied
/// channels, gaps, spikes, delays and too little motion; exit code 2 where something cannot be right. Recordings that stand
/// beside a scene are compared with its body too.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct Options {
    /// Scene file (scene.toml), recordings (.parquet, .csv, .journal) or folders of them
    #[cfg_attr(feature = "clap", arg(required = true, value_name = "FILE"))]
    pub files: Vec<PathBuf>,
}

/// Recordings of which something cannot be right; all findings have been printed.
#[derive(Debug)]
pub struct Refused {
    /// The outcome, which `--json` prints all the same.
    pub outcome: Printed,
    n_errors: usize,
    first: BadInput,
}

impl std::fmt::Display for Refused {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} of the findings cannot be right, the first", self.n_errors)
    }
}

impl std::error::Error for Refused {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        Some(&self.first)
    }
}

/// Carries out the verb.
///
/// # Errors
/// Bad input; [`Refused`].
pub fn run(options: &Options, context: &Context) -> anyhow::Result<Outcome> {
    let (scenes, others): (Vec<&PathBuf>, Vec<&PathBuf>) =
        options.files.iter().partition(|path| is_scene(path));
    match (&scenes[..], &others[..]) {
        ([scene], []) => Ok(Outcome::Scene(self::scene(scene, context)?.0)),
        ([], _) => recordings::check(&others, (None, None), context),
        ([scene], _) => {
            let (outcome, length) = self::scene(scene, context)?;
            context.print("");
            recordings::check(&others, (Some(outcome), Some(length)), context)
        }
        _ => {
            let found = scenes.iter().map(|path| path.display().to_string()).collect::<Vec<_>>().join(", ");
            Err(BadInput::new("FILE", "one scene at most", found)
                .hint("check them one after the other")
                .into())
        }
    }
}

/// True for what is no recording by its ending, and no folder.
fn is_scene(path: &Path) -> bool {
    let ending = path.extension().and_then(|ending| ending.to_str());
    !path.is_dir() && !matches!(ending, Some("parquet" | "csv" | "journal"))
}

/// Checks a scene and its mesh; gives the length of the body too [m].
fn scene(path: &Path, context: &Context) -> anyhow::Result<(SceneSummary, f64)> {
    let scene = Scene::read(path)?;
    let (body, quality) = hysteron_twin::read_body(&scene)?;
    let twin = Twin::new(&scene, &body)?;

    context.print(format_args!("{}: {}", scene.name, scene.mesh_path.display()));
    print_quality(&body, &quality, context);
    let mass = scene.material.density * quality.volume.sum;
    let tip = twin.tip_of(&twin.rest()).map(|c| (1e6 * c).round() / 1e3 + 0.0);
    context.print("");
    context.print(format_args!(
        "mass {:.2} g, tip at ({:.3}, {:.3}, {:.3}) mm",
        1e3 * mass,
        tip[0],
        tip[1],
        tip[2]
    ));
    context.print("");
    print_tendons(&twin, context);
    print_friction(&twin, context);
    context.print("");
    let factor = print_equations(&twin, context)?;
    quality.warnings().iter().for_each(|warning| tracing::warn!("{warning}"));
    let estimator = Estimator::new(&scene, &body)?;
    estimator.warn();
    let outcome = SceneSummary {
        robot: scene.name.clone(),
        scene_sha256: scene.hash.clone(),
        mesh: MeshSummary::new(&body, &quality),
        mass_kg: mass,
        tip_m: twin.tip_of(&twin.rest()),
        tendons: twin.n_primary,
        auxiliary_tendons: twin.tendons.len() - twin.n_primary,
        unknowns: twin.body.n_unknowns(),
        factor_bytes: factor,
        locking: estimator.estimate().clone(),
        warnings: quality.warnings(),
    };
    Ok((outcome, body_length(&twin)))
}

/// The outcome of `check`: of a scene alone, or of recordings, with the scene that they are compared with.
#[derive(Debug, Clone, Serialize, JsonSchema)]
#[serde(untagged)]
pub enum Outcome {
    /// Of recordings.
    Recordings(RecordingFindings),
    /// Of a scene.
    Scene(SceneSummary),
}

impl crate::shared::outcome::Outcome for Outcome {}

impl<'de> Deserialize<'de> for Outcome {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        outcome::by_key(deserializer, "findings", Self::Recordings, Self::Scene)
    }
}

/// A scene in numbers.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct SceneSummary {
    /// Name of the robot.
    pub robot: String,
    /// SHA-256 of the scene.
    pub scene_sha256: String,
    /// The mesh.
    pub mesh: MeshSummary,
    /// Mass of the body [kg].
    pub mass_kg: f64,
    /// Tip of the unloaded body [m].
    pub tip_m: [f64; 3],
    /// Tendons of the robot.
    pub tendons: usize,
    /// Auxiliary tendons, which correct the twin.
    pub auxiliary_tendons: usize,
    /// Degrees of freedom.
    pub unknowns: usize,
    /// Memory that the factor of the stiffness takes [byte].
    pub factor_bytes: usize,
    /// Share of the motion that linear tetrahedra lose.
    pub locking: LockingEstimate,
    /// Doubts about the mesh, as sentences.
    pub warnings: Vec<String>,
}

fn print_friction(twin: &Twin, context: &Context) {
    if twin.backlash > 0.0 {
        context.print(format_args!("backlash {} mm", in_thousandths(twin.backlash)));
    }
    for (j, tendon) in twin.tendons.iter().enumerate() {
        let points = twin.friction.iter().filter(|point| point.tendon == j);
        let sheath = points
            .clone()
            .filter(|point| point.first == 0)
            .map(|point| format!("in the sheath, exponent {}, {} N; ", point.coefficient, point.constant));
        let inside: Vec<_> = points.filter(|point| point.first > 0).collect();
        let constant: f64 = inside.iter().map(|point| point.constant).sum();
        let body = inside.first().map(|point| {
            let n = inside.len();
            format!("at {n} points of the body, coefficient {}, {constant} N in all", point.coefficient)
        });
        let parts: String = sheath.chain(body).collect();
        if !parts.is_empty() {
            context.print(format_args!("{} rubs {}", tendon.name, parts.trim_end_matches("; ")));
        }
    }
}

fn print_tendons(twin: &Twin, context: &Context) {
    context.print(
        "tendon             driven by   points   length [mm]   outside the body [mm]   tension [N]   stretch [mm/N]   zero [mm]",
    );
    for j in 0..twin.n_primary {
        print_row(twin, &twin.tendons[j].name, j, j + 1, context);
    }
    if twin.tendons.len() > twin.n_primary {
        let (first, last) = (&twin.tendons[twin.n_primary], &twin.tendons[twin.tendons.len() - 1]);
        let name = format!("{} to {}", first.name, last.name.trim_start_matches("aux_"));
        print_row(twin, &name, twin.n_primary, twin.tendons.len(), context);
    }
}

/// A row for the tendons from `first` up to, not including, `end`, which differ only in where they run.
fn print_row(twin: &Twin, name: &str, first: usize, end: usize, context: &Context) {
    let tendon = &twin.tendons[first];
    let n_points = twin.cables.polyline(first, &twin.body.rest).len();
    let outside = twin.tendons[first..end].iter().map(|tendon| tendon.outside).fold(0.0, f64::max);
    let drive = match tendon.drive {
        PrescribedQuantity::Stroke => "stroke",
        PrescribedQuantity::Tension => "tension",
        PrescribedQuantity::Free => "nothing",
    };
    context.print(format_args!(
        "{name:<19}{drive:<12}{:>6}{:>14.3}{:>24.3}   {:<14}{:<17}{}",
        n_points,
        1e3 * twin.cables.rest_lengths[first],
        1e3 * outside,
        format!("{} to {}", tendon.tension.min, tendon.tension.max),
        in_thousandths(tendon.compliance),
        in_thousandths(tendon.zero),
    ));
}

/// A length in millimetres, or a compliance in millimetres per newton, without the noise of the conversion.
fn in_thousandths(value: f64) -> f64 {
    (1e9 * value).round() / 1e6 + 0.0
}

/// Prints their size; gives that of the factor [bytes].
fn print_equations(twin: &Twin, context: &Context) -> anyhow::Result<usize> {
    let pattern = Arc::new(twin.body.stiffness_pattern(&[]));
    let kind = FactorKind::fastest(&pattern);
    let mut factor = StiffnessFactor::new(&pattern, kind, twin.body.isa);
    let mut stiffness = Stiffness::zeros(pattern);
    twin.body.stiffness_into(&twin.body.rest, Tangent::Warped, &mut stiffness);
    factor.factorize(&stiffness)?;
    let (name, bytes) = match kind {
        FactorKind::Envelope => ("block envelope, single precision", 4),
        FactorKind::Supernodal => ("supernodal Cholesky, double precision", 8),
    };
    context.print(format_args!(
        "{} unknowns, {} tensions; factor: {name}, {:.1} MB",
        twin.body.n_unknowns(),
        twin.cables.len(),
        (factor.n_stored() * bytes) as f64 / 1e6,
    ));
    Ok(factor.n_stored() * bytes)
}
