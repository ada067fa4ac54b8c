//! The size of a motion over time: attack, sustain, decay (CoReAct paper, section V-A c).
//!
//! Attack and decay are halves of a raised cosine, so that the motion begins and ends at zero with zero speed and
//! its speed never jumps.

use std::f64::consts::{FRAC_PI_2, PI};

/// Less than this before its end counts as the end [s]: the last sample is at rest exactly.
const ROUNDING: f64 = 1e-9;

/// Times of an envelope.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Envelope {
    /// Time to grow from 0 to 1 [s], > 0.
    pub attack: f64,
    /// Time at 1 [s], >= 0.
    pub sustain: f64,
    /// Time to shrink from 1 to 0 [s], > 0.
    pub decay: f64,
}

impl Envelope {
    /// Time from 0 to 0 [s].
    pub fn duration(&self) -> f64 {
        self.attack + self.sustain + self.decay
    }

    /// Size at time `t` [s] from its beginning, 0 to 1 [-]; exactly 0 outside.
    pub fn at(&self, t: f64) -> f64 {
        let left = self.duration() - t;
        if t <= 0.0 || left <= ROUNDING { 0.0 } else { rise(t / self.attack).min(rise(left / self.decay)) }
    }

    /// Largest speed of growth or decay [1/s].
    pub fn rate_bound(&self) -> f64 {
        FRAC_PI_2 / self.attack.min(self.decay)
    }
}

/// A smooth step from 0 at `part` = 0 to 1 at `part` = 1, flat at both; its slope is at most π/2.
pub(crate) fn rise(part: f64) -> f64 {
    match part {
        // What the cosine gives there, without it: most samples of a plan are beyond the step.
        _ if part <= 0.0 => 0.0,
        _ if part >= 1.0 => 1.0,
        _ => 0.5 - 0.5 * (PI * part).cos(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ENVELOPE: Envelope = Envelope { attack: 2.0, sustain: 3.0, decay: 4.0 };

    #[test]
    fn begins_and_ends_at_zero_and_is_one_between() {
        for (t, size) in
            [(-1.0, 0.0), (0.0, 0.0), (1.0, 0.5), (2.0, 1.0), (5.0, 1.0), (7.0, 0.5), (9.0, 0.0), (10.0, 0.0)]
        {
            assert!((ENVELOPE.at(t) - size).abs() < 1e-15, "{t}: {}", ENVELOPE.at(t));
        }
        assert_eq!(ENVELOPE.at(9.0 - 1e-10), 0.0);
    }

    #[test]
    fn speed_is_continuous_and_bounded() {
        let h = 1e-4;
        let speed = |t: f64| (ENVELOPE.at(t + h) - ENVELOPE.at(t - h)) / (2.0 * h);
        // Of a raised cosine: half of (π / duration)² is the largest change of speed.
        let acceleration = 0.5 * (PI / ENVELOPE.attack).powi(2);
        let mut t = -1.0;
        let mut largest: f64 = 0.0;
        while t < 10.0 {
            assert!((speed(t + h) - speed(t)).abs() <= 1.01 * acceleration * h, "jump of speed at {t}");
            largest = largest.max(speed(t).abs());
            t += h;
        }
        assert!(largest <= ENVELOPE.rate_bound() && largest > 0.999 * ENVELOPE.rate_bound());
    }
}
