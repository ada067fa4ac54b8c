//! From four-node to ten-node tetrahedra: a node at the middle of every edge.

use std::collections::{BTreeMap, HashMap};

use crate::mesh::faces::{EDGE_CORNERS, boundary_faces};
use crate::{Cells, Mesh};

impl Mesh {
    /// The same tetrahedra with a node at the middle of every straight edge.
    ///
    /// The corners keep their numbers; the middles follow, in the order in which the tetrahedra name them.
    /// A middle joins a group when a whole boundary face or a whole tetrahedron around it belongs to the
    /// group. A mesh of ten-node tetrahedra is returned as it is. Edges stay straight: on a curved side the
    /// middles lie on the facets.
    pub fn to_quadratic(&self) -> Self {
        let Cells::Tet4(cells) = &self.cells else {
            return self.clone();
        };
        let mut nodes = self.nodes.clone();
        let mut middle: HashMap<[u32; 2], u32> = HashMap::new();
        let mut ten = Vec::with_capacity(cells.len());
        for c in cells {
            let mut n = [0; 10];
            n[..4].copy_from_slice(c);
            for (k, [i, j]) in EDGE_CORNERS.into_iter().enumerate() {
                let key = edge(c[i], c[j]);
                n[4 + k] = *middle.entry(key).or_insert_with(|| {
                    let [a, b] = key.map(|v| self.nodes.get(v as usize).copied().unwrap_or([f64::NAN; 3]));
                    nodes.push([0, 1, 2].map(|d| 0.5 * (a[d] + b[d])));
                    nodes.len() as u32 - 1
                });
            }
            ten.push(n);
        }
        let groups = self.quadratic_groups(cells, &middle);
        Self { nodes, cells: Cells::Tet10(ten), groups }
    }

    fn quadratic_groups(
        &self,
        cells: &[[u32; 4]],
        middle: &HashMap<[u32; 2], u32>,
    ) -> BTreeMap<String, Vec<u32>> {
        let faces = boundary_faces(&self.cells);
        let mut groups = BTreeMap::new();
        for (name, set) in &self.groups {
            let holds = |n: &u32| set.binary_search(n).is_ok();
            let mut all = set.clone();
            let mut join = |corners: &[u32]| {
                for (i, &a) in corners.iter().enumerate() {
                    all.extend(corners[..i].iter().filter_map(|&b| middle.get(&edge(a, b))));
                }
            };
            for face in faces.iter().filter(|f| f.corners.iter().all(holds)) {
                join(&face.corners);
            }
            for cell in cells.iter().filter(|c| c.iter().all(holds)) {
                join(cell);
            }
            all.sort_unstable();
            all.dedup();
            groups.insert(name.clone(), all);
        }
        groups
    }
}

fn edge(a: u32, b: u32) -> [u32; 2] {
    [a.min(b), a.max(b)]
}
