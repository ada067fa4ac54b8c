//! Parts of a plan for several machines.

use std::str::FromStr;

/// The I-th of N parts: every N-th trajectory.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shard {
    part: usize,
    of: usize,
}

impl Shard {
    /// Number of parts, N.
    pub fn of(self) -> usize {
        self.of
    }

    /// Whether the `k`-th trajectory, from 0, is in it.
    pub fn has(self, k: usize) -> bool {
        k % self.of == self.part - 1
    }
}

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let numbers =
            text.split_once('/').and_then(|(part, of)| Some((part.parse().ok()?, of.parse().ok()?)));
        match numbers {
            Some((part, of)) if 1 <= part && part <= of => Ok(Self { part, of }),
            _ => Err("expected I/N with 1 <= I <= N, as in 2/3".to_owned()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_trajectory_is_in_one_part() {
        for of in 1..=5 {
            let parts = (1..=of).map(|part| format!("{part}/{of}").parse::<Shard>().expect("a shard"));
            let parts: Vec<Shard> = parts.collect();
            assert!((0..20).all(|k| parts.iter().filter(|part| part.has(k)).count() == 1), "{of}");
        }
    }

    #[test]
    fn a_part_that_is_none_is_refused() {
        for text in ["", "1", "0/3", "4/3", "1/0", "a/b", "1/2/3", "-1/3"] {
            assert!(text.parse::<Shard>().is_err(), "{text}");
        }
    }
}
