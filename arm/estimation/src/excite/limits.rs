//! Limits that a motion has to stay within.

use hysteron_base::BadInput;

use hysteron_arm_dynamics::{JointKind, Model};

/// Limits that the robot's file lacks, or that are to be smaller.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LimitOptions {
    /// Part of every limit that is used, 0 to 1 [-].
    pub part: f64,
    /// Greatest speed of a joint whose file has none [rad/s or m/s].
    pub speed: Option<f64>,
    /// Greatest acceleration of every joint; files never have one [rad/s² or m/s²].
    pub acceleration: Option<f64>,
}

impl Default for LimitOptions {
    fn default() -> Self {
        Self { part: 0.9, speed: None, acceleration: None }
    }
}

/// Limits of every joint.
#[derive(Debug, Clone, PartialEq)]
pub struct MotionLimits {
    /// Least and greatest coordinate [rad or m].
    pub range: Vec<[f64; 2]>,
    /// Greatest speed [rad/s or m/s].
    pub speed: Vec<f64>,
    /// Greatest acceleration, infinite where there is none [rad/s² or m/s²].
    pub acceleration: Vec<f64>,
    /// Greatest torque or force, infinite where there is none [N m or N].
    pub torque: Vec<f64>,
}

impl MotionLimits {
    /// Those of a robot; a joint that turns for ever gets half a turn to both sides.
    ///
    /// # Errors
    /// `BadInput` for a joint without limit of speed where `options` has none, for one that slides without range, and for a
    /// limit of zero.
    pub fn of(model: &Model, options: LimitOptions) -> Result<Self, BadInput> {
        let part = options.part;
        if !(part > 0.0 && part <= 1.0) {
            return Err(BadInput::new("limits", "a part from 0 to 1", part.to_string()));
        }
        for (name, limit) in [("speed", options.speed), ("acceleration", options.acceleration)] {
            if limit.is_some_and(|limit| !(limit > 0.0 && limit.is_finite())) {
                return Err(BadInput::new(name, "a finite limit > 0", format!("{limit:?}")));
            }
        }
        let mut limits = Self { range: vec![], speed: vec![], acceleration: vec![], torque: vec![] };
        for joint in model.joints() {
            let bad =
                |expected: &str, found: &str| BadInput::new(format!("joint {}", joint.name), expected, found);
            let [low, high] = match (joint.drive.range, joint.kind) {
                (Some([low, high]), _) if low < high => [low, high],
                (Some(_), _) => return Err(bad("a range that is more than a point", "one point")),
                (None, JointKind::Revolute) => [-std::f64::consts::PI, std::f64::consts::PI],
                (None, JointKind::Prismatic) => return Err(bad("a range", "none")),
            };
            let (middle, half) = (0.5 * (low + high), 0.5 * part * (high - low));
            let speed = joint.drive.speed_limit.or(options.speed).filter(|speed| *speed > 0.0);
            let Some(speed) = speed else {
                return Err(bad("a limit of speed > 0", "none")
                    .hint("--speed-limit gives one to joints that have none"));
            };
            let torque = joint.drive.effort_limit.unwrap_or(f64::INFINITY);
            if torque <= 0.0 {
                return Err(bad("a limit of torque > 0, or none", "0"));
            }
            limits.range.push([middle - half, middle + half]);
            limits.speed.push(part * speed);
            limits.acceleration.push(part * options.acceleration.unwrap_or(f64::INFINITY));
            limits.torque.push(part * torque);
        }
        Ok(limits)
    }
}
