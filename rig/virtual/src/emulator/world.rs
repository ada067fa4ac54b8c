//! Interface of the world that the emulated servos are attached to.

use crate::virtual_rig::World;
use hysteron_actuator::ServoCommand;
use hysteron_rig::bus::model::{ServoModel, XL430_W250};

/// State of a servo, as it would report it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ServoReadings {
    /// Angle of the output [rad].
    pub angle: f64,
    /// Speed of the output [rad/s].
    pub velocity: f64,
    /// Reference of the position loop, on its way to the goal [rad].
    pub reference: f64,
    /// Part of the supply voltage that the motor is given, -1 to 1 [-].
    pub pwm: f64,
    /// Supply voltage at the servo [V].
    pub voltage: f64,
    /// Temperature [°C].
    pub temperature: f64,
}

/// A world with servos, which advances on command; the emulator gives them registers and a bus.
pub trait ServoWorld: Send + std::fmt::Debug {
    /// Which servos they are.
    fn model(&self) -> &'static ServoModel;
    /// Whether they have profiles, an integral gain and a limit of their PWM. Where they do not, these registers cannot be
    /// changed.
    fn has_full_loop(&self) -> bool;
    /// Seconds since power-on [s].
    fn time(&self) -> f64;
    /// Lets `dt` [s] pass.
    fn advance(&mut self, dt: f64);
    /// Number of servos.
    fn n_servos(&self) -> usize;
    /// Readings of servo `k`.
    fn servo(&self, k: usize) -> ServoReadings;
    /// Load of servo `k`, -1 to 1 of its stall torque, positive towards positive angles [-].
    fn load(&self, k: usize) -> f64;
    /// Effort of the motor of servo `k`, by its model: load [-] or current [A].
    fn effort(&self, k: usize) -> f64;
    /// Sets the command of servo `k`, which holds until the next one.
    fn command(&mut self, k: usize, command: &ServoCommand);
    /// Switches servo `k` off and on again: it forgets its command; its output stays where it was, without torque.
    fn power_cycle(&mut self, k: usize);
    /// Sets the supply voltage [V].
    fn set_supply(&mut self, volts: f64);
    /// Adds a torque against servo `k`: positive towards positive angles [N m].
    fn set_disturbance(&mut self, k: usize, torque: f64);
}

impl ServoWorld for World {
    fn model(&self) -> &'static ServoModel {
        &XL430_W250
    }

    fn has_full_loop(&self) -> bool {
        true
    }

    fn time(&self) -> f64 {
        self.time()
    }

    fn advance(&mut self, dt: f64) {
        self.advance(dt);
    }

    fn n_servos(&self) -> usize {
        self.n_servos()
    }

    fn servo(&self, k: usize) -> ServoReadings {
        let servo = self.servo(k);
        ServoReadings {
            angle: servo.state.angle,
            velocity: servo.state.velocity,
            reference: servo.position_loop.reference,
            pwm: servo.duty,
            voltage: servo.voltage(),
            temperature: servo.state.winding_temperature,
        }
    }

    fn load(&self, k: usize) -> f64 {
        self.load(k)
    }

    fn effort(&self, k: usize) -> f64 {
        self.load(k)
    }

    fn command(&mut self, k: usize, command: &ServoCommand) {
        *self.command_mut(k) = *command;
    }

    fn power_cycle(&mut self, k: usize) {
        self.power_cycle(k);
    }

    fn set_supply(&mut self, volts: f64) {
        self.set_supply(volts);
    }

    fn set_disturbance(&mut self, k: usize, torque: f64) {
        self.set_disturbance(k, torque);
    }
}
