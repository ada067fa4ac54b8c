//! Iterative learning control: a path that is run again is led to where it was missed.
//!
//! The robot is asked for a path r instead of its goal d. After a repeat with the tip y the next one is asked for
//!
//! r' = r + L Q (d - y),
//!
//! with a gain L and a filter Q without phase that keeps what a repeat can show and drops the tracker's noise. Whatever finds the
//! strokes for r, a network or a twin, stands for the inverse of the robot; where it is right but for a factor a of the tip's motion, the error
//! after k repeats is (1 - a L)^k of the first one, so that it falls for every a between 0 and 2/L (Bristow et al. 2006, IEEE Control
//! Systems Magazine 26(3), with the inverse of the plant as the learning function).

use crate::inverse::TipPosition;

/// Gain, filter and bounds of the learning.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RepetitionLearning {
    /// L [-].
    pub gain: f64,
    /// Half the width of each of the two moving means of Q [s].
    pub half_width_s: f64,
    /// Farthest that r is from d [m].
    pub farthest_m: f64,
}

impl Default for RepetitionLearning {
    fn default() -> Self {
        Self { gain: 0.8, half_width_s: 0.1, farthest_m: 5e-3 }
    }
}

/// A sample that is off by more than this many times the median distance is the tracker's error, not the robot's [-], unless it is
/// below [`TRUSTED`].
const OUTLIER: f64 = 6.0;
/// Distance that is always believed [m].
const TRUSTED: f64 = 1e-3;

/// A repeat of a path.
#[derive(Debug, Clone, PartialEq)]
pub struct Repeat {
    /// Path that the strokes were found for, r (n_samples) [m].
    pub led: Vec<TipPosition>,
    /// Tip that was measured, y (n_samples) [m].
    pub tip: Vec<TipPosition>,
    /// True where it was not (n_samples).
    pub gap: Vec<bool>,
}

impl Repeat {
    /// Distance from the goal d (n_samples) [m] of samples that were measured, root mean square over time [m].
    pub fn error_m(&self, goal: &[TipPosition]) -> f64 {
        let (sum, count) =
            self.missed(goal).iter().flatten().fold((0.0, 0.0), |(sum, count), e| {
                (sum + e.iter().map(|c| c * c).sum::<f64>(), count + 1.0)
            });
        (sum / f64::max(count, 1.0)).sqrt()
    }

    /// d - y where it can be believed (n_samples) [m].
    fn missed(&self, goal: &[TipPosition]) -> Vec<Option<[f64; 3]>> {
        let length = |e: &[f64; 3]| e.iter().map(|c| c * c).sum::<f64>().sqrt();
        let measured = goal.iter().zip(&self.tip).zip(&self.gap).map(|((goal, tip), gap)| {
            (!gap).then(|| std::array::from_fn(|c| goal[c] - tip[c])).filter(|e| length(e).is_finite())
        });
        let mut missed: Vec<Option<[f64; 3]>> = measured.collect();
        let mut lengths: Vec<f64> = missed.iter().flatten().map(length).collect();
        lengths.sort_by(f64::total_cmp);
        let median = lengths.get(lengths.len() / 2).copied().unwrap_or(0.0);
        let farthest = f64::max(OUTLIER * median, TRUSTED);
        missed.iter_mut().for_each(|e| *e = e.filter(|e| length(e) <= farthest));
        missed
    }

    /// The path r' to find strokes for next, at samples `step` apart [s].
    pub fn next(&self, goal: &[TipPosition], step: f64, learning: &RepetitionLearning) -> Vec<TipPosition> {
        let half = (learning.half_width_s / step).round() as usize;
        let filtered = moving_mean(&moving_mean(&filled(&self.missed(goal)), half), half);
        let moved = self.led.iter().zip(&filtered).zip(goal);
        let of = |((led, e), goal): ((&TipPosition, &[f64; 3]), &TipPosition)| -> TipPosition {
            let off: [f64; 3] = std::array::from_fn(|c| led[c] + learning.gain * e[c] - goal[c]);
            let far = off.iter().map(|c| c * c).sum::<f64>().sqrt();
            let part = (learning.farthest_m / f64::max(far, f64::MIN_POSITIVE)).min(1.0);
            std::array::from_fn(|c| goal[c] + part * off[c])
        };
        moved.map(of).collect()
    }
}

/// The same with a straight line from sample to sample where there is none; before the first and after the last it keeps their value.
fn filled(values: &[Option<[f64; 3]>]) -> Vec<[f64; 3]> {
    let known: Vec<(usize, [f64; 3])> =
        values.iter().enumerate().filter_map(|(i, v)| Some((i, (*v)?))).collect();
    let Some((&(_, at_first), &(last, at_last))) = known.first().zip(known.last()) else {
        return vec![[0.0; 3]; values.len()];
    };
    let mut all = vec![at_first; values.len()];
    all[last..].fill(at_last);
    for pair in known.windows(2) {
        let [(a, from), (b, to)] = [pair[0], pair[1]];
        for i in a..b {
            let part = (i - a) as f64 / (b - a) as f64;
            all[i] = std::array::from_fn(|c| from[c] + part * (to[c] - from[c]));
        }
    }
    all
}

/// Mean over `half` samples on either side, or as many as there are on both.
fn moving_mean(values: &[[f64; 3]], half: usize) -> Vec<[f64; 3]> {
    let n = values.len();
    let mut sums = vec![[0.0; 3]];
    for value in values {
        let sum = sums[sums.len() - 1];
        sums.push(std::array::from_fn(|c| sum[c] + value[c]));
    }
    let mean = |i: usize| {
        let half = half.min(i).min(n - 1 - i);
        let (first, last) = (&sums[i - half], &sums[i + half + 1]);
        std::array::from_fn(|c| (last[c] - first[c]) / (2 * half + 1) as f64)
    };
    (0..n).map(mean).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const STEP: f64 = 0.01;

    fn goal() -> Vec<TipPosition> {
        (0..1000)
            .map(|i| 0.01 * i as f64 * 0.6)
            .map(|t: f64| [15e-3 * t.cos(), 10e-3 * t.sin(), 0.08])
            .collect()
    }

    /// Runs a path on a robot whose tip goes `part` of the way and is off by a constant.
    fn run(led: Vec<TipPosition>, part: f64) -> Repeat {
        let tip = led.iter().map(|r| [part * r[0] + 1e-3, part * r[1] - 5e-4, r[2]]).collect();
        Repeat { gap: vec![false; led.len()], led, tip }
    }

    #[test]
    fn the_error_falls_by_the_factor_of_the_theory() {
        let goal = goal();
        for part in [0.7, 1.0, 1.3] {
            let learning = RepetitionLearning { gain: 0.8, half_width_s: 0.0, farthest_m: 1.0 };
            let mut repeat = run(goal.clone(), part);
            let first = repeat.error_m(&goal);
            for k in 1..=4 {
                repeat = run(repeat.next(&goal, STEP, &learning), part);
                let expected = (1.0 - part * learning.gain).abs().powi(k) * first;
                assert!((repeat.error_m(&goal) - expected).abs() < 1e-9 * first, "{part} {k}");
            }
        }
    }

    #[test]
    fn the_filter_has_no_phase_and_takes_what_it_should_of_a_wave() {
        // Two means of 2 h + 1 samples: the square of the Dirichlet kernel, in phase.
        let (half, omega) = (10, 0.1);
        let wave: Vec<[f64; 3]> = (0..400).map(|i| [(omega * i as f64).sin(), 0.0, 0.0]).collect();
        let twice = moving_mean(&moving_mean(&wave, half), half);
        let n = (2 * half + 1) as f64;
        let factor = ((0.5 * n * omega).sin() / (n * (0.5 * omega).sin())).powi(2);
        for i in 2 * half..wave.len() - 2 * half {
            assert!((twice[i][0] - factor * wave[i][0]).abs() < 1e-12, "sample {i}");
        }
    }

    #[test]
    fn gaps_and_outliers_of_the_tracker_teach_nothing() {
        let goal = goal();
        let clean = run(goal.clone(), 0.9);
        let mut damaged = clean.clone();
        for i in 300..330 {
            (damaged.gap[i], damaged.tip[i]) = (true, [f64::NAN; 3]);
        }
        damaged.tip[600] = [0.3, -0.2, 0.5];
        let learning = RepetitionLearning::default();
        let [expected, found] = [&clean, &damaged].map(|repeat| repeat.next(&goal, STEP, &learning));
        // A straight line through a gap of T = 0.3 s misses at most the second derivative of the error times T²/8; the outlier is less.
        // The error is a tenth of the goal, which turns at 0.6 rad/s.
        let tol = learning.gain * 0.1 * 15e-3 * 0.6f64.powi(2) * 0.3f64.powi(2) / 8.0;
        for (a, b) in expected.iter().zip(&found) {
            assert!((0..3).all(|c| (a[c] - b[c]).abs() < tol), "{a:?} {b:?}");
        }
        assert!((damaged.error_m(&goal) / clean.error_m(&goal) - 1.0).abs() < 0.02);
    }

    #[test]
    fn the_path_is_led_no_farther_from_its_goal_than_allowed() {
        let goal = goal();
        let learning = RepetitionLearning { farthest_m: 1e-3, ..RepetitionLearning::default() };
        let led = run(goal.clone(), 0.5).next(&goal, STEP, &learning);
        let off =
            |(a, b): (&TipPosition, &TipPosition)| (0..3).map(|c| (a[c] - b[c]).powi(2)).sum::<f64>().sqrt();
        let largest = led.iter().zip(&goal).map(off).fold(0.0, f64::max);
        assert!((largest - 1e-3).abs() < 1e-12, "{largest}");
    }
}
