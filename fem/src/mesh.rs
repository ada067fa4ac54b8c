//! The rest mesh, as a file or the built-in mesher gives it.
//!
//! Nodes keep their order from the file, counted from 0; everything a person reads names them so.
//! Lengths are metres: the reader converts.

use std::collections::BTreeMap;

pub(crate) mod faces;
mod quadratic;

/// Tetrahedra of one kind. A mesh never mixes them.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Cells {
    /// Four nodes, linear displacement.
    Tet4(Vec<[u32; 4]>),
    /// Ten nodes, quadratic displacement: corners 0-3, then the middles of edges
    /// 01, 12, 02, 03, 13, 23 (the order of VTK).
    Tet10(Vec<[u32; 10]>),
}

impl Cells {
    /// Number of tetrahedra.
    pub fn len(&self) -> usize {
        match self {
            Self::Tet4(cells) => cells.len(),
            Self::Tet10(cells) => cells.len(),
        }
    }

    /// True when there is none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// All nodes of tetrahedron `e` (4 or 10).
    pub fn nodes(&self, e: usize) -> &[u32] {
        match self {
            Self::Tet4(cells) => &cells[e],
            Self::Tet10(cells) => &cells[e],
        }
    }

    /// Corners of the faces of one tetrahedron only, seen from outside counter-clockwise: the surface.
    pub fn surface(&self) -> Vec<[u32; 3]> {
        faces::boundary_faces(self).iter().map(|face| face.corners).collect()
    }

    /// The four corners of tetrahedron `e`.
    pub fn corners(&self, e: usize) -> [u32; 4] {
        let n = self.nodes(e);
        [n[0], n[1], n[2], n[3]]
    }
}

/// A rest mesh with named node sets.
#[derive(Debug, Clone, PartialEq)]
pub struct Mesh {
    /// Rest positions, one per node \[m\].
    pub nodes: Vec<[f64; 3]>,
    /// Tetrahedra.
    pub cells: Cells,
    /// Nodes of every named physical group (of any dimension), ascending.
    pub groups: BTreeMap<String, Vec<u32>>,
}

/// Larger meshes take too long for a step.
const MAX_NODES: usize = 2_000_000;

impl Mesh {
    /// Accepts a mesh whose stiffness and factor this machine has memory for.
    ///
    /// A block of the stiffness takes 136 bytes, and each node has about eight; the factor of a body as wide as it
    /// is long has about 32 n^4/3 numbers, that of a slender one fewer.
    ///
    /// # Errors
    /// `BadInput` with the number of nodes, or the memory.
    pub fn check_size(&self) -> crate::Result<()> {
        let n = self.nodes.len();
        hysteron_base::size::check_at_most("mesh: nodes", n, MAX_NODES)?;
        let n = n as f64;
        let bytes = 1500.0 * n + 8.0 * 32.0 * n.powf(4.0 / 3.0);
        Ok(hysteron_base::size::check_memory("mesh", bytes, "a coarser mesh")?)
    }
}
