//! Whether a pose can be trusted, from the last good one before it; repetitions are evaluated in `repeats.rs`.

use crate::{Pose, Quality};

/// Limits that a working sensor on this robot does not exceed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PoseLimits {
    /// Largest speed of the tip [m/s].
    pub speed: f64,
    /// Largest distance that noise alone puts between two poses [m].
    pub noise: f64,
    /// Corner of the range in the tracker's frame with the smallest coordinates [m]. A pose outside the range is
    /// flagged.
    pub range_min: [f64; 3],
    /// Corner with the largest coordinates [m].
    pub range_max: [f64; 3],
}

impl Default for PoseLimits {
    /// A tip that follows a hand, an electromagnetic tracker at 40 Hz, no limit of the range.
    fn default() -> Self {
        Self { speed: 1.0, noise: 3e-3, range_min: [f64::NEG_INFINITY; 3], range_max: [f64::INFINITY; 3] }
    }
}

/// Watches the poses of one sensor.
#[derive(Debug, Clone)]
pub struct Monitor {
    limits: PoseLimits,
    /// Last pose that was good.
    good: Option<Pose>,
}

impl Monitor {
    /// A watch that has seen nothing.
    pub fn new(limits: PoseLimits) -> Self {
        Self { limits, good: None }
    }

    /// Evaluates the next pose. Its own quality is that given by the tracker.
    ///
    /// A jump is measured from the last good pose, so what was moved by hand is good again after the time that the
    /// tip could have needed.
    pub fn evaluate(&mut self, pose: &Pose) -> Quality {
        let limits = &self.limits;
        let outside =
            (0..3).any(|k| !(limits.range_min[k]..=limits.range_max[k]).contains(&pose.position[k]));
        if pose.quality != Quality::Good || outside {
            return Quality::Flagged;
        }
        if let Some(good) = &self.good {
            let squares = (0..3).map(|k| (pose.position[k] - good.position[k]).powi(2));
            let reach = limits.noise + limits.speed * (pose.time - good.time).max(0.0);
            if squares.sum::<f64>().sqrt() > reach {
                return Quality::Jump;
            }
        }
        self.good = Some(*pose);
        Quality::Good
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pose(time: f64, x: f64) -> Pose {
        Pose { time, position: [x, 0.0, 0.0], orientation: [1.0, 0.0, 0.0, 0.0], quality: Quality::Good }
    }

    #[test]
    fn jump_is_faster_than_the_tip_and_is_forgiven_when_the_tip_could_be_there() {
        let mut monitor = Monitor::new(PoseLimits { speed: 0.5, noise: 1e-3, ..PoseLimits::default() });
        assert_eq!(monitor.evaluate(&pose(0.0, 0.0)), Quality::Good);
        // 0.5 m/s over 25 ms and 1 mm of noise: 13.5 mm.
        assert_eq!(monitor.evaluate(&pose(0.025, 0.0136)), Quality::Jump);
        assert_eq!(monitor.evaluate(&pose(0.025, 0.0134)), Quality::Good);
        let back: Vec<Quality> = (1..=8)
            .map(|k| monitor.evaluate(&pose(0.025 + 0.025 * f64::from(k), 0.1 + 1e-5 * f64::from(k))))
            .collect();
        assert_eq!(back[..6], [Quality::Jump; 6]);
        assert_eq!(back[7], Quality::Good);
    }

    #[test]
    fn flag_and_range_come_first() {
        let limits =
            PoseLimits { range_max: [0.1, 1.0, 1.0], range_min: [-0.1, -1.0, -1.0], ..PoseLimits::default() };
        let mut monitor = Monitor::new(limits);
        assert_eq!(monitor.evaluate(&pose(0.0, 0.11)), Quality::Flagged);
        assert_eq!(monitor.evaluate(&pose(0.1, -0.11)), Quality::Flagged);
        assert_eq!(monitor.evaluate(&Pose { quality: Quality::Flagged, ..pose(0.2, 0.0) }), Quality::Flagged);
        assert_eq!(
            monitor.evaluate(&pose(0.3, 0.1)),
            Quality::Good,
            "a flagged pose is no place to jump from"
        );
    }
}
