//! Faces and edges of the tetrahedra.

use crate::mesh::Cells;

/// Corners of the four faces, seen from outside counter-clockwise.
const FACE_CORNERS: [[usize; 3]; 4] = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]];

/// Corners of the six edges, in the order of the middles of [`Cells::Tet10`].
pub(crate) const EDGE_CORNERS: [[usize; 2]; 6] = [[0, 1], [1, 2], [0, 2], [0, 3], [1, 3], [2, 3]];

/// A face of one tetrahedron.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Face {
    /// Tetrahedron.
    pub(crate) cell: u32,
    /// Corner nodes, seen from outside counter-clockwise.
    pub(crate) corners: [u32; 3],
}

/// All faces, those of the same three corners next to each other.
pub(crate) fn sorted_faces(cells: &Cells) -> Vec<([u32; 3], Face)> {
    let mut faces = Vec::with_capacity(4 * cells.len());
    for (cell, e) in (0..).zip(0..cells.len()) {
        let c = cells.corners(e);
        for local in FACE_CORNERS {
            let corners = local.map(|i| c[i]);
            let mut key = corners;
            key.sort_unstable();
            faces.push((key, Face { cell, corners }));
        }
    }
    faces.sort_unstable_by_key(|(key, face)| (*key, face.cell));
    faces
}

/// Faces of one tetrahedron only, in the order of the tetrahedra.
pub(crate) fn boundary_faces(cells: &Cells) -> Vec<Face> {
    let faces = sorted_faces(cells);
    let mut out: Vec<Face> = faces
        .chunk_by(|a, b| a.0 == b.0)
        .filter(|same| same.len() == 1)
        .flat_map(|same| same.iter().map(|(_, face)| *face))
        .collect();
    out.sort_by_key(|face| face.cell);
    out
}

/// The node at the middle of the edge between two corners of a ten-node tetrahedron.
pub(crate) fn middle_of(nodes: &[u32; 10], a: u32, b: u32) -> Option<u32> {
    let edge = EDGE_CORNERS
        .iter()
        .position(|&[i, j]| (nodes[i] == a && nodes[j] == b) || (nodes[i] == b && nodes[j] == a))?;
    Some(nodes[4 + edge])
}
