//! Named, independent streams of random numbers from the one seed of a scene.
//!
//! The key of each stream is the SHA-256 of a fixed word, the seed and the name. A new stream therefore never
//! disturbs the others, streams do not depend on the order in which they are made, and ChaCha8 gives the same
//! numbers on every machine.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use sha2::{Digest, Sha256};

/// Separates these keys from other uses of SHA-256. Changing it changes every random number of the project.
const DOMAIN: &[u8] = b"hysteron-rng-1";

/// The stream `name` of `seed`, at its beginning: `rng(scene.seed, "dataset/noise")`.
///
/// Equal arguments give equal streams; anything else gives an independent one. Threads each take a stream of
/// their own (`"dataset/noise/17"`), so results do not depend on their number.
pub fn rng(seed: u64, name: &str) -> ChaCha8Rng {
    let mut hasher = Sha256::new();
    hasher.update(DOMAIN);
    hasher.update(seed.to_le_bytes());
    hasher.update(name.as_bytes());
    ChaCha8Rng::from_seed(hasher.finalize().into())
}

/// A standard normal number as noise needs it: the sum of twelve uniform ones, never beyond six deviations.
#[inline] // where it is called, at the speed of that crate
pub fn normal(stream: &mut ChaCha8Rng) -> f64 {
    (0..12).map(|_| stream.random_range(-0.5..0.5)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::Rng;

    #[test]
    fn first_values_are_pinned() {
        // Made by this function when it was written; a change would change every dataset.
        let mut stream = rng(1, "dataset/noise");
        assert_eq!(
            [stream.next_u64(), stream.next_u64()],
            [8_603_982_703_601_014_427, 973_749_333_871_189_609]
        );
    }

    #[test]
    fn streams_differ_by_seed_and_by_name() {
        let first = |seed, name| rng(seed, name).next_u64();
        let values = [first(1, "a"), first(2, "a"), first(1, "b"), first(1, ""), first(1, "aa")];
        for i in 0..values.len() {
            for j in 0..i {
                assert_ne!(values[i], values[j], "streams {i} and {j}");
            }
        }
        assert_eq!(first(1, "a"), values[0]);
    }
}
