//! The part of a scene and its mesh that a chain of sections depends on.

use hysteron_base::{AuxiliaryLayout, Bounds, PrescribedQuantity, Scene, Tendon, file, json};
use hysteron_fem::{Cells, Mesh};

/// Hashes of everything that a chain is made of. Young's modulus, density and gravity are not in it, nor what moves the tendons
/// and how they rub: a chain follows all of these.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct BodyShape {
    /// SHA-256 of mesh, clamp, law, Poisson's ratio, stiffer parts, tip, point forces and the ways of the tendons.
    pub body: String,
    /// SHA-256 of where the auxiliary tendons run, if there are any.
    pub auxiliary: Option<String>,
}

impl BodyShape {
    /// Of a scene on the mesh with this hash.
    pub fn new(scene: &Scene, mesh: &str) -> Self {
        let values = json!({
            "mesh": mesh,
            "clamp": scene.clamp,
            "law": scene.material.law,
            "poisson_ratio": scene.material.poisson_ratio,
            "inserts": scene.inserts,
            "tip": scene.tip,
            "point_forces": scene.point_forces,
            "tendons": scene.tendons.iter().map(way).collect::<Vec<_>>(),
        });
        let auxiliary = scene.auxiliary.as_ref().map(|layout| {
            let layout = AuxiliaryLayout {
                drive: PrescribedQuantity::Stroke,
                tension: NOTHING,
                stroke: NOTHING,
                stroke_rate: 0.0,
                ..layout.clone()
            };
            file::sha256_hex(json!(layout).to_string().as_bytes())
        });
        Self { body: file::sha256_hex(values.to_string().as_bytes()), auxiliary }
    }
}

/// Bounds of what does not count.
const NOTHING: Bounds = Bounds { min: 0.0, max: 0.0 };

/// Where a tendon runs and how it is held, without what moves it.
fn way(tendon: &Tendon) -> Tendon {
    Tendon {
        name: String::new(),
        drive: PrescribedQuantity::Stroke,
        tension: NOTHING,
        stroke: NOTHING,
        compliance: 0.0,
        zero: 0.0,
        ..tendon.clone()
    }
}

/// SHA-256 of nodes, elements and groups.
pub(crate) fn mesh_hash(mesh: &Mesh) -> String {
    let nodes = mesh.nodes.as_flattened().iter().flat_map(|x| x.to_le_bytes());
    let cells = match &mesh.cells {
        Cells::Tet4(cells) => cells.as_flattened(),
        Cells::Tet10(cells) => cells.as_flattened(),
    };
    let groups = mesh.groups.iter().flat_map(|(name, nodes)| {
        let size = (nodes.len() as u64).to_le_bytes();
        name.bytes().chain(size).chain(nodes.iter().flat_map(|node| node.to_le_bytes()))
    });
    let cells = cells.iter().flat_map(|node| node.to_le_bytes());
    let bytes: Vec<u8> = nodes.chain(cells).chain(groups).collect();
    file::sha256_hex(&bytes)
}
