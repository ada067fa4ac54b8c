//! The procedure of `hysteron rig calibrate`.
//!
//! A tendon is pulled slowly from slack; its load stays flat, then rises. The corner of that line is where the slack
//! ends, its slope the stiffness that the servo feels, and the zero lies where the line reaches the pretension. It is
//! found twice, the second time with all other tendons already at their pretension, and always by winding, so that
//! friction shifts every tendon alike. Then each tendon pulls the tip a little, and the directions in which the tip
//! goes turn the tracker's frame into the robot's.

use super::{RigCalibration, provisional};
use crate::config::RigConfig;
use crate::session::{RigSession, Stop};
use crate::tracker::{PulledMotion, Registration};
use crate::{Error, Hardware, Quality, Result};
use hysteron_base::BadInput;

/// Cycles per second of the procedure [Hz].
const RATE: f64 = 50.0;
/// Speed of winding in search of the slack's end, of the rig file's slew [-].
const SEARCH_SPEED: f64 = 0.5;
/// Loads that are averaged against noise.
const SMOOTH: usize = 10;
/// How far a tendon is let out again below the end of its slack [m].
const BACK_OFF: f64 = 1e-3;
/// How far it moves before its load is used [m].
const RUN_UP: f64 = 0.2e-3;
/// How long the tip is left alone, and then how long it is measured [s].
const REST: f64 = 1.0;
/// Load with which no tendon is let out [-]: the friction of a servo takes a few hundredths.
const WRONG_WAY: f64 = 0.2;
/// Least motion of the tip when a tendon is pulled by 1 [-].
const MIN_MOTION: f64 = 0.1;
/// A corner explains this part of what a level line leaves of the loads, or there is none [-].
const CORNER: f64 = 0.5;

/// Calibrates a rig; `say` prints the progress.
///
/// # Errors
/// `Bus` if servos do not answer, or a tendon's load does not rise; `BadInput` if the tip's motions do not fit the
/// tendons' angles; a limit that is passed. The torque is off at the end, in every case.
pub fn calibrate(
    hardware: &mut dyn Hardware,
    rig: &RigConfig,
    date: String,
    stop_requested: &dyn Fn() -> bool,
    say: &mut dyn FnMut(&str),
) -> Result<RigCalibration> {
    let servos = hardware.prepare()?;
    let positions: Vec<i32> = servos.iter().map(|servo| servo.position).collect();
    let mut found = provisional(rig, &positions);
    for (channel, servo) in found.channels.iter_mut().zip(&servos) {
        channel.model = servo.model;
    }
    if servos.iter().all(|servo| !servo.registers.is_empty()) {
        found.registers = servos.iter().map(|servo| servo.registers.clone()).collect();
    }
    found.date = date;
    // Before there is a zero, strokes count from the present positions of the servos.
    let mut wide = rig.clone();
    wide.limits.stroke_min = -2.0 * rig.calibration.search_max;
    wide.limits.stroke_max = 2.0 * rig.calibration.search_max;
    let session = RigSession::start(hardware, &wide, &found, RATE)?;
    let mut search = CalibrationRun { session, rig, stop_requested, at: vec![0.0; positions.len()] };
    let done = search.run(&mut found, say);
    done.map_err(|stop| match stop {
        Stop::Failed(error) => error,
        Stop::Limit(violation) => Error::Limit(violation.to_string()),
        Stop::Asked => Error::Interrupted("the calibration was complete"),
    })?;
    Ok(found)
}

type Moved<T> = std::result::Result<T, Stop>;

/// A calibration under way.
struct CalibrationRun<'a> {
    session: RigSession<'a>,
    rig: &'a RigConfig,
    stop_requested: &'a dyn Fn() -> bool,
    /// Strokes commanded, from the first positions of the servos (n) [m].
    at: Vec<f64>,
}

impl CalibrationRun<'_> {
    fn run(&mut self, found: &mut RigCalibration, say: &mut dyn FnMut(&str)) -> Moved<()> {
        let n = self.at.len();
        let mut corners = vec![(0.0, 0.0); n];
        for pass in ["slack", "zero"] {
            for k in 0..n {
                let corner = self.corner(k)?;
                corners[k] = (corner.stroke, self.rig.calibration.pretension_load / corner.slope);
                say(&format!(
                    "tendon {}: {pass} found at {:.2} mm, {:.1} % of load per mm",
                    k + 1,
                    1e3 * corner.stroke,
                    1e-1 * corner.slope
                ));
                // In the second pass each goes back to its pretension, and the next is found with it there.
                let stroke =
                    if pass == "slack" { corners[k].0 - BACK_OFF } else { corners[k].0 + corners[k].1 };
                self.go(k, stroke)?;
            }
            if pass == "slack" {
                for k in 0..n {
                    self.go(k, corners[k].0 + corners[k].1)?;
                }
            }
        }
        for ((channel, now), (corner, beyond)) in
            found.channels.iter_mut().zip(&self.session.calibration.channels).zip(&corners)
        {
            channel.zero = now.ticks(corner + beyond);
            channel.slack_end = -beyond;
        }
        if let Some(missed) = self.session.stats().missed_cycles() {
            say(&missed);
        }
        if self.rig.tracker.is_some() {
            let (registration, residual) = self.register(say)?;
            found.registration = Some(registration);
            found.registration_residual = residual;
        }
        Ok(())
    }

    /// Brings tendon `k` to a stroke.
    fn go(&mut self, k: usize, stroke: f64) -> Moved<()> {
        self.at[k] = stroke;
        let target = self.at.clone();
        self.session.slew(&target, 0.0, self.stop_requested)
    }

    /// Lets tendon `k` out until it is slack, winds it up again and finds the corner in its load.
    fn corner(&mut self, k: usize) -> Moved<Corner> {
        let settings = &self.rig.calibration;
        let step = SEARCH_SPEED * self.rig.motion.slew / RATE;
        let start = self.at[k];
        // Out, for as long as the load keeps falling.
        let mut loads = Vec::new();
        loop {
            loads.push(self.step(k, -step)?);
            let n = loads.len();
            if n >= 3 * SMOOTH
                && mean(&loads[n - SMOOTH..])
                    > mean(&loads[n - 3 * SMOOTH..n - 2 * SMOOTH]) - 0.1 * settings.slack_load
            {
                break;
            }
            // A tendon that is pulled by what should release it pulls the servo the other way.
            let is_reversed = n >= SMOOTH && mean(&loads[n - SMOOTH..]) < -WRONG_WAY;
            if is_reversed || start - self.at[k] > settings.search_max {
                return Err(self.no_corner(k, "fall", start - self.at[k]));
            }
        }
        self.go(k, self.at[k] - BACK_OFF)?;
        // In, until it has risen well above the slack's level.
        let (mut strokes, mut loads) = (Vec::new(), Vec::new());
        let (start, measured_start) = (self.at[k], self.session.strokes()[k]);
        loop {
            let load = self.step(k, step)?;
            let stroke = self.session.strokes()[k];
            // Before it moves, the load is that of a servo which overcomes its own friction.
            if stroke - measured_start > RUN_UP {
                strokes.push(stroke);
                loads.push(load);
            }
            let n = loads.len();
            if n >= 2 * SMOOTH && mean(&loads[n - SMOOTH..]) - mean(&loads[..SMOOTH]) > settings.slack_load {
                break;
            }
            if self.at[k] - start > settings.search_max {
                return Err(self.no_corner(k, "rise", self.at[k] - start));
            }
        }
        Corner::fit(&strokes, &loads).ok_or_else(|| self.no_corner(k, "rise in a corner", self.at[k] - start))
    }

    /// One cycle with tendon `k` moved by `step`; its load in the direction of winding [-].
    fn step(&mut self, k: usize, step: f64) -> Moved<f64> {
        let stroke = self.at[k] + step;
        self.go(k, stroke)?;
        let sample = self.session.samples()[k];
        Ok(sample.map_or(0.0, |sample| self.rig.tendons[k].winds.sign() * sample.load))
    }

    fn no_corner(&self, k: usize, what: &str, over: f64) -> Stop {
        Stop::Failed(Error::Bus(format!(
            "tendon {}: expected its load to {what} within {:.0} mm (search_max_mm), got none over {:.1} mm (hint: is it \
             threaded and tied? is its direction right, tendon[{}].winds? if it hangs looser, wind it up by hand)",
            k + 1,
            1e3 * self.rig.calibration.search_max,
            1e3 * over,
            k + 1
        )))
    }

    /// Pulls every tendon in turn and turns the tracker's frame into the robot's.
    fn register(&mut self, say: &mut dyn FnMut(&str)) -> Moved<(Registration, f64)> {
        let zero = self.at.clone();
        let angles: Vec<f64> = self.rig.tendons.iter().map(|tendon| tendon.angle).collect();
        let n = angles.len();
        let mut rest = self.tip()?;
        let first_rest = rest;
        let mut moved = Vec::with_capacity(n);
        for k in 0..n {
            for j in 0..n {
                self.at[j] = zero[j] + self.rig.calibration.probe * (angles[j] - angles[k]).cos();
            }
            let pulled = self.tip()?;
            self.at.copy_from_slice(&zero);
            let back = self.tip()?;
            // Friction keeps the tip from coming back all the way; half of what is left belongs to either side.
            moved.push([0, 1, 2].map(|i| pulled[i] - 0.5 * (rest[i] + back[i])));
            rest = back;
        }
        check_motion(&moved, self.rig.calibration.probe)?;
        let motions = PulledMotion::of_tendons(&moved, &angles);
        let tip_rest = self.rig.tracker.as_ref().map_or([0.0; 3], |tracker| tracker.tip_rest);
        let found = Registration::from_motions(&motions, first_rest, tip_rest).map_err(Error::from)?;
        say(&format!("tracker registered, {:.2} deg left", found.1.to_degrees()));
        Ok(found)
    }

    /// Goes to the present strokes and measures where the tip comes to rest, in the tracker's frame [m].
    fn tip(&mut self) -> Moved<[f64; 3]> {
        let target = self.at.clone();
        self.session.slew(&target, REST, self.stop_requested)?;
        let (mut sum, mut n) = ([0.0; 3], 0);
        self.session.slew_with(&target, REST, self.stop_requested, &mut |session| {
            for pose in session.poses().iter().filter(|pose| pose.quality == Quality::Good) {
                (0..3).for_each(|i| sum[i] += pose.position[i]);
                n += 1;
            }
        })?;
        if n == 0 {
            let hint = "is its address right, and its device's name?";
            return Err(Error::Tracker(format!("no pose in {REST} s (hint: {hint})")).into());
        }
        Ok(sum.map(|x| x / f64::from(n)))
    }
}

/// Refuses motions of the tip that no pull can have had: the tip of a bent body moves further than its tendon.
fn check_motion(moved: &[[f64; 3]], probe: f64) -> Moved<()> {
    let length = |motion: &[f64; 3]| motion.iter().map(|x| x * x).sum::<f64>().sqrt();
    let furthest = moved.iter().map(length).fold(0.0, f64::max);
    if furthest >= MIN_MOTION * probe {
        return Ok(());
    }
    let expected =
        format!("{:.2} mm at least for tendons pulled by {:.1} mm", 1e3 * MIN_MOTION * probe, 1e3 * probe);
    let found = format!("{:.4} mm at most", 1e3 * furthest);
    let hint = "does the tracker send metres instead of millimetres? is the sensor at the tip? `hysteron rig check` looks at the \
                tracker";
    Err(BadInput::new("motion of the tip, by the tracker", expected, found).hint(hint).into())
}

impl From<BadInput> for Stop {
    fn from(bad: BadInput) -> Self {
        Self::Failed(bad.into())
    }
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// A level line that turns into a rising one.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Corner {
    /// Where it turns [m].
    stroke: f64,
    /// How it rises [1/m].
    slope: f64,
}

impl Corner {
    /// The least-squares fit of load = a + b max(0, stroke - corner), over all corners between samples; `None` if it
    /// explains the loads little better than a level line.
    fn fit(strokes: &[f64], loads: &[f64]) -> Option<Self> {
        let n = strokes.len() as f64;
        let load_mean = mean(loads);
        let level: f64 = loads.iter().map(|load| (load - load_mean).powi(2)).sum();
        let mut best = (CORNER * level, None);
        for &corner in strokes {
            let beyond = |s: f64| (s - corner).max(0.0);
            let beyond_mean = strokes.iter().map(|s| beyond(*s)).sum::<f64>() / n;
            let (mut covariance, mut variance) = (0.0, 0.0);
            for (s, load) in strokes.iter().zip(loads) {
                covariance += (beyond(*s) - beyond_mean) * (load - load_mean);
                variance += (beyond(*s) - beyond_mean).powi(2);
            }
            let slope = covariance / variance;
            let left = level - slope * covariance;
            if slope > 0.0 && left < best.0 {
                best = (left, Some(Self { stroke: corner, slope }));
            }
        }
        best.1
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)] // a test may stop where it stands
    use super::*;

    #[test]
    fn the_corner_of_a_bent_line_is_found() {
        let strokes: Vec<f64> = (0..100).map(|i| 1e-4 * f64::from(i)).collect();
        let loads: Vec<f64> = strokes.iter().map(|s| 0.02 + 30.0 * (s - 0.0061).max(0.0)).collect();
        let corner = Corner::fit(&strokes, &loads).unwrap();
        assert!((corner.stroke - 0.0061).abs() < 1e-12 && (corner.slope - 30.0).abs() < 1e-9, "{corner:?}");
    }

    #[test]
    fn a_level_or_falling_line_has_no_corner() {
        let strokes: Vec<f64> = (0..100).map(|i| 1e-4 * f64::from(i)).collect();
        let noise: Vec<f64> = (0..100).map(|i| 1e-3 * f64::from(i % 7)).collect();
        assert_eq!(Corner::fit(&strokes, &noise), None);
        let falling: Vec<f64> = strokes.iter().map(|s| -s).collect();
        assert_eq!(Corner::fit(&strokes, &falling), None);
    }
}
