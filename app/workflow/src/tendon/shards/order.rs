//! The order in which a worker takes the shards.

use std::ops::Range;

use crate::tendon::generate::Shard;

/// Shards 0 to n − 1, each once: those of a part in their order, or all in an order of the worker's own, so that workers that know
/// nothing of each other rarely take the same one.
#[derive(Debug, Clone)]
pub(super) struct WorkOrder {
    positions: Range<usize>,
    n: usize,
    /// Step from one to the next, without a common factor with n, and the first.
    step: usize,
    first: usize,
    part: Option<Shard>,
}

impl WorkOrder {
    /// The shards of a part.
    pub fn of_part(part: Shard, n: usize) -> Self {
        Self { positions: 0..n, n, step: 1, first: 0, part: Some(part) }
    }

    /// All shards, in an order that follows from a number of the worker's own.
    pub fn of_worker(number: u64, n: usize) -> Self {
        let n_wide = n.max(1) as u64;
        let first = (number % n_wide) as usize;
        let start = (number.rotate_left(32) % n_wide) as usize;
        let step = (start..).find(|step| common_factor(*step, n) == 1).unwrap_or(1);
        Self { positions: 0..n, n, step, first, part: None }
    }
}

impl Iterator for WorkOrder {
    type Item = usize;

    fn next(&mut self) -> Option<usize> {
        let at =
            |position: usize| (position as u128 * self.step as u128 + self.first as u128) % self.n as u128;
        let mut shards = self.positions.by_ref().map(|position| at(position) as usize);
        shards.find(|shard| self.part.is_none_or(|part| part.has(*shard)))
    }
}

/// The greatest common divisor.
fn common_factor(a: usize, b: usize) -> usize {
    if b == 0 { a } else { common_factor(b, a % b) }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)] // a test may stop where it stands
    use super::*;

    #[test]
    fn every_shard_is_taken_once() {
        for n in [1, 2, 3, 12, 97, 1000] {
            for number in [0, 1, 7, u64::MAX, 0x1234_5678_9abc_def0] {
                let mut all: Vec<usize> = WorkOrder::of_worker(number, n).collect();
                all.sort_unstable();
                assert!(all.into_iter().eq(0..n), "{n} {number}");
            }
            let parts = ["1/3", "2/3", "3/3"].map(|text| WorkOrder::of_part(text.parse().unwrap(), n));
            let mut all: Vec<usize> = parts.into_iter().flatten().collect();
            all.sort_unstable();
            assert!(all.into_iter().eq(0..n), "{n}");
        }
    }

    #[test]
    fn workers_differ_in_their_order() {
        let order = |number: u64| WorkOrder::of_worker(number, 1000).take(10).collect::<Vec<_>>();
        assert_ne!(order(0x1111_2222_3333_4444), order(0x5555_6666_7777_8888));
    }
}
