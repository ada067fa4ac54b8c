//! Sections of an MSH file of any version, as plain lists, before they become a mesh.

use std::collections::{BTreeMap, HashMap};

use hysteron_base::BadInput;

use super::elements::{self, GmshType};
use super::scan::Scan;

/// Content of the file, in its own numbering and unit.
#[derive(Debug, Default)]
pub(super) struct Sections {
    /// Name of a physical group by dimension and tag.
    pub(super) names: BTreeMap<(i64, i64), String>,
    /// Physical tags of a geometric entity by dimension and tag.
    pub(super) physicals: BTreeMap<(i64, i64), Vec<i64>>,
    /// Coordinates in file order, in the unit of the file.
    pub(super) nodes: Vec<[f64; 3]>,
    /// Position in `nodes` by node tag.
    pub(super) index_of: HashMap<u64, u32>,
    /// Elements in file order.
    pub(super) blocks: Vec<ElementBlock>,
    /// Whether an element may be in the file more than once: for each of its groups (MSH 1 and 2), or for each
    /// partition that sees it.
    pub(super) is_partitioned: bool,
}

/// Elements of one kind on one entity.
#[derive(Debug)]
pub(super) struct ElementBlock {
    /// Dimension and tag of the entity.
    pub(super) entity: (i64, i64),
    /// Element type.
    pub(super) kind: GmshType,
    /// Tag of each element.
    pub(super) tags: Vec<u64>,
    /// Nodes as positions in `Sections::nodes`, `kind.n_nodes` per element, in Gmsh's order.
    pub(super) nodes: Vec<u32>,
}

impl ElementBlock {
    pub(super) fn new(entity: (i64, i64), kind: GmshType) -> Self {
        Self { entity, kind, tags: Vec::new(), nodes: Vec::new() }
    }
}

impl Sections {
    /// Adds a node. One that is in the file twice, as parts of a partitioned mesh may repeat it, must be in the
    /// same place.
    pub(super) fn add_node(&mut self, scan: &Scan<'_>, tag: u64, x: [f64; 3]) -> Result<(), BadInput> {
        let index =
            u32::try_from(self.nodes.len()).map_err(|_| scan.bad("at most 4 294 967 295 nodes", "more"))?;
        match self.index_of.entry(tag) {
            std::collections::hash_map::Entry::Vacant(entry) => {
                entry.insert(index);
                self.nodes.push(x);
            }
            std::collections::hash_map::Entry::Occupied(entry) => {
                if self.nodes[*entry.get() as usize] != x {
                    return Err(scan
                        .bad("every node in one place", format!("node {tag} twice"))
                        .hint("renumber it: `gmsh old.msh -save -format msh41 -o new.msh`"));
                }
            }
        }
        Ok(())
    }

    /// Position in `nodes` of a node of element `element`.
    pub(super) fn index(&self, scan: &Scan<'_>, element: u64, node: u64) -> Result<u32, BadInput> {
        self.index_of.get(&node).copied().ok_or_else(|| {
            scan.bad(format!("nodes of element {element} that `$Nodes` lists"), format!("node {node}"))
                .hint("the file is damaged: write it again")
        })
    }
}

/// The element type of a number in the file.
pub(super) fn kind_of(scan: &Scan<'_>, number: i64) -> Result<GmshType, BadInput> {
    elements::find(number).ok_or_else(|| {
        scan.bad("an element type of Gmsh with a fixed number of nodes", elements::describe(number))
            .hint("mesh the part with four- or ten-node tetrahedra")
    })
}
