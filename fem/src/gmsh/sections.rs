//! The sections of an MSH 4.1 file as plain lists, before anything is made of them.

use std::collections::{BTreeMap, HashMap};

use hysteron_base::BadInput;

use super::elements::{self, Kind};
use super::scan::{Binary, Scan, printable};

/// What stands in the file, in its own numbering and unit.
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
    pub(super) blocks: Vec<Block>,
}

/// Elements of one kind on one entity.
#[derive(Debug)]
pub(super) struct Block {
    /// Dimension and tag of the entity.
    pub(super) entity: (i64, i64),
    /// Element type.
    pub(super) kind: Kind,
    /// Tag of each element.
    pub(super) tags: Vec<u64>,
    /// Nodes as positions in `Sections::nodes`, `kind.n_nodes` per element, in Gmsh's order.
    pub(super) nodes: Vec<u32>,
}

/// Splits the bytes of a file into its sections.
///
/// # Errors
/// `BadInput` with the line (text) or byte (binary) that is wrong.
pub(super) fn parse(bytes: &[u8]) -> Result<Sections, BadInput> {
    let mut scan = Scan::new(bytes);
    parse_header(&mut scan)?;
    let mut out = Sections::default();
    let mut seen_nodes = false;
    let mut seen_elements = false;
    loop {
        scan.skip_blank();
        if scan.at_end() {
            break;
        }
        let start = scan.bad("a section such as `$Nodes`", "");
        let line = scan.line().trim_ascii_end();
        let name = line.strip_prefix(b"$").and_then(|n| std::str::from_utf8(n).ok());
        let Some(name) = name.filter(|n| !n.is_empty() && n.bytes().all(|b| b.is_ascii_alphanumeric()))
        else {
            return Err(BadInput { found: format!("`{}`", printable(line)), ..start });
        };
        match name {
            "PhysicalNames" => parse_names(&mut scan, &mut out)?,
            "Entities" => parse_entities(&mut scan, &mut out)?,
            "PartitionedEntities" => {
                return Err(BadInput { found: "a partitioned mesh".into(), ..start }.hint(
                    "save it unpartitioned: `gmsh old.msh -unpartition -save -format msh41 -o new.msh`",
                ));
            }
            "Nodes" if seen_nodes => {
                return Err(BadInput { found: "a second `$Nodes`".into(), ..start });
            }
            "Nodes" => {
                seen_nodes = true;
                parse_nodes(&mut scan, &mut out)?;
            }
            "Elements" if seen_elements => {
                return Err(BadInput { found: "a second `$Elements`".into(), ..start });
            }
            "Elements" if !seen_nodes => {
                return Err(BadInput { found: "`$Elements` before `$Nodes`".into(), ..start });
            }
            "Elements" => {
                seen_elements = true;
                parse_elements(&mut scan, &mut out)?;
            }
            other => {
                scan.skip_behind(&format!("$End{other}"))?;
                continue;
            }
        }
        scan.end_of(name)?;
    }
    for (seen, section) in [(seen_nodes, "$Nodes"), (seen_elements, "$Elements")] {
        if !seen {
            return Err(scan
                .bad(format!("a section `{section}`"), "the end of the file")
                .hint("the file is cut short, or was saved before the mesh was made"));
        }
    }
    Ok(out)
}

fn parse_header(scan: &mut Scan<'_>) -> Result<(), BadInput> {
    scan.skip_blank();
    if scan.at_end() {
        return Err(scan.bad("a Gmsh mesh", "an empty file"));
    }
    let first = scan.line().trim_ascii_end();
    if first != b"$MeshFormat" {
        return Err(BadInput::new("line 1", "`$MeshFormat`", format!("`{}`", printable(first)))
            .hint("this is not a Gmsh mesh; export the part as .msh version 4.1"));
    }
    let version = scan.word("a format version")?;
    if version != "4.1" {
        return Err(scan
            .bad("MSH version 4.1", format!("version {}", printable(version.as_bytes())))
            .hint("convert it: `gmsh old.msh -save -format msh41 -o new.msh`"));
    }
    let kind = scan.word("0 (text) or 1 (binary)")?;
    if kind != "0" && kind != "1" {
        return Err(scan.bad("0 (text) or 1 (binary)", format!("`{}`", printable(kind.as_bytes()))));
    }
    let size_bytes = match scan.word("the size of a count, 4 or 8")? {
        "4" => 4,
        "8" => 8,
        other => {
            return Err(scan.bad("the size of a count, 4 or 8", format!("`{}`", printable(other.as_bytes()))));
        }
    };
    if kind == "1" {
        scan.line();
        let big_endian = scan.byte_order()?;
        scan.binary = Some(Binary { big_endian, size_bytes });
    }
    scan.end_of("MeshFormat")
}

/// Names are text in both kinds of file.
fn parse_names(scan: &mut Scan<'_>, out: &mut Sections) -> Result<(), BadInput> {
    let binary = scan.binary.take();
    let count = scan.size("the number of physical names")?;
    for _ in 0..count {
        let dimension = scan.int("the dimension of a physical group")?;
        let tag = scan.int("the tag of a physical group")?;
        let line = String::from_utf8_lossy(scan.line()).into_owned();
        let name = line.trim().strip_prefix('"').and_then(|n| n.strip_suffix('"'));
        let Some(name) = name else {
            return Err(scan
                .bad("the name of a physical group in quotes", format!("`{}`", printable(line.as_bytes()))));
        };
        if !name.is_empty() {
            out.names.insert((dimension, tag.saturating_abs()), name.to_owned());
        }
    }
    scan.binary = binary;
    Ok(())
}

fn parse_entities(scan: &mut Scan<'_>, out: &mut Sections) -> Result<(), BadInput> {
    let mut counts = [0; 4];
    for count in &mut counts {
        *count = scan.size("the number of entities")?;
    }
    for (dimension, &count) in (0..).zip(&counts) {
        for _ in 0..count {
            let tag = scan.int("the tag of an entity")?;
            for _ in 0..if dimension == 0 { 3 } else { 6 } {
                scan.float("the bounds of an entity")?;
            }
            let n_physicals = scan.size("the number of physical tags")?;
            let mut physicals = Vec::new();
            for _ in 0..n_physicals {
                physicals.push(scan.int("a physical tag")?.saturating_abs());
            }
            if dimension > 0 {
                for _ in 0..scan.size("the number of bounding entities")? {
                    scan.int("the tag of a bounding entity")?;
                }
            }
            out.physicals.entry((dimension, tag)).or_default().extend(physicals);
        }
    }
    Ok(())
}

fn parse_nodes(scan: &mut Scan<'_>, out: &mut Sections) -> Result<(), BadInput> {
    let n_blocks = scan.size("the number of node blocks")?;
    let n_nodes = scan.size("the number of nodes")?;
    scan.size("the smallest node tag")?;
    scan.size("the largest node tag")?;
    for _ in 0..n_blocks {
        let dimension = scan.int("the dimension of an entity")?;
        if !(0..=3).contains(&dimension) {
            return Err(scan.bad("a dimension from 0 to 3", dimension.to_string()));
        }
        scan.int("the tag of an entity")?;
        let n_extra = match scan.int("0, or 1 for nodes with parameters")? {
            0 => 0,
            1 => dimension,
            other => return Err(scan.bad("0, or 1 for nodes with parameters", other.to_string())),
        };
        let count = scan.size("the number of nodes of a block")?;
        let mut tags = Vec::with_capacity(scan.capacity(count));
        for _ in 0..count {
            let tag = scan.size("a node tag")?;
            let index = u32::try_from(out.nodes.len() + tags.len())
                .map_err(|_| scan.bad("at most 4 294 967 295 nodes", "more"))?;
            if out.index_of.insert(tag, index).is_some() {
                return Err(scan
                    .bad("every node once", format!("node {tag} twice"))
                    .hint("renumber it: `gmsh old.msh -save -format msh41 -o new.msh`"));
            }
            tags.push(tag);
        }
        for tag in tags {
            let mut x = [0.0; 3];
            for value in &mut x {
                *value = scan.float("a coordinate")?;
                if !value.is_finite() {
                    return Err(scan
                        .bad(format!("finite coordinates of node {tag}"), value.to_string())
                        .hint("mesh the part again"));
                }
            }
            for _ in 0..n_extra {
                scan.float("a parameter of a node")?;
            }
            out.nodes.push(x);
        }
    }
    if out.nodes.len() as u64 != n_nodes {
        return Err(scan.bad(format!("{n_nodes} nodes"), format!("{}", out.nodes.len())));
    }
    Ok(())
}

fn parse_elements(scan: &mut Scan<'_>, out: &mut Sections) -> Result<(), BadInput> {
    let n_blocks = scan.size("the number of element blocks")?;
    let n_elements = scan.size("the number of elements")?;
    scan.size("the smallest element tag")?;
    scan.size("the largest element tag")?;
    let mut n_read = 0_u64;
    for _ in 0..n_blocks {
        let dimension = scan.int("the dimension of an entity")?;
        let entity = scan.int("the tag of an entity")?;
        let number = scan.int("an element type")?;
        let Some(kind) = elements::find(number) else {
            return Err(scan
                .bad("an element type of Gmsh", number.to_string())
                .hint("mesh the part with four- or ten-node tetrahedra"));
        };
        let count = scan.size("the number of elements of a block")?;
        let capacity = scan.capacity(count);
        let mut tags = Vec::with_capacity(capacity);
        let mut nodes = Vec::with_capacity(capacity);
        for _ in 0..count {
            let tag = scan.size("an element tag")?;
            for _ in 0..kind.n_nodes {
                let node = scan.size("the node of an element")?;
                let Some(&index) = out.index_of.get(&node) else {
                    return Err(scan
                        .bad(format!("nodes of element {tag} that `$Nodes` lists"), format!("node {node}"))
                        .hint("the file is damaged: write it again"));
                };
                nodes.push(index);
            }
            tags.push(tag);
        }
        n_read += tags.len() as u64;
        out.blocks.push(Block { entity: (dimension, entity), kind, tags, nodes });
    }
    if n_read != n_elements {
        return Err(scan.bad(format!("{n_elements} elements"), n_read.to_string()));
    }
    Ok(())
}
