//! Node sets from the physical groups of a file.

use std::collections::{BTreeMap, BTreeSet};

use super::sections::Sections;

const DIMENSIONS: [&str; 4] = ["point", "curve", "surface", "volume"];

/// The nodes of every physical group, as positions in `Sections::nodes`, not sorted, with repeats.
///
/// A group's nodes are those of the elements on its entities. Groups of one name join, for any
/// dimensions. A group without a name is called by its tag, `"1"`; where groups of two dimensions share an
/// unnamed tag they are called `"surface 1"`, `"volume 1"`, so that none swallows the other.
pub(super) fn node_sets(sections: &Sections) -> BTreeMap<String, Vec<u32>> {
    let mut dimensions_of: BTreeMap<i64, BTreeSet<i64>> = BTreeMap::new();
    for (&(dimension, _), tags) in &sections.physicals {
        for &tag in tags {
            if !sections.names.contains_key(&(dimension, tag)) {
                dimensions_of.entry(tag).or_default().insert(dimension);
            }
        }
    }
    let name_of = |dimension: i64, tag: i64| {
        if let Some(name) = sections.names.get(&(dimension, tag)) {
            return name.clone();
        }
        let shared = dimensions_of.get(&tag).is_some_and(|d| d.len() > 1);
        match usize::try_from(dimension).ok().and_then(|d| DIMENSIONS.get(d)) {
            Some(word) if shared => format!("{word} {tag}"),
            _ => tag.to_string(),
        }
    };
    let mut sets: BTreeMap<String, Vec<u32>> = BTreeMap::new();
    for block in &sections.blocks {
        let Some(tags) = sections.physicals.get(&block.entity).filter(|tags| !tags.is_empty()) else {
            continue;
        };
        // Once each, before many groups take them.
        let mut nodes = block.nodes.clone();
        nodes.sort_unstable();
        nodes.dedup();
        for &tag in tags {
            sets.entry(name_of(block.entity.0, tag)).or_default().extend(&nodes);
        }
    }
    sets
}
