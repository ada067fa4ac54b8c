//! Moves from rest to rest.
//!
//! # Reference
//! Quintic polynomial: Lynch, Park (2017), Modern Robotics, section 9.2. Cycloid (a sinusoidal acceleration): equation (12) of
//! Li et al. (`docs/references.md`), q = q₀ + Δ/T (t − T/2π sin(2πt/T)).

use hysteron_base::BadInput;

use super::{Motion, MotionLimits, torque_use};
use hysteron_arm_dynamics::{Data, Model};

/// How far a move is, over time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MotionLaw {
    /// 10 s³ − 15 s⁴ + 6 s⁵: velocity and acceleration are zero at both ends.
    Quintic,
    /// s − sin(2πs)/2π: the same with a sinusoidal acceleration.
    Cycloid,
}

impl MotionLaw {
    /// Part of the way and its first two derivatives at the part `s` of the time.
    fn at(self, s: f64) -> [f64; 3] {
        match self {
            Self::Quintic => {
                let way = s * s * s * (10.0 + s * (6.0 * s - 15.0));
                [way, 30.0 * s * s * (1.0 - s) * (1.0 - s), 60.0 * s * (1.0 - s) * (1.0 - 2.0 * s)]
            }
            Self::Cycloid => {
                let full = 2.0 * std::f64::consts::PI;
                let (sin, cos) = (full * s).sin_cos();
                [s - sin / full, 1.0 - cos, full * sin]
            }
        }
    }

    /// The greatest first and second derivative.
    fn peaks(self) -> [f64; 2] {
        match self {
            Self::Quintic => [15.0 / 8.0, 10.0 / 3.0_f64.sqrt()],
            Self::Cycloid => [2.0, 2.0 * std::f64::consts::PI],
        }
    }
}

/// A move of all joints, from rest to rest in the same time.
#[derive(Debug, Clone, PartialEq)]
pub struct PointToPoint {
    from: Vec<f64>,
    to: Vec<f64>,
    duration: f64,
    law: MotionLaw,
}

/// Samples on which torques are checked.
const SAMPLES: usize = 400;

impl PointToPoint {
    /// A move from `from` to `to` [rad or m] within limits, in `duration` [s] or as fast as they allow.
    ///
    /// # Errors
    /// `BadInput` for another number of joints, a place outside the ranges, a move that goes nowhere, or a time that breaks a
    /// limit.
    pub fn new(
        model: &Model,
        [from, to]: [&[f64]; 2],
        duration: Option<f64>,
        law: MotionLaw,
        limits: &MotionLimits,
    ) -> Result<Self, BadInput> {
        let n = model.n_joints();
        for (name, place) in [("from", from), ("to", to)] {
            if place.len() != n || place.iter().any(|q| !q.is_finite()) {
                return Err(BadInput::new(name, format!("{n} finite coordinates"), format!("{place:?}")));
            }
            if let Some(k) =
                (0..n).find(|k| !(limits.range[*k][0]..=limits.range[*k][1]).contains(&place[*k]))
            {
                let [low, high] = limits.range[k];
                let expected = format!("{} from {low:.4} to {high:.4}", model.joints()[k].name);
                return Err(BadInput::new(name, expected, place[k].to_string()));
            }
        }
        let [speed, acceleration] = law.peaks();
        let least = (0..n).fold(0.0_f64, |least, k| {
            let way = (to[k] - from[k]).abs();
            least.max(speed * way / limits.speed[k]).max((acceleration * way / limits.acceleration[k]).sqrt())
        });
        if least == 0.0 {
            return Err(BadInput::new("to", "another place than from", "the same"));
        }
        let mut data = Data::new(model, 0.0);
        let mut of = |duration: f64| {
            let motion = Self { from: from.to_vec(), to: to.to_vec(), duration, law };
            let share = torque_use(model, &mut data, &motion, limits, SAMPLES);
            (motion, share)
        };
        let Some(requested) = duration else {
            // Torques fall with time towards those of gravity.
            let mut duration = least;
            for _ in 0..60 {
                match of(duration) {
                    (motion, share) if share <= 1.0 => return Ok(motion),
                    _ => duration *= 1.1,
                }
            }
            return Err(BadInput::new("limits", "torques that hold the arm on its way", "too small ones"));
        };
        // Rounding of what was printed.
        if !(requested >= least * (1.0 - 1e-9) && requested.is_finite()) {
            return Err(BadInput::new(
                "duration",
                format!("at least {least:.4} s, by speeds and accelerations"),
                requested.to_string(),
            ));
        }
        match of(requested) {
            (motion, share) if share <= 1.0 => Ok(motion),
            (_, share) => {
                let found = format!("{:.0} % of a joint's torque", 100.0 * share);
                Err(BadInput::new("duration", "torques within the limits", found).hint("a longer duration"))
            }
        }
    }
}

impl Motion for PointToPoint {
    fn at(&self, joint: usize, t: f64) -> [f64; 3] {
        let (way, span) = (self.to[joint] - self.from[joint], self.duration);
        let [s, ds, dds] = self.law.at(t / span);
        [self.from[joint] + way * s, way * ds / span, way * dds / (span * span)]
    }

    fn duration(&self) -> f64 {
        self.duration
    }
}
