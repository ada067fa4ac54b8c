//! The position loop of a servo, as its registers have it: profile generator and PID, whose outcome is a share of the supply.

use std::f64::consts::TAU;

/// Command of a servo: goal, profile, gains.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ServoCommand {
    /// Whether it drives its motor at all.
    pub torque_on: bool,
    /// Goal position [ticks].
    pub goal: i32,
    /// Largest speed of the profile [rad/s]; 0: none, the reference jumps to the goal.
    pub profile_velocity: f64,
    /// Acceleration of the profile [rad/s²]; 0: none, the reference has its full speed at once.
    pub profile_acceleration: f64,
    /// Gains of the position loop, as the registers state them.
    pub gains: Gains,
    /// Largest part of the supply voltage that the motor is given, 0 to 1 [-].
    pub pwm_limit: f64,
}

impl ServoCommand {
    /// As after power-on: torque off, no profile, the manual's gains.
    pub const POWER_ON: Self = Self {
        torque_on: false,
        goal: 0,
        profile_velocity: 0.0,
        profile_acceleration: 0.0,
        gains: Gains::XL430,
        pwm_limit: 1.0,
    };
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

impl Gains {
    /// Defaults of an XL430-W250 (e-Manual, control table, addresses 80 to 84).
    pub const XL430: Self = Self { p: 640, i: 0, d: 4000 };
}

/// The position loop of a servo: what the numbers in its registers mean, and what it ignores.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LoopSpec {
    /// Ticks of a full turn of the output.
    pub ticks_per_turn: f64,
    /// PWM units of the whole supply voltage.
    pub pwm_full_scale: f64,
    /// Register units of P, I and D that make one PWM unit per tick, per tick and control period, and per tick of change in
    /// a control period.
    pub gains: [f64; 3],
    /// Control period [s].
    pub period: f64,
    /// Error of position that is ignored [ticks].
    pub dead_band: f64,
}

impl LoopSpec {
    /// XL430-W250: K_P = P/128, K_I = I/65536, K_D = D/16 (ROBOTIS e-Manual, "Position PID Gain", "PWM Limit").
    pub const XL430: Self = Self {
        ticks_per_turn: 4096.0,
        pwm_full_scale: 885.0,
        gains: [128.0, 65536.0, 16.0],
        period: 1e-3,
        dead_band: 0.0,
    };

    /// Part of the supply voltage per error of position, with gain `p` as the register has it [1/rad].
    pub fn duty_per_radian(&self, p: f64) -> f64 {
        p / self.gains[0] / self.pwm_full_scale * self.ticks_per_turn / TAU
    }
}

/// The memory of profile generator and PID.
#[derive(Debug, Clone, PartialEq)]
pub struct PositionLoop {
    /// Reference, on its way to the goal [rad].
    pub reference: f64,
    reference_velocity: f64,
    /// Sum of errors [ticks × control periods].
    integral: f64,
    was_on: bool,
}

impl PositionLoop {
    /// At rest at `angle` [rad], torque off.
    pub fn new(angle: f64) -> Self {
        Self { reference: angle, reference_velocity: 0.0, integral: 0.0, was_on: false }
    }

    /// Part of the supply voltage that the motor is given after `h` [s] more, -1 to 1 [-]; zero with the torque off.
    ///
    /// (`angle`, `velocity`) are those of the output [rad, rad/s]. The encoder rounds the angle to ticks.
    pub fn duty(
        &mut self,
        spec: &LoopSpec,
        command: &ServoCommand,
        (angle, velocity): (f64, f64),
        h: f64,
    ) -> f64 {
        if !command.torque_on {
            (self.reference, self.reference_velocity, self.integral) = (angle, 0.0, 0.0);
            self.was_on = false;
            return 0.0;
        }
        if !self.was_on {
            // Torque comes on: the reference starts where the output is.
            self.reference = angle;
        }
        self.was_on = true;
        self.follow_profile(spec, command, h);
        let LoopSpec { ticks_per_turn, pwm_full_scale, gains, period, dead_band } = *spec;
        let gain = |register: u16, unit: f64| f64::from(register) / unit;
        let ticks = (angle / TAU * ticks_per_turn).round();
        let exact = self.reference / TAU * ticks_per_turn - ticks;
        let error = if exact.abs() <= dead_band { 0.0 } else { exact };
        // Speeds instead of differences of ticks: a servo smooths what it differentiates.
        let rate = (self.reference_velocity - velocity) / TAU * ticks_per_turn * period;
        let proportional = gain(command.gains.p, gains[0]) * error;
        let derivative = gain(command.gains.d, gains[2]) * rate;
        let k_i = gain(command.gains.i, gains[1]);
        let most = command.pwm_limit.clamp(0.0, 1.0) * pwm_full_scale;
        self.integral += error * (h / period);
        if k_i > 0.0 {
            // No more than the motor can be given.
            self.integral = self.integral.clamp(-most / k_i, most / k_i);
        } else {
            self.integral = 0.0;
        }
        (proportional + derivative + k_i * self.integral).clamp(-most, most) / pwm_full_scale
    }

    /// Moves the reference towards the goal: trapezoidal speed.
    fn follow_profile(&mut self, spec: &LoopSpec, command: &ServoCommand, h: f64) {
        let goal = f64::from(command.goal) * TAU / spec.ticks_per_turn;
        let way = goal - self.reference;
        let (most, acceleration) = (command.profile_velocity, command.profile_acceleration);
        if most <= 0.0 || way == 0.0 && self.reference_velocity == 0.0 {
            (self.reference, self.reference_velocity) = (goal, 0.0);
            return;
        }
        let target_speed = if acceleration > 0.0 {
            // Fastest speed from which steps of a h still stop at the goal.
            let dv = acceleration * h;
            let stopping = dv * ((0.25 + 2.0 * way.abs() / (dv * h)).sqrt() - 0.5);
            let target_speed = stopping.min(most).copysign(way);
            self.reference_velocity + (target_speed - self.reference_velocity).clamp(-dv, dv)
        } else {
            most.copysign(way)
        };
        let has_arrived = (target_speed * h).abs() >= way.abs() && target_speed * way >= 0.0;
        let is_slow = acceleration <= 0.0 || target_speed.abs() <= 1.5 * acceleration * h;
        if has_arrived && is_slow {
            (self.reference, self.reference_velocity) = (goal, 0.0);
        } else {
            self.reference_velocity = target_speed;
            self.reference += target_speed * h;
        }
    }
}
