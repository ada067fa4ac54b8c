//! A tracker that sends its last pose again, with a new stamp: is the tip at rest, or the tracker frozen?
//!
//! Noise hardly ever gives the same numbers twice, unless the tracker rounds them to more than its noise; then a tip at
//! rest repeats itself for as long as it rests. Which of the two a tracker does is learned from what it sends. A run of
//! repetitions is withheld for a moment, and accepted if
//!
//! - it is no longer than this tracker's share of repetitions p explains: p to the power of its length is no rarer than
//!   once a day. That is required of trackers whose noise exceeds their rounding alone: below it, p depends on where
//!   between two steps of the rounding the tip happens to rest; and
//! - the next other pose is where noise alone could have put it: a tip that was really at rest does not reappear
//!   millimetres away.

use crate::{Pose, Quality};

/// How rare a run of repetitions must be to be none of a healthy tracker's: at 100 Hz, once a day.
const RARE: f64 = 1e-7;
/// A tracker that rounds to more than its noise repeats itself more often: wherever between its steps the tip rests,
/// each of three coordinates is equal at least every other time, 1/8 together.
const NOISY: f64 = 0.1;
/// Pairs of successive poses over which shares and steps are learned.
const WINDOW: usize = 40;
/// With none of n pairs equal, the share is below 3/n at 95 % (the rule of three).
const THREE: f64 = 3.0;
/// Steps between two poses at rest, of their RMS, that noise exceeds once in 5e9 (normal noise, three coordinates).
const FURTHEST_STEP: f64 = 4.0;

/// Watches the repetitions of one sensor.
#[derive(Debug, Clone)]
pub(super) struct RepeatWatch {
    /// Longest that a repetition is withheld [s].
    hold: f64,
    /// Last pose that was no repetition.
    last: Option<Pose>,
    /// Its repetitions that are not decided, in order of time.
    withheld: Vec<Pose>,
    /// Its repetitions.
    n: usize,
    /// They were held for long enough: the tip rests.
    is_at_rest: bool,
    /// They are more than can be.
    is_frozen: bool,
    /// Window from which the share of repetitions is estimated.
    window: RepeatWindow,
    /// Largest share of repetitions in any window, at 95 %: motion makes it smaller, rest shows it.
    share: Option<f64>,
    /// Smallest RMS step between poses that differ in any window [m]: motion makes it larger.
    step: Option<f64>,
}

#[derive(Debug, Clone, Copy, Default)]
struct RepeatWindow {
    n_pairs: usize,
    n_repeats: usize,
    /// Sum of the squared steps between poses that differ [m²].
    squares: f64,
}

impl RepeatWindow {
    /// Largest share of repetitions that this many of them leave likely [-].
    fn share(&self) -> f64 {
        ((self.n_repeats as f64 + THREE) / (self.n_pairs as f64 + THREE)).min(1.0)
    }
}

impl RepeatWatch {
    /// A watch that has seen nothing, and holds a repetition back for `hold` [s] at most.
    pub fn new(hold: f64) -> Self {
        Self {
            hold,
            last: None,
            withheld: Vec::new(),
            n: 0,
            is_at_rest: false,
            is_frozen: false,
            window: RepeatWindow::default(),
            share: None,
            step: None,
        }
    }

    /// Takes the next pose; appends those that are decided, in order of time.
    pub fn take(&mut self, pose: Pose, decided: &mut Vec<Pose>) {
        if pose.quality != Quality::Good {
            self.decide(!self.is_frozen, decided);
            decided.push(pose);
            return;
        }
        match self.last {
            Some(last) if is_same(&last, &pose) => self.repeat(pose, decided),
            last => {
                let step = last.map(|last| distance(&last, &pose));
                let is_near = step.zip(self.step).is_none_or(|(step, usual)| step <= FURTHEST_STEP * usual);
                let was_at_rest = !self.is_frozen && (is_near || self.is_at_rest);
                self.decide(was_at_rest, decided);
                if let Some(step) = step.filter(|_| was_at_rest || self.n == 0) {
                    self.learn(step);
                }
                (self.last, self.n, self.is_at_rest, self.is_frozen) = (Some(pose), 0, false, false);
                decided.push(pose);
            }
        }
    }

    fn repeat(&mut self, pose: Pose, decided: &mut Vec<Pose>) {
        self.n += 1;
        self.withheld.push(pose);
        let share = self.share.unwrap_or_else(|| self.window.share());
        self.is_frozen |= share < NOISY && share.powf(self.n as f64) < RARE;
        self.is_at_rest |= pose.time - self.withheld[0].time >= self.hold;
        if self.is_frozen {
            self.decide(false, decided);
        } else if self.is_at_rest {
            self.decide(true, decided);
        }
    }

    /// Passes on the withheld poses: unchanged, or marked frozen.
    fn decide(&mut self, is_believed: bool, decided: &mut Vec<Pose>) {
        let quality = if is_believed { Quality::Good } else { Quality::Frozen };
        decided.extend(self.withheld.drain(..).map(|pose| Pose { quality, ..pose }));
    }

    /// Learns from a run of repetitions and the step that ended it [m].
    fn learn(&mut self, step: f64) {
        let window = &mut self.window;
        window.n_pairs += self.n + 1;
        window.n_repeats += self.n;
        window.squares += step * step;
        if window.n_pairs >= WINDOW {
            let rms = (window.squares / (window.n_pairs - window.n_repeats) as f64).sqrt();
            self.share = Some(window.share().max(self.share.unwrap_or(0.0)));
            if rms > 0.0 {
                // Zero where the orientation alone differs.
                self.step = Some(rms.min(self.step.unwrap_or(f64::INFINITY)));
            }
            *window = RepeatWindow::default();
        }
    }
}

fn distance(a: &Pose, b: &Pose) -> f64 {
    (0..3).map(|k| (a.position[k] - b.position[k]).powi(2)).sum::<f64>().sqrt()
}

/// Whether position and orientation are the same numbers; zero has two signs.
fn is_same(a: &Pose, b: &Pose) -> bool {
    a.position == b.position && a.orientation == b.orientation
}

#[cfg(test)]
mod tests {
    use super::*;
    use hysteron_base::rng;

    const RATE: f64 = 80.0;

    /// Poses of a tip that is at `x(time)` [m], measured with normal noise and rounded [m], sent again while
    /// `is_frozen`.
    fn poses(
        n: usize,
        (noise, rounding): (f64, f64),
        x: impl Fn(f64) -> f64,
        is_frozen: impl Fn(f64) -> bool,
    ) -> Vec<Pose> {
        let mut rng = rng(5, "tests/repeats");
        let mut normal = || hysteron_base::normal(&mut rng);
        let mut sent: Option<Pose> = None;
        let pose = |k: usize| {
            let time = k as f64 / RATE;
            let measured = [x(time) + noise * normal(), noise * normal(), 0.08 + noise * normal()];
            let rounded =
                if rounding > 0.0 { measured.map(|x| (x / rounding).round() * rounding) } else { measured };
            let pose =
                Pose { time, position: rounded, orientation: [1.0, 0.0, 0.0, 0.0], quality: Quality::Good };
            let repeated = sent.filter(|_| is_frozen(time)).map(|last| Pose { time, ..last });
            sent = Some(repeated.unwrap_or(pose));
            repeated.unwrap_or(pose)
        };
        (0..n).map(pose).collect()
    }

    fn decided(poses: &[Pose]) -> Vec<Pose> {
        let (mut repeats, mut all) = (RepeatWatch::new(0.15), Vec::new());
        poses.iter().for_each(|pose| repeats.take(*pose, &mut all));
        let times: Vec<f64> = all.iter().map(|pose| pose.time).collect();
        assert!(times.windows(2).all(|pair| pair[0] < pair[1]), "out of order");
        assert!(poses.len() - all.len() <= 13, "{} are held back", poses.len() - all.len());
        all
    }

    fn n_frozen(poses: &[Pose]) -> usize {
        poses.iter().filter(|pose| pose.quality == Quality::Frozen).count()
    }

    /// At rest for two seconds, then to and fro at so much at most [m/s], with rests of a second between.
    fn moving(speed: f64) -> impl Fn(f64) -> f64 {
        move |time: f64| {
            let t = (time - 2.0).max(0.0) % 5.0;
            // 4 s of a smooth way out and back: its rate is pi a / 4 s at most.
            let a = speed * 4.0 / std::f64::consts::PI;
            if t < 4.0 { 0.5 * a * (1.0 - (std::f64::consts::FRAC_PI_2 * t).cos()) } else { 0.0 }
        }
    }

    #[test]
    fn a_tip_at_rest_is_never_frozen_however_its_tracker_rounds() {
        for rounding in [0.0, 1e-5, 1e-4, 5e-4, 2e-3] {
            for noise in [0.0, 2e-6, 5e-5, 2e-4] {
                if noise == 0.0 && rounding == 0.0 {
                    continue; // no tracker
                }
                let all = decided(&poses(20_000, (noise, rounding), |_| 0.0, |_| false));
                assert_eq!(n_frozen(&all), 0, "noise {noise}, rounding {rounding}");
            }
        }
    }

    #[test]
    fn a_tip_that_moves_and_rests_is_hardly_ever_frozen_however_its_tracker_rounds() {
        for rounding in [0.0, 1e-5, 1e-4, 5e-4] {
            for noise in [0.0, 5e-5] {
                for speed in [0.5e-3, 5e-3, 30e-3] {
                    let all = decided(&poses(20_000, (noise, rounding), moving(speed), |_| false));
                    // Two equal poses by chance on the move cost one row, filled in from its neighbours: at most one
                    // in ten thousand.
                    assert!(n_frozen(&all) <= 2, "noise {noise}, rounding {rounding}, speed {speed}");
                }
            }
        }
    }

    #[test]
    fn repetitions_of_a_moving_tip_are_rejected_beyond_the_noise() {
        let noise = 5e-5;
        for speed in [2e-3, 10e-3, 28e-3] {
            for length in [0.02, 0.05, 0.1, 0.2, 0.4] {
                // In the middle of every way.
                let is_frozen = |time: f64| time > 4.0 && ((time - 2.0) % 5.0 - 0.8).abs() < 0.5 * length;
                let truth = moving(speed);
                let all = decided(&poses(4000, (noise, 0.0), &truth, is_frozen));
                let worst = all
                    .iter()
                    .filter(|pose| pose.quality == Quality::Good)
                    .map(|pose| (pose.position[0] - truth(pose.time)).abs())
                    .fold(0.0, f64::max);
                // What the next pose shows, and the noise of either.
                let hidden = FURTHEST_STEP * 6_f64.sqrt() * noise + 6.0 * noise;
                assert!(worst <= hidden, "{worst} m at {speed} m/s for {length} s, {hidden} m");
                let is_seen = speed * length > 2.0 * hidden;
                assert!(!is_seen || n_frozen(&all) > 0, "{speed} m/s for {length} s");
            }
        }
    }

    #[test]
    fn a_noisy_tracker_that_freezes_at_rest_is_seen_too() {
        let all = decided(&poses(800, (5e-5, 0.0), |_| 0.0, |time| time > 5.0));
        let frozen: Vec<f64> =
            all.iter().filter(|pose| pose.quality == Quality::Frozen).map(|pose| pose.time).collect();
        assert!(frozen.len() > 390 && frozen.iter().all(|time| *time > 5.0), "{} frozen", frozen.len());
    }

    #[test]
    fn a_flagged_pose_keeps_the_order_of_time() {
        let mut poses = poses(200, (0.0, 1e-4), |_| 0.0, |_| false);
        poses.iter_mut().step_by(7).for_each(|pose| pose.quality = Quality::Flagged);
        assert_eq!(n_frozen(&decided(&poses)), 0);
    }
}
