//! From a length to a motion along it: at one speed, but for a smooth start and end.

use std::f64::consts::PI;

/// A motion along a length that begins and ends at rest, and that lasts a whole number of samples.
///
/// Its speed rises and falls as half a raised cosine, so that neither speed nor acceleration jumps.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Ramped {
    /// Time to reach the speed, and to lose it [s].
    ramp: f64,
    /// Speed between [m/s]; at most the requested one.
    speed: f64,
    length: f64,
    duration: f64,
}

impl Ramped {
    /// Along `length` [m] at `speed` [m/s], lowered by so much that it ends with a sample.
    /// `length >= speed * ramp`, so that the ramps have room.
    pub(super) fn new(length: f64, speed: f64, ramp: f64, rate_hz: f64) -> Self {
        // Each ramp covers half of what its time would at full speed. A rounding is no further sample.
        let n = ((length / speed + ramp) * rate_hz - 1e-6).ceil();
        let duration = n / rate_hz;
        Self { ramp, speed: length / (duration - ramp), length, duration }
    }

    /// Number of steps from sample to sample.
    pub(super) fn n_steps(&self, rate_hz: f64) -> usize {
        (self.duration * rate_hz).round() as usize
    }

    /// Length covered at time `t` [s] from its beginning [m].
    pub(super) fn at(&self, t: f64) -> f64 {
        let t = t.clamp(0.0, self.duration);
        let left = self.duration - t;
        if t < self.ramp {
            self.begun(t)
        } else if left < self.ramp {
            self.length - self.begun(left)
        } else {
            self.speed * (t - 0.5 * self.ramp)
        }
    }

    /// Integral of the rising speed.
    fn begun(&self, t: f64) -> f64 {
        0.5 * self.speed * (t - self.ramp / PI * (PI * t / self.ramp).sin())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn begins_and_ends_at_rest_and_runs_evenly_between() {
        let motion = Ramped::new(1.0, 0.3, 0.5, 100.0);
        let duration = motion.n_steps(100.0) as f64 / 100.0;
        assert!((duration - (1.0 / 0.3 + 0.5)).abs() <= 0.01);
        assert_eq!((motion.at(0.0), motion.at(duration)), (0.0, 1.0));
        let h = 1e-4;
        let speed = |t: f64| (motion.at(t + h) - motion.at(t - h)) / (2.0 * h);
        for t in [0.6, 1.0, 3.0] {
            assert!((speed(t) - motion.speed).abs() < 1e-9 && motion.speed <= 0.3, "{t}");
        }
        // The largest acceleration of a raised cosine, times the step.
        let change = 0.5 * PI / motion.ramp * motion.speed * h;
        let mut t = -0.1;
        while t < duration + 0.1 {
            assert!((speed(t + h) - speed(t)).abs() <= 1.01 * change, "jump of speed at {t}");
            t += h;
        }
        assert!(speed(1e-3) < 1e-4 && speed(duration - 1e-3) < 1e-4);
    }
}
