//! A position servo: what it is told and what it does.
//!
//! Profile generator, PID in the units of its registers, DC motor, gearbox with dry friction, one thermal mass. The speed
//! is found implicitly in every step, so that friction can hold the output exactly still.

use crate::friction::Stribeck;
use hysteron_base::BadInput;
use std::f64::consts::TAU;

/// Ticks of a full turn of the output, of an XL430-W250 (ROBOTIS e-Manual).
pub const TICKS_PER_TURN: f64 = 4096.0;
/// PWM units that stand for the whole supply voltage (e-Manual, "PWM Limit").
pub const PWM_FULL_SCALE: f64 = 885.0;
/// Supply voltage that the catalogue's figures hold for [V].
pub const NOMINAL_VOLTAGE: f64 = 11.1;
/// Register units of the gains (e-Manual, "Position PID Gain"): K_P = P/128, K_I = I/65536, K_D = D/16, in PWM units per
/// tick, per tick and control period, and per tick of change in a control period.
const GAIN_UNITS: [f64; 3] = [128.0, 65536.0, 16.0];
/// Control period of the position loop [s].
const CONTROL_PERIOD: f64 = 1e-3;

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

/// What a servo is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ServoSpec {
    /// Torque that the stalled output gives at [`NOMINAL_VOLTAGE`] [N m].
    pub stall_torque: f64,
    /// Speed of the free output at [`NOMINAL_VOLTAGE`] [rad/s].
    pub no_load_speed: f64,
    /// Current of the stalled motor at [`NOMINAL_VOLTAGE`] [A].
    pub stall_current: f64,
    /// Inertia of motor and gears at the output [kg m²].
    pub inertia: f64,
    /// Friction of motor and gears at the output; its breakaway is what a load must overcome to turn it.
    pub friction: Stribeck,
    /// Error of position that the loop ignores [ticks].
    pub dead_band: f64,
    /// Heat that warms the motor by one kelvin [J/K].
    pub heat_capacity: f64,
    /// Temperature difference per heat flow to the air [K/W].
    pub thermal_resistance: f64,
    /// Temperature of the air [°C].
    pub ambient_temperature: f64,
}

/// A servo: motor, gearbox, controller.
#[derive(Debug, Clone, PartialEq)]
pub struct Servo {
    /// What it is.
    pub spec: ServoSpec,
    /// What it does.
    pub state: ServoState,
    /// Current of the motor [A].
    pub current: f64,
    reference_velocity: f64,
    /// Sum of errors [ticks × control periods].
    integral: f64,
    was_on: bool,
    /// PWM as its load estimate sees it, smoothed [-].
    smooth_pwm: f64,
}

impl ServoSpec {
    /// The same, if every number can be.
    ///
    /// # Errors
    /// `BadInput` naming the first that cannot.
    pub fn checked(self) -> Result<Self, BadInput> {
        let positive = [
            ("stall_torque", self.stall_torque),
            ("no_load_speed", self.no_load_speed),
            ("stall_current", self.stall_current),
            ("inertia", self.inertia),
            ("heat_capacity", self.heat_capacity),
            ("thermal_resistance", self.thermal_resistance),
        ];
        if let Some((name, x)) = positive.into_iter().find(|(_, x)| !(x.is_finite() && *x > 0.0)) {
            return Err(BadInput::new(name, "a finite number > 0", format!("{x:?}")));
        }
        if !(self.dead_band.is_finite() && self.dead_band >= 0.0) {
            return Err(BadInput::new("dead_band", "a finite number >= 0", format!("{:?}", self.dead_band)));
        }
        if self.back_emf() <= 0.0 {
            let expected = "friction at the free speed below the stall torque";
            return Err(BadInput::new("friction", expected, "more"));
        }
        Ok(self)
    }

    /// Electric torque at full nominal voltage and standstill: what the output gives and what dry friction takes [N m].
    fn electric_torque(&self) -> f64 {
        self.stall_torque + self.friction.coulomb
    }

    /// Torque lost per speed by back EMF, so that the free output reaches its speed [N m s/rad].
    fn back_emf(&self) -> f64 {
        let friction = self.friction.torque(self.no_load_speed);
        (self.electric_torque() - friction) / self.no_load_speed
    }

    /// Torque per angle of the position loop with gain `p` at `voltage` [V]: what a load is held against [N m/rad].
    pub fn stiffness(&self, p: u16, voltage: f64) -> f64 {
        let pwm_per_tick = f64::from(p) / GAIN_UNITS[0] / PWM_FULL_SCALE;
        pwm_per_tick * TICKS_PER_TURN / TAU * self.electric_torque() * voltage / NOMINAL_VOLTAGE
    }
}

impl ServoState {
    /// Position as the encoder gives it [ticks].
    pub fn ticks(&self) -> i32 {
        (self.angle / TAU * TICKS_PER_TURN).round() as i32
    }
}

impl Servo {
    /// A servo at rest at `angle` [rad], as warm as the air.
    pub fn new(spec: ServoSpec, angle: f64) -> Self {
        let state = ServoState {
            angle,
            reference: angle,
            voltage: NOMINAL_VOLTAGE,
            temperature: spec.ambient_temperature,
            ..ServoState::default()
        };
        Self {
            spec,
            state,
            current: 0.0,
            reference_velocity: 0.0,
            integral: 0.0,
            was_on: false,
            smooth_pwm: 0.0,
        }
    }

    /// Position as the encoder gives it [ticks].
    pub fn ticks(&self) -> i32 {
        self.state.ticks()
    }

    /// The load it reports: no measurement, but what the motor is given, smoothed, as part of the stall torque and
    /// positive where it drives towards positive ticks [-].
    pub fn load(&self) -> f64 {
        (self.smooth_pwm * self.state.voltage / NOMINAL_VOLTAGE).clamp(-1.0, 1.0)
    }

    /// Lets `h` [s] pass, not more than a control period, under `load` on the output, positive towards positive
    /// angles [N m].
    pub fn step(&mut self, command: &ServoCommand, load: f64, h: f64) {
        self.state.pwm = if command.torque_on { self.control(command, h) } else { 0.0 };
        self.was_on = command.torque_on;
        if !command.torque_on {
            self.state.reference = self.state.angle;
            (self.reference_velocity, self.integral) = (0.0, 0.0);
        }
        self.turn(command.torque_on, load, h);
        self.smooth_pwm += (self.state.pwm - self.smooth_pwm) * (h / 0.02).min(1.0);
    }

    /// Part of the supply voltage that the position loop asks for [-].
    fn control(&mut self, command: &ServoCommand, h: f64) -> f64 {
        if !self.was_on {
            // Torque comes on: the reference starts where the output is.
            self.state.reference = self.state.angle;
        }
        self.follow_profile(command, h);
        let gain = |register: u16, unit: f64| f64::from(register) / unit;
        let exact = self.state.reference / TAU * TICKS_PER_TURN - f64::from(self.ticks());
        let error = if exact.abs() <= self.spec.dead_band { 0.0 } else { exact };
        let periods = h / CONTROL_PERIOD;
        // Speeds instead of differences of ticks: a servo smooths what it differentiates.
        let rate = (self.reference_velocity - self.state.velocity) / TAU * TICKS_PER_TURN * CONTROL_PERIOD;
        let proportional = gain(command.gains.p, GAIN_UNITS[0]) * error;
        let derivative = gain(command.gains.d, GAIN_UNITS[2]) * rate;
        let k_i = gain(command.gains.i, GAIN_UNITS[1]);
        let most = command.pwm_limit.clamp(0.0, 1.0) * PWM_FULL_SCALE;
        self.integral += error * periods;
        if k_i > 0.0 {
            // No more than the motor can be given.
            self.integral = self.integral.clamp(-most / k_i, most / k_i);
        } else {
            self.integral = 0.0;
        }
        (proportional + derivative + k_i * self.integral).clamp(-most, most) / PWM_FULL_SCALE
    }

    /// Moves the reference towards the goal: trapezoidal speed.
    fn follow_profile(&mut self, command: &ServoCommand, h: f64) {
        let goal = f64::from(command.goal) * TAU / TICKS_PER_TURN;
        let way = goal - self.state.reference;
        let (most, acceleration) = (command.profile_velocity, command.profile_acceleration);
        if most <= 0.0 || way == 0.0 && self.reference_velocity == 0.0 {
            (self.state.reference, self.reference_velocity) = (goal, 0.0);
            return;
        }
        let wanted = if acceleration > 0.0 {
            // Fastest speed from which steps of a h still stop at the goal.
            let dv = acceleration * h;
            let stopping = dv * ((0.25 + 2.0 * way.abs() / (dv * h)).sqrt() - 0.5);
            let wanted = stopping.min(most).copysign(way);
            self.reference_velocity + (wanted - self.reference_velocity).clamp(-dv, dv)
        } else {
            most.copysign(way)
        };
        let has_arrived = (wanted * h).abs() >= way.abs() && wanted * way >= 0.0;
        let is_slow = acceleration <= 0.0 || wanted.abs() <= 1.5 * acceleration * h;
        if has_arrived && is_slow {
            (self.state.reference, self.reference_velocity) = (goal, 0.0);
        } else {
            self.reference_velocity = wanted;
            self.state.reference += wanted * h;
        }
    }

    /// Motor, gears, heat.
    fn turn(&mut self, is_driven: bool, load: f64, h: f64) {
        let spec = &self.spec;
        let (before, inertia) = (self.state.velocity, spec.inertia / h);
        // Without drive the motor's terminals are open: no current brakes it.
        let damping = if is_driven { spec.back_emf() } else { 0.0 };
        let torque = self.state.pwm * self.state.voltage / NOMINAL_VOLTAGE * spec.electric_torque();
        let velocity =
            spec.friction.velocity_after(inertia * before + torque + load, inertia + damping, before);
        self.state.velocity = velocity;
        self.state.angle += velocity * h;
        self.current = if is_driven {
            (torque - damping * velocity) / spec.electric_torque() * spec.stall_current
        } else {
            0.0
        };
        let resistance = NOMINAL_VOLTAGE / spec.stall_current;
        let heat = resistance * self.current * self.current
            - (self.state.temperature - spec.ambient_temperature) / spec.thermal_resistance;
        self.state.temperature += heat * h / spec.heat_capacity;
    }
}
