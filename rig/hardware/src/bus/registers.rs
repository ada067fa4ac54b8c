//! Every register of the control table: its meaning, and its required value before a motor is driven.
//!
//! The table is closed: a register is stored with the calibration, set before every run, written by the session,
//! measured, or without effect in the two position modes. Source: ROBOTIS e-Manual, "Control Table" of each model.

use super::model::ServoModel;
use super::xl430::{self, ControlRegister, drive};
use crate::config::{ServoConfig, ServoMode};
use hysteron_base::BadInput;
use serde::{Serialize, Serializer};
use std::collections::BTreeMap;

/// Role of a register in the checks before the torque is switched on.
#[derive(Debug, Clone, Copy)]
pub enum RegisterRole {
    /// Says which servo it is and how it is reached: the search on the bus depends on it.
    Identity,
    /// Kept without power: compared with what the calibration stored or, without that, with the factory's value. A
    /// value that has none from the factory is compared only with what was stored.
    Stored(fn(&ServoModel) -> Option<i64>),
    /// Written before every run and read back.
    Set(RegisterSetting),
    /// Written while a session lasts.
    Commanded,
    /// Written by the servo alone.
    Measured,
    /// Changes neither what a tick, a current or a goal means nor what the servo does in a position mode.
    WithoutEffect,
}

/// Value that a register is given before every run.
#[derive(Debug, Clone, Copy)]
pub enum RegisterSetting {
    /// The same for all.
    Fixed(i64),
    /// Operating mode of the rig file.
    Mode,
    /// Gain of the position loop by the rig file: P, I or D by its number.
    PositionGain(usize),
    /// Gain of the velocity loop from the factory: I or P by its number.
    VelocityGain(usize),
    /// All that the limit of the PWM allows.
    PwmLimit,
}

/// One register of the control table.
#[derive(Debug)]
pub struct RegisterSpec {
    /// Where it is.
    pub register: ControlRegister,
    /// As the manual calls it.
    pub name: &'static str,
    /// Role in the checks before the torque is switched on.
    pub role: RegisterRole,
    /// Effect of another value.
    pub effect: &'static str,
}

const fn row(
    register: ControlRegister,
    name: &'static str,
    role: RegisterRole,
    effect: &'static str,
) -> RegisterSpec {
    RegisterSpec { register, name, role, effect }
}

const PROFILE: &str = "goals are approached at another speed";
const GAIN: &str = "the servo follows its goal more stiffly, more softly or in another time";
const MEASURED: &str = "it is measured";

/// All registers up to the indirect addresses, in order; those of one kind of servo alone among them.
pub const TABLE: [RegisterSpec; 57] = {
    use RegisterRole::{Commanded, Identity, Measured, Set, Stored, WithoutEffect};
    use RegisterSetting::{Fixed, Mode, PositionGain, PwmLimit, VelocityGain};
    [
        row(xl430::MODEL_NUMBER, "Model Number", Identity, "another servo"),
        row(xl430::MODEL_INFORMATION, "Model Information", WithoutEffect, "nothing"),
        row(xl430::FIRMWARE, "Firmware Version", Stored(|_| None), "registers may have other meanings"),
        row(xl430::ID, "ID", Identity, "another servo answers"),
        row(xl430::BAUD, "Baud Rate", Identity, "the servo is not heard"),
        row(xl430::RETURN_DELAY, "Return Delay Time", Set(Fixed(0)), "answers come later"),
        row(
            xl430::DRIVE_MODE,
            "Drive Mode",
            Stored(|_| Some(0)),
            "profiles are times instead of speeds, or a goal switches the torque on",
        ),
        row(
            xl430::OPERATING_MODE,
            "Operating Mode",
            Set(Mode),
            "a goal is a speed, a PWM or wraps at a turn",
        ),
        row(
            xl430::SECONDARY_ID,
            "Secondary ID",
            Stored(|_| Some(255)),
            "the servo obeys instructions to another one",
        ),
        row(xl430::PROTOCOL, "Protocol Type", Stored(|_| Some(2)), "the servo speaks another protocol"),
        row(xl430::HOMING_OFFSET, "Homing Offset", Stored(|_| Some(0)), "every position is shifted"),
        row(
            xl430::MOVING_THRESHOLD,
            "Moving Threshold",
            Stored(|_| Some(10)),
            "the servo reports motion from another speed on",
        ),
        row(
            xl430::TEMPERATURE_LIMIT,
            "Temperature Limit",
            Stored(|m| Some(m.temperature as i64)),
            "the servo protects itself at another temperature",
        ),
        row(
            xl430::MAX_VOLTAGE,
            "Max Voltage Limit",
            Stored(|m| Some(m.voltage[1] as i64)),
            "the servo protects itself at another supply",
        ),
        row(
            xl430::MIN_VOLTAGE,
            "Min Voltage Limit",
            Stored(|m| Some(m.voltage[0] as i64)),
            "the servo protects itself at another supply",
        ),
        row(
            xl430::PWM_LIMIT,
            "PWM Limit",
            Stored(|_| Some(xl430::PWM_MAX as i64)),
            "the motor pulls with less than its torque, and lags",
        ),
        row(
            xl430::CURRENT_LIMIT,
            "Current Limit",
            Stored(|m| m.current_limit.map(i64::from)),
            "the motor is given another current at most",
        ),
        row(
            xl430::VELOCITY_LIMIT,
            "Velocity Limit",
            Stored(|m| Some(m.velocity as i64)),
            "the servo moves slower than its goal",
        ),
        row(
            xl430::MAX_POSITION,
            "Max Position Limit",
            Stored(|_| Some(xl430::TICKS_PER_TURN as i64 - 1)),
            "goals beyond it are refused in position mode",
        ),
        row(
            xl430::MIN_POSITION,
            "Min Position Limit",
            Stored(|_| Some(0)),
            "goals below it are refused in position mode",
        ),
        row(
            xl430::STARTUP,
            "Startup Configuration",
            Stored(|_| Some(0)),
            "the torque goes on with the supply, or other settings come back with it",
        ),
        row(
            xl430::PWM_SLOPE,
            "PWM Slope",
            Stored(|m| m.pwm_slope.map(i64::from)),
            "the motor's PWM rises at another rate",
        ),
        row(
            xl430::SHUTDOWN,
            "Shutdown",
            Stored(|m| Some(m.shutdown as i64)),
            "other errors switch the torque off",
        ),
        row(xl430::TORQUE_ENABLE, "Torque Enable", Commanded, "the motor is driven"),
        row(xl430::LED, "LED", WithoutEffect, "nothing"),
        row(xl430::STATUS_RETURN, "Status Return Level", Set(Fixed(2)), "the servo does not answer"),
        row(xl430::REGISTERED, "Registered Instruction", Measured, MEASURED),
        row(xl430::HARDWARE_ERROR, "Hardware Error Status", Measured, MEASURED),
        row(xl430::VELOCITY_I_GAIN, "Velocity I Gain", Set(VelocityGain(0)), GAIN),
        row(xl430::VELOCITY_P_GAIN, "Velocity P Gain", Set(VelocityGain(1)), GAIN),
        row(xl430::POSITION_D_GAIN, "Position D Gain", Set(PositionGain(2)), GAIN),
        row(xl430::POSITION_I_GAIN, "Position I Gain", Set(PositionGain(1)), GAIN),
        row(xl430::POSITION_P_GAIN, "Position P Gain", Set(PositionGain(0)), GAIN),
        row(xl430::FEEDFORWARD_2ND_GAIN, "Feedforward 2nd Gain", Set(Fixed(0)), GAIN),
        row(xl430::FEEDFORWARD_1ST_GAIN, "Feedforward 1st Gain", Set(Fixed(0)), GAIN),
        row(xl430::BUS_WATCHDOG, "Bus Watchdog", Set(Fixed(0)), "goals are refused after a silence"),
        row(
            xl430::GOAL_PWM,
            "Goal PWM",
            Set(PwmLimit),
            "the motor pulls with less than its torque, and lags",
        ),
        row(xl430::GOAL_CURRENT, "Goal Current", WithoutEffect, "nothing in a position mode"),
        row(xl430::GOAL_VELOCITY, "Goal Velocity", WithoutEffect, "nothing in a position mode"),
        row(xl430::PROFILE_ACCELERATION, "Profile Acceleration", Set(Fixed(0)), PROFILE),
        row(xl430::PROFILE_VELOCITY, "Profile Velocity", Set(Fixed(0)), PROFILE),
        row(xl430::GOAL_POSITION, "Goal Position", Commanded, "where the servo goes"),
        row(xl430::REALTIME_TICK, "Realtime Tick", Measured, MEASURED),
        row(xl430::MOVING, "Moving", Measured, MEASURED),
        row(xl430::MOVING_STATUS, "Moving Status", Measured, MEASURED),
        row(xl430::PRESENT_PWM, "Present PWM", Measured, MEASURED),
        row(xl430::PRESENT_LOAD, "Present Load or Current", Measured, MEASURED),
        row(xl430::PRESENT_VELOCITY, "Present Velocity", Measured, MEASURED),
        row(xl430::PRESENT_POSITION, "Present Position", Measured, MEASURED),
        row(xl430::VELOCITY_TRAJECTORY, "Velocity Trajectory", Measured, MEASURED),
        row(xl430::POSITION_TRAJECTORY, "Position Trajectory", Measured, MEASURED),
        row(xl430::PRESENT_VOLTAGE, "Present Input Voltage", Measured, MEASURED),
        row(xl430::PRESENT_TEMPERATURE, "Present Temperature", Measured, MEASURED),
        row(xl430::BACKUP_READY, "Backup Ready", Measured, MEASURED),
        row(
            xl430::INDIRECT_ADDRESS,
            "Indirect Address",
            Commanded,
            "the block of a cycle holds other registers",
        ),
        row(xl430::INDIRECT_ADDRESS_2, "Indirect Address 2", WithoutEffect, "nothing: it is not read"),
        row(xl430::INDIRECT_DATA, "Indirect Data", Measured, MEASURED),
    ]
};

impl RegisterSpec {
    /// As files call it.
    pub fn key(&self) -> String {
        self.name.to_lowercase().replace(' ', "_")
    }

    /// Whether a servo of that model has it.
    pub fn is_of(&self, model: &ServoModel) -> bool {
        match self.register {
            xl430::CURRENT_LIMIT | xl430::GOAL_CURRENT => model.current_limit.is_some(),
            xl430::PWM_SLOPE => model.pwm_slope.is_some(),
            _ => true,
        }
    }

    /// Whether it can be written back.
    pub fn is_writable(&self) -> bool {
        !matches!(self.role, RegisterRole::Measured | RegisterRole::Identity)
            && self.register != xl430::FIRMWARE
    }

    /// Required value before a run; `None` if it is not set before a run.
    pub fn setting(&self, config: &ServoConfig, model: &ServoModel, pwm_limit: i64) -> Option<i64> {
        let RegisterRole::Set(setting) = self.role else { return None };
        Some(match setting {
            RegisterSetting::Fixed(value) => value,
            RegisterSetting::Mode => i64::from(match config.mode {
                ServoMode::Position => xl430::mode::POSITION,
                ServoMode::Extended => xl430::mode::EXTENDED_POSITION,
            }),
            RegisterSetting::PositionGain(k) => i64::from(config.gains[k]),
            RegisterSetting::VelocityGain(k) => i64::from(model.velocity_gains[k]),
            RegisterSetting::PwmLimit => pwm_limit,
        })
    }

    /// Why no servo with this value is driven, with any calibration.
    pub fn ban(&self, value: i64) -> Option<&'static str> {
        let has = |bit: u8| value & i64::from(bit) != 0;
        match self.register {
            xl430::DRIVE_MODE if has(drive::TORQUE_ON_BY_GOAL) => {
                Some("a goal switches its torque on without confirmation")
            }
            xl430::STARTUP if has(xl430::TORQUE_ON_AT_START) => Some("its torque goes on with the supply"),
            xl430::SECONDARY_ID if value <= i64::from(xl430::SECONDARY_ID_MAX) => {
                Some("it obeys instructions to another servo")
            }
            xl430::PROTOCOL if value != 2 => Some("it speaks another protocol"),
            _ => None,
        }
    }

    /// Consequence of the register holding `found` instead of `expected`.
    pub fn consequence(&self, expected: i64, found: i64) -> String {
        match self.register {
            xl430::HOMING_OFFSET => {
                let ticks = found - expected;
                let turn = ticks as f64 / f64::from(xl430::TICKS_PER_TURN);
                format!("every position is shifted by {ticks} ticks, {:.1} degrees", 360.0 * turn)
            }
            xl430::DRIVE_MODE if (found ^ expected) & i64::from(drive::REVERSE) != 0 => {
                "its direction is turned round, and a goal lies up to a turn away".into()
            }
            _ => self.effect.into(),
        }
    }

    /// The value in the bytes of the register, with its sign where it has one. All values of a
    /// secondary id that are no id mean the same.
    fn value(&self, bytes: &[u8]) -> i64 {
        let unsigned = bytes.iter().rev().fold(0_u32, |value, byte| (value << 8) | u32::from(*byte));
        match self.register {
            xl430::HOMING_OFFSET => i64::from(unsigned.cast_signed()),
            xl430::SECONDARY_ID if unsigned > u32::from(xl430::SECONDARY_ID_MAX) => 255,
            _ => i64::from(unsigned),
        }
    }
}

/// Registers that calibrations store.
pub fn stored() -> impl Iterator<Item = (&'static RegisterSpec, fn(&ServoModel) -> Option<i64>)> {
    TABLE.iter().filter_map(|spec| match spec.role {
        RegisterRole::Stored(factory) => Some((spec, factory)),
        _ => None,
    })
}

/// The lower part of a servo's control table, as it was read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RegisterImage(pub(super) Vec<u8>);

impl RegisterImage {
    /// Bytes that are read: up to the goals.
    pub const LEN: u16 = 120;

    /// Value of a register; `None` beyond what was read.
    pub fn value(&self, spec: &RegisterSpec) -> Option<i64> {
        let first = usize::from(spec.register.address);
        self.0.get(first..first + usize::from(spec.register.size)).map(|bytes| spec.value(bytes))
    }

    /// Values of the registers that a calibration of such a servo stores.
    pub fn stored(&self, model: &ServoModel) -> StoredRegisters {
        let of_model = stored().filter(|(spec, _)| spec.is_of(model));
        StoredRegisters(
            of_model.filter_map(|(spec, _)| Some((spec.register.address, self.value(spec)?))).collect(),
        )
    }
}

/// Register values of a servo that a calibration stores, by address; empty where they are not known.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct StoredRegisters(BTreeMap<u16, i64>);

impl StoredRegisters {
    /// As such a servo has them from the factory.
    pub fn factory(model: &ServoModel) -> Self {
        let of_model = stored().filter(|(spec, _)| spec.is_of(model));
        Self(of_model.filter_map(|(spec, factory)| Some((spec.register.address, factory(model)?))).collect())
    }

    /// From the keys of a file.
    ///
    /// # Errors
    /// `BadInput` for a key that is no register, or a value that it cannot hold.
    pub fn from_keys(place: &str, typed: &BTreeMap<String, i64>) -> Result<Self, BadInput> {
        let mut values = BTreeMap::new();
        for (key, value) in typed {
            let place = format!("{place}.{key}");
            let Some((spec, _)) = stored().find(|(spec, _)| spec.key() == *key) else {
                let known: Vec<String> = stored().map(|(spec, _)| spec.key()).collect();
                return Err(BadInput::new(place, format!("one of {}", known.join(", ")), "another name"));
            };
            let bits = 8 * u32::from(spec.register.size);
            let least = if spec.register == xl430::HOMING_OFFSET { -(1_i64 << (bits - 1)) } else { 0 };
            if !(least..1 << bits).contains(value) {
                let expected = format!("a number of {} bytes", spec.register.size);
                return Err(BadInput::new(place, expected, value.to_string()));
            }
            values.insert(spec.register.address, *value);
        }
        Ok(Self(values))
    }

    /// The same for a file.
    pub fn to_keys(&self) -> BTreeMap<String, i64> {
        stored().filter_map(|(spec, _)| Some((spec.key(), self.value(spec)?))).collect()
    }

    /// Value of a register; `None` if it is not known.
    pub fn value(&self, spec: &RegisterSpec) -> Option<i64> {
        self.0.get(&spec.register.address).copied()
    }

    /// Whether nothing is known.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// The same, with these values instead where there are any.
    pub fn with(mut self, others: &Self) -> Self {
        self.0.extend(&others.0);
        self
    }

    /// Addresses and values in order, for a hash.
    pub fn numbers(&self) -> impl Iterator<Item = f64> + '_ {
        self.0.iter().flat_map(|(address, value)| [f64::from(*address), *value as f64])
    }
}

impl Serialize for StoredRegisters {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.to_keys().serialize(serializer)
    }
}
