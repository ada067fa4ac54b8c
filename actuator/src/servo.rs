//! A position servo: what it is told and what it does.
//!
//! Profile generator, PID in the units of its registers, DC motor, gearbox with dry friction, one thermal mass. The speed
//! is found implicitly in every step, so that friction can hold the output exactly still.

use crate::friction::Stribeck;
use crate::position_loop::{LoopUnits, PositionLoop, ServoCommand};
use hysteron_base::BadInput;
use std::f64::consts::TAU;

/// Ticks of a full turn of the output, of an XL430-W250 (ROBOTIS e-Manual).
pub const TICKS_PER_TURN: f64 = 4096.0;
/// PWM units that stand for the whole supply voltage (e-Manual, "PWM Limit").
pub const PWM_FULL_SCALE: f64 = 885.0;
/// Supply voltage that the catalogue's figures hold for [V].
pub const NOMINAL_VOLTAGE: f64 = 11.1;
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
    position_loop: PositionLoop,
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
        let pwm_per_tick = f64::from(p) / LoopUnits::XL430.gains[0] / PWM_FULL_SCALE;
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
            position_loop: PositionLoop::new(LoopUnits::XL430, angle),
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
        let at = (self.state.angle, self.state.velocity);
        self.state.pwm = self.position_loop.duty(command, self.spec.dead_band, at, h);
        self.state.reference = self.position_loop.reference;
        self.turn(command.torque_on, load, h);
        self.smooth_pwm += (self.state.pwm - self.smooth_pwm) * (h / 0.02).min(1.0);
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
