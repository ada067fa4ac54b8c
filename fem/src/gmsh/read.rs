//! MSH file in, rest mesh out.
//!
//! Main decision: the volume must consist of tetrahedra of one kind; points, lines and surfaces only give
//! which nodes a physical group holds.

use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::path::Path;

use hysteron_base::BadInput;

use super::sections::{ElementBlock, Sections};
use super::split::parse;
use super::{TET4, TET10, foreign, groups, swap_last_two};
use crate::{Cells, Mesh, Result};

/// Reads a Gmsh MSH file (1, 2.0 to 2.2, 4.0, 4.1; text or binary; partitioned or not) and converts it to metres.
///
/// `metres_per_unit` is the length unit of the file \[m\]: 0.001 for millimetres.
///
/// Nodes keep the order of the file; those of no tetrahedron are dropped, and the others move up.
/// Physical groups of any dimension become node sets under their names. A group without a name is called
/// by its tag, `"1"` (`"surface 1"` and `"volume 1"` where both exist); one without a node of the
/// tetrahedra is dropped. Ten-node tetrahedra get the node order of [`Cells::Tet10`].
///
/// # Errors
/// `BadInput` naming the file and the line (text) or byte (binary) for a file that is missing, empty, cut
/// short, of another format or version, or damaged; for cells that are not tetrahedra or of two kinds; for
/// a coordinate that is not finite. [`check_mesh`](crate::check_mesh) checks the shape of the tetrahedra.
pub fn read_mesh(path: &Path, metres_per_unit: f64) -> Result<Mesh> {
    let bytes = hysteron_base::file::read_bytes(path)?;
    if !(metres_per_unit.is_finite() && metres_per_unit > 0.0) {
        return Err(bad_unit(metres_per_unit).within(path.display()).into());
    }
    if let Some(bad) = foreign::refusal(path, &bytes) {
        return Err(bad.within(path.display()).into());
    }
    let mesh = mesh_from_bytes(&bytes, metres_per_unit).map_err(|e| e.within(path.display()))?;
    Ok(mesh)
}

/// The error for an unknown unit of length.
pub(super) fn bad_unit(metres_per_unit: f64) -> BadInput {
    BadInput::new("length unit", "a positive number of metres", metres_per_unit.to_string())
        .hint("0.001 for a mesh in millimetres")
}

fn mesh_from_bytes(bytes: &[u8], metres_per_unit: f64) -> std::result::Result<Mesh, BadInput> {
    let sections = parse(bytes)?;
    let mut cells = cells(&sections)?;
    let new_index = drop_unused(&mut cells, sections.nodes.len());

    let mut nodes = Vec::with_capacity(sections.nodes.len());
    for (node, x) in sections.nodes.iter().enumerate() {
        if new_index[node].is_none() {
            continue;
        }
        let metres = x.map(|v| v * metres_per_unit);
        if metres.iter().any(|v| !v.is_finite()) {
            return Err(BadInput::new(
                format!("node {}", nodes.len()),
                "finite coordinates in metres",
                format!("{x:?} times {metres_per_unit}"),
            ));
        }
        nodes.push(metres);
    }
    let mut groups = groups::node_sets(&sections);
    for set in groups.values_mut() {
        *set = set.iter().filter_map(|&n| new_index[n as usize]).collect();
        set.sort_unstable();
        set.dedup();
    }
    groups.retain(|_, set| !set.is_empty());
    Ok(Mesh { nodes, cells, groups })
}

/// Gathers the tetrahedra and refuses every other kind of volume.
fn cells(sections: &Sections) -> std::result::Result<Cells, BadInput> {
    let mut kind = None;
    let mut repeats = RepeatedElements { is_possible: sections.is_partitioned, seen: HashMap::new() };
    let mut tet4 = Vec::new();
    let mut tet10 = Vec::new();
    for block in sections.blocks.iter().filter(|b| b.kind.shape.dimension() == 3) {
        let (Some(&tag), number) = (block.tags.first(), block.kind.number) else {
            continue;
        };
        if number != TET4 && number != TET10 {
            return Err(BadInput::new(
                format!("$Elements: element {tag}"),
                "four- or ten-node tetrahedra",
                format!("a {}", block.kind.name()),
            )
            .hint("mesh the part with tetrahedra of order 1 or 2, without recombining or extruding layers"));
        }
        if kind.is_some_and(|k| k != number) {
            return Err(BadInput::new(
                format!("$Elements: element {tag}"),
                "tetrahedra of one kind",
                "four-node and ten-node tetrahedra together",
            )
            .hint(
                "give all of the mesh the same order: `printf 'Merge \"old.msh\"; SetOrder 2; Save \"new.msh\";' > \
                 order.geo`, then `gmsh order.geo -parse_and_exit`",
            ));
        }
        kind = Some(number);
        let mut once = |k: &usize, nodes: &[u32]| repeats.is_first(block, *k, nodes);
        if number == TET4 {
            let cells = block.nodes.as_chunks::<4>().0.iter().enumerate();
            tet4.extend(cells.filter(|(k, n)| once(k, &n[..])).map(|(_, n)| *n));
        } else {
            let cells = block.nodes.as_chunks::<10>().0.iter().enumerate();
            tet10.extend(cells.filter(|(k, n)| once(k, &n[..])).map(|(_, n)| swap_last_two(*n)));
        }
    }
    match kind {
        Some(TET10) => Ok(Cells::Tet10(tet10)),
        Some(_) => Ok(Cells::Tet4(tet4)),
        None => Err(BadInput::new("$Elements", "tetrahedra", "none").hint(
            "mesh the volume: `gmsh part.geo -3`; with physical groups, the volume must be in one too or it is not saved",
        )),
    }
}

/// Finds tetrahedra that a file lists again: for another group (MSH 1 and 2), or under the same number for another
/// partition. The same nodes under another number in the same group are doubled by mistake, and stay for
/// [`check_mesh`](crate::check_mesh) to refuse.
struct RepeatedElements {
    is_possible: bool,
    /// Entity and number under which the corners came first.
    seen: HashMap<[u32; 4], ((i64, i64), u64)>,
}

impl RepeatedElements {
    /// Element `k` of a block, with these nodes in Gmsh's order.
    fn is_first(&mut self, block: &ElementBlock, k: usize, nodes: &[u32]) -> bool {
        let (Some(&corners), Some(&tag)) = (nodes.first_chunk::<4>(), block.tags.get(k)) else {
            return true;
        };
        if !self.is_possible {
            return true;
        }
        match self.seen.entry(corners) {
            Entry::Vacant(entry) => {
                entry.insert((block.entity, tag));
                true
            }
            Entry::Occupied(entry) => {
                let (entity, number) = *entry.get();
                entity == block.entity && number != tag
            }
        }
    }
}

/// Renumbers the tetrahedra over the nodes they use; returns the new index of every old node.
fn drop_unused(cells: &mut Cells, n_nodes: usize) -> Vec<Option<u32>> {
    let mut new_index = vec![None; n_nodes];
    for e in 0..cells.len() {
        for &n in cells.nodes(e) {
            new_index[n as usize] = Some(0);
        }
    }
    for (index, used) in (0..).zip(new_index.iter_mut().flatten()) {
        *used = index;
    }
    let renumber = |n: &mut u32| *n = new_index[*n as usize].unwrap_or(*n);
    match cells {
        Cells::Tet4(cells) => cells.iter_mut().flatten().for_each(renumber),
        Cells::Tet10(cells) => cells.iter_mut().flatten().for_each(renumber),
    }
    new_index
}
