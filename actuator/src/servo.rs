//! A position servo: what it is told and what it does.

/// What a servo is told.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ServoCommand {
    /// Whether it drives its motor at all.
    pub torque_on: bool,
    /// Where to go [ticks].
    pub goal: i32,
    /// Largest speed of the way there [rad/s]; 0: none, the reference jumps to the goal.
    pub profile_velocity: f64,
    /// Acceleration of the way there [rad/s²]; 0: none, the reference has its full speed at once.
    pub profile_acceleration: f64,
    /// Gains of the position loop, as the registers state them.
    pub gains: Gains,
    /// Largest part of the supply voltage that the motor is given, 0 to 1 [-].
    pub pwm_limit: f64,
}

/// Gains of the position loop, as the registers of the servo state them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Gains {
    /// Proportional.
    pub p: u16,
    /// Integral.
    pub i: u16,
    /// Derivative.
    pub d: u16,
}

/// What a servo does, as it would report it.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct ServoState {
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
    /// Temperature of the motor [°C].
    pub temperature: f64,
}
