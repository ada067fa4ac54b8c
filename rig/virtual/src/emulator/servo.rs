//! One emulated servo: its control table on one side, the servo of a [`ServoWorld`] on the other.
//!
//! The world moves the output; this module decides what it is commanded and what it reports: ticks, modes, goals, shutdowns,
//! the watchdog, and what is lost without power. Multi-turn counts are lost too, as in the real one: after
//! a restart the servo reads 0 to 4095 again.

use super::protection::{Protection, Readings};
use super::table::{ControlTable, Refusal, WATCHDOG_TRIPPED};
use super::world::ServoWorld;
use hysteron_actuator::{Gains, ServoCommand};
use hysteron_rig::bus::model::EffortRegister;
use hysteron_rig::bus::xl430::{self, ControlRegister, drive, mode};
use std::f64::consts::TAU;

/// How long a servo is silent after a restart [s].
pub(super) const START_TIME: f64 = 0.3;
/// How far the clocks of two servos that got their power together are apart [ms].
const START_APART: i64 = 37;
/// How near to the goal counts as there, for the moving status [ticks].
const IN_POSITION: i32 = 8;

/// Whether the servo has power.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Power {
    On,
    /// Back on, but silent until that time [s].
    Starting(f64),
    Off,
}

/// One emulated servo.
#[derive(Debug)]
pub(super) struct EmulatedServo {
    /// Control table: the values of its registers.
    pub table: ControlTable,
    /// Its number in the world.
    k: usize,
    /// Position reading at angle 0 with no turns counted [ticks].
    mount: i32,
    /// Whole turns that were lost without power [ticks].
    lost_turns: i32,
    power: Power,
    protection: Protection,
    /// Address and data of a reg write that waits for the action.
    registered: Option<(u16, Vec<u8>)>,
    /// When an instruction last came [s].
    heard_at: f64,
    /// Way from the reference to the goal when the goal was written [ticks]; what a profile in times is made for.
    way: i32,
    /// Reference before, and when that was [ticks, s].
    reference_before: (i32, f64),
}

impl EmulatedServo {
    /// Servo `k` of the world, with this id and further EEPROM values, at rest and without torque.
    pub fn new(k: usize, eeprom: &[(ControlRegister, i64)], world: &mut dyn ServoWorld) -> Self {
        let mut table = ControlTable::new(world.model(), world.has_full_loop());
        for (register, value) in eeprom {
            table.set(*register, *value);
        }
        // A horn sits half a turn from where the count wraps, unless the world has it there already.
        let turn = xl430::TICKS_PER_TURN;
        let at = ticks(world.servo(k).angle).rem_euclid(turn);
        let mount = if (turn / 4..3 * turn / 4).contains(&at) { 0 } else { turn / 2 };
        let time = world.time();
        let mut servo = Self {
            table,
            k,
            mount,
            lost_turns: 0,
            power: Power::On,
            protection: Protection::default(),
            registered: None,
            heard_at: time,
            way: 0,
            reference_before: (0, time),
        };
        servo.reset_turns(world);
        servo
    }

    /// Its id.
    pub fn id(&self) -> u8 {
        self.table.unsigned(xl430::ID).to_le_bytes()[0]
    }

    /// Whether it listens and answers.
    pub fn is_awake(&self) -> bool {
        self.power == Power::On
    }

    /// Whether it has power; it may still be starting.
    pub fn has_power(&self) -> bool {
        self.power != Power::Off
    }

    /// Whether it drives its motor.
    pub fn is_torque_on(&self) -> bool {
        self.is_awake() && self.table.is_set(xl430::TORQUE_ENABLE)
    }

    /// Error byte of an answer: alert bit and number.
    pub fn error_byte(&self, refusal: Option<Refusal>) -> u8 {
        let alert = if self.table.is_set(xl430::HARDWARE_ERROR) { 0x80 } else { 0 };
        alert | refusal.map_or(0, |refusal| refusal as u8)
    }

    /// An instruction came over the bus, to this servo or another, or bytes of one.
    pub fn hear(&mut self, time: f64) {
        self.heard_at = time;
    }

    /// Brings the registers up to date with the world, and stops what must stop.
    pub fn refresh(&mut self, world: &mut dyn ServoWorld) {
        let time = world.time();
        if matches!(self.power, Power::Starting(until) if time >= until) {
            self.power = Power::On;
            let startup = self.table.unsigned(xl430::STARTUP);
            if startup & u32::from(xl430::TORQUE_ON_AT_START) != 0 {
                self.report(world);
                self.stay();
                self.table.set(xl430::TORQUE_ENABLE, 1);
                self.drive(world);
            }
        }
        if !self.is_awake() {
            return;
        }
        self.report(world);
        self.protect(world);
        let watchdog = self.table.unsigned(xl430::BUS_WATCHDOG);
        let silence = time - self.heard_at;
        if self.is_torque_on()
            && watchdog != 0
            && watchdog != WATCHDOG_TRIPPED
            && silence > f64::from(watchdog) * xl430::WATCHDOG_UNIT
        {
            self.table.set(xl430::BUS_WATCHDOG, i64::from(WATCHDOG_TRIPPED));
            self.stay();
            self.drive(world);
        }
    }

    /// Writes what the world's servo does into the registers.
    fn report(&mut self, world: &dyn ServoWorld) {
        let (state, time) = (world.servo(self.k), world.time());
        let direction = f64::from(self.direction());
        let (position, reference) = (self.position_of(state.angle), self.position_of(state.reference));
        let velocity = (direction * state.velocity / xl430::VELOCITY_UNIT).round() as i64;
        let unit = match world.model().effort {
            EffortRegister::Load => xl430::LOAD_UNIT,
            EffortRegister::Current(unit) => unit,
        };
        let effort = direction * world.effort(self.k);
        let is_moving = velocity.abs() > i64::from(self.table.unsigned(xl430::MOVING_THRESHOLD));
        let is_there = (position - self.table.signed(xl430::GOAL_POSITION)).abs() <= IN_POSITION;
        let is_on_the_way = self.is_torque_on() && reference != self.table.signed(xl430::GOAL_POSITION);
        let (reference_before, time_before) = self.reference_before;
        if time > time_before {
            let speed = f64::from(reference - reference_before) / (time - time_before);
            let units = speed * TAU / f64::from(xl430::TICKS_PER_TURN) / xl430::VELOCITY_UNIT;
            self.table.set(xl430::VELOCITY_TRAJECTORY, units.round() as i64);
            self.reference_before = (reference, time);
        }
        for (register, value) in [
            (xl430::REALTIME_TICK, ((1e3 * time) as i64 + START_APART * self.k as i64) % 32_768),
            (xl430::MOVING, i64::from(is_moving)),
            (xl430::MOVING_STATUS, i64::from(is_there) | i64::from(is_on_the_way) << 1),
            (xl430::PRESENT_PWM, (direction * state.pwm * f64::from(xl430::PWM_MAX)).round() as i64),
            (xl430::PRESENT_LOAD, (effort / unit).round() as i64),
            (xl430::PRESENT_VELOCITY, velocity),
            (xl430::PRESENT_POSITION, i64::from(position)),
            (xl430::POSITION_TRAJECTORY, i64::from(reference)),
            (xl430::PRESENT_VOLTAGE, (state.voltage / xl430::VOLTAGE_UNIT).round() as i64),
            (xl430::PRESENT_TEMPERATURE, self.protection.warmed(state.temperature, time).round() as i64),
        ] {
            self.table.set(register, value);
        }
    }

    /// Looks for hardware errors; those in the shutdown mask switch the torque off.
    fn protect(&mut self, world: &mut dyn ServoWorld) {
        let state = world.servo(self.k);
        let time = world.time();
        let readings = Readings {
            time,
            load: if self.is_torque_on() { world.load(self.k) } else { 0.0 },
            temperature: self.protection.warmed(state.temperature, time),
            voltage: state.voltage,
        };
        let mask = self.table.unsigned(xl430::SHUTDOWN).to_le_bytes()[0];
        let before = self.table.unsigned(xl430::HARDWARE_ERROR).to_le_bytes()[0];
        let errors = self.protection.errors(&readings, &self.table) | (before & mask);
        self.table.set(xl430::HARDWARE_ERROR, i64::from(errors));
        if errors & mask != 0 && self.is_torque_on() {
            self.table.set(xl430::TORQUE_ENABLE, 0);
            self.drive(world);
        }
    }

    /// Reports a hardware error as if the servo had found it.
    pub fn trip(&mut self, bits: u8, world: &mut dyn ServoWorld) {
        self.protection.force(bits);
        self.protect(world);
    }

    /// Reports this much more heat [°C] until that time [s].
    pub fn warm(&mut self, by: f64, until: f64) {
        self.protection.warm(by, until);
    }

    /// Reads registers.
    ///
    /// # Errors
    /// As [`ControlTable::read`].
    pub fn read(&self, address: u16, count: u16) -> Result<Vec<u8>, Refusal> {
        self.table.read(address, count)
    }

    /// Writes registers and does what they ask.
    ///
    /// # Errors
    /// As [`ControlTable::write`].
    pub fn write(&mut self, address: u16, data: &[u8], world: &mut dyn ServoWorld) -> Result<(), Refusal> {
        let was_on = self.is_torque_on();
        let touched = self.table.write(address, data)?;
        let drive_mode = self.table.unsigned(xl430::DRIVE_MODE);
        let is_on_by_goal = drive_mode & u32::from(drive::TORQUE_ON_BY_GOAL) != 0;
        if is_on_by_goal && touched.contains(&xl430::GOAL_POSITION) {
            // Refused after a shutdown, as any other way to switch it on.
            let _ = self.table.write(xl430::TORQUE_ENABLE.address, &[1]);
        }
        if [xl430::GOAL_POSITION, xl430::PROFILE_VELOCITY, xl430::PROFILE_ACCELERATION, xl430::DRIVE_MODE]
            .iter()
            .any(|register| touched.contains(register))
        {
            self.way = (self.table.signed(xl430::GOAL_POSITION)
                - self.table.signed(xl430::POSITION_TRAJECTORY))
            .abs();
        }
        if !was_on && self.is_torque_on() {
            self.protection.rest();
            if !touched.contains(&xl430::GOAL_POSITION) {
                self.stay();
            }
        }
        let shifts = [xl430::OPERATING_MODE, xl430::HOMING_OFFSET, xl430::DRIVE_MODE];
        if shifts.iter().any(|register| touched.contains(register)) {
            self.report(world);
            self.stay();
        }
        self.drive(world);
        Ok(())
    }

    /// Keeps a write for the action that follows.
    ///
    /// # Errors
    /// As [`ControlTable::write`].
    pub fn register(&mut self, address: u16, data: &[u8]) -> Result<(), Refusal> {
        self.table.check(address, data)?;
        self.registered = Some((address, data.to_vec()));
        self.table.set(xl430::REGISTERED, 1);
        Ok(())
    }

    /// Carries out what was registered.
    ///
    /// # Errors
    /// `Result` if nothing was, else as [`ControlTable::write`].
    pub fn act(&mut self, world: &mut dyn ServoWorld) -> Result<(), Refusal> {
        let (address, data) = self.registered.take().ok_or(Refusal::Result)?;
        self.table.set(xl430::REGISTERED, 0);
        self.write(address, &data, world)
    }

    /// Forgets whole turns: the position becomes 0 to 4095.
    ///
    /// # Errors
    /// `Result` while it moves.
    pub fn clear_turns(&mut self, world: &mut dyn ServoWorld) -> Result<(), Refusal> {
        self.report(world);
        if self.table.is_set(xl430::MOVING) {
            return Err(Refusal::Result);
        }
        self.reset_turns(world);
        self.drive(world);
        Ok(())
    }

    /// Everything as from the factory, then a restart.
    pub fn factory_reset(&mut self, kept: &[ControlRegister], world: &mut dyn ServoWorld) {
        self.table.reset_all_but(kept);
        self.restart(world);
    }

    /// Off and on again: silent for [`START_TIME`], without torque, RAM and turns lost.
    pub fn restart(&mut self, world: &mut dyn ServoWorld) {
        self.cut(world);
        self.power = Power::Starting(world.time() + START_TIME);
    }

    /// Takes its power away.
    pub fn cut(&mut self, world: &mut dyn ServoWorld) {
        self.power = Power::Off;
        self.registered = None;
        self.protection = Protection::default();
        self.table.reset_ram();
        world.power_cycle(self.k);
        self.reset_turns(world);
    }

    /// Resets whole turns, and makes the present position the goal.
    fn reset_turns(&mut self, world: &dyn ServoWorld) {
        let turn = xl430::TICKS_PER_TURN;
        self.lost_turns = (ticks(world.servo(self.k).angle) + self.mount).div_euclid(turn) * turn;
        self.report(world);
        self.stay();
    }

    /// Makes the present position the goal.
    fn stay(&mut self) {
        let here = self.table.signed(xl430::PRESENT_POSITION);
        self.table.set(xl430::GOAL_POSITION, i64::from(here));
    }

    /// Sets the command of the world's servo from the registers.
    fn drive(&self, world: &mut dyn ServoWorld) {
        let table = &self.table;
        let unsigned = |register| table.unsigned(register);
        let gain = |register| u16::try_from(unsigned(register)).unwrap_or(u16::MAX);
        let goal = self.direction() * (table.signed(xl430::GOAL_POSITION) - self.offset());
        let fastest = unsigned(xl430::VELOCITY_LIMIT);
        let pwm = table.signed(xl430::GOAL_PWM).unsigned_abs().min(unsigned(xl430::PWM_LIMIT));
        let (velocity, acceleration) = self.profile();
        let velocity = velocity.min(f64::from(fastest) * xl430::VELOCITY_UNIT);
        let command = ServoCommand {
            torque_on: self.is_torque_on(),
            goal: goal - self.mount + self.lost_turns,
            profile_velocity: velocity,
            profile_acceleration: acceleration,
            gains: Gains {
                p: gain(xl430::POSITION_P_GAIN),
                i: gain(xl430::POSITION_I_GAIN),
                d: gain(xl430::POSITION_D_GAIN),
            },
            pwm_limit: f64::from(pwm) / f64::from(xl430::PWM_MAX),
        };
        world.command(self.k, &command);
    }

    /// Speed [rad/s] and acceleration [rad/s²] of the profile; 0 for none. In a profile of times the first register is
    /// the time of the whole way and the second that of its acceleration [ms], at most half of it.
    fn profile(&self) -> (f64, f64) {
        let value = |register| f64::from(self.table.unsigned(register));
        let (velocity, acceleration) = (value(xl430::PROFILE_VELOCITY), value(xl430::PROFILE_ACCELERATION));
        if self.table.unsigned(xl430::DRIVE_MODE) & u32::from(drive::TIME_BASED) == 0 {
            return (velocity * xl430::VELOCITY_UNIT, acceleration * xl430::ACCELERATION_UNIT);
        }
        if velocity == 0.0 || self.way == 0 {
            return (0.0, 0.0);
        }
        let way = f64::from(self.way) * TAU / f64::from(xl430::TICKS_PER_TURN);
        let ramp = acceleration.min(0.5 * velocity);
        let speed = way / (1e-3 * (velocity - ramp));
        (speed, if ramp == 0.0 { 0.0 } else { speed / (1e-3 * ramp) })
    }

    /// Position reading [ticks] at an angle of the world [rad].
    fn position_of(&self, angle: f64) -> i32 {
        self.direction() * (ticks(angle) + self.mount - self.lost_turns) + self.offset()
    }

    /// -1 if the drive mode turns the direction round.
    fn direction(&self) -> i32 {
        let is_reverse = self.table.unsigned(xl430::DRIVE_MODE) & u32::from(drive::REVERSE) != 0;
        if is_reverse { -1 } else { 1 }
    }

    /// Homing offset [ticks]; in position mode a quarter turn at most has effect.
    fn offset(&self) -> i32 {
        let offset = self.table.signed(xl430::HOMING_OFFSET);
        let quarter = xl430::TICKS_PER_TURN / 4;
        let is_single_turn = self.table.unsigned(xl430::OPERATING_MODE) == u32::from(mode::POSITION);
        if is_single_turn { offset.clamp(-quarter, quarter) } else { offset }
    }
}

/// An angle [rad] in ticks.
fn ticks(angle: f64) -> i32 {
    (angle * f64::from(xl430::TICKS_PER_TURN) / TAU).round() as i32
}
