//! Curves in tendon space, of size 1, run through at constant frequency (CoReAct paper, section V-A c).
//!
//! A point of tendon space is (a, b): a pulls towards 0°, b towards 90°. The size of every curve is the distance
//! of its farthest point from the centre, so that amplitudes of families compare.

use super::Envelope;
use std::f64::consts::{SQRT_2, TAU};

/// Kinds of curves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Family {
    /// A straight line through the centre, run to and fro as a sine.
    Sinusoid,
    /// A circle at constant angular velocity; with its envelope an inward spiral.
    Circle,
    /// A square at constant speed along its perimeter; the size reaches to its corners.
    Square,
    /// An ellipse; the size reaches to the ends of its long axis.
    Ellipse {
        /// Short axis over long axis, in (0, 1] [-].
        aspect: f64,
    },
    /// A rose, whose distance from the centre goes to and fro while it turns: it passes the centre, and everything
    /// around it, in ever new directions.
    Rose {
        /// Swings of the distance in a turn, > 0; the curve closes only where they are a ratio of small integers [-].
        swings: f64,
    },
}

/// Sense of rotation, seen from the tip with 90° to the left of 0°.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Direction {
    /// From 0° to 90°.
    CounterClockwise,
    /// From 90° to 0°.
    Clockwise,
}

/// A curve with its size and timing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CurveMotion {
    /// Which curve.
    pub family: Family,
    /// Size where the envelope is 1 [m], > 0.
    pub amplitude: f64,
    /// Turns per second [Hz], > 0.
    pub frequency: f64,
    /// Where on the curve it begins [rad]; a full turn is the whole curve.
    pub phase: f64,
    /// Direction of the line, of a corner, of the long axis, from 0° on [rad].
    pub orientation: f64,
    /// Sense of rotation.
    pub direction: Direction,
    /// Growth and decay.
    pub envelope: Envelope,
}

impl Family {
    /// Name as in a plan file.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Sinusoid => "sinusoid",
            Self::Circle => "circle",
            Self::Square => "square",
            Self::Ellipse { .. } => "ellipse",
            Self::Rose { .. } => "rose",
        }
    }

    /// Point of the curve of size 1 after `turns` of 1 turn.
    pub fn point(&self, turns: f64) -> [f64; 2] {
        let (sin, cos) = (TAU * turns).sin_cos();
        match self {
            Self::Sinusoid => [sin, 0.0],
            Self::Circle => [cos, sin],
            Self::Ellipse { aspect } => [cos, aspect * sin],
            Self::Rose { swings } => [cos, sin].map(|part| (TAU * swings * turns).cos() * part),
            Self::Square => {
                const CORNERS: [[f64; 2]; 5] = [[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0], [1.0, 0.0]];
                let sides = 4.0 * turns.rem_euclid(1.0);
                let side = (sides as usize).min(3);
                let (from, to, part) = (CORNERS[side], CORNERS[side + 1], sides - side as f64);
                [0, 1].map(|c| from[c] * (1.0 - part) + to[c] * part)
            }
        }
    }

    /// Largest speed along the curve of size 1 [1/turn].
    pub fn speed_bound(&self) -> f64 {
        match self {
            Self::Square => 4.0 * SQRT_2,
            Self::Rose { swings } => TAU * swings.max(1.0),
            Self::Sinusoid | Self::Circle | Self::Ellipse { .. } => TAU,
        }
    }
}

impl CurveMotion {
    /// Point (a, b) of tendon space [m] at time `t` [s] from the beginning of the envelope.
    pub fn position_at(&self, t: f64) -> [f64; 2] {
        self.position_about(self.orientation.sin_cos(), t)
    }

    /// The same for the sine and the cosine of the orientation, which are those of all times.
    pub(super) fn position_about(&self, (sin, cos): (f64, f64), t: f64) -> [f64; 2] {
        let size = self.amplitude * self.envelope.at(t);
        if size == 0.0 {
            return [0.0; 2];
        }
        let turned = match self.direction {
            Direction::CounterClockwise => self.frequency * t,
            Direction::Clockwise => -self.frequency * t,
        };
        let [x, y] = self.family.point(self.phase / TAU + turned);
        [size * (cos * x - sin * y), size * (sin * x + cos * y)]
    }

    /// A speed in tendon space that is never passed [m/s]: growth at full distance plus turning at full size.
    pub fn speed_bound(&self) -> f64 {
        self.amplitude * (self.envelope.rate_bound() + self.frequency * self.family.speed_bound())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FAMILIES: [Family; 5] = [
        Family::Sinusoid,
        Family::Circle,
        Family::Square,
        Family::Ellipse { aspect: 0.4 },
        Family::Rose { swings: 2.0 },
    ];

    fn motion(family: Family) -> CurveMotion {
        let envelope = Envelope { attack: 1.0, sustain: 40.0, decay: 1.0 };
        let direction = Direction::CounterClockwise;
        CurveMotion {
            family,
            amplitude: 2.0,
            frequency: 0.1,
            phase: 0.3,
            orientation: 0.7,
            direction,
            envelope,
        }
    }

    fn length([x, y]: [f64; 2]) -> f64 {
        x.hypot(y)
    }

    #[test]
    fn curves_are_closed_and_of_size_one() {
        for family in FAMILIES {
            let mut largest: f64 = 0.0;
            for k in 0..1000 {
                let turns = f64::from(k) / 1000.0;
                let (here, later) = (family.point(turns), family.point(turns + 3.0));
                assert!(length([here[0] - later[0], here[1] - later[1]]) < 1e-13, "{family:?} {turns}");
                largest = largest.max(length(here));
            }
            assert!((largest - 1.0).abs() < 1e-15, "{family:?} {largest}");
        }
    }

    #[test]
    fn no_curve_is_faster_than_its_bound() {
        let h = 1e-6;
        for family in FAMILIES {
            let speed = |k: i32| {
                let (a, b) = (family.point(f64::from(k) / 999.0), family.point(f64::from(k) / 999.0 + h));
                length([b[0] - a[0], b[1] - a[1]]) / h
            };
            let largest = (0..999).map(speed).fold(0.0, f64::max);
            let bound = family.speed_bound();
            assert!(largest <= bound * (1.0 + 1e-9) && largest > 0.999 * bound, "{family:?} {largest}");
        }
    }

    #[test]
    fn a_square_has_four_corners_and_one_speed() {
        let square = motion(Family::Square);
        let h = 1e-3;
        let velocity = |t: f64| {
            let (a, b) = (square.position_at(t), square.position_at(t + h));
            [(b[0] - a[0]) / h, (b[1] - a[1]) / h]
        };
        // Perimeter of a square whose corners are 2 from the centre, ten times a second less.
        let expected = 0.1 * 4.0 * SQRT_2 * 2.0;
        let mut corners = Vec::new();
        for k in 2000..12000 {
            let t = f64::from(k) * h;
            let (v, w) = (velocity(t), velocity(t + h));
            let is_corner = v[0] * w[0] + v[1] * w[1] < 0.99 * length(v) * length(w);
            if is_corner {
                corners.push(square.position_at(t + h));
            } else {
                assert!((length(v) - expected).abs() < 1e-9, "{t}: {}", length(v));
            }
        }
        // A corner between samples shows in two of them.
        assert!((4..=8).contains(&corners.len()), "{corners:?}");
        for [a, b] in corners {
            assert!((length([a, b]) - 2.0).abs() < 1e-2);
            let quarter = (b.atan2(a) - 0.7).rem_euclid(TAU / 4.0);
            assert!(quarter < 1e-2 || TAU / 4.0 - quarter < 1e-2, "{quarter}");
        }
    }

    #[test]
    fn an_ellipse_has_its_aspect_along_its_orientation() {
        let ellipse = motion(Family::Ellipse { aspect: 0.4 });
        let (sin, cos) = 0.7_f64.sin_cos();
        let (mut along, mut across): (f64, f64) = (0.0, 0.0);
        for k in 200..1300 {
            let [a, b] = ellipse.position_at(f64::from(k) * 0.01);
            along = along.max((cos * a + sin * b).abs());
            across = across.max((cos * b - sin * a).abs());
        }
        assert!((along - 2.0).abs() < 1e-4 && (across / along - 0.4).abs() < 1e-4, "{along} {across}");
    }

    #[test]
    fn a_rose_turns_evenly_while_its_distance_swings() {
        let rose = motion(Family::Rose { swings: 0.6 });
        for k in 200..4000 {
            let t = f64::from(k) * 0.01;
            let turned = 0.3 + TAU * 0.1 * t;
            let (distance, angle) = (2.0 * (0.6 * turned).cos(), 0.7 + turned);
            let [a, b] = rose.position_at(t);
            assert!(length([a - distance * angle.cos(), b - distance * angle.sin()]) < 1e-12, "{t}");
        }
    }

    #[test]
    fn a_sinusoid_stays_on_its_line_and_a_circle_turns_evenly() {
        let (sin, cos) = 0.7_f64.sin_cos();
        let (line, circle) = (motion(Family::Sinusoid), motion(Family::Circle));
        let clockwise = CurveMotion { direction: Direction::Clockwise, ..circle };
        for k in 0..4200 {
            let t = f64::from(k) * 0.01;
            let [a, b] = line.position_at(t);
            assert!((cos * b - sin * a).abs() < 1e-15);
            for (circle, sense) in [(circle, 1.0), (clockwise, -1.0)] {
                let [a, b] = circle.position_at(t);
                let size = 2.0 * circle.envelope.at(t);
                let angle = 0.7 + 0.3 + sense * TAU * 0.1 * t;
                assert!(length([a - size * angle.cos(), b - size * angle.sin()]) < 1e-13, "{t}");
            }
        }
    }
}
