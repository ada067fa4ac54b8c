//! Whether a plan stays within limits, before the first move.

use super::{Plan, Trajectory};
use crate::{Error, Result};
use hysteron_base::{BadInput, Bounds};

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
        let Bounds { min, max } = limits.stroke;
        // Bounds of the whole curve spare the samples.
        let bound = self.stroke_bound();
        if bound <= max && -bound >= min && self.stroke_rate_bound() <= limits.stroke_rate {
            return Ok(());
        }
        let air = ROUNDING * self.stroke_bound();
        let rate_air = ROUNDING * self.stroke_rate_bound();
        let mut before = self.strokes_at(0.0);
        let mut strokes = before.clone();
        for i in 0..self.n_samples() {
            let t = self.time(i);
            self.strokes_into(t, &mut strokes);
            for (k, stroke) in strokes.iter().enumerate() {
                let is_within = min - air <= *stroke && *stroke <= max + air; // false for NaN too
                if !is_within {
                    let expected = format!("{:?} to {:?} mm", 1e3 * min, 1e3 * max);
                    let bad = BadInput::new(self.place(k, t), expected, format!("{:.3} mm", 1e3 * stroke));
                    return Err(Error::Stroke(bad.hint("a smaller amplitude_mm, or scale for all of them")));
                }
                let rate = (stroke - before[k]) * self.rate_hz;
                if rate.abs() > limits.stroke_rate + rate_air {
                    let expected = format!("a change of at most {:?} mm/s", 1e3 * limits.stroke_rate);
                    let found = format!("{:.3} mm/s", 1e3 * rate);
                    let bad = BadInput::new(self.place(k, t), expected, found);
                    return Err(Error::StrokeRate(
                        bad.hint("a smaller amplitude_mm or frequency_hz, or a longer attack_s or decay_s"),
                    ));
                }
            }
            std::mem::swap(&mut before, &mut strokes);
        }
        Ok(())
    }

    fn place(&self, tendon: usize, t: f64) -> String {
        format!("trajectory {}: t = {t:.3} s: stroke {}", self.name, tendon + 1)
    }
}
