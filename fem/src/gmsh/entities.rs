//! Names of groups, and the entities of MSH 4 that carry them, partitioned ones included.

use hysteron_base::BadInput;

use super::header::Version;
use super::scan::{Scan, printable};
use super::sections::Sections;

/// Physical groups that one entity may belong to; bounds the memory and time of [`groups`](super::groups).
const MAX_GROUPS_OF_ENTITY: u64 = 100;

/// `$PhysicalNames`, text in both kinds of file. Version 2.0 gives no dimension: such a name counts for all.
pub(super) fn parse_names(scan: &mut Scan<'_>, out: &mut Sections) -> Result<(), BadInput> {
    let binary = scan.binary.take();
    let count = scan.size("the number of physical names")?;
    scan.line();
    for _ in 0..count {
        if scan.at_end() {
            return Err(scan.ends("the name of a physical group"));
        }
        let place = scan.place();
        let line = String::from_utf8_lossy(scan.line()).into_owned();
        let Some((dimension, tag, name)) = split_name(&line) else {
            let expected = "dimension, tag and quoted name of a physical group";
            return Err(BadInput::new(place, expected, format!("`{}`", printable(line.as_bytes()))));
        };
        if name.is_empty() {
            continue;
        }
        let dimensions = dimension.map_or(0..=3, |d| d..=d);
        for dimension in dimensions {
            out.names.insert((dimension, tag.saturating_abs()), name.to_owned());
        }
    }
    scan.binary = binary;
    Ok(())
}

/// Dimension, tag and name of a line `2 1 "base"`.
fn split_name(line: &str) -> Option<(Option<i64>, i64, &str)> {
    let (numbers, rest) = line.trim().split_once('"')?;
    let name = rest.strip_suffix('"')?;
    let mut numbers = numbers.split_whitespace().map(str::parse::<i64>);
    let first = numbers.next()?.ok()?;
    match (numbers.next(), numbers.next()) {
        (Some(tag), None) => Some((Some(first), tag.ok()?, name)),
        (None, _) => Some((None, first, name)),
        _ => None,
    }
}

/// `$Entities`: the physical tags of every point, curve, surface and volume.
pub(super) fn parse_entities(
    scan: &mut Scan<'_>,
    version: Version,
    out: &mut Sections,
) -> Result<(), BadInput> {
    let counts = entity_counts(scan)?;
    for (dimension, &count) in (0..).zip(&counts) {
        for _ in 0..count {
            let tag = scan.int("the tag of an entity")?;
            parse_entity(scan, version, (dimension, tag), out)?;
        }
    }
    Ok(())
}

/// `$PartitionedEntities`: parts of entities, with tags of their own and the groups of the whole.
pub(super) fn parse_partitioned(
    scan: &mut Scan<'_>,
    version: Version,
    out: &mut Sections,
) -> Result<(), BadInput> {
    scan.size("the number of partitions")?;
    for _ in 0..scan.size("the number of ghost entities")? {
        scan.int("the tag of a ghost entity")?;
        scan.int("the partition of a ghost entity")?;
    }
    // The tags of the parts replace those of the wholes, whose elements are all in parts.
    out.physicals.clear();
    out.is_partitioned = true;
    let counts = entity_counts(scan)?;
    for (dimension, &count) in (0..).zip(&counts) {
        for _ in 0..count {
            let tag = scan.int("the tag of an entity")?;
            scan.int("the dimension of a whole entity")?;
            scan.int("the tag of a whole entity")?;
            for _ in 0..scan.size("the number of partitions of an entity")? {
                scan.int("a partition")?;
            }
            parse_entity(scan, version, (dimension, tag), out)?;
        }
    }
    Ok(())
}

fn entity_counts(scan: &mut Scan<'_>) -> Result<[u64; 4], BadInput> {
    let mut counts = [0; 4];
    for count in &mut counts {
        *count = scan.size("the number of entities")?;
    }
    Ok(counts)
}

/// Bounds, physical tags and boundary of one entity.
fn parse_entity(
    scan: &mut Scan<'_>,
    version: Version,
    entity: (i64, i64),
    out: &mut Sections,
) -> Result<(), BadInput> {
    let is_point = entity.0 == 0;
    for _ in 0..if is_point && version == Version::V41 { 3 } else { 6 } {
        scan.float("the bounds of an entity")?;
    }
    let n_physicals = scan.size("the number of physical tags")?;
    if n_physicals > MAX_GROUPS_OF_ENTITY {
        let expected = format!("at most {MAX_GROUPS_OF_ENTITY} physical groups of one entity");
        return Err(scan.bad(expected, n_physicals.to_string()));
    }
    let physicals = out.physicals.entry(entity).or_default();
    for _ in 0..n_physicals {
        let tag = scan.int("a physical tag")?.saturating_abs();
        if !physicals.contains(&tag) {
            physicals.push(tag);
        }
    }
    if physicals.len() as u64 > MAX_GROUPS_OF_ENTITY {
        return Err(scan.bad("every entity once", format!("entity {} many times", entity.1)));
    }
    if !is_point {
        for _ in 0..scan.size("the number of bounding entities")? {
            scan.int("the tag of a bounding entity")?;
        }
    }
    Ok(())
}
