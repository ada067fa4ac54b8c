//! Whether a plan stays within limits, before the first move.

use super::{Plan, Trajectory};
use crate::{Error, Result};
use hysteron_base::{BadInput, Bounds, Recording};

/// What the strokes of a robot may do.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// Stroke of every tendon [m], positive when pulled.
    pub stroke: Bounds,
    /// Largest change of a stroke per time, in either direction [m/s].
    pub stroke_rate: f64,
}

/// Rounding of a stroke that is typed as its limit [-].
const ROUNDING: f64 = 1e-9;

impl Plan {
    /// Accepts the plan if every sample of every trajectory is within the limits, and every change from one to
    /// the next. The plan's own limits were checked when it was read; these are those of a robot.
    ///
    /// # Errors
    /// `Stroke` or `StrokeRate` naming trajectory, time, tendon, limit and value; the first one found.
    pub fn check(&self, limits: &Limits) -> Result<()> {
        self.trajectories.iter().try_for_each(|trajectory| trajectory.check(limits))
    }
}

impl Trajectory {
    /// See [`Plan::check`].
    ///
    /// # Errors
    /// As there.
    pub fn check(&self, limits: &Limits) -> Result<()> {
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
        limits
            .check_each(&self.commands()?, hints)
            .map_err(|error| error.within(format!("trajectory {}", self.name)))
    }
}

impl Limits {
    /// Accepts commanded strokes, `stroke_1_m`, `stroke_2_m`, .., if every sample is within the limits, and every change
    /// from one to the next.
    ///
    /// # Errors
    /// `Stroke` or `StrokeRate` naming time, tendon, limit and value; the first one found. `BadInput` without a fixed
    /// rate.
    pub fn check_commands(&self, commands: &Recording) -> Result<()> {
        self.check_each(commands, ["a smaller path", "a slower path"])
    }

    fn check_each(&self, commands: &Recording, [smaller, slower]: [&str; 2]) -> Result<()> {
        let Bounds { min, max } = self.stroke;
        let (strokes, time) = (commands.strokes(), commands.time());
        let rate_hz = commands
            .rate_hz()
            .ok_or_else(|| BadInput::new("time_s", "samples at a fixed rate", "uneven steps"))?;
        let largest = strokes.iter().copied().flatten().fold(0.0f64, |max, stroke| max.max(stroke.abs()));
        let air = ROUNDING * largest;
        for i in 0..time.len() {
            for (k, values) in strokes.iter().enumerate() {
                let place = || format!("t = {:.3} s: stroke {}", time[i], k + 1);
                let is_within = min - air <= values[i] && values[i] <= max + air; // false for NaN too
                if !is_within {
                    let expected = format!("{:?} to {:?} mm", 1e3 * min, 1e3 * max);
                    let bad = BadInput::new(place(), expected, format!("{:.3} mm", 1e3 * values[i]));
                    return Err(Error::Stroke(bad.hint(smaller)));
                }
                let rate = (values[i] - values[i.saturating_sub(1)]) * rate_hz;
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
