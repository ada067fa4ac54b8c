//! Scenes: the robot, its material, tendons and loads, as one valid value in SI.
//!
//! The file as typed (`schema.rs`) and the valid scene (here) are two types with one conversion between
//! (`convert.rs`), so that nothing downstream checks a bound or converts a unit again. Physics has no defaults.
//! A scene may also be put together in code: the fields are public, and their comments state what holds.

mod convert;
mod schema;

use crate::units::LengthUnit;
use crate::{Result, file};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// Everything that defines a simulation, valid and in SI.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Scene {
    /// Name of the robot.
    pub name: String,
    /// Seed of every random stream, see [`crate::rng`].
    pub seed: u64,
    /// SHA-256 of all that decides where the tip goes, 64 hexadecimal digits: the values of the scene, however they are
    /// typed, the bytes of the mesh and of the reduced body, and the version of the equations.
    #[serde(skip)]
    pub hash: String,
    /// File of the mesh, already relative to the current folder rather than to the scene.
    #[serde(skip)]
    pub mesh_path: PathBuf,
    /// Unit of the mesh file.
    pub mesh_unit: LengthUnit,
    /// File of the reduced body that moves in place of the mesh, if any; relative as the mesh is.
    #[serde(skip)]
    pub reduced_path: Option<PathBuf>,
    /// Nodes that cannot move.
    pub clamp: Region,
    /// Material of the whole body.
    pub material: Material,
    /// Parts that are stiffer than the rest; of parts that overlap the last one counts.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub inserts: Vec<Insert>,
    /// Acceleration of gravity [m/s²].
    pub gravity: [f64; 3],
    /// Constant forces.
    pub point_forces: Vec<PointForce>,
    /// Definition of the point reported as the tip.
    pub tip: TipDefinition,
    /// Frame in which the tip is recorded.
    pub tracker: TrackerFrame,
    /// Primary tendons, with different names.
    pub tendons: Vec<Tendon>,
    /// How the primary tendons rub, if they do.
    pub friction: Option<Friction>,
    /// Layout of the auxiliary tendons of CoReAct.
    pub auxiliary: Option<AuxiliaryLayout>,
    /// Numerical tolerances.
    pub solver: Solver,
}

/// Part of a mesh.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub enum Region {
    /// A physical group of the mesh, by name.
    Group(String),
    /// All nodes in an axis-aligned box, its faces included; `min <= max` on each axis.
    Box {
        /// Lower corner [m].
        min: [f64; 3],
        /// Upper corner [m].
        max: [f64; 3],
    },
}

/// A part of the body of another stiffness: a cap that tendons end in, a ring between segments.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Insert {
    /// All elements with every corner in it.
    pub region: Region,
    /// Young's modulus over that of the body [-], > 0.
    pub modulus_ratio: f64,
}

/// Where the tip is.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub enum TipDefinition {
    /// Mean of the nodes of a physical group.
    Group(String),
    /// A point of the body at rest [m].
    Point([f64; 3]),
}

/// Frame of the tracker against that of the scene: a point x of the scene is recorded at R x + shift, with R the
/// rotation about the rotation vector `turn`. The default is the scene's own frame.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct TrackerFrame {
    /// Rotation vector [rad], shorter than half a turn.
    pub turn: [f64; 3],
    /// Where the scene's origin is recorded [m].
    pub shift: [f64; 3],
}

/// Strain measure and stress law of the elements.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum MaterialLaw {
    /// Linear elasticity of the rest shape.
    SmallStrain,
    /// Linear elasticity in a frame turned with each element, by polar decomposition.
    Corotational,
    /// The same with the frame taken from the edges of the element.
    CorotationalEdges,
    /// Compressible neo-Hookean.
    NeoHookean,
}

/// An isotropic elastic material.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Material {
    /// Which law.
    pub law: MaterialLaw,
    /// Young's modulus E > 0 [Pa].
    pub youngs_modulus: f64,
    /// Poisson's ratio, -1 < nu < 0.5 [-].
    pub poisson_ratio: f64,
    /// Density >= 0 [kg/m³].
    pub density: f64,
}

/// A constant force at a point of the body.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PointForce {
    /// Point of the body at rest [m], carried by the element there.
    pub at: [f64; 3],
    /// Force in the world [N].
    pub force: [f64; 3],
}

/// Prescribed quantity of a tendon.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum PrescribedQuantity {
    /// The pulled length is prescribed, the tension follows.
    Stroke,
    /// The tension is prescribed, the pulled length follows.
    Tension,
    /// Neither: the solver chooses within the bounds.
    Free,
}

/// A closed interval, `min <= max`, both finite.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Bounds {
    /// Smallest allowed value.
    pub min: f64,
    /// Largest allowed value.
    pub max: f64,
}

impl Bounds {
    /// The value moved to the nearest allowed one.
    pub fn clamp(&self, value: f64) -> f64 {
        value.clamp(self.min, self.max)
    }

    /// True if the value is allowed.
    pub fn contains(&self, value: f64) -> bool {
        (self.min..=self.max).contains(&value)
    }
}

/// A tendon through points of the body.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Tendon {
    /// Name, not empty.
    pub name: String,
    /// At least two points of the body at rest [m], from the pulled end at the base to the tip; neighbours differ.
    pub points: Vec<[f64; 3]>,
    /// Which of `points` are fixed in space instead of carried by the body, ascending: eyelets and pulleys of the base.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub fixed: Vec<usize>,
    /// Prescribed quantity.
    pub drive: PrescribedQuantity,
    /// Tension [N]; a minimum of zero means that it pulls only and goes slack.
    pub tension: Bounds,
    /// Pulled length [m].
    pub stroke: Bounds,
    /// How far outside the body a point may lie [m], >= 0; it is then carried by the nearest element.
    pub attach_within: f64,
    /// Radius of the circle around the tendon whose points carry each of its points [m], as a channel's
    /// wall does; zero for the point alone.
    pub ring: f64,
    /// Radius of the anchor by which each of its points acts on the body [m], > 0; without one they act by ring or point.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub anchor: Option<f64>,
    /// How much the tendon stretches per tension, from the servo to its end [m/N], >= 0; zero for one that keeps
    /// its length.
    pub compliance: f64,
    /// How far the tendon has already been pulled at stroke zero of a recording [m]: positive for pretension,
    /// negative for slack.
    pub zero: f64,
}

/// How every primary tendon rubs between servo and tip. All numbers are finite and >= 0; a zero is no such effect.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Friction {
    /// Coefficient of friction in the body's channels [-].
    pub coefficient: f64,
    /// Friction of a whole tendon in the body without tension [N].
    pub coulomb: f64,
    /// Friction points of a tendon in the body, at most as many as it has inner points; each has an equal
    /// share of these.
    pub points: usize,
    /// Friction coefficient times the whole turn of the sheath between servo and body [-]: of a tension T that moves
    /// through it, T exp(-this) is left.
    pub sheath_exponent: f64,
    /// Friction in the sheath without tension [N].
    pub sheath_coulomb: f64,
    /// Share, 0 to 1, of a tendon's compliance that lies before the friction of the sheath; the rest lies along the
    /// body [-].
    pub sheath_compliance_share: f64,
    /// How far a servo moves on reversal until its tendon follows [m].
    pub backlash: f64,
}

/// Auxiliary tendons around the axis z, segment by segment; `twin` expands them (CoReAct paper, section V-A b).
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct AuxiliaryLayout {
    /// Number of segments, >= 1.
    pub segments: usize,
    /// Length of each [m], > 0.
    pub segment_length: f64,
    /// Where the first begins along z [m].
    pub start: f64,
    /// Distance of the cables from the axis [m], > 0.
    pub radius: f64,
    /// Cables of each segment, >= 1, evenly spaced around the axis.
    pub cables_per_segment: usize,
    /// Angle of the first cable of the first segment about z [rad].
    pub first_plane: f64,
    /// Turn from each segment to the next [rad].
    pub plane_step: f64,
    /// Prescribed quantity.
    pub drive: PrescribedQuantity,
    /// Tension [N]; negative pushes.
    pub tension: Bounds,
    /// Pulled length [m].
    pub stroke: Bounds,
    /// Fastest that an identified stroke may change [m/s], > 0; infinite where the scene has no limit.
    pub stroke_rate: f64,
    /// How far outside the body a point may lie [m], >= 0.
    pub attach_within: f64,
    /// Radius of the anchor by which each end acts on the body [m], > 0; without one it acts by a point.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub anchor: Option<f64>,
}

/// Numerical tolerances: the only part of a scene with defaults.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Solver {
    /// Largest remaining force over the applied one, in (0, 1) [-].
    pub relative_residual: f64,
    /// Largest error of a prescribed stroke [m], > 0.
    pub stroke_tolerance: f64,
}

impl Default for Solver {
    fn default() -> Self {
        Self { relative_residual: 1e-6, stroke_tolerance: 1e-9 }
    }
}

/// Version of what the program makes of a scene, and part of [`Scene::hash`]: raised whenever the same scene and
/// strokes lead the tip elsewhere, beyond the tolerance of the solver. What was made with another version is then
/// not taken for made from the same scene. `tests/it/equations.rs`
/// notices where it was forgotten.
const EQUATIONS: u32 = 1;

impl Scene {
    /// Reads and validates a scene file; the paths in it are taken relative to its folder. Of the mesh and of the reduced body
    /// only the hash is taken.
    ///
    /// # Errors
    /// `BadInput` naming the key, what it may be and what it was, or that there is no mesh; `Io` if a file cannot be
    /// read.
    pub fn read(path: impl AsRef<Path>) -> Result<Self> {
        Self::read_with(path, None)
    }

    /// As [`Scene::read`], with the reduced body of a file, if one is given, in place of that which the scene names.
    ///
    /// # Errors
    /// As [`Scene::read`].
    pub fn read_with(path: impl AsRef<Path>, reduced: Option<PathBuf>) -> Result<Self> {
        Self::read_parts(path.as_ref(), |named| reduced.or(named))
    }

    /// As [`Scene::read`], without the reduced body that the scene names, whose file need not exist yet.
    ///
    /// # Errors
    /// As [`Scene::read`].
    pub fn read_unreduced(path: impl AsRef<Path>) -> Result<Self> {
        Self::read_parts(path.as_ref(), |_| None)
    }

    /// A scene file, and the hashes of its mesh and of the reduced body that `reduced` makes of the one it names.
    fn read_parts(path: &Path, reduced: impl FnOnce(Option<PathBuf>) -> Option<PathBuf>) -> Result<Self> {
        let folder = path.parent().unwrap_or(Path::new(""));
        let scene = Self::from_toml(&file::read_text(path)?, &path.display().to_string(), folder)?;
        let mesh = file::sha256_of(&scene.mesh_path)?;
        let mut hash = file::sha256_hex(format!("{}\n{mesh}", scene.hash).as_bytes());
        let reduced_path = reduced(scene.reduced_path);
        if let Some(path) = &reduced_path {
            hash = file::sha256_hex(format!("{hash}\nreduced {}", file::sha256_of(path)?).as_bytes());
        }
        Ok(Self { hash, reduced_path, ..scene })
    }

    /// The scene in the text of a scene file; `place` names the file in messages, `folder` is where the
    /// mesh path starts. The mesh is not read, and no part of the hash.
    ///
    /// # Errors
    /// As [`Scene::read`].
    pub fn from_toml(text: &str, place: &str, folder: &Path) -> Result<Self> {
        let typed: schema::SceneFile = crate::schema::parse(text).map_err(|bad| bad.within(place))?;
        let mut scene = convert::scene(typed, folder).map_err(|bad| bad.within(place))?;
        scene.hash = scene.hash_of_values();
        Ok(scene)
    }

    /// SHA-256 of the values in SI, each in the fewest digits that give it back, and of the version of the equations.
    fn hash_of_values(&self) -> String {
        let values = crate::json!({ "equations": EQUATIONS, "scene": self });
        file::sha256_hex(values.to_string().as_bytes())
    }
}

#[cfg(test)]
mod tests;
