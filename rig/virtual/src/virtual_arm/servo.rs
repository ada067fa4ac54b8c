//! Model of a servo: motor, gear with load-dependent friction, heat, and the position loop of its registers.
//!
//! Written for this arm alone: what estimators know of friction and drives is in `hysteron-actuator`.

use std::f64::consts::TAU;

/// Encoder steps of a turn.
pub const TICKS_PER_TURN: f64 = 4096.0;
/// Register counts of full PWM.
pub const FULL_PWM: f64 = 885.0;
/// Register units of P and D that make one PWM count per tick of error and per tick of change in a control period.
const GAIN_UNITS: [f64; 2] = [128.0, 16.0];
/// Temperature at which torque constant and resistance are as stated [°C].
const REFERENCE_DEGC: f64 = 25.0;

/// A servo with everything that is true of it. SI.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VirtualServo {
    /// Torque per current and back EMF per speed, at the output [N m/A].
    pub torque_constant: f64,
    /// Of winding and bridge [Ω].
    pub resistance: f64,
    /// [A].
    pub current_limit: f64,
    /// Inertia of rotor and gears at the output [kg m²].
    pub armature: f64,
    /// Of the teeth and shafts, at the output [N m/rad].
    pub stiffness: f64,
    /// Of the teeth while they touch [N m s/rad].
    pub damping: f64,
    /// Free way between the flanks, at the output [rad].
    pub backlash: f64,
    /// Dry friction of the output's bearing [N m].
    pub bearing: f64,
    /// Friction of motor and gear.
    pub friction: GearFriction,
    /// Its heat.
    pub heat: WindingHeat,
    /// Registers P and D of the position loop.
    pub gains: [f64; 2],
}

/// Friction of a gear: bam's m6.
///
/// # Reference
/// Duclusaud, Passault, Padois, Ly (2024), Extended friction models for the physics simulation of servo actuators, model M6.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GearFriction {
    /// Without load, at speed [N m].
    pub base: f64,
    /// Additional friction at rest [N m].
    pub stribeck: f64,
    /// Share of the motor's torque, and of the load's [-].
    pub load: [f64; 2],
    /// Additional shares at rest [-].
    pub load_stribeck: [f64; 2],
    /// Of their squares [1/(N m)].
    pub load_squared: [f64; 2],
    /// Speed at which what comes on top at rest is down to 1/e [rad/s].
    pub stribeck_speed: f64,
    /// Exponent of the speed [-].
    pub alpha: f64,
    /// [N m s/rad].
    pub viscous: f64,
}

/// A winding in a case in air.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WindingHeat {
    /// Of the winding [J/K].
    pub winding: f64,
    /// From winding to case [K/W].
    pub to_case: f64,
    /// Of the case [J/K].
    pub case: f64,
    /// From case to air [K/W].
    pub to_air: f64,
    /// Relative rise of resistance per kelvin [1/K].
    pub resistance_slope: f64,
    /// Relative loss of torque constant per kelvin [1/K].
    pub magnet_slope: f64,
}

/// State of a servo's motor and case.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct ServoState {
    /// Angle of the rotor, as the output would have it without backlash [rad].
    pub angle: f64,
    /// [rad/s].
    pub speed: f64,
    /// Share of the supply on the motor, -1 to 1.
    pub duty: f64,
    /// [A].
    pub current: f64,
    /// [°C].
    pub winding: f64,
    /// [°C].
    pub case: f64,
    /// Position error of the control period before [ticks].
    pub error: f64,
}

/// Motor torque as a function of the speed at the end of a step: τ = at_rest − slope · ω [N m].
#[derive(Debug, Clone, Copy)]
pub struct MotorLine {
    /// [N m].
    pub at_rest: f64,
    /// [N m s/rad].
    pub slope: f64,
    /// [N m/A].
    pub torque_constant: f64,
}

impl GearFriction {
    /// Dry friction at `speed` of the rotor, under torque `motor` of the motor and `load` on its other side [N m].
    pub fn dry(&self, speed: f64, motor: f64, load: f64) -> f64 {
        let slow = (-(speed.abs() / self.stribeck_speed).powf(self.alpha)).exp();
        let gear = |[by_motor, by_load]: [f64; 2]| (by_load * load - by_motor * motor).abs();
        let [by_motor, by_load] = self.load_squared;
        self.base
            + gear(self.load)
            + slow * (self.stribeck + gear(self.load_stribeck))
            + by_motor * motor * motor
            + by_load * load * load
    }
}

impl VirtualServo {
    /// At rest at `angle` [rad], winding and case as warm as `temperature` [°C].
    pub fn resting(angle: f64, temperature: f64) -> ServoState {
        ServoState { angle, winding: temperature, case: temperature, ..ServoState::default() }
    }

    /// A period of the position loop: encoder at `angle` of the output, asked for `goal` [rad].
    pub fn control(&self, state: &mut ServoState, goal: f64, angle: f64) {
        let ticks = |x: f64| (x / TAU * TICKS_PER_TURN).round();
        let error = ticks(goal) - ticks(angle);
        let [p, d] = [self.gains[0] / GAIN_UNITS[0], self.gains[1] / GAIN_UNITS[1]];
        let pwm = p * error + d * (error - state.error);
        state.error = error;
        state.duty = pwm.clamp(-FULL_PWM, FULL_PWM).trunc() / FULL_PWM;
    }

    /// Torque-speed line of the motor in a step at `voltage` of the supply [V].
    pub fn motor(&self, state: &ServoState, voltage: f64) -> MotorLine {
        let above = state.winding - REFERENCE_DEGC;
        let k = self.torque_constant * (1.0 - self.heat.magnet_slope * above);
        let resistance = self.resistance * (1.0 + self.heat.resistance_slope * above);
        let stalled = state.duty * voltage / resistance;
        let now = stalled - k / resistance * state.speed;
        if now.abs() > self.current_limit {
            let at_rest = k * self.current_limit.copysign(now);
            return MotorLine { at_rest, slope: 0.0, torque_constant: k };
        }
        MotorLine { at_rest: k * stalled, slope: k * k / resistance, torque_constant: k }
    }

    /// Warms winding and case over `h` [s].
    pub fn warm(&self, state: &mut ServoState, air: f64, h: f64) {
        let heat = &self.heat;
        let resistance = self.resistance * (1.0 + heat.resistance_slope * (state.winding - REFERENCE_DEGC));
        let out = (state.winding - state.case) / heat.to_case;
        let lost = (state.case - air) / heat.to_air;
        state.winding += h * (resistance * state.current * state.current - out) / heat.winding;
        state.case += h * (out - lost) / heat.case;
    }
}

impl MotorLine {
    /// That of a motor whose winding is open.
    pub const OPEN: Self = Self { at_rest: 0.0, slope: 0.0, torque_constant: 1.0 };

    /// Torque [N m] and current [A] at a speed.
    pub fn at(&self, speed: f64) -> (f64, f64) {
        let torque = self.at_rest - self.slope * speed;
        (torque, torque / self.torque_constant)
    }
}

impl GearFriction {
    /// All of it times `factor`.
    pub fn scaled(&self, factor: f64) -> Self {
        let both = |x: [f64; 2]| x.map(|x| factor * x);
        Self {
            base: factor * self.base,
            stribeck: factor * self.stribeck,
            load: both(self.load),
            load_stribeck: both(self.load_stribeck),
            load_squared: both(self.load_squared),
            viscous: factor * self.viscous,
            ..*self
        }
    }
}
