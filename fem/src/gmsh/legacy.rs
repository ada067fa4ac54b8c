//! Nodes and elements of MSH 1 and 2, where every element carries its groups and partitions as tags.

use hysteron_base::BadInput;

use super::elements::GmshType;
use super::header::Version;
use super::scan::Scan;
use super::sections::{ElementBlock, Sections, kind_of};

/// Reads the count of a section, which is text in binary files too.
fn count(scan: &mut Scan<'_>, what: &str) -> Result<u64, BadInput> {
    let binary = scan.binary.take();
    let count = scan.size(what)?;
    if binary.is_some() {
        scan.line();
    }
    scan.binary = binary;
    Ok(count)
}

/// `$Nodes`.
pub(super) fn parse_nodes(scan: &mut Scan<'_>, out: &mut Sections) -> Result<(), BadInput> {
    for _ in 0..count(scan, "the number of nodes")? {
        let tag = scan.positive("a node number")?;
        let x = scan.coordinates(tag)?;
        out.add_node(scan, tag, x)?;
    }
    Ok(())
}

/// `$NOD` of MSH 1, which is always text: a node a line, with or without its entity and parameters.
pub(super) fn parse_nodes_1(scan: &mut Scan<'_>, out: &mut Sections) -> Result<(), BadInput> {
    for _ in 0..count(scan, "the number of nodes")? {
        let tag = scan.positive("a node number")?;
        let x = scan.coordinates(tag)?;
        if !scan.is_line_read() {
            skip_parameters(scan)?;
            if !scan.is_line_read() {
                return Err(scan.bad(format!("the end of the line of node {tag}"), "more numbers"));
            }
        }
        out.add_node(scan, tag, x)?;
    }
    Ok(())
}

/// `$ParametricNodes`: nodes with their entity, and their parameters on it.
pub(super) fn parse_parametric_nodes(scan: &mut Scan<'_>, out: &mut Sections) -> Result<(), BadInput> {
    for _ in 0..count(scan, "the number of nodes")? {
        let tag = scan.positive("a node number")?;
        let x = scan.coordinates(tag)?;
        skip_parameters(scan)?;
        out.add_node(scan, tag, x)?;
    }
    Ok(())
}

/// The entity of a node, and as many parameters as a curve or surface has.
fn skip_parameters(scan: &mut Scan<'_>) -> Result<(), BadInput> {
    let dimension = scan.int("the dimension of an entity")?;
    scan.int("the tag of an entity")?;
    for _ in 0..if (1..=2).contains(&dimension) { dimension } else { 0 } {
        scan.float("a parameter of a node")?;
    }
    Ok(())
}

/// `$ELM`, `$Elements`.
pub(super) fn parse_elements(
    scan: &mut Scan<'_>,
    version: Version,
    out: &mut Sections,
) -> Result<(), BadInput> {
    let n_elements = count(scan, "the number of elements")?;
    let mut n_read = 0;
    while n_read < n_elements {
        n_read += match (version, scan.binary.is_some()) {
            (Version::V1, _) => parse_element_1(scan, out)?,
            (_, false) => parse_element_2(scan, out)?,
            (_, true) => parse_block_2(scan, out)?,
        };
    }
    if n_read != n_elements {
        return Err(scan.bad(format!("{n_elements} elements"), n_read.to_string()));
    }
    Ok(())
}

/// `number type physical elementary n nodes…`
fn parse_element_1(scan: &mut Scan<'_>, out: &mut Sections) -> Result<u64, BadInput> {
    let number = scan.positive("an element number")?;
    let kind = scan.int("an element type")?;
    let kind = kind_of(scan, kind)?;
    let physical = scan.int("a physical tag")?;
    scan.int("the tag of an entity")?;
    let n_nodes = scan.size("the number of nodes of an element")?;
    if n_nodes != kind.n_nodes as u64 {
        return Err(scan.bad(format!("{} nodes of a {}", kind.n_nodes, kind.name()), n_nodes.to_string()));
    }
    parse_element(scan, kind, physical, number, out)?;
    Ok(1)
}

/// `number type n tags… nodes…`
fn parse_element_2(scan: &mut Scan<'_>, out: &mut Sections) -> Result<u64, BadInput> {
    let number = scan.positive("an element number")?;
    let kind = scan.int("an element type")?;
    let kind = kind_of(scan, kind)?;
    let n_tags = scan.size("the number of tags")?;
    let physical = parse_tags(scan, n_tags)?;
    parse_element(scan, kind, physical, number, out)?;
    Ok(1)
}

/// Binary: type, number of elements and of tags, then `number tags… nodes…` of each.
fn parse_block_2(scan: &mut Scan<'_>, out: &mut Sections) -> Result<u64, BadInput> {
    let kind = scan.int("an element type")?;
    let kind = kind_of(scan, kind)?;
    let n_follow = scan.positive("the number of elements of a block")?;
    let n_tags = scan.size("the number of tags")?;
    for _ in 0..n_follow {
        let number = scan.positive("an element number")?;
        let physical = parse_tags(scan, n_tags)?;
        parse_element(scan, kind, physical, number, out)?;
    }
    Ok(n_follow)
}

/// The physical tag, the first of all; 0 for none. The others are the entity and the partitions, negative for those
/// in which the element is a ghost.
fn parse_tags(scan: &mut Scan<'_>, n_tags: u64) -> Result<i64, BadInput> {
    let mut physical = 0;
    for k in 0..n_tags {
        let tag = scan.int("a tag of an element")?;
        if k == 0 {
            physical = tag;
        }
    }
    Ok(physical)
}

/// The nodes of one element. A physical group counts as an entity.
fn parse_element(
    scan: &mut Scan<'_>,
    kind: GmshType,
    physical: i64,
    number: u64,
    out: &mut Sections,
) -> Result<(), BadInput> {
    let entity = (i64::from(kind.shape.dimension()), physical.saturating_abs());
    let mut nodes = Vec::with_capacity(kind.n_nodes);
    for _ in 0..kind.n_nodes {
        let node = scan.positive("the node of an element")?;
        nodes.push(out.index(scan, number, node)?);
    }
    if physical != 0 {
        out.physicals.entry(entity).or_insert_with(|| vec![entity.1]);
    }
    match out.blocks.last_mut().filter(|block| block.kind == kind && block.entity == entity) {
        Some(block) => {
            block.tags.push(number);
            block.nodes.append(&mut nodes);
        }
        None => out.blocks.push(ElementBlock { entity, kind, tags: vec![number], nodes }),
    }
    Ok(())
}
