//! Motion in blocks: each is the test block in turn. A change must help along a motion that it was not found on, so that whole
//! motions are blocks where there are two.

use std::ops::Range;

use crate::motion::RobotMotion;

/// Number of blocks into which a single motion is cut, and the shortest duration of a block [s].
const PIECES: usize = 6;
const SHORTEST_S: f64 = 4.0;

/// Samples of a motion.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct MotionBlock {
    /// Which motion.
    pub motion: usize,
    /// Which of its samples.
    pub samples: Range<usize>,
}

/// Whole motions, or pieces of a single one.
pub(super) fn blocks(motions: &[RobotMotion]) -> Vec<MotionBlock> {
    let pieces = |(motion, of): (usize, &RobotMotion)| {
        let n = of.len();
        let most = (n as f64 * of.step / SHORTEST_S) as usize;
        let count = if motions.len() > 1 { 1 } else { PIECES.min(most).max(1) };
        (0..count).map(move |k| MotionBlock { motion, samples: k * n / count..(k + 1) * n / count })
    };
    motions.iter().enumerate().flat_map(pieces).collect()
}
