//! Which samples of a motion a fit steps through, and which it compares.
//!
//! Friction remembers, so a motion is passed from its beginning, in steps that the fast iteration can follow. What
//! counts is how far the tendons move, not how many samples that took: a rest costs nothing.

use hysteron_base::BadInput;

use crate::motion::Motion;
use crate::{Result, Target};

/// How a fit goes through its motions.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stepping {
    /// How far a stroke moves from one step to the next (or the tip, where tendons are driven by tension) [m].
    pub step: f64,
    /// How far from one compared sample to the next [m].
    pub every: f64,
    /// Most steps of an evaluation, shared evenly by all motions: of each, the beginning.
    pub most: usize,
}

/// The part of a motion that a fit uses.
#[derive(Debug, Clone, PartialEq)]
pub struct Course {
    /// Samples that are stepped through, from 0.
    pub samples: Vec<usize>,
    /// Per step, a target for every primary tendon.
    pub targets: Vec<Vec<Target>>,
    /// Per step, the measured tip if it is compared [m].
    pub tips: Vec<Option<[f64; 3]>>,
}

/// Fewest compared samples of a motion.
const FEWEST: usize = 8;

impl Course {
    /// Chooses at most `most` samples of `motion`; filled-in ones are passed and not compared.
    ///
    /// # Errors
    /// Fewer than eight to compare.
    pub fn new(motion: &Motion, stepping: &Stepping, most: usize) -> Result<Self> {
        let (mut samples, mut tips) = (Vec::new(), Vec::new());
        let mut compared = None;
        for sample in 0..motion.len() {
            if samples.len() == most {
                break;
            }
            let moved = |from: &usize| moved(motion, *from, sample);
            if samples.last().is_some_and(|last| moved(last) < stepping.step) {
                continue;
            }
            samples.push(sample);
            let is_due = compared.is_none_or(|last| moved(&last) >= stepping.every);
            let is_compared = is_due && !motion.gap[sample];
            tips.push(is_compared.then(|| motion.tips[sample]));
            if is_compared {
                compared = Some(sample);
            }
        }
        let n = tips.iter().flatten().count();
        if n < FEWEST {
            let expected = format!("at least {FEWEST} rows between which robot and tip move");
            let hint = "rows count that differ by --every-mm from the one before and are no gap";
            return Err(BadInput::new(format!("{}: recording", motion.name), expected, n.to_string())
                .hint(hint)
                .into());
        }
        let targets = samples.iter().map(|&sample| motion.targets_at(sample)).collect();
        Ok(Self { samples, targets, tips })
    }
}

/// The courses of all motions.
///
/// # Errors
/// Those of [`Course::new`].
pub fn courses(motions: &[Motion], stepping: &Stepping) -> Result<Vec<Course>> {
    let most = stepping.most / motions.len().max(1);
    motions.iter().map(|motion| Course::new(motion, stepping, most)).collect()
}

/// Largest change of a stroke between two samples, and of the tip where tensions drive [m].
fn moved(motion: &Motion, from: usize, to: usize) -> f64 {
    let by_stroke = motion.strokes_at(from).iter().zip(motion.strokes_at(to)).map(|(a, b)| (a - b).abs());
    let tip = if motion.has_tensions() { distance(motion.tips[from], motion.tips[to]) } else { 0.0 };
    by_stroke.fold(tip, f64::max)
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|c| (a[c] - b[c]).powi(2)).sum::<f64>().sqrt()
}
