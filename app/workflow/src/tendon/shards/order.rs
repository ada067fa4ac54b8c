//! The order in which a worker takes the shards.

use hysteron_base::rng;
use rand::RngExt;

use super::shard_set::ShardSet;
use crate::tendon::generate::Shard;

/// The shards of a worker, one after the other.
///
/// A worker of a part takes those of the part in their order. A free worker begins at a random missing shard and goes on with the
/// ones behind it; where it meets what another worker has made, or has made the same as one, it begins again at a random missing one. So workers that know nothing of each other work in
/// different stretches, and rarely make the same shard.
#[derive(Debug)]
pub(super) struct WorkOrder {
    n: usize,
    part: Option<Shard>,
    /// The shard that is next, if it is missing.
    next: usize,
    /// The worker's own number, and how often it has begun again.
    number: u64,
    jumps: u64,
}

impl WorkOrder {
    /// Of a part of `n` shards.
    pub fn of_part(part: Shard, n: usize) -> Self {
        Self { n, part: Some(part), next: 0, number: 0, jumps: 0 }
    }

    /// Of a free worker; workers of different numbers differ in their orders.
    pub fn of_worker(number: u64, n: usize) -> Self {
        Self { n, part: None, next: n, number, jumps: 0 }
    }

    /// Shards that are in it.
    pub fn n_shards(&self) -> usize {
        self.part.map_or(self.n, |part| (0..self.n).filter(|shard| part.has(*shard)).count())
    }

    /// Leaves the stretch of a free worker, in which another one is ahead.
    pub fn leave_stretch(&mut self) {
        if self.part.is_none() {
            self.next = self.n;
        }
    }

    /// The next shard that is not in `there`; `None` where none is missing.
    pub fn next(&mut self, there: &ShardSet) -> Option<usize> {
        let is_missing = |shard: usize| !there.has(shard);
        let found = match self.part {
            Some(part) => (self.next..self.n).find(|shard| part.has(*shard) && is_missing(*shard)),
            None if self.next < self.n && is_missing(self.next) => Some(self.next),
            None => match self.n - there.len() {
                0 => None,
                missing => {
                    self.jumps += 1;
                    let mut stream = rng(self.number, &format!("shards/order/{}", self.jumps));
                    there.missing().nth(stream.random_range(0..missing))
                }
            },
        };
        self.next = found.map_or(self.n, |shard| shard + 1);
        found
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)] // a test may stop where it stands
    use super::*;

    fn all(mut order: WorkOrder) -> Vec<usize> {
        let mut there = ShardSet::empty(order.n);
        let mut shards = Vec::new();
        while let Some(shard) = order.next(&there) {
            there.insert(shard);
            shards.push(shard);
        }
        assert_eq!(shards.len(), order.n_shards());
        shards
    }

    #[test]
    fn every_shard_is_taken_once() {
        for n in [1, 2, 3, 12, 97, 1000] {
            let parts = ["1/3", "2/3", "3/3"].map(|text| WorkOrder::of_part(text.parse().unwrap(), n));
            let of_parts = parts.into_iter().flat_map(all).collect();
            for mut shards in [all(WorkOrder::of_worker(7, n)), of_parts] {
                shards.sort_unstable();
                assert!(shards.into_iter().eq(0..n), "{n}");
            }
        }
    }

    #[test]
    fn a_hundred_free_workers_rarely_make_the_same_shard() {
        let n = 10_000;
        let mut stream = rng(1, "times");
        let mut done = ShardSet::empty(n);
        // Of each worker: its order, what it knows, the shard that it is at, and when it will have made it.
        let mut workers: Vec<(WorkOrder, ShardSet, Option<usize>, f64)> =
            (0..100).map(|k| (WorkOrder::of_worker(k, n), done.clone(), None, 0.0)).collect();
        let mut n_made = 0;
        loop {
            let first = workers.iter_mut().filter(|worker| worker.3.is_finite());
            let Some((order, known, at, time)) = first.min_by(|a, b| a.3.total_cmp(&b.3)) else { break };
            if let Some(shard) = at.take() {
                if done.has(shard) {
                    known.clone_from(&done);
                    order.leave_stretch();
                }
                done.insert(shard);
                known.insert(shard);
                n_made += 1;
            }
            *at = order.next(known);
            if at.is_some_and(|shard| done.has(shard)) {
                known.clone_from(&done);
                *at = order.next(known);
            }
            *time = at.map_or(f64::INFINITY, |_| *time + stream.random_range(0.7..1.3));
        }
        assert_eq!(done.len(), n);
        assert!(n_made < n + n / 20, "{n_made} shards made for {n}");
    }
}
