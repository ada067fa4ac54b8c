//! Robots built in code: the tube that SOFA was run on, and tubes of any resolution.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use hysteron_base::{
    Bounds, Friction, LengthUnit, Material, MaterialLaw, PrescribedQuantity, Region, Scene, Solver, Tendon,
    TipDefinition,
};
use hysteron_fem::{Layers, Mesh, Order, Tube, read_mesh};
use hysteron_twin::{Target, Twin};

use super::columns::read_columns;

/// Number of primary tendons of every scene here.
pub const N_PRIMARY: usize = 4;
/// Primary and auxiliary tendons of the SOFA scene.
pub const N_TENDONS: usize = 40;
/// Height of the tube [m].
pub const HEIGHT: f64 = 0.08;
/// Tension bounds of a cable that may push [N].
pub const MAY_PUSH: Bounds = Bounds { min: -1e3, max: 1e3 };
const PULLS_ONLY: Bounds = Bounds { min: 0.0, max: 1e3 };

/// Which law and accuracy a scene is solved with.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Setting {
    /// Strain measure and stress.
    pub law: MaterialLaw,
    /// Relative force residual [-].
    pub relative_residual: f64,
    /// Stroke error [m].
    pub stroke_tolerance: f64,
    /// Radius of the ring that carries each tendon point [m]; zero for the point alone, as in SOFA.
    pub ring: f64,
    /// Compliance of each tendon [m/N].
    pub compliance: f64,
    /// Friction of the tendons.
    pub friction: Option<Friction>,
}

impl Setting {
    /// Accuracy of the performance targets: 1e-6 and 1e-6 mm.
    pub const TARGETS: Self = Self {
        law: MaterialLaw::Corotational,
        relative_residual: 1e-6,
        stroke_tolerance: 1e-9,
        ring: 0.0,
        compliance: 0.0,
        friction: None,
    };
    /// The same with tendons that stretch, with friction in their sheath and at three points of the body.
    pub const RUBBING: Self = Self {
        compliance: 2e-5,
        friction: Some(Friction {
            coefficient: 0.1,
            coulomb: 0.1,
            points: 3,
            sheath_exponent: 0.31,
            sheath_coulomb: 0.1,
            sheath_compliance_share: 0.6,
            backlash: 5e-5,
        }),
        ..Self::TARGETS
    };

    /// Converged far beyond the reference's own 1e-10 mm.
    pub fn exact(law: MaterialLaw) -> Self {
        Self { law, relative_residual: 1e-10, stroke_tolerance: 1e-13, ..Self::TARGETS }
    }
}

/// The folder with the meshes and curves of SOFA, below the root of a checkout of the project.
pub fn sofa_folder(repository: &Path) -> PathBuf {
    repository.join("tests/reference/sofa")
}

/// SOFA's mesh with its nodes at z = 0 and at the other end as groups `base` and `tip`.
///
/// # Errors
/// The files of the reference cannot be read.
pub fn sofa_mesh(repository: &Path) -> Result<Mesh> {
    let folder = sofa_folder(repository);
    let mut mesh = read_mesh(&folder.join("meshA.msh"), LengthUnit::Millimetre.to_m())?;
    for (group, file) in [("base", "meshA_fixed.csv"), ("tip", "meshA_tip.csv")] {
        let nodes = read_columns(&folder.join(file), &["node_id"])?.remove(0);
        mesh.groups.insert(group.into(), nodes.into_iter().map(|node| node as u32).collect());
    }
    Ok(mesh)
}

/// SOFA's scene on `mesh`, with the first `n_tendons` of its cables. Primary cables pull only, auxiliary ones may push.
///
/// # Errors
/// The files of the reference cannot be read, or do not fit the mesh.
pub fn sofa_scene(repository: &Path, setting: Setting, mesh: &Mesh, n_tendons: usize) -> Result<Twin> {
    let path = sofa_folder(repository).join("cables.csv");
    let columns = read_columns(&path, &["x_mm", "y_mm", "z_mm", "point"])?;
    let mut tendons: Vec<Tendon> = Vec::new();
    for k in 0..columns[0].len() {
        if columns[3][k] == 0.0 {
            let number = tendons.len();
            let (name, tension) = if number < N_PRIMARY {
                (format!("p{number}"), PULLS_ONLY)
            } else {
                (format!("a{}", number - N_PRIMARY), MAY_PUSH)
            };
            tendons.push(tendon(name, Vec::new(), tension));
        }
        let point = [0, 1, 2].map(|c| 1e-3 * columns[c][k]);
        tendons.last_mut().context("cables.csv starts within a cable")?.points.push(point);
    }
    ensure!(n_tendons <= tendons.len(), "{n_tendons} tendons of {}", tendons.len());
    tendons.truncate(n_tendons);
    twin(setting, rubber(setting), mesh, tendons, [0.0; 3])
}

/// The same tube, meshed by the built-in mesher, with the four primaries.
///
/// # Errors
/// Divisions that cannot be meshed.
pub fn tube_scene(setting: Setting, mesh: &Mesh) -> Result<Twin> {
    let tendons = (0..N_PRIMARY).map(|k| {
        let (sin, cos) = (std::f64::consts::FRAC_PI_2 * k as f64).sin_cos();
        let points = (0..=10).map(|i| [4.5e-3 * cos, 4.5e-3 * sin, 0.1 * HEIGHT * f64::from(i)]);
        tendon(format!("p{k}"), points.collect(), PULLS_ONLY)
    });
    twin(setting, rubber(setting), mesh, tendons.collect(), [0.0; 3])
}

/// The tube without channels, `divisions` sides around and layers as high as the sides are long.
pub fn tube(divisions: u32, order: Order) -> Tube {
    let radius = 6e-3;
    let side = std::f64::consts::TAU * radius / f64::from(divisions);
    Tube {
        profile: vec![[0.0, radius], [HEIGHT, radius]],
        bore_radius: 3e-3,
        channels: Vec::new(),
        outer_divisions: divisions,
        bore_divisions: divisions,
        channel_divisions: divisions,
        layers: Layers::Count((HEIGHT / side).ceil() as u32),
        order,
    }
}

/// A tendon whose stroke is not bounded.
pub fn tendon(name: String, points: Vec<[f64; 3]>, tension: Bounds) -> Tendon {
    let stroke = Bounds { min: -1.0, max: 1.0 };
    Tendon {
        name,
        points,
        fixed: Vec::new(),
        drive: PrescribedQuantity::Stroke,
        tension,
        stroke,
        attach_within: 3e-4,
        anchor: None,
        ring: 0.0,
        compliance: 0.0,
        zero: 0.0,
    }
}

/// A twin clamped at the group `base` with its tip at the group `tip`.
///
/// # Errors
/// As [`Twin::new`].
pub fn twin(
    setting: Setting,
    material: Material,
    mesh: &Mesh,
    tendons: Vec<Tendon>,
    gravity: [f64; 3],
) -> Result<Twin> {
    let tendons = tendons
        .into_iter()
        .map(|tendon| Tendon { ring: setting.ring, compliance: setting.compliance, ..tendon })
        .collect();
    let scene = Scene {
        name: "bench".into(),
        seed: 1,
        hash: String::new(),
        mesh_path: PathBuf::new(),
        mesh_unit: LengthUnit::Metre,
        reduced_path: None,
        clamp: Region::Group("base".into()),
        material,
        gravity,
        point_forces: Vec::new(),
        inserts: Vec::new(),
        tracker: Default::default(),
        tip: TipDefinition::Group("tip".into()),
        tendons,
        friction: setting.friction,
        auxiliary: None,
        solver: Solver {
            relative_residual: setting.relative_residual,
            stroke_tolerance: setting.stroke_tolerance,
        },
    };
    Ok(Twin::new(&scene, mesh)?)
}

fn rubber(setting: Setting) -> Material {
    Material { law: setting.law, youngs_modulus: 20e6, poisson_ratio: 0.45, density: 0.0 }
}

/// The first primary tendon pulled to `stroke` [m], the other tendons without tension.
pub fn one_sided(n_tendons: usize, stroke: f64) -> Vec<Target> {
    let mut targets = vec![Target::Tension(0.0); n_tendons];
    targets[0] = Target::Stroke(stroke);
    targets
}
