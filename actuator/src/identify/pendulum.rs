//! A servo that swings a weight: the test bench of bam, and its simulation.

use std::f64::consts::TAU;

use hysteron_base::BadInput;

use crate::position_loop::LoopSpec;
use crate::{Bridge, Drive, DriveLoad, DriveState};

/// Standard gravity [m/s²].
const GRAVITY: f64 = 9.80665;

/// A weight on a rod on a servo.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pendulum {
    /// Weight [kg].
    pub mass: f64,
    /// Distance from the axis [m].
    pub length: f64,
    /// Reading of the servo where the weight hangs straight down, with the sign reversed [rad].
    pub offset: f64,
}

impl Pendulum {
    /// Inertia and torque of the weight on the output at `angle` [rad].
    pub fn load(&self, angle: f64) -> DriveLoad {
        let weight = self.mass * GRAVITY * self.length;
        DriveLoad {
            inertia: self.mass * self.length * self.length,
            torque: -weight * (angle + self.offset).sin(),
        }
    }
}

/// A recorded motion of a servo with a pendulum.
#[derive(Debug, Clone, PartialEq)]
pub struct PendulumRun {
    /// Where it comes from, for messages.
    pub name: String,
    /// Ascending [s].
    pub time: Vec<f64>,
    /// Commanded at that time, held until the next [rad].
    pub goal: Vec<f64>,
    /// Measured [rad].
    pub position: Vec<f64>,
    /// Whether the motor was driven.
    pub torque_on: Vec<bool>,
    /// Measured at the start [°C].
    pub temperature: f64,
    /// Proportional gain as the register has it; I and D are zero.
    pub gain: f64,
    /// The weight without the offset, which is the drive's to find.
    pub pendulum: Pendulum,
}

impl PendulumRun {
    /// The same, if it can be simulated and carries information.
    ///
    /// # Errors
    /// `BadInput` naming what is wrong: lengths that differ, numbers that are not finite, time out of order, positions that never change.
    pub fn checked(self) -> Result<Self, BadInput> {
        let n = self.time.len();
        let refuse = |what: &str, expected: &str, found: String| {
            Err(BadInput::new(format!("{}: {what}", self.name), expected, found))
        };
        if [self.goal.len(), self.position.len(), self.torque_on.len()] != [n; 3] || n < 10 {
            return refuse("samples", "10 or more, as many of each channel", n.to_string());
        }
        for (what, values) in [("time", &self.time), ("goal", &self.goal), ("position", &self.position)] {
            if let Some(k) = values.iter().position(|value| !value.is_finite()) {
                return refuse(what, "finite numbers", format!("{} in sample {}", values[k], k + 1));
            }
        }
        if let Some(k) = self.time.windows(2).position(|pair| pair[1] <= pair[0]) {
            return refuse("time", "ascending", format!("{} after {}", self.time[k + 1], self.time[k]));
        }
        let (low, high) = self.position.iter().fold((f64::MAX, f64::MIN), |(a, b), x| (a.min(*x), b.max(*x)));
        if high <= low + 0.02 {
            let hint = "record a motion of at least some tens of degrees";
            let refused =
                BadInput::new(format!("{}: position", self.name), "a motion", format!("{low} to {high} rad"));
            return Err(refused.hint(hint));
        }
        Ok(self)
    }
}

/// Simulated motion of a drive.
#[derive(Debug, Clone, PartialEq)]
pub struct PendulumRollout {
    /// Position at every recorded time [rad].
    pub position: Vec<f64>,
    /// Current [A].
    pub current: Vec<f64>,
    /// Temperature of the winding at the end [°C].
    pub winding_temperature: f64,
}

/// Simulates `run` open loop from its first position at rest: goals alone are given, no measurement corrects it.
///
/// The loop's proportional gain acts on exact angles, not on whole ticks, so that the motion is a smooth function of the drive's numbers.
pub fn rollout(drive: &Drive, offset: f64, run: &PendulumRun, longest_step: f64) -> PendulumRollout {
    let pendulum = Pendulum { offset, ..run.pendulum };
    let mut state = DriveState::resting(run.position[0], run.temperature);
    let LoopSpec { ticks_per_turn, pwm_full_scale, gains, .. } = drive.position_loop;
    let duty_per_radian = run.gain / gains[0] * ticks_per_turn / TAU / pwm_full_scale;
    let (mut position, mut current) = (vec![state.angle], vec![0.0]);
    for (k, pair) in run.time.windows(2).enumerate() {
        let n = ((pair[1] - pair[0]) / longest_step).ceil().max(1.0);
        let h = (pair[1] - pair[0]) / n;
        for _ in 0..n as usize {
            let bridge = match run.torque_on[k] {
                true => Bridge::Driven((duty_per_radian * (run.goal[k] - state.angle)).clamp(-1.0, 1.0)),
                false => Bridge::Open,
            };
            let load = pendulum.load(state.angle);
            drive.step(&mut state, bridge, load, h);
        }
        position.push(state.angle);
        current.push(state.current);
    }
    PendulumRollout { position, current, winding_temperature: state.winding_temperature }
}
