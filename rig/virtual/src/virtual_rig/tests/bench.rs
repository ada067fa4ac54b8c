//! A bench for whole virtual rigs: commands by stroke, as a calibrated program would give them.

use super::super::{LoopWidth, VirtualRobot, World, loop_width};
use std::f64::consts::TAU;

/// Time between two commands [s].
pub(super) const PERIOD: f64 = 0.01;

pub(super) struct Bench {
    pub(super) world: World,
    zeros: Vec<i32>,
    arms: Vec<f64>,
}

impl Bench {
    pub(super) fn new(robot: &VirtualRobot, seed: u64) -> Self {
        let mut world = World::new(robot, seed);
        let arms = robot.servos.directions.iter().map(|sign| sign * robot.servos.pulley_radius).collect();
        let zeros = (0..world.n_servos())
            .map(|k| {
                let command = world.command_mut(k);
                command.torque_on = true;
                command.goal
            })
            .collect();
        Self { world, zeros, arms }
    }

    /// Commands strokes [m] and lets a period pass.
    pub(super) fn command(&mut self, strokes: &[f64]) {
        for (k, stroke) in strokes.iter().enumerate() {
            let ticks = (stroke / self.arms[k] * 4096.0 / TAU).round() as i32;
            self.world.command_mut(k).goal = self.zeros[k] + ticks;
        }
        self.world.advance(PERIOD);
    }

    /// Stroke that the encoder of servo `k` shows since power-on [m].
    pub(super) fn present(&self, k: usize) -> f64 {
        let ticks = (self.world.servo(k).state.angle * 4096.0 / TAU).round() - f64::from(self.zeros[k]);
        ticks * TAU / 4096.0 * self.arms[k]
    }

    pub(super) fn tip(&self) -> [f64; 3] {
        self.world.tip().position
    }

    /// Pulls tendon `k` by `stroke` [m] and releases it, its antagonist the other way round; the loop.
    pub(super) fn pull(&mut self, k: usize, stroke: f64, seconds: f64) -> LoopWidth {
        let n = (seconds / PERIOD).round() as usize;
        let (mut strokes, mut tips) = (Vec::new(), Vec::new());
        for i in 0..=n {
            let now = stroke * (1.0 - (2.0 * i as f64 / n as f64 - 1.0).abs());
            let mut all = [0.0; 4];
            (all[k], all[(k + 2) % 4]) = (now, -now);
            self.command(&all);
            strokes.push(self.present(k));
            tips.push(self.tip());
        }
        loop_width(&strokes, &tips).unwrap()
    }

    /// Holds all strokes at zero for a while; where the tip then is.
    pub(super) fn rest(&mut self, seconds: f64) -> [f64; 3] {
        (0..(seconds / PERIOD).round() as usize).for_each(|_| self.command(&[0.0; 4]));
        self.tip()
    }

    /// One circle of strokes of amplitude `stroke` [m] after a ramp and a first one; the tips at 360 angles.
    pub(super) fn circle(&mut self, stroke: f64, seconds: f64) -> Vec<[f64; 3]> {
        let n = (seconds / PERIOD).round() as usize;
        let mut tips = Vec::new();
        for i in 0..=3 * n {
            let angle = TAU * i as f64 / n as f64;
            let now = stroke * (i as f64 / n as f64).min(1.0);
            self.command(&[0, 1, 2, 3].map(|k| now * (angle - f64::from(k) * 0.25 * TAU).cos()));
            if i >= 2 * n {
                tips.push(self.tip());
            }
        }
        (0..360).map(|degree| tips[degree * n / 360]).collect()
    }
}

pub(super) fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>().sqrt()
}
