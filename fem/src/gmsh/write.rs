//! Rest mesh in, MSH 4.1 file out.
//!
//! Main decision: a node set has no element of its own in this format, so every group is written as the
//! elements that carry exactly its nodes: all tetrahedra of the set, else the boundary faces, else points.
//! The nodes keep their order and are tagged from 1.

use std::collections::BTreeMap;
use std::path::Path;

use hysteron_base::{BadInput, file};

use super::read::bad_unit;
use super::{TET4, TET10, swap_last_two};
use crate::mesh::faces::{boundary_faces, middle_of};
use crate::{Cells, Mesh, Result};

/// How the numbers are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MshEncoding {
    /// Text, every number as short as exact reading allows.
    Ascii,
    /// Little-endian bytes.
    Binary,
}

/// Writes a mesh as Gmsh MSH 4.1 in the given length unit \[m\], with its groups.
///
/// [`read_mesh`](crate::read_mesh) with the same unit gives the same tetrahedra and groups, and the same
/// nodes but for the last binary digit. The file appears whole or not at all.
///
/// # Errors
/// `BadInput` for a unit that is no positive number, a coordinate that is not finite, an index out of
/// range, a group name that does not fit on a line in quotes, or a mesh without tetrahedra; `File` where the file
/// system refuses.
pub fn write_mesh(path: &Path, mesh: &Mesh, metres_per_unit: f64, encoding: MshEncoding) -> Result<()> {
    let prepared = prepare(mesh, metres_per_unit).map_err(|e| e.within(path.display()))?;
    let mut bytes = Vec::new();
    emit(&mut Out { bytes: &mut bytes, encoding }, &prepared);
    Ok(file::write_bytes(path, &bytes)?)
}

/// Elements of one kind on one entity.
struct WrittenBlock {
    dimension: i32,
    entity: i32,
    kind: i64,
    n_nodes: usize,
    /// Node positions in Gmsh's order, `n_nodes` per element.
    nodes: Vec<u32>,
}

/// The contents of the file.
struct MshContent {
    /// Dimension, tag, name.
    names: Vec<(i32, i32, String)>,
    /// Physical tags of every entity, per dimension in the order of the entity tags 1, 2, …
    entities: [Vec<Vec<i32>>; 4],
    nodes: Vec<[f64; 3]>,
    blocks: Vec<WrittenBlock>,
}

fn prepare(mesh: &Mesh, metres_per_unit: f64) -> std::result::Result<MshContent, BadInput> {
    check(mesh, metres_per_unit)?;
    let faces = boundary_nodes(&mesh.cells);
    let all_cells: Vec<&[u32]> = (0..mesh.cells.len()).map(|e| mesh.cells.nodes(e)).collect();
    let all_faces: Vec<&[u32]> = faces.iter().map(Vec::as_slice).collect();

    let mut names = Vec::new();
    // Physical tags of every tetrahedron, boundary face, and the groups left to points.
    let mut on_cells = vec![Vec::new(); all_cells.len()];
    let mut on_faces = vec![Vec::new(); all_faces.len()];
    let mut points = Vec::new();
    for (tag, (name, set)) in (1..).zip(&mesh.groups) {
        let (dimension, tagged) = if let Some(cells) = elements_of(&all_cells, set, mesh.nodes.len()) {
            (3, Some((&mut on_cells, cells)))
        } else if let Some(faces) = elements_of(&all_faces, set, mesh.nodes.len()) {
            (2, Some((&mut on_faces, faces)))
        } else {
            points.push((tag, set));
            (0, None)
        };
        for (tags, element) in tagged.into_iter().flat_map(|(tags, elements)| {
            let mut inside = vec![false; tags.len()];
            elements.into_iter().for_each(|e| inside[e] = true);
            tags.iter_mut().zip(inside)
        }) {
            if element {
                tags.push(tag);
            }
        }
        names.push((dimension, tag, name.clone()));
    }
    names.sort_by_key(|(dimension, tag, _)| (*dimension, *tag));

    let mut entities: [Vec<Vec<i32>>; 4] = Default::default();
    let mut blocks = Vec::new();
    for (tag, set) in points {
        entities[0].push(vec![tag]);
        let entity = entities[0].len() as i32;
        blocks.push(WrittenBlock { dimension: 0, entity, kind: 15, n_nodes: 1, nodes: set.clone() });
    }
    let (cell_kind, face_kind) = match mesh.cells {
        Cells::Tet4(_) => ((TET4, 4), (2, 3)),
        Cells::Tet10(_) => ((TET10, 10), (9, 6)),
    };
    // Faces of no group are not written; the tetrahedra all are, in their order.
    let tagged = |tags: &Vec<i32>| !tags.is_empty();
    blocks.extend(in_blocks(2, face_kind, &all_faces, &on_faces, tagged, &mut entities[2]));
    blocks.extend(in_blocks(3, cell_kind, &all_cells, &on_cells, |_| true, &mut entities[3]));

    let nodes = mesh.nodes.iter().map(|x| x.map(|v| in_unit(v, metres_per_unit))).collect();
    Ok(MshContent { names, entities, nodes, blocks })
}

fn check(mesh: &Mesh, metres_per_unit: f64) -> std::result::Result<(), BadInput> {
    if !(metres_per_unit.is_finite() && metres_per_unit > 0.0) {
        return Err(bad_unit(metres_per_unit));
    }
    if mesh.cells.is_empty() {
        return Err(BadInput::new("mesh", "tetrahedra", "none"));
    }
    for (node, x) in mesh.nodes.iter().enumerate() {
        if x.iter().any(|v| !(v / metres_per_unit).is_finite()) {
            return Err(BadInput::new(format!("node {node}"), "finite coordinates", format!("{x:?}")));
        }
    }
    let outside = |n: &&u32| **n as usize >= mesh.nodes.len();
    let range = format!("nodes below {}", mesh.nodes.len());
    for e in 0..mesh.cells.len() {
        if let Some(n) = mesh.cells.nodes(e).iter().find(outside) {
            return Err(BadInput::new(format!("tetrahedron {e}"), range, n.to_string()));
        }
    }
    for (name, set) in &mesh.groups {
        if name.is_empty() || name.contains('"') || name.contains(char::is_control) {
            return Err(BadInput::new("group", "a name of one line without quotes", format!("{name:?}")));
        }
        if let Some(n) = set.iter().find(outside) {
            return Err(BadInput::new(format!("group {name}"), range, n.to_string()));
        }
    }
    Ok(())
}

/// Nodes of the boundary faces in Gmsh's order: corners, then the middles of 01, 12, 20.
fn boundary_nodes(cells: &Cells) -> Vec<Vec<u32>> {
    let with_middles = |face: &crate::mesh::faces::Face| {
        let [a, b, c] = face.corners;
        let mut nodes = vec![a, b, c];
        if let Cells::Tet10(cells) = cells {
            let n = &cells[face.cell as usize];
            nodes.extend([(a, b), (b, c), (c, a)].iter().filter_map(|&(i, j)| middle_of(n, i, j)));
        }
        nodes
    };
    boundary_faces(cells).iter().map(with_middles).collect()
}

/// The elements whose nodes all belong to the set, if together they hold the whole set.
fn elements_of(elements: &[&[u32]], set: &[u32], n_nodes: usize) -> Option<Vec<usize>> {
    let mut in_set = vec![false; n_nodes];
    set.iter().for_each(|&n| in_set[n as usize] = true);
    let inside: Vec<usize> =
        (0..elements.len()).filter(|&e| elements[e].iter().all(|&n| in_set[n as usize])).collect();
    for &e in &inside {
        elements[e].iter().for_each(|&n| in_set[n as usize] = false);
    }
    (!set.is_empty() && !in_set.contains(&true)).then_some(inside)
}

/// One entity per combination of physical tags, and one block per run of elements on the same entity.
fn in_blocks(
    dimension: i32,
    (kind, n_nodes): (i64, usize),
    elements: &[&[u32]],
    tags: &[Vec<i32>],
    selects: impl Fn(&Vec<i32>) -> bool,
    entities: &mut Vec<Vec<i32>>,
) -> Vec<WrittenBlock> {
    let mut entity_of: BTreeMap<&[i32], i32> = BTreeMap::new();
    let mut blocks: Vec<WrittenBlock> = Vec::new();
    for (element, tags) in elements.iter().zip(tags) {
        if !selects(tags) {
            continue;
        }
        let entity = *entity_of.entry(tags).or_insert_with(|| {
            entities.push(tags.clone());
            entities.len() as i32
        });
        let mut nodes = element.to_vec();
        if let Ok(ten) = <[u32; 10]>::try_from(*element) {
            nodes = swap_last_two(ten).to_vec();
        }
        match blocks.last_mut() {
            Some(last) if last.entity == entity => last.nodes.extend(nodes),
            _ => blocks.push(WrittenBlock { dimension, entity, kind, n_nodes, nodes }),
        }
    }
    blocks
}

/// The number with the fewest of 15 to 17 digits that reads back as exactly `metres`.
fn in_unit(metres: f64, metres_per_unit: f64) -> f64 {
    let plain = metres / metres_per_unit;
    (14..17)
        .filter_map(|digits| format!("{plain:.digits$e}").parse::<f64>().ok())
        .find(|value| value * metres_per_unit == metres)
        .unwrap_or(plain)
}

/// Numbers of one line (text) or record (binary).
struct Out<'a> {
    bytes: &'a mut Vec<u8>,
    encoding: MshEncoding,
}

impl Out<'_> {
    fn text(&mut self, text: &str) {
        self.bytes.extend_from_slice(text.as_bytes());
    }

    fn word(&mut self, value: impl std::fmt::Display) {
        if self.bytes.last().is_some_and(|&b| b != b'\n') {
            self.bytes.push(b' ');
        }
        self.text(&value.to_string());
    }

    fn int(&mut self, value: i32) {
        match self.encoding {
            MshEncoding::Ascii => self.word(value),
            MshEncoding::Binary => self.bytes.extend_from_slice(&value.to_le_bytes()),
        }
    }

    fn size(&mut self, value: usize) {
        match self.encoding {
            MshEncoding::Ascii => self.word(value),
            MshEncoding::Binary => self.bytes.extend_from_slice(&(value as u64).to_le_bytes()),
        }
    }

    fn float(&mut self, value: f64) {
        match self.encoding {
            MshEncoding::Ascii => self.word(value),
            MshEncoding::Binary => self.bytes.extend_from_slice(&value.to_le_bytes()),
        }
    }

    /// Ends a line of text.
    fn end(&mut self) {
        if self.encoding == MshEncoding::Ascii {
            self.bytes.push(b'\n');
        }
    }
}

fn emit(out: &mut Out<'_>, file: &MshContent) {
    match out.encoding {
        MshEncoding::Ascii => out.text("$MeshFormat\n4.1 0 8\n$EndMeshFormat\n"),
        MshEncoding::Binary => {
            out.text("$MeshFormat\n4.1 1 8\n");
            out.int(1);
            out.text("\n$EndMeshFormat\n");
        }
    }
    if !file.names.is_empty() {
        out.text(&format!("$PhysicalNames\n{}\n", file.names.len()));
        for (dimension, tag, name) in &file.names {
            out.text(&format!("{dimension} {tag} \"{name}\"\n"));
        }
        out.text("$EndPhysicalNames\n");
    }
    emit_entities(out, file);
    emit_nodes(out, file);
    emit_elements(out, file);
}

fn close(out: &mut Out<'_>, section: &str) {
    if out.encoding == MshEncoding::Binary {
        out.text("\n");
    }
    out.text(&format!("$End{section}\n"));
}

fn emit_entities(out: &mut Out<'_>, file: &MshContent) {
    let mut low = [f64::INFINITY; 3];
    let mut high = [f64::NEG_INFINITY; 3];
    for x in &file.nodes {
        for d in 0..3 {
            low[d] = low[d].min(x[d]);
            high[d] = high[d].max(x[d]);
        }
    }
    out.text("$Entities\n");
    file.entities.iter().for_each(|e| out.size(e.len()));
    out.end();
    for (dimension, entities) in file.entities.iter().enumerate() {
        for (tag, physicals) in (1..).zip(entities) {
            out.int(tag);
            low.iter().for_each(|&v| out.float(v));
            if dimension > 0 {
                high.iter().for_each(|&v| out.float(v));
            }
            out.size(physicals.len());
            physicals.iter().for_each(|&p| out.int(p));
            if dimension > 0 {
                out.size(0);
            }
            out.end();
        }
    }
    close(out, "Entities");
}

fn emit_nodes(out: &mut Out<'_>, file: &MshContent) {
    let n = file.nodes.len();
    out.text("$Nodes\n");
    [1, n, 1, n].into_iter().for_each(|v| out.size(v));
    out.end();
    // All nodes belong to the first volume: that keeps their order.
    [3, 1, 0].into_iter().for_each(|v| out.int(v));
    out.size(n);
    out.end();
    for tag in 1..=n {
        out.size(tag);
        out.end();
    }
    for x in &file.nodes {
        x.iter().for_each(|&v| out.float(v));
        out.end();
    }
    close(out, "Nodes");
}

fn emit_elements(out: &mut Out<'_>, file: &MshContent) {
    let n: usize = file.blocks.iter().map(|b| b.nodes.len() / b.n_nodes).sum();
    out.text("$Elements\n");
    [file.blocks.len(), n, 1, n].into_iter().for_each(|v| out.size(v));
    out.end();
    let mut tag = 0;
    for block in &file.blocks {
        [block.dimension, block.entity, block.kind as i32].into_iter().for_each(|v| out.int(v));
        out.size(block.nodes.len() / block.n_nodes);
        out.end();
        for element in block.nodes.chunks(block.n_nodes) {
            tag += 1;
            out.size(tag);
            element.iter().for_each(|&node| out.size(node as usize + 1));
            out.end();
        }
    }
    close(out, "Elements");
}
