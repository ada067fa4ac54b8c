//! The control table of the XL430-W250, as the driver and the emulator both need it; the other servos of [`model`](super::model)
//! have the same, with their current where this one has its load.
//!
//! Source: ROBOTIS e-Manual, XL430-W250, "Control Table". All values are little-endian.

#![allow(missing_docs)] // the names are those of the manual

/// A place in the control table.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ControlRegister {
    /// First address.
    pub address: u16,
    /// Bytes.
    pub size: u8,
}

const fn at(address: u16, size: u8) -> ControlRegister {
    ControlRegister { address, size }
}

/// Ticks of a full turn. (The CoReAct paper counts ±4096 as ±180°, which this servo cannot do.)
pub const TICKS_PER_TURN: i32 = 4096;
/// Unit of velocities [rad/s]: 0.229 turns per minute.
pub const VELOCITY_UNIT: f64 = 0.229 * std::f64::consts::TAU / 60.0;
/// Unit of profile accelerations [rad/s²]: 214.577 turns per minute².
pub const ACCELERATION_UNIT: f64 = 214.577 * std::f64::consts::TAU / 3600.0;
/// Unit of loads, of the largest torque [-].
pub const LOAD_UNIT: f64 = 1e-3;
/// Unit of voltages [V].
pub const VOLTAGE_UNIT: f64 = 0.1;
/// Largest value of the PWM registers.
pub const PWM_MAX: i16 = 885;
/// Unit of the return delay time [s].
pub const RETURN_DELAY_UNIT: f64 = 2e-6;
/// Unit of the bus watchdog [s].
pub const WATCHDOG_UNIT: f64 = 20e-3;
/// Bauds by the number in the register.
pub const BAUDS: [u32; 8] = [9_600, 57_600, 115_200, 1_000_000, 2_000_000, 3_000_000, 4_000_000, 4_500_000];

pub const MODEL_NUMBER: ControlRegister = at(0, 2);
pub const MODEL_INFORMATION: ControlRegister = at(2, 4);
pub const FIRMWARE: ControlRegister = at(6, 1);
pub const ID: ControlRegister = at(7, 1);
pub const BAUD: ControlRegister = at(8, 1);
pub const RETURN_DELAY: ControlRegister = at(9, 1);
pub const DRIVE_MODE: ControlRegister = at(10, 1);
pub const OPERATING_MODE: ControlRegister = at(11, 1);
pub const SECONDARY_ID: ControlRegister = at(12, 1);
pub const PROTOCOL: ControlRegister = at(13, 1);
pub const HOMING_OFFSET: ControlRegister = at(20, 4);
pub const MOVING_THRESHOLD: ControlRegister = at(24, 4);
pub const TEMPERATURE_LIMIT: ControlRegister = at(31, 1);
pub const MAX_VOLTAGE: ControlRegister = at(32, 2);
pub const MIN_VOLTAGE: ControlRegister = at(34, 2);
pub const PWM_LIMIT: ControlRegister = at(36, 2);
/// Not of the XL430, which measures no current.
pub const CURRENT_LIMIT: ControlRegister = at(38, 2);
pub const VELOCITY_LIMIT: ControlRegister = at(44, 4);
pub const MAX_POSITION: ControlRegister = at(48, 4);
pub const MIN_POSITION: ControlRegister = at(52, 4);
pub const STARTUP: ControlRegister = at(60, 1);
/// Of the XL330 alone.
pub const PWM_SLOPE: ControlRegister = at(62, 1);
pub const SHUTDOWN: ControlRegister = at(63, 1);
pub const TORQUE_ENABLE: ControlRegister = at(64, 1);
pub const LED: ControlRegister = at(65, 1);
pub const STATUS_RETURN: ControlRegister = at(68, 1);
pub const REGISTERED: ControlRegister = at(69, 1);
pub const HARDWARE_ERROR: ControlRegister = at(70, 1);
pub const VELOCITY_I_GAIN: ControlRegister = at(76, 2);
pub const VELOCITY_P_GAIN: ControlRegister = at(78, 2);
pub const POSITION_D_GAIN: ControlRegister = at(80, 2);
pub const POSITION_I_GAIN: ControlRegister = at(82, 2);
pub const POSITION_P_GAIN: ControlRegister = at(84, 2);
pub const FEEDFORWARD_2ND_GAIN: ControlRegister = at(88, 2);
pub const FEEDFORWARD_1ST_GAIN: ControlRegister = at(90, 2);
pub const BUS_WATCHDOG: ControlRegister = at(98, 1);
pub const GOAL_PWM: ControlRegister = at(100, 2);
/// Not of the XL430.
pub const GOAL_CURRENT: ControlRegister = at(102, 2);
pub const GOAL_VELOCITY: ControlRegister = at(104, 4);
pub const PROFILE_ACCELERATION: ControlRegister = at(108, 4);
pub const PROFILE_VELOCITY: ControlRegister = at(112, 4);
pub const GOAL_POSITION: ControlRegister = at(116, 4);
pub const REALTIME_TICK: ControlRegister = at(120, 2);
pub const MOVING: ControlRegister = at(122, 1);
pub const MOVING_STATUS: ControlRegister = at(123, 1);
pub const PRESENT_PWM: ControlRegister = at(124, 2);
pub const PRESENT_LOAD: ControlRegister = at(126, 2);
pub const PRESENT_VELOCITY: ControlRegister = at(128, 4);
pub const PRESENT_POSITION: ControlRegister = at(132, 4);
pub const VELOCITY_TRAJECTORY: ControlRegister = at(136, 4);
pub const POSITION_TRAJECTORY: ControlRegister = at(140, 4);
pub const PRESENT_VOLTAGE: ControlRegister = at(144, 2);
pub const PRESENT_TEMPERATURE: ControlRegister = at(146, 1);
pub const BACKUP_READY: ControlRegister = at(147, 1);
/// First of 28 indirect addresses of two bytes each.
pub const INDIRECT_ADDRESS: ControlRegister = at(168, 56);
/// The bytes that the 28 indirect addresses point to.
pub const INDIRECT_DATA: ControlRegister = at(224, 28);
/// First of 28 further indirect addresses.
pub const INDIRECT_ADDRESS_2: ControlRegister = at(578, 56);
/// The bytes that these point to.
pub const INDIRECT_DATA_2: ControlRegister = at(634, 28);

/// Bits of [`HARDWARE_ERROR`] and [`SHUTDOWN`].
pub mod error_bit {
    pub const INPUT_VOLTAGE: u8 = 1 << 0;
    pub const OVERHEATING: u8 = 1 << 2;
    pub const ENCODER: u8 = 1 << 3;
    pub const ELECTRICAL_SHOCK: u8 = 1 << 4;
    pub const OVERLOAD: u8 = 1 << 5;
}

/// Bits of [`DRIVE_MODE`].
pub mod drive {
    /// Positions grow, and goals lie, the other way round.
    pub const REVERSE: u8 = 1 << 0;
    /// Profiles are times [ms] instead of speeds.
    pub const TIME_BASED: u8 = 1 << 2;
    /// A goal switches the torque on.
    pub const TORQUE_ON_BY_GOAL: u8 = 1 << 3;
}

/// Bit of [`STARTUP`] that switches the torque on with the supply.
pub const TORQUE_ON_AT_START: u8 = 1;
/// Largest value of [`SECONDARY_ID`] that is one; all above are none.
pub const SECONDARY_ID_MAX: u8 = 252;

/// Values of [`OPERATING_MODE`].
pub mod mode {
    pub const VELOCITY: u8 = 1;
    pub const POSITION: u8 = 3;
    pub const EXTENDED_POSITION: u8 = 4;
    pub const PWM: u8 = 16;
}

/// The errors in a register of hardware errors, for people.
pub fn describe_errors(register: u8) -> String {
    let names = [
        (error_bit::INPUT_VOLTAGE, "input voltage"),
        (error_bit::OVERHEATING, "overheating"),
        (error_bit::ENCODER, "encoder"),
        (error_bit::ELECTRICAL_SHOCK, "electrical shock"),
        (error_bit::OVERLOAD, "overload"),
    ];
    let set: Vec<&str> = names.iter().filter(|(bit, _)| register & bit != 0).map(|(_, name)| *name).collect();
    if set.is_empty() { format!("unknown error {register:#04x}") } else { set.join(", ") }
}
