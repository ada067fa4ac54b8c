//! Nodes and elements of MSH 4.0 and 4.1, which are in blocks, one for each entity.

use hysteron_base::BadInput;

use super::elements::GmshType;
use super::header::Version;
use super::scan::Scan;
use super::sections::{ElementBlock, Sections, kind_of};

/// A node or element tag: four bytes in 4.0, the size of the header in 4.1.
fn tag(scan: &mut Scan<'_>, version: Version, what: &str) -> Result<u64, BadInput> {
    if version == Version::V41 { scan.size(what) } else { scan.positive(what) }
}

/// Dimension and tag of the entity of a block; 4.0 has them the other way round.
fn entity(scan: &mut Scan<'_>, version: Version) -> Result<(i64, i64), BadInput> {
    let first = scan.int("the dimension or tag of an entity")?;
    let second = scan.int("the tag or dimension of an entity")?;
    let (dimension, tag) = if version == Version::V41 { (first, second) } else { (second, first) };
    if !(0..=3).contains(&dimension) {
        return Err(scan.bad("a dimension from 0 to 3", dimension.to_string()));
    }
    Ok((dimension, tag))
}

/// Numbers of blocks and items at the head of a section.
fn head(scan: &mut Scan<'_>, version: Version) -> Result<[u64; 2], BadInput> {
    let counts = [scan.size("the number of blocks")?, scan.size("the number of nodes or elements")?];
    if version == Version::V41 {
        scan.size("the smallest tag")?;
        scan.size("the largest tag")?;
    }
    Ok(counts)
}

pub(super) fn parse_nodes(scan: &mut Scan<'_>, version: Version, out: &mut Sections) -> Result<(), BadInput> {
    let [n_blocks, n_nodes] = head(scan, version)?;
    let mut n_read = 0_u64;
    for _ in 0..n_blocks {
        let (dimension, _) = entity(scan, version)?;
        let n_parameters = match scan.int("0, or 1 for nodes with parameters")? {
            0 => 0,
            1 => dimension,
            other => return Err(scan.bad("0, or 1 for nodes with parameters", other.to_string())),
        };
        let count = scan.size("the number of nodes of a block")?;
        n_read = n_read.saturating_add(count);
        if version == Version::V41 {
            let mut tags = Vec::with_capacity(scan.capacity(count));
            for _ in 0..count {
                tags.push(scan.size("a node tag")?);
            }
            for tag in tags {
                parse_node(scan, tag, n_parameters, out)?;
            }
        } else {
            for _ in 0..count {
                let tag = tag(scan, version, "a node tag")?;
                parse_node(scan, tag, n_parameters, out)?;
            }
        }
    }
    if n_read != n_nodes {
        return Err(scan.bad(format!("{n_nodes} nodes"), n_read.to_string()));
    }
    Ok(())
}

fn parse_node(scan: &mut Scan<'_>, tag: u64, n_parameters: i64, out: &mut Sections) -> Result<(), BadInput> {
    let x = scan.coordinates(tag)?;
    for _ in 0..n_parameters {
        scan.float("a parameter of a node")?;
    }
    out.add_node(scan, tag, x)
}

pub(super) fn parse_elements(
    scan: &mut Scan<'_>,
    version: Version,
    out: &mut Sections,
) -> Result<(), BadInput> {
    let [n_blocks, n_elements] = head(scan, version)?;
    let mut n_read = 0_u64;
    for _ in 0..n_blocks {
        let entity = entity(scan, version)?;
        let number = scan.int("an element type")?;
        let kind = kind_of(scan, number)?;
        let count = scan.size("the number of elements of a block")?;
        let block = parse_block(scan, version, (entity, kind, count), out)?;
        n_read += block.tags.len() as u64;
        out.blocks.push(block);
    }
    if n_read != n_elements {
        return Err(scan.bad(format!("{n_elements} elements"), n_read.to_string()));
    }
    Ok(())
}

fn parse_block(
    scan: &mut Scan<'_>,
    version: Version,
    (entity, kind, count): ((i64, i64), GmshType, u64),
    out: &Sections,
) -> Result<ElementBlock, BadInput> {
    let mut block = ElementBlock::new(entity, kind);
    for _ in 0..count {
        let number = tag(scan, version, "an element tag")?;
        for _ in 0..kind.n_nodes {
            let node = tag(scan, version, "the node of an element")?;
            block.nodes.push(out.index(scan, number, node)?);
        }
        block.tags.push(number);
    }
    Ok(block)
}
