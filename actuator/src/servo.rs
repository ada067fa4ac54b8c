//! A position servo: a drive with the memory of its position loop, and what it reports.

use crate::drive::{Drive, DriveLoad, DriveState, Gear};
use crate::friction::Stribeck;
use crate::law::{Law, SymmetricStribeck};
use crate::motor::{Bridge, Motor, Supply, Winding};
use crate::position_loop::{LoopSpec, PositionLoop, ServoCommand};
use hysteron_base::BadInput;
use std::f64::consts::TAU;

/// Ticks of a full turn of the output, of an XL430-W250 (ROBOTIS e-Manual).
pub const TICKS_PER_TURN: f64 = LoopSpec::XL430.ticks_per_turn;
/// Supply voltage that the catalogue's figures hold for [V].
pub const NOMINAL_VOLTAGE: f64 = 11.1;
/// Time over which a servo smooths the load that it reports [s].
const LOAD_TIME: f64 = 0.02;

/// A servo like the XL430-W250 by the figures of a catalogue: a preset of [`Drive`].
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
        if !self.ambient_temperature.is_finite() {
            let found = format!("{:?}", self.ambient_temperature);
            return Err(BadInput::new("ambient_temperature", "a finite number", found));
        }
        let friction = self.friction;
        let of_friction =
            [friction.coulomb, friction.breakaway, friction.stribeck_velocity, friction.viscous];
        if let Some(bad) = of_friction.into_iter().find(|x| !x.is_finite()) {
            return Err(BadInput::new("friction", "finite numbers", format!("{bad:?}")));
        }
        if self.back_emf_damping() <= 0.0 {
            let expected = "friction at the free speed below the stall torque";
            return Err(BadInput::new("friction", expected, "more"));
        }
        Ok(self)
    }

    /// The drive on a supply of [`NOMINAL_VOLTAGE`] that does not sag.
    ///
    /// A catalogue's stall torque is what friction leaves of the motor's, and its free speed is reached in spite of friction. The one
    /// thermal mass keeps resistance and magnet as they are.
    pub fn drive(&self) -> Drive {
        Drive {
            motor: Motor {
                rated_voltage: NOMINAL_VOLTAGE,
                stall_torque: self.motor_torque(),
                stall_current: self.stall_current,
                back_emf_damping: self.back_emf_damping(),
                current_limit: f64::INFINITY,
            },
            supply: Supply { voltage: NOMINAL_VOLTAGE, resistance: 0.0 },
            winding: Winding {
                heat_capacity: self.heat_capacity,
                to_case: self.thermal_resistance,
                resistance_slope: 0.0,
                air: self.ambient_temperature,
                ..Winding::COLD
            },
            gear: Gear {
                armature: self.inertia,
                backlash: 0.0,
                law: Law::Stribeck(SymmetricStribeck),
                friction: self.friction.parameters().to_vec(),
            },
            position_loop: LoopSpec { dead_band: self.dead_band, ..LoopSpec::XL430 },
        }
    }

    /// Torque of the stalled motor: what the output gives and what dry friction takes [N m].
    fn motor_torque(&self) -> f64 {
        self.stall_torque + self.friction.coulomb
    }

    /// Torque lost per speed by back EMF, so that the free output reaches its speed [N m s/rad].
    fn back_emf_damping(&self) -> f64 {
        let friction = self.friction.torque(self.no_load_speed);
        (self.motor_torque() - friction) / self.no_load_speed
    }
}

/// A simulated drive.
#[derive(Debug, Clone, PartialEq)]
pub struct ServoSimulation {
    /// Its drive.
    pub drive: Drive,
    /// State of the drive.
    pub state: DriveState,
    /// Part of the supply voltage on the motor, -1 to 1 [-].
    pub duty: f64,
    /// The memory of its position loop, with the reference on its way to the goal.
    pub position_loop: PositionLoop,
    /// Smoothed duty of its load estimate [-].
    smooth_duty: f64,
}

impl ServoSimulation {
    /// A servo at rest at `angle` [rad], as warm as the air.
    pub fn new(drive: Drive, angle: f64) -> Self {
        let state = DriveState::resting(angle, drive.winding.air);
        Self { drive, state, duty: 0.0, position_loop: PositionLoop::new(angle), smooth_duty: 0.0 }
    }

    /// Position as the encoder gives it [ticks].
    pub fn ticks(&self) -> i32 {
        (self.state.angle / TAU * self.drive.position_loop.ticks_per_turn).round() as i32
    }

    /// Voltage of the supply at the servo, under its own current [V].
    pub fn voltage(&self) -> f64 {
        self.drive.supply.voltage - self.drive.supply.resistance * self.duty * self.state.current
    }

    /// The load it reports: no measurement, but what the motor is given, smoothed, as part of the stall torque and
    /// positive where it drives towards positive ticks [-].
    pub fn load(&self) -> f64 {
        (self.smooth_duty * self.voltage() / self.drive.motor.rated_voltage).clamp(-1.0, 1.0)
    }

    /// Lets `h` [s] pass, not more than a control period, under `load`.
    pub fn step(&mut self, command: &ServoCommand, load: DriveLoad, h: f64) {
        let at = (self.state.angle, self.state.velocity);
        self.duty = self.position_loop.duty(&self.drive.position_loop, command, at, h);
        let bridge = if command.torque_on { Bridge::Driven(self.duty) } else { Bridge::Open };
        self.drive.step(&mut self.state, bridge, load, h);
        self.smooth_duty += (self.duty - self.smooth_duty) * (h / LOAD_TIME).min(1.0);
    }
}

/// Stroke of a tick of its servo, positive where it pulls with positive ticks, by least squares [m]; none where the servo rested.
pub fn stroke_per_tick(goals: &[f64], strokes: &[f64]) -> Option<f64> {
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let (mx, my) = (mean(goals), mean(strokes));
    let across: f64 = goals.iter().zip(strokes).map(|(x, y)| (x - mx) * (y - my)).sum();
    let slope = across / goals.iter().map(|x| (x - mx).powi(2)).sum::<f64>();
    (slope.is_finite() && slope != 0.0).then_some(slope)
}
