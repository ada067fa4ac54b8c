//! Robots made in code, on small meshes. Unit and integration tests share this file and each use a part.
#![allow(dead_code, clippy::unwrap_used)]

use hysteron_base::{
    AuxiliaryLayout, Bounds, Friction, LengthUnit, Material, MaterialLaw, PrescribedQuantity, Region, Scene,
    Solver, Tendon, TipDefinition,
};
use hysteron_fem::{Layers, Mesh, Order, Tube};

/// Length and radii of [`robot`] [m].
pub const LENGTH: f64 = 0.04;
pub const OUTER: f64 = 0.006;
pub const TENDON_RADIUS: f64 = 0.0045;

/// Beyond all tensions: every point sticks. One at its bound slips one way only, and has two derivatives.
pub const STUCK: Friction = Friction {
    coefficient: 0.0,
    coulomb: 200.0,
    points: 4,
    sheath_exponent: 0.0,
    sheath_coulomb: 0.0,
    sheath_compliance_share: 0.5,
    backlash: 0.0,
};

/// A soft tube of 40 mm with four tendons, about 240 nodes.
pub fn robot() -> (Scene, Mesh) {
    robot_with(MaterialLaw::Corotational, Order::Linear, 12)
}

/// The same body with another law, order of elements or number of layers.
pub fn robot_with(law: MaterialLaw, order: Order, layers: u32) -> (Scene, Mesh) {
    let mesh = tube(LENGTH, OUTER, 0.0025, layers, order);
    let mut scene = scene("robot", law);
    scene.tendons = (0..4).map(|k| tendon(k, LENGTH, TENDON_RADIUS, 10)).collect();
    (scene, mesh)
}

/// The same robot with auxiliary tendons: two in each of `segments`, a quarter turn on from one to the next.
pub fn actuated(segments: usize) -> (Scene, Mesh) {
    let (mut scene, mesh) = robot();
    scene.auxiliary = Some(AuxiliaryLayout {
        segments,
        segment_length: 0.8 * LENGTH / segments as f64,
        start: 4e-3,
        radius: 5e-3,
        cables_per_segment: 2,
        first_plane: 0.0,
        plane_step: std::f64::consts::FRAC_PI_2,
        drive: PrescribedQuantity::Tension,
        tension: Bounds { min: -20.0, max: 20.0 },
        stroke: Bounds { min: -1e-3, max: 1e-3 },
        stroke_rate: f64::INFINITY,
        attach_within: 1e-3,
        anchor: None,
    });
    (scene, mesh)
}

/// Tendons that stretch by `compliance` [m/N], with friction everywhere, without backlash.
pub fn roughen(scene: &mut Scene, compliance: f64) {
    for tendon in &mut scene.tendons {
        tendon.compliance = compliance;
    }
    scene.friction = Some(ROUGH);
}

/// Friction everywhere.
pub const ROUGH: Friction = Friction {
    coefficient: 0.3,
    coulomb: 0.05,
    points: 4,
    sheath_exponent: 0.2,
    sheath_coulomb: 0.1,
    sheath_compliance_share: 0.6,
    backlash: 0.0,
};

/// A tube with eight sides.
pub fn tube(length: f64, outer: f64, bore: f64, layers: u32, order: Order) -> Mesh {
    let tube = Tube {
        profile: vec![[0.0, outer], [length, outer]],
        bore_radius: bore,
        ..tube_of(8, Layers::Count(layers), order)
    };
    tube.mesh().unwrap()
}

/// The tube of [`robot`] with as many sides outside as inside.
pub fn tube_of(sides: u32, layers: Layers, order: Order) -> Tube {
    Tube {
        profile: vec![[0.0, OUTER], [LENGTH, OUTER]],
        bore_radius: 0.0025,
        channels: Vec::new(),
        outer_divisions: sides,
        bore_divisions: sides,
        channel_divisions: 6,
        layers,
        order,
    }
}

/// A clamped body of TPU without tendons.
pub fn scene(name: &str, law: MaterialLaw) -> Scene {
    Scene {
        name: name.into(),
        seed: 1,
        hash: "0".repeat(64),
        mesh_path: "made-in-code.msh".into(),
        mesh_unit: LengthUnit::Metre,
        reduced_path: None,
        clamp: Region::Group("base".into()),
        material: Material { law, youngs_modulus: 5e6, poisson_ratio: 0.4, density: 1200.0 },
        gravity: [0.0; 3],
        point_forces: Vec::new(),
        inserts: Vec::new(),
        tracker: Default::default(),
        tip: TipDefinition::Group("tip".into()),
        tendons: Vec::new(),
        friction: None,
        auxiliary: None,
        solver: Solver { relative_residual: 1e-8, stroke_tolerance: 1e-10 },
    }
}

/// Straight tendon `k` of four, at a quarter turn from each other.
pub fn tendon(k: usize, length: f64, radius: f64, segments: usize) -> Tendon {
    let [x, y] = [[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]][k];
    let point = |i: usize| [radius * x, radius * y, length * i as f64 / segments as f64];
    Tendon {
        name: format!("tendon_{}", k + 1),
        points: (0..=segments).map(point).collect(),
        fixed: Vec::new(),
        drive: PrescribedQuantity::Stroke,
        tension: Bounds { min: 0.0, max: 100.0 },
        stroke: Bounds { min: -0.01, max: 0.01 },
        attach_within: 1e-4,
        anchor: None,
        ring: 0.0,
        compliance: 0.0,
        zero: 0.0,
    }
}
