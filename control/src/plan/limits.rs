//! Whether a plan stays within limits, before the first move.

use super::trajectory::Sampler;
use super::{MotionPlan, Trajectory};
use crate::{Error, Result};
use hysteron_base::{BadInput, Bounds, Recording};
use std::ops::Range;

/// Limits of a robot's strokes and their rates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StrokeLimits {
    /// Stroke of every tendon [m], positive when pulled.
    pub stroke: Bounds,
    /// Largest change of a stroke per time, in either direction [m/s].
    pub stroke_rate: f64,
}

/// Rounding of a stroke that is typed as its limit [-].
const ROUNDING: f64 = 1e-9;

impl MotionPlan {
    /// Accepts the plan if every sample of every trajectory is within the limits, and every change from one to
    /// the next. The plan's own limits were checked when it was read; these are those of a robot.
    ///
    /// # Errors
    /// `Stroke` or `StrokeRate` naming trajectory, time, tendon, limit and value; the first one found.
    pub fn check(&self, limits: &StrokeLimits) -> Result<()> {
        self.trajectories.iter().try_for_each(|trajectory| trajectory.check(limits))
    }
}

impl MotionPlan {
    /// The largest scale, at most 1, at which every sample is within these limits, one for each tendon, and every change from one to
    /// the next.
    pub fn largest_scale(&self, limits: &[StrokeLimits]) -> f64 {
        self.trajectories.iter().map(|trajectory| trajectory.largest_scale(limits)).fold(1.0, f64::min)
    }
}

impl Trajectory {
    fn largest_scale(&self, limits: &[StrokeLimits]) -> f64 {
        let mut scale: f64 = 1.0;
        let (mut strokes, mut before) = (vec![0.0; self.tendons.angles.len()], Vec::new());
        let sampler = Sampler::new(self);
        for i in 0..self.n_samples() {
            sampler.strokes_into(self.time(i), &mut strokes);
            for (k, (stroke, limits)) in strokes.iter().zip(limits).enumerate() {
                let bound = if *stroke > 0.0 { limits.stroke.max } else { -limits.stroke.min };
                if stroke.abs() * scale > bound {
                    scale = (bound / stroke.abs()).max(0.0);
                }
                let rate = before.get(k).map_or(0.0, |before: &f64| (stroke - before).abs() * self.rate_hz);
                if rate * scale > limits.stroke_rate {
                    scale = limits.stroke_rate / rate;
                }
            }
            before.clone_from(&strokes);
        }
        scale
    }

    /// See [`MotionPlan::check`].
    ///
    /// # Errors
    /// As there.
    pub fn check(&self, limits: &StrokeLimits) -> Result<()> {
        self.check_space()?;
        let Bounds { min, max } = limits.stroke;
        // Bounds of the whole curve spare the samples.
        let bound = self.stroke_bound();
        if bound <= max && -bound >= min && self.stroke_rate_bound() <= limits.stroke_rate {
            return Ok(());
        }
        let hints = [
            "a smaller amplitude_mm, or scale for all of them",
            "a smaller amplitude_mm or frequency_hz, or a longer attack_s or decay_s",
        ];
        let sampler = Sampler::new(self);
        let strokes = |i: usize, strokes: &mut Vec<f64>| {
            strokes.resize(self.tendons.angles.len(), 0.0);
            sampler.strokes_into(self.time(i), strokes);
            self.time(i)
        };
        // Nor are those looked at which the bounds of the time of full size spare, most of them in a long plan.
        let is_slow = bound <= max && -bound >= min && self.sustained_rate_bound() <= limits.stroke_rate;
        let n = self.n_samples();
        let spared = if is_slow { self.sustained() } else { n..n };
        let parts = [0..spared.start.min(n), spared.end.saturating_sub(1)..n];
        parts
            .into_iter()
            .try_for_each(|part| limits.check_each(part, strokes, (bound, self.rate_hz), hints))
            .map_err(|error| error.within(format!("trajectory {}", self.name)))
    }
}

impl StrokeLimits {
    /// Accepts commanded strokes, `stroke_1_m`, `stroke_2_m`, .., if every sample is within the limits, and every
    /// change from one to the next.
    ///
    /// # Errors
    /// `Stroke` or `StrokeRate` naming time, tendon, limit and value; the first one found. `BadInput` without a fixed
    /// rate.
    pub fn check_commands(&self, commands: &Recording) -> Result<()> {
        let (columns, time) = (commands.strokes(), commands.time());
        let rate_hz = commands
            .rate_hz()
            .ok_or_else(|| BadInput::new("time_s", "samples at a fixed rate", "uneven steps"))?;
        let largest = columns.iter().copied().flatten().fold(0.0f64, |max, stroke| max.max(stroke.abs()));
        let strokes = |i: usize, strokes: &mut Vec<f64>| {
            strokes.clear();
            strokes.extend(columns.iter().map(|values| values[i]));
            time[i]
        };
        self.check_each(0..time.len(), strokes, (largest, rate_hz), ["a smaller path", "a slower path"])
    }

    /// Goes through samples: `strokes_into` gives the time of each [s] and its strokes [m]. `largest` bounds their size [m].
    fn check_each(
        &self,
        samples: Range<usize>,
        strokes_into: impl Fn(usize, &mut Vec<f64>) -> f64,
        (largest, rate_hz): (f64, f64),
        [smaller, slower]: [&str; 2],
    ) -> Result<()> {
        let Bounds { min, max } = self.stroke;
        let air = ROUNDING * largest;
        let (mut strokes, mut before) = (Vec::new(), Vec::new());
        for i in samples {
            std::mem::swap(&mut strokes, &mut before);
            let time = strokes_into(i, &mut strokes);
            for (k, stroke) in strokes.iter().enumerate() {
                let place = || format!("t = {time:.3} s: stroke {}", k + 1);
                let is_within = min - air <= *stroke && *stroke <= max + air; // false for NaN too
                if !is_within {
                    let expected = format!("{:?} to {:?} mm", 1e3 * min, 1e3 * max);
                    let bad = BadInput::new(place(), expected, format!("{:.3} mm", 1e3 * stroke));
                    return Err(Error::Stroke(bad.hint(smaller)));
                }
                let rate = before.get(k).map_or(0.0, |before| (stroke - before) * rate_hz);
                if rate.abs() > self.stroke_rate * (1.0 + ROUNDING) {
                    let expected = format!("a change of at most {:?} mm/s", 1e3 * self.stroke_rate);
                    let bad = BadInput::new(place(), expected, format!("{:.3} mm/s", 1e3 * rate));
                    return Err(Error::StrokeRate(bad.hint(slower)));
                }
            }
        }
        Ok(())
    }
}
