//! Safety limits, checked in every cycle.
//!
//! A limit that is passed ends the run. Whether the robot first goes back to rest or the torque goes off at once depends on the
//! limit: with a load, heat or supply out of bounds, moving on is no cure.

use crate::bus::ServoBounds;
use crate::bus::xl430;
use crate::config::SafetyLimits;
use crate::{Pose, ServoSample, SlowSample};

/// How a run ends that cannot continue.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum ShutdownAction {
    /// Slowly back to rest, then `at_end` of the rig file.
    ToRest,
    /// Torque off at once.
    TorqueOff,
}

/// A limit that was passed.
#[derive(Debug, Clone, PartialEq)]
pub struct Violation {
    /// Servo it concerns, counted from 0 in the order of the tendons.
    pub tendon: Option<usize>,
    /// Which limit, what was allowed and what was found.
    pub message: String,
    /// How to end.
    pub shutdown: ShutdownAction,
}

impl std::fmt::Display for Violation {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.tendon {
            Some(k) => write!(f, "tendon {}: {}", k + 1, self.message),
            None => write!(f, "{}", self.message),
        }
    }
}

/// By how much a measured stroke may pass its limit while the command keeps to it [m]: the servo overshoots by a few
/// ticks, and its position is read a cycle late.
const STROKE_MARGIN: f64 = 0.25e-3;
/// By how much a measured rate may pass its limit [-]: one tick more or less in a cycle, and the servo catching up.
const RATE_MARGIN: f64 = 1.0;

impl SafetyLimits {
    /// A command, `dt` [s] after the one before.
    ///
    /// # Errors
    /// The first stroke or rate that is out of bounds.
    pub fn check_command(&self, before: &[f64], strokes: &[f64], dt: f64) -> Result<(), Violation> {
        for (k, (&s, &s0)) in strokes.iter().zip(before).enumerate() {
            let outward = s < self.stroke_min && s < s0 || s > self.stroke_max && s > s0;
            if outward || !s.is_finite() {
                return Err(self.stroke_violation(k, s, "commanded"));
            }
            let rate = (s - s0) / dt;
            // A rounding of the time, not of the command.
            if rate.abs() > self.stroke_rate_max * (1.0 + 1e-6) {
                return Err(self.rate_violation(k, rate, "commanded"));
            }
        }
        Ok(())
    }

    /// Checks the reports of the servos, the strokes of their positions and the commanded strokes [m] against
    /// the limits.
    ///
    /// # Errors
    /// The first that is out of bounds.
    pub fn check_servos(
        &self,
        samples: &[Option<ServoSample>],
        strokes: &[f64],
        commanded: &[f64],
        radii: &[f64],
    ) -> Result<(), Violation> {
        for (k, sample) in samples.iter().enumerate() {
            let Some(sample) = sample else { continue };
            let at_once =
                |message| Violation { tendon: Some(k), message, shutdown: ShutdownAction::TorqueOff };
            if sample.hardware_error != 0 {
                let errors = xl430::describe_errors(sample.hardware_error);
                return Err(at_once(format!("the servo reports {errors}")));
            }
            if !sample.torque_on {
                return Err(at_once("the servo's torque is off; it lost its supply or tripped".into()));
            }
            // A rounding of the unit, not of the load.
            if sample.load.abs() > self.load_max + 0.5 * xl430::LOAD_UNIT {
                return Err(at_once(format!(
                    "load: expected at most {:.0} %, got {:.1} %",
                    100.0 * self.load_max,
                    100.0 * sample.load.abs()
                )));
            }
            let s = strokes[k];
            if s < self.stroke_min - STROKE_MARGIN || s > self.stroke_max + STROKE_MARGIN {
                return Err(self.stroke_violation(k, s, "measured"));
            }
            let lag = commanded[k] - s;
            if lag.abs() > self.lag_max {
                return Err(at_once(format!(
                    "lag: expected the servo within {:.2} mm of its command, got {:.2} mm",
                    1e3 * self.lag_max,
                    1e3 * lag.abs()
                )));
            }
            let rate = sample.velocity * radii[k];
            if rate.abs() > self.stroke_rate_max * (1.0 + RATE_MARGIN) {
                return Err(self.rate_violation(k, rate, "measured"));
            }
        }
        Ok(())
    }

    /// Bounds of each servo.
    pub fn servo_bounds(&self) -> ServoBounds {
        let Self { voltage_min, voltage_max, temperature_max, .. } = *self;
        ServoBounds { voltage_min, voltage_max, temperature_max }
    }

    /// Voltages and temperatures.
    ///
    /// # Errors
    /// The first that is out of bounds.
    pub fn check_slow(&self, samples: &[Option<SlowSample>]) -> Result<(), Violation> {
        for (k, sample) in samples.iter().enumerate() {
            let Some(sample) = sample else { continue };
            let violation = self.servo_bounds().violation(sample.voltage, sample.temperature);
            let Some(message) = violation else { continue };
            return Err(Violation { tendon: Some(k), message, shutdown: ShutdownAction::TorqueOff });
        }
        Ok(())
    }

    /// The tip, in the robot's frame.
    ///
    /// # Errors
    /// The first coordinate out of bounds.
    pub fn check_tip(&self, pose: &Pose) -> Result<(), Violation> {
        for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
            let (low, x, high) = (self.tip_min[axis], pose.position[axis], self.tip_max[axis]);
            if !(low..=high).contains(&x) {
                let message = format!(
                    "tip: expected {name} from {:.1} to {:.1} mm, got {:.2} mm",
                    1e3 * low,
                    1e3 * high,
                    1e3 * x
                );
                return Err(Violation { tendon: None, message, shutdown: ShutdownAction::ToRest });
            }
        }
        Ok(())
    }

    fn stroke_violation(&self, k: usize, stroke: f64, how: &str) -> Violation {
        let message = format!(
            "stroke, {how}: expected {:.2} to {:.2} mm, got {:.3} mm",
            1e3 * self.stroke_min,
            1e3 * self.stroke_max,
            1e3 * stroke
        );
        Violation { tendon: Some(k), message, shutdown: ShutdownAction::ToRest }
    }

    fn rate_violation(&self, k: usize, rate: f64, how: &str) -> Violation {
        let message = format!(
            "stroke rate, {how}: expected at most {:.2} mm/s, got {:.2} mm/s",
            1e3 * self.stroke_rate_max,
            1e3 * rate.abs()
        );
        Violation { tendon: Some(k), message, shutdown: ShutdownAction::ToRest }
    }
}
