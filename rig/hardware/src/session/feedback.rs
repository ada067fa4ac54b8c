//! Feedback of the tip while strokes are run: a slow correction towards the path that they are for.
//!
//! Strokes that were found open loop lead the tip near its goal d; what is left changes slowly, with the robot's hysteresis. The
//! correction c of the goal follows it,
//!
//! dc/dt = K (d(t) - y(t)),   u = u0 + (du/dd) c,
//!
//! with the tip y at the time t of its pose, so that neither the tracker's delay nor the motion is taken for an error. An integral with the
//! gain K behind a delay T keeps its phase margin of 90° less K T; errors slower than K are taken out.

use hysteron_base::{BadInput, Bounds, Recording};

use crate::config::RigConfig;
use crate::{Pose, Quality};

/// K [1/s]: with a delay of 0.15 s the margin is 64°, and 39° where the robot answers twice as much as du/dd says.
const GAIN: f64 = 3.0;
/// Farthest that the goal is corrected [m].
const FARTHEST: f64 = 4e-3;
/// Errors that differ by more than this from the one before are the tracker's, not the robot's [m].
const LEAP: f64 = 3e-3;
/// Longest time between two poses that counts [s]: a silent tracker teaches nothing.
const LONGEST_STEP: f64 = 0.1;

/// Channels of a recording of strokes that hold the goal of the tip.
const GOAL: [&str; 2] = ["target_x_m", "target_y_m"];
/// Channel that is 1 where the correction follows the error, and 0 elsewhere.
pub const FEEDBACK_GATE: &str = "feedback";

/// Name of the channel du/dd of a tendon, numbered from 1, along x or y [-].
pub fn response_channel(tendon: usize, axis: usize) -> String {
    format!("response_{}_{tendon}_ratio", ["x", "y"][axis])
}

/// The correction of strokes by the tip that was measured.
#[derive(Debug, Clone)]
pub struct TipFeedback {
    /// Goal of the tip, by row [m].
    goal: Vec<[f64; 2]>,
    /// Whether the correction follows the error, by row.
    gate: Vec<bool>,
    /// du/dd by row, then by tendon [-].
    response: Vec<Vec<[f64; 2]>>,
    stroke: Bounds,
    /// Largest change in a row [m].
    largest_change: f64,
    /// Duration of a row [s].
    period: f64,
    /// Correction of the goal [m].
    correction: [f64; 2],
    /// Time and error of the last pose that was believed [s, m].
    last: Option<(f64, [f64; 2])>,
    /// Whether a limit held a stroke in the last row: then the correction does not grow.
    is_limited: bool,
}

impl TipFeedback {
    /// For a recording of strokes that has the goal, [`FEEDBACK_GATE`] and [`response_channel`].
    ///
    /// # Errors
    /// `BadInput` for a missing channel, or a rig without a tracker.
    pub fn new(commands: &Recording, rig: &RigConfig) -> Result<Self, BadInput> {
        if rig.tracker.is_none() {
            return Err(BadInput::new("--feedback", "a rig with a tracker", format!("\"{}\"", rig.name)));
        }
        let n = rig.tendons.len();
        let channel = |name: &str| {
            let hint = "hysteron track --feedback writes strokes with all that feedback needs";
            commands.require(name).map_err(|bad| bad.hint(hint))
        };
        let [x, y] = GOAL.map(channel);
        let (x, y, gate) = (x?, y?, channel(FEEDBACK_GATE)?);
        let responses = (1..=n)
            .map(|k| Ok([channel(&response_channel(k, 0))?, channel(&response_channel(k, 1))?]))
            .collect::<Result<Vec<[&[f64]; 2]>, BadInput>>()?;
        let rate =
            commands.rate_hz().ok_or_else(|| BadInput::new("time_s", "a fixed rate", "uneven steps"))?;
        let limits = &rig.limits;
        Ok(Self {
            goal: x.iter().zip(y).map(|(x, y)| [*x, *y]).collect(),
            gate: gate.iter().map(|gate| *gate > 0.0).collect(),
            response: (0..x.len()).map(|i| responses.iter().map(|[x, y]| [x[i], y[i]]).collect()).collect(),
            stroke: Bounds { min: limits.stroke_min, max: limits.stroke_max },
            largest_change: limits.stroke_rate_max / rate,
            period: rate.recip(),
            correction: [0.0; 2],
            last: None,
            is_limited: false,
        })
    }

    /// Takes a pose in the robot's frame, `since` seconds after the first row.
    pub(super) fn take_pose(&mut self, pose: &Pose, since: f64) {
        let row = since / self.period;
        if pose.quality != Quality::Good || !(0.0..=(self.goal.len() - 1) as f64).contains(&row) {
            return;
        }
        let (i, part) = (row as usize, row.fract());
        let next = (i + 1).min(self.goal.len() - 1);
        let goal = |c: usize| self.goal[i][c] + part * (self.goal[next][c] - self.goal[i][c]);
        let error: [f64; 2] = std::array::from_fn(|c| goal(c) - pose.position[c]);
        if !error.iter().all(|e| e.is_finite()) {
            return;
        }
        if !self.gate[i] {
            self.last = None;
            return;
        }
        let Some((then, before)) = self.last else {
            self.last = Some((since, error));
            return;
        };
        let step = since - then;
        let leap = (error[0] - before[0]).hypot(error[1] - before[1]);
        // A tip that is really elsewhere after a while is believed again.
        if leap > LEAP && step < LONGEST_STEP {
            return;
        }
        self.last = Some((since, error));
        if step <= 0.0 || step > LONGEST_STEP {
            return;
        }
        let moved: [f64; 2] = std::array::from_fn(|c| self.correction[c] + GAIN * step * error[c]);
        let far = moved[0].hypot(moved[1]);
        // At a limit it can only come back.
        if self.is_limited && far >= self.correction[0].hypot(self.correction[1]) {
            return;
        }
        let part = (FARTHEST / f64::max(far, f64::MIN_POSITIVE)).min(1.0);
        self.correction = moved.map(|c| part * c);
    }

    /// Corrects the strokes of a row in place, within the range and the rate of the rig; `before` are those of the row before [m].
    pub(super) fn correct(&mut self, row: usize, before: &[f64], strokes: &mut [f64]) {
        self.is_limited = false;
        for ((stroke, before), response) in strokes.iter_mut().zip(before).zip(&self.response[row]) {
            let moved = response[0] * self.correction[0] + response[1] * self.correction[1];
            // The strokes as they are were checked; the correction must not lead beyond the range.
            let (low, high) = (self.stroke.min.min(*stroke), self.stroke.max.max(*stroke));
            let wanted = *stroke + moved;
            let allowed =
                wanted.clamp(low, high).clamp(before - self.largest_change, before + self.largest_change);
            self.is_limited |= allowed != wanted;
            *stroke = allowed;
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)] // a test may stop where it stands
    use super::*;

    const PERIOD: f64 = 0.01;
    const N: usize = 2000;

    /// One tendon that moves the tip by as much along x; a goal at rest, strokes of none.
    fn feedback() -> TipFeedback {
        TipFeedback {
            goal: vec![[1e-3, 0.0]; N],
            gate: vec![true; N],
            response: vec![vec![[1.0, 0.0]]; N],
            stroke: Bounds { min: -5e-3, max: 5e-3 },
            largest_change: 12e-3 * PERIOD,
            period: PERIOD,
            correction: [0.0; 2],
            last: None,
            is_limited: false,
        }
    }

    fn pose(x: f64, quality: Quality) -> Pose {
        Pose { time: 0.0, position: [x, 0.0, 0.08], orientation: [1.0, 0.0, 0.0, 0.0], quality }
    }

    /// Runs a robot whose tip goes `factor` times the stroke, `late` rows later, as the tracker shows it; gives the strokes.
    fn run(factor: f64, late: usize, seen: impl Fn(usize, f64) -> Option<Pose>) -> Vec<f64> {
        let (mut feedback, mut strokes) = (feedback(), vec![0.0]);
        for i in 0..N {
            let tip = factor * strokes[i.saturating_sub(late)];
            if let Some(pose) = seen(i, tip) {
                feedback.take_pose(&pose, i as f64 * PERIOD);
            }
            let mut stroke = [0.0];
            feedback.correct(i, &[strokes[i]], &mut stroke);
            strokes.push(stroke[0]);
        }
        strokes
    }

    fn good(_: usize, tip: f64) -> Option<Pose> {
        Some(pose(tip, Quality::Good))
    }

    #[test]
    fn the_error_falls_as_that_of_an_integral_and_is_stable_behind_a_delay() {
        // Without delay e' = -K e: after a second exp(-K) of it is left, by Euler's steps (1 - K dt)^100, a row later.
        let strokes = run(1.0, 0, good);
        let left = 1.0 - strokes[101] / 1e-3;
        assert!((left - (1.0 - GAIN * PERIOD).powi(100)).abs() < GAIN * PERIOD, "{left}");
        // Behind 0.15 s, and with twice the answer, it still comes to rest at the goal.
        for factor in [1.0, 2.0] {
            let strokes = run(factor, 15, good);
            assert!((factor * strokes[N] - 1e-3).abs() < 1e-8, "{factor} {}", strokes[N]);
        }
    }

    #[test]
    fn a_tracker_that_is_silent_lies_or_leaps_leads_nobody_away() {
        let undisturbed = run(1.0, 15, good);
        let worst = |seen: &dyn Fn(usize, f64) -> Option<Pose>| {
            let strokes = run(1.0, 15, seen);
            strokes.iter().zip(&undisturbed).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
        };
        // At rest at the goal by then: what is held is right.
        let from = 1000..1200;
        let silent = worst(&|i, tip| if from.contains(&i) { None } else { good(i, tip) });
        let flagged = worst(&|i, tip| {
            let x = if from.contains(&i) { 0.2 } else { tip };
            Some(pose(x, if from.contains(&i) { Quality::Flagged } else { Quality::Good }))
        });
        let leaping =
            worst(&|i, tip| Some(pose(if i % 50 == 0 && i > 0 { tip + 0.02 } else { tip }, Quality::Good)));
        let none = worst(&|i, tip| Some(pose(if i == 1000 { f64::NAN } else { tip }, Quality::Good)));
        for (what, error) in [("silent", silent), ("flagged", flagged), ("leaping", leaping), ("none", none)]
        {
            assert!(error < 1e-5, "{what}: {error}");
        }
    }

    #[test]
    fn strokes_stay_within_range_rate_and_reach_whatever_the_tip_does() {
        for tip in [-0.01, 0.01, 1.0] {
            let strokes = run(0.0, 0, |_, _| Some(pose(tip, Quality::Good)));
            let fastest = strokes.windows(2).map(|pair| (pair[1] - pair[0]).abs()).fold(0.0, f64::max);
            let farthest = strokes.iter().map(|stroke| stroke.abs()).fold(0.0, f64::max);
            assert!(fastest <= 12e-3 * PERIOD * (1.0 + 1e-9) && farthest <= FARTHEST * (1.0 + 1e-9), "{tip}");
        }
        // A goal that the range does not allow: the stroke waits at its end, and comes back at once when the tip does.
        let mut feedback = TipFeedback { response: vec![vec![[2.0, 0.0]]; N], ..feedback() };
        let mut before = 0.0;
        for i in 0..1000 {
            feedback.take_pose(&pose(if i < 500 { -5e-3 } else { 5e-3 }, Quality::Good), i as f64 * PERIOD);
            let mut stroke = [0.0];
            feedback.correct(i, &[before], &mut stroke);
            before = stroke[0];
            assert!(before.abs() <= 5e-3);
            // The leap is believed after 0.1 s, and 5 mm at 12 mm/s take 0.42 s.
            assert!(i < 555 || before < 0.0, "{i} {before}");
        }
    }

    #[test]
    fn outside_of_the_path_nothing_is_learned() {
        let mut feedback = TipFeedback { gate: vec![false; N], ..feedback() };
        for i in 0..N {
            feedback.take_pose(&pose(-1e-3, Quality::Good), i as f64 * PERIOD);
        }
        assert_eq!(feedback.correction, [0.0; 2]);
    }
}
