//! Where the leader is moved: smooth, with the unsteadiness of a hand, never twice the same.
//!
//! A motion is a list of knots: from one to the next all coordinates follow 10 s³ − 15 s⁴ + 6 s⁵, which begins and ends at rest.
//! A circle is a part of its own. The hand adds slow sinuses to every joint.

use std::f64::consts::TAU;

use nalgebra::Vector3;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::chain::{BodyChain, N_JOINTS};
use super::gripper::VirtualGripper;
use super::world::N_SERVOS;

/// Joint angles [rad], then the aperture [m].
pub type Posture = [f64; N_SERVOS];

/// How the leader is moved.
#[derive(Debug, Clone)]
pub struct VirtualLeader {
    knots: Vec<(f64, Posture)>,
    circle: Option<TipCircle>,
    tremor: [[Sinus; 3]; N_JOINTS],
    kinematics: Kinematics,
}

/// A circle of the tip that begins and ends at rest, in between two knots of the same posture.
#[derive(Debug, Clone, Copy)]
struct TipCircle {
    from: f64,
    until: f64,
    centre: Vector3<f64>,
    radius: f64,
    turns: f64,
    pitch: f64,
}

#[derive(Debug, Clone, Copy)]
struct Sinus {
    amplitude: f64,
    rate: f64,
    phase: f64,
}

/// The arm's geometry in its plane: lengths of upper arm, forearm and hand, and where these begin.
#[derive(Debug, Clone, Copy)]
struct Kinematics {
    axis: f64,
    shoulder: f64,
    upper: f64,
    lean: f64,
    fore: f64,
    hand: f64,
}

/// How near to stretched or folded the arm is moved [m].
const NEAREST: f64 = 1e-6;

/// A smooth step from 0 to 1.
fn eased(s: f64) -> f64 {
    let s = s.clamp(0.0, 1.0);
    s * s * s * (10.0 + s * (6.0 * s - 15.0))
}

impl Kinematics {
    fn of(chain: &BodyChain) -> Self {
        let [base, shoulder, elbow, wrist] = [0, 1, 2, 3].map(|k: usize| chain.links[k].origin);
        Self {
            axis: base.x,
            shoulder: base.z + shoulder.z,
            upper: elbow.x.hypot(elbow.z),
            lean: -elbow.z.atan2(elbow.x),
            fore: wrist.x,
            hand: chain.tip.x,
        }
    }

    /// Angles at which the tip is at `tip` and the hand points `pitch` below the horizontal; the nearest where it is out of reach.
    fn inverse(&self, tip: &Vector3<f64>, pitch: f64) -> [f64; N_JOINTS] {
        let (x, y) = (tip.x - self.axis, tip.y);
        let (out, up) =
            (x.hypot(y) - self.hand * pitch.cos(), tip.z + self.hand * pitch.sin() - self.shoulder);
        let distance =
            out.hypot(up).clamp((self.upper - self.fore).abs() + NEAREST, self.upper + self.fore - NEAREST);
        let cosine = (distance * distance - self.upper * self.upper - self.fore * self.fore)
            / (2.0 * self.upper * self.fore);
        let elbow = cosine.clamp(-1.0, 1.0).acos();
        let upper = (-up).atan2(out) - (self.fore * elbow.sin()).atan2(self.upper + self.fore * elbow.cos());
        let second = upper - self.lean;
        let third = upper + elbow - second;
        [y.atan2(x), second, third, pitch - second - third]
    }
}

impl VirtualLeader {
    /// Of a hand that is not steady, for an arm like `chain`.
    pub fn new(chain: &BodyChain, stream: &mut ChaCha8Rng) -> Self {
        let mut sinus = |k: usize| Sinus {
            amplitude: 0.012 * stream.random_range(0.3..1.0) / (1.0 + k as f64),
            rate: TAU * stream.random_range(0.15..0.4) * (1.0 + k as f64),
            phase: TAU * stream.random_range(0.0..1.0),
        };
        let tremor = std::array::from_fn(|_| std::array::from_fn(&mut sinus));
        Self { knots: Vec::new(), circle: None, tremor, kinematics: Kinematics::of(chain) }
    }

    /// Of a program: without tremor.
    pub fn steady(chain: &BodyChain) -> Self {
        let tremor = [[Sinus { amplitude: 0.0, rate: 0.0, phase: 0.0 }; 3]; N_JOINTS];
        Self { knots: Vec::new(), circle: None, tremor, kinematics: Kinematics::of(chain) }
    }

    /// Starts in a posture, or is in it after `seconds` more.
    pub fn then(&mut self, seconds: f64, posture: Posture) {
        let before = self.knots.last().map_or(0.0, |(time, _)| *time);
        self.knots.push((if self.knots.is_empty() { 0.0 } else { before + seconds }, posture));
    }

    /// Stays for `seconds`.
    pub fn stays(&mut self, seconds: f64) {
        if let Some((_, posture)) = self.knots.last().copied() {
            self.then(seconds, posture);
        }
    }

    /// Moves the tip to `tip` [m] with the hand `pitch` [rad] below the horizontal and the jaws `aperture` [m] open.
    pub fn reaches(&mut self, seconds: f64, tip: Vector3<f64>, pitch: f64, aperture: f64) {
        let [a, b, c, d] = self.kinematics.inverse(&tip, pitch);
        self.then(seconds, [a, b, c, d, aperture]);
    }

    /// Turns `turns` circles of `radius` [m] in the vertical plane across the arm, counterclockwise as seen from the arm, for
    /// `seconds`; starts where it is, at the highest point.
    pub fn circles(&mut self, seconds: f64, tip: Vector3<f64>, pitch: f64, radius: f64, turns: f64) {
        let from = self.knots.last().map_or(0.0, |(time, _)| *time);
        let centre = tip - Vector3::z() * radius;
        self.circle = Some(TipCircle { from, until: from + seconds, centre, radius, turns, pitch });
        self.stays(seconds);
    }

    /// When the motion is over [s].
    pub fn end(&self) -> f64 {
        self.knots.last().map_or(0.0, |(time, _)| *time)
    }

    /// Where the leader is at `time` [s].
    pub fn at(&self, time: f64) -> Posture {
        let mut posture = self.smooth(time);
        for (angle, sinuses) in posture.iter_mut().zip(&self.tremor) {
            // No hand moves it before the start.
            let grown = eased(time / 1.5);
            *angle +=
                grown * sinuses.iter().map(|s| s.amplitude * (s.rate * time + s.phase).sin()).sum::<f64>();
        }
        posture
    }

    fn smooth(&self, time: f64) -> Posture {
        let next = self.knots.partition_point(|(at, _)| *at <= time).clamp(1, self.knots.len() - 1);
        let ((from, a), (until, b)) = (self.knots[next - 1], self.knots[next]);
        if let Some(circle) = self.circle.filter(|circle| (circle.from..circle.until).contains(&time)) {
            let share = (time - circle.from) / (circle.until - circle.from);
            // Starts and ends at rest: eased at the ends, even in between.
            let edge = 0.1;
            let even = |s: f64| {
                if s < edge {
                    0.5 * s * s / edge
                } else if s > 1.0 - edge {
                    1.0 - edge - 0.5 * (1.0 - s) * (1.0 - s) / edge
                } else {
                    s - 0.5 * edge
                }
            };
            let angle = TAU * circle.turns * even(share) / even(1.0);
            let around = Vector3::new(0.0, -angle.sin(), angle.cos()) * circle.radius;
            let [q1, q2, q3, q4] = self.kinematics.inverse(&(circle.centre + around), circle.pitch);
            return [q1, q2, q3, q4, a[N_JOINTS]];
        }
        let share = eased((time - from) / (until - from).max(1e-9));
        std::array::from_fn(|k| a[k] + share * (b[k] - a[k]))
    }

    /// Goals of the servos in a posture [rad].
    pub fn goals(posture: &Posture, gripper: &VirtualGripper) -> [f64; N_SERVOS] {
        let mut goals = *posture;
        goals[N_JOINTS] = gripper.angle(posture[N_JOINTS]);
        goals
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)] // a test may stop where it stands
mod tests {
    use super::*;
    use crate::virtual_arm::VirtualArm;

    #[test]
    fn the_tip_is_where_the_inverse_wants_it() {
        let chain = VirtualArm::preset("open-manipulator-x").unwrap().chain;
        let kinematics = Kinematics::of(&chain);
        for (x, y, z, pitch) in [(0.22, 0.05, 0.1, 0.3), (0.15, -0.1, 0.05, 1.2), (0.25, 0.0, 0.2, -0.2)] {
            let goal = Vector3::new(x, y, z);
            let q = kinematics.inverse(&goal, pitch);
            let found = chain.at(&q, &[0.0; N_JOINTS]).tip;
            assert!((found - goal).norm() < 1e-12, "{found} {goal}");
            assert!((q[1] + q[2] + q[3] - pitch).abs() < 1e-12);
        }
    }
}
