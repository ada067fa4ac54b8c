//! A set of shards, a bit each: which ones are there.

use super::rule::{ROWS, SKETCHES, shard_of};
use crate::shared::object_store::Store;

/// Shards 0 to n − 1, each in it or not.
#[derive(Debug, Clone)]
pub(super) struct ShardSet {
    bits: Vec<u64>,
    n: usize,
}

/// The state of a set by a listing of its objects.
#[derive(Debug, Clone)]
pub(super) struct Listing {
    /// Shards with rows and sketch.
    pub done: ShardSet,
    /// Shards whose rows are there and whose sketch is not.
    pub unfinished: usize,
    /// Size of all rows [byte].
    pub bytes: u64,
    /// When the first and the last sketch were written, by the clock of the store [s since 1970].
    pub written_s: Option<[f64; 2]>,
}

impl ShardSet {
    /// None of `n` shards.
    pub fn empty(n: usize) -> Self {
        Self { bits: vec![0; n.div_ceil(64)], n }
    }

    /// Adds a shard; one that cannot be is ignored.
    pub fn insert(&mut self, shard: usize) {
        if shard < self.n {
            self.bits[shard / 64] |= 1 << (shard % 64);
        }
    }

    /// Whether a shard is in it.
    pub fn has(&self, shard: usize) -> bool {
        shard < self.n && self.bits[shard / 64] >> (shard % 64) & 1 == 1
    }

    /// Number of shards in it.
    pub fn len(&self) -> usize {
        self.bits.iter().map(|word| word.count_ones() as usize).sum()
    }

    /// Shards that are not in it, in their order.
    pub fn missing(&self) -> impl Iterator<Item = usize> {
        (0..self.n).filter(|shard| !self.has(*shard))
    }

    /// The missing shards in words: the first few runs of them.
    pub fn describe_missing(&self) -> String {
        const MAX_RUNS: usize = 8;
        let mut runs: Vec<[usize; 2]> = Vec::new();
        let mut is_more = false;
        for shard in self.missing() {
            let is_full = runs.len() == MAX_RUNS;
            match runs.last_mut() {
                Some([_, last]) if *last + 1 == shard => *last = shard,
                _ if is_full => {
                    is_more = true;
                    break;
                }
                _ => runs.push([shard, shard]),
            }
        }
        let run = |[first, last]: &[usize; 2]| match first == last {
            true => first.to_string(),
            false => format!("{first} to {last}"),
        };
        let runs: Vec<String> = runs.iter().map(run).collect();
        runs.join(", ") + if is_more { ", …" } else { "" }
    }
}

impl Listing {
    /// Of a set of `n` shards; memory follows the number of shards, a quarter of a byte for each.
    pub fn of(store: &Store, n: usize) -> anyhow::Result<Self> {
        let (mut rows, mut sketches) = (ShardSet::empty(n), ShardSet::empty(n));
        let (mut bytes, mut written_s) = (0, None);
        store.list(ROWS, |entry| {
            if let Some(shard) = shard_of(entry.name).filter(|shard| *shard < n) {
                rows.insert(shard);
                bytes += entry.bytes;
            }
        })?;
        store.list(SKETCHES, |entry| {
            if let Some(shard) = shard_of(entry.name).filter(|shard| *shard < n) {
                sketches.insert(shard);
                let [first, last] = written_s.unwrap_or([entry.written_s; 2]);
                written_s = Some([first.min(entry.written_s), last.max(entry.written_s)]);
            }
        })?;
        let both = rows.bits.iter().zip(&sketches.bits).map(|(rows, sketches)| rows & sketches);
        let done = ShardSet { bits: both.collect(), n };
        Ok(Self { unfinished: rows.len() - done.len(), done, bytes, written_s })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn missing_shards_are_named_in_runs() {
        let mut set = ShardSet::empty(130);
        (0..130).filter(|shard| ![3, 64, 65, 66, 129].contains(shard)).for_each(|shard| set.insert(shard));
        set.insert(5000);
        assert_eq!(set.len(), 125);
        assert_eq!(set.describe_missing(), "3, 64 to 66, 129");
        let mut even = ShardSet::empty(40);
        (0..20).for_each(|k| even.insert(2 * k));
        assert_eq!(even.describe_missing(), "1, 3, 5, 7, 9, 11, 13, 15, …");
    }
}
