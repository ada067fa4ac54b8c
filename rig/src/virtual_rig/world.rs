//! Servos, tendons, body and tracker of the virtual rig, advanced together.

use crate::Pose;
use hysteron_actuator::{ServoCommand, ServoState};

/// A pose on its way from the tracker to whoever listens.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrackedPose {
    /// What was measured; its time is when, on the world's clock [s].
    pub pose: Pose,
    /// When it leaves the tracker, on the world's clock [s].
    pub sent_at: f64,
}

/// The virtual rig at one moment.
#[derive(Debug, Clone)]
pub struct World {
    time: f64,
    commands: Vec<ServoCommand>,
    servos: Vec<ServoState>,
}

impl World {
    /// `n` servos at rest, at half a turn, with nothing on their pulleys.
    pub fn idle(n: usize) -> Self {
        let angle = std::f64::consts::PI;
        let servo =
            ServoState { angle, reference: angle, voltage: 12.0, temperature: 30.0, ..ServoState::default() };
        let gains = hysteron_actuator::Gains { p: 640, i: 0, d: 4000 };
        let command = ServoCommand {
            torque_on: false,
            goal: 0,
            profile_velocity: 0.0,
            profile_acceleration: 0.0,
            gains,
            pwm_limit: 1.0,
        };
        Self { time: 0.0, commands: vec![command; n], servos: vec![servo; n] }
    }

    /// Seconds since power-on [s].
    pub fn time(&self) -> f64 {
        self.time
    }

    /// Number of servos, one per tendon.
    pub fn n_servos(&self) -> usize {
        self.servos.len()
    }

    /// What servo `k` is told; stays until it is told otherwise.
    pub fn command_mut(&mut self, k: usize) -> &mut ServoCommand {
        &mut self.commands[k]
    }

    /// What servo `k` does.
    pub fn servo(&self, k: usize) -> &ServoState {
        &self.servos[k]
    }

    /// Lets `dt` [s] pass.
    pub fn advance(&mut self, dt: f64) {
        self.time += dt;
        for (servo, command) in self.servos.iter_mut().zip(&self.commands) {
            if command.torque_on {
                servo.reference = f64::from(command.goal) * std::f64::consts::TAU / 4096.0;
                servo.angle += (servo.reference - servo.angle).clamp(-dt, dt);
            }
        }
    }

    /// Load that servo `k` senses, -1 to 1 of its stall torque, positive towards positive ticks [-].
    pub fn load(&self, _k: usize) -> f64 {
        0.0
    }

    /// Appends the poses that the tracker has sent since the last call.
    pub fn take_poses(&mut self, _poses: &mut Vec<TrackedPose>) {}

    /// Switches servo `k` off and on again: it forgets its command; its output stays where it was.
    pub fn power_cycle(&mut self, k: usize) {
        self.commands[k].torque_on = false;
    }

    /// Sets the supply voltage [V].
    pub fn set_supply(&mut self, volts: f64) {
        self.servos.iter_mut().for_each(|servo| servo.voltage = volts);
    }

    /// Adds a torque against servo `k`, as if something held its pulley [N m].
    pub fn set_disturbance(&mut self, _k: usize, _torque: f64) {}
}
