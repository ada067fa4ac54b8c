//! Motion in blocks: each is held out in turn.

use std::ops::Range;

use crate::motion::Motion;

/// Fewest motions that are blocks as they are; fewer are cut.
const FEWEST_WHOLE: usize = 3;
/// Into how many pieces all motions together are cut, and how long a piece is at the least [s].
const PIECES: usize = 6;
const SHORTEST_S: f64 = 4.0;

/// Samples of a motion.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Block {
    /// Which motion.
    pub motion: usize,
    /// Which of its samples.
    pub samples: Range<usize>,
}

/// Whole motions, or pieces of them where there are few.
pub(super) fn blocks(motions: &[Motion]) -> Vec<Block> {
    let pieces = |(motion, of): (usize, &Motion)| {
        let n = of.len();
        let most = (n as f64 * of.step / SHORTEST_S) as usize;
        let count = if motions.len() >= FEWEST_WHOLE { 1 } else { (PIECES / motions.len()).min(most).max(1) };
        (0..count).map(move |k| Block { motion, samples: k * n / count..(k + 1) * n / count })
    };
    motions.iter().enumerate().flat_map(pieces).collect()
}
