//! The outcome of `mesh`: size and quality of the mesh.

use std::collections::BTreeMap;
use std::path::PathBuf;

use hysteron_fem::{Distribution, Mesh, MeshQuality};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The outcome of `mesh`.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct Outcome {
    /// The file.
    pub out: PathBuf,
    /// The mesh in it.
    #[serde(flatten)]
    pub mesh: MeshSummary,
}

impl crate::shared::outcome::Outcome for Outcome {}

/// Size and quality of a mesh.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct MeshSummary {
    /// Number of nodes.
    pub nodes: usize,
    /// Number of tetrahedra.
    pub tetrahedra: usize,
    /// Volume of the body [m³].
    pub volume_m3: f64,
    /// Number of nodes in each group, by its name.
    pub groups: BTreeMap<String, usize>,
    /// Three times the radius of the inscribed over that of the circumscribed sphere [-]: 1 for a regular tetrahedron.
    pub radius_ratio: Spread,
    /// Smallest angle between two faces [rad].
    pub smallest_angle_rad: Spread,
}

/// The distribution of a measure of quality over the tetrahedra.
#[derive(Debug, Clone, Copy, Serialize, Deserialize, JsonSchema)]
pub struct Spread {
    /// Smallest value.
    pub min: f64,
    /// The tetrahedron that has it, by its number in the file.
    pub min_tetrahedron: usize,
    /// A hundredth of the tetrahedra are below this.
    pub percentile_1: f64,
    /// A twentieth of the tetrahedra are below this.
    pub percentile_5: f64,
    /// Half of the tetrahedra are below this.
    pub median: f64,
    /// Mean.
    pub mean: f64,
    /// Largest value.
    pub max: f64,
}

impl MeshSummary {
    /// Of a mesh that was checked.
    pub fn new(mesh: &Mesh, quality: &MeshQuality) -> Self {
        let spread = |of: &Distribution| Spread {
            min: of.min,
            min_tetrahedron: of.min_cell,
            percentile_1: of.percentile_1,
            percentile_5: of.percentile_5,
            median: of.median,
            mean: of.mean,
            max: of.max,
        };
        Self {
            nodes: quality.n_nodes,
            tetrahedra: quality.n_cells,
            volume_m3: quality.volume.sum,
            groups: mesh.groups.iter().map(|(name, nodes)| (name.clone(), nodes.len())).collect(),
            radius_ratio: spread(&quality.radius_ratio),
            smallest_angle_rad: spread(&quality.smallest_angle),
        }
    }
}
