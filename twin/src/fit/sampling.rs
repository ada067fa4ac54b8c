//! Which samples of a motion a fit steps through, and which it compares.
//!
//! Friction has memory, so a motion is passed from its beginning. What counts is the path of the strokes, not
//! how many samples that took: a rest costs nothing, a straight way little, and where strokes turn back, a
//! sample is kept, however long the steps are.

use hysteron_base::BadInput;

use crate::motion::RobotMotion;
use crate::{Result, Target};

/// How a fit goes through its motions.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stepping {
    /// How far a stroke moves from one step to the next at most, unless a single sample moves farther (or the tip,
    /// where tendons are driven by tension) [m].
    pub step: f64,
    /// How far from one compared sample to the next [m].
    pub every: f64,
    /// Most steps of an evaluation, shared evenly by all motions: of each, the beginning.
    pub most: usize,
}

/// The part of a motion that a fit uses.
#[derive(Debug, Clone, PartialEq)]
pub struct FitSamples {
    /// Samples that are stepped through, from 0.
    pub samples: Vec<usize>,
    /// Per step, a target for every primary tendon.
    pub targets: Vec<Vec<Target>>,
    /// Per step, the measured tip if it is compared [m].
    pub tips: Vec<Option<[f64; 3]>>,
}

/// Fewest compared samples of a motion.
const MIN_SAMPLES: usize = 8;
/// Part of a step by which a stroke must go back to count as one that turns [-].
const TURNED: f64 = 0.2;
/// Part of a step by which a stroke must have moved before it turned back: less is noise [-].
const MIN_STROKE_PART: f64 = 0.02;

impl FitSamples {
    /// Chooses samples of `motion`, at most `most`; filled-in ones are passed and not compared.
    ///
    /// # Errors
    /// Fewer than eight to compare.
    pub fn new(motion: &RobotMotion, stepping: &Stepping, most: usize) -> Result<Self> {
        let samples = way(motion, stepping.step, most);
        let mut compared = None;
        let mut tips = Vec::with_capacity(samples.len());
        for &sample in &samples {
            let is_due = compared.is_none_or(|last| moved(motion, last, sample) >= stepping.every);
            let is_compared = is_due && !motion.gap[sample];
            tips.push(is_compared.then(|| motion.tips[sample]));
            if is_compared {
                compared = Some(sample);
            }
        }
        let n = tips.iter().flatten().count();
        if n < MIN_SAMPLES {
            let expected = format!("at least {MIN_SAMPLES} rows between which robot and tip move");
            let hint = "rows count that differ by --every-mm from the one before and are no gap";
            return Err(BadInput::new(format!("{}: recording", motion.name), expected, n.to_string())
                .hint(hint)
                .into());
        }
        let targets = samples.iter().map(|&sample| motion.targets_at(sample)).collect();
        Ok(Self { samples, targets, tips })
    }

    /// The first `n` steps.
    pub fn beginning(&self, n: usize) -> Self {
        let n = n.min(self.samples.len());
        Self {
            samples: self.samples[..n].to_vec(),
            targets: self.targets[..n].to_vec(),
            tips: self.tips[..n].to_vec(),
        }
    }
}

/// The courses of all motions.
///
/// # Errors
/// Those of [`FitSamples::new`].
pub fn courses(motions: &[RobotMotion], stepping: &Stepping) -> Result<Vec<FitSamples>> {
    let most = stepping.most / motions.len().max(1);
    motions.iter().map(|motion| FitSamples::new(motion, stepping, most)).collect()
}

/// Samples from 0 on, at most `most`: from each, the farthest that lies within a step, or where a stroke turns back
/// before that, or the next one that moves at all.
fn way(motion: &RobotMotion, step: f64, most: usize) -> Vec<usize> {
    let mut samples = vec![0];
    while samples.len() < most {
        let Some(next) = next(motion, samples[samples.len() - 1], step) else { break };
        samples.push(next);
    }
    samples
}

/// The sample after `from`; none where nothing moves any more.
fn next(motion: &RobotMotion, from: usize, step: f64) -> Option<usize> {
    let start: Vec<f64> = coordinates(motion, from).collect();
    // Farthest in either direction of each coordinate, and where that was.
    let mut extremes = vec![[(0.0, from); 2]; start.len()];
    let (mut last, mut size) = (from, 0.0);
    for sample in from + 1..motion.len() {
        let mut largest: f64 = 0.0;
        for ((now, start), extremes) in coordinates(motion, sample).zip(&start).zip(&mut extremes) {
            for (extreme, way) in extremes.iter_mut().zip([now - start, start - now]) {
                largest = largest.max(way);
                if way > extreme.0 {
                    *extreme = (way, sample);
                }
                let turns_back = extreme.0 - way > TURNED * step && extreme.0 > MIN_STROKE_PART * step;
                if turns_back {
                    return Some(extreme.1);
                }
            }
        }
        if largest > step {
            return Some(if size > TURNED * step { last } else { sample });
        }
        (last, size) = (sample, largest);
    }
    // What is left is worth a step where it moves.
    (size > TURNED * step).then_some(last)
}

/// Coordinates that measure the progress of a motion: strokes, and where tensions drive, the tip [m].
fn coordinates(motion: &RobotMotion, sample: usize) -> impl Iterator<Item = f64> {
    let tip = if motion.has_tensions() { &motion.tips[sample][..] } else { &[] };
    motion.strokes_at(sample).iter().chain(tip).copied()
}

/// Largest change of a coordinate between two samples [m].
fn moved(motion: &RobotMotion, from: usize, to: usize) -> f64 {
    coordinates(motion, from).zip(coordinates(motion, to)).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}
