//! Which trajectories each shard has, as a rule: no list grows with their number.

use std::ops::Range;

use serde::{Deserialize, Serialize};

/// Shards of a folder; folders of millions of files are slow.
const PER_FOLDER: usize = 1000;

/// Trajectories of a plan shared out to shards: shard `s` of `N` has those from ⌊s T / N⌋ up to ⌊(s + 1) T / N⌋, exclusive.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ShardRule {
    /// Trajectories of the plan, T.
    pub trajectories: usize,
    /// Shards, N: at least one, at most T.
    pub shards: usize,
}

impl ShardRule {
    /// The trajectories of shard `shard`, at least one.
    pub fn range(self, shard: usize) -> Range<usize> {
        // A product of two counts may be longer than a count.
        let first = |shard: usize| (shard as u128 * self.trajectories as u128 / self.shards as u128) as usize;
        first(shard)..first(shard + 1)
    }
}

/// The object with the rows of a shard.
pub(super) fn rows_name(shard: usize) -> String {
    format!("{ROWS}/{:06}/{shard:09}.parquet", shard / PER_FOLDER)
}

/// The object with the sketch of a shard.
pub(super) fn sketch_name(shard: usize) -> String {
    format!("{SKETCHES}/{:06}/{shard:09}.json", shard / PER_FOLDER)
}

/// Folder of the rows.
pub(super) const ROWS: &str = "shards";
/// Folder of the sketches.
pub(super) const SKETCHES: &str = "sketches";

/// The shard whose object has this name; `None` for any other object.
pub(super) fn shard_of(name: &str) -> Option<usize> {
    let shard = name.rsplit('/').next()?.split('.').next()?.parse().ok()?;
    (name == rows_name(shard) || name == sketch_name(shard)).then_some(shard)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)] // a test may stop where it stands
    use super::*;

    #[test]
    fn every_trajectory_is_in_one_shard() {
        for (trajectories, shards) in [(1, 1), (7, 3), (25, 25), (1000, 7)] {
            let rule = ShardRule { trajectories, shards };
            let all: Vec<usize> = (0..shards).flat_map(|shard| rule.range(shard)).collect();
            assert!(all.into_iter().eq(0..trajectories));
            assert!((0..shards).all(|shard| !rule.range(shard).is_empty()));
        }
        let large = ShardRule { trajectories: usize::MAX, shards: 1_000_000_000_000 };
        assert_eq!(large.range(large.shards - 1).end, usize::MAX);
    }

    #[test]
    fn a_shard_is_known_by_the_name_of_its_objects() {
        for shard in [0, 999, 1000, 123_456_789, 5_000_000_000] {
            assert_eq!(shard_of(&rows_name(shard)).unwrap(), shard);
            assert_eq!(shard_of(&sketch_name(shard)).unwrap(), shard);
        }
        for other in
            ["shards/000000/000000001.parquet#1", "shards/000001/000000001.parquet", "manifest.json", ""]
        {
            assert_eq!(shard_of(other), None, "{other}");
        }
    }
}
