//! Allowed values of each register: who may write it, when, in which range, and its factory value.
//!
//! Source: ROBOTIS e-Manual, XL430-W250, "Control Table", and [`ServoModel`] for the others. Narrower than the manual
//! where the worlds cannot follow: only the two position modes and this protocol; and servos without a full loop keep to
//! the factory's profiles, integral gain and PWM. Gains of the velocity loop and of the feed-forward change nothing.

use hysteron_rig::bus::model::ServoModel;
use hysteron_rig::bus::xl430::{self, ControlRegister, drive, mode};

/// Bytes of the control table.
pub(super) const TABLE_LEN: usize = 662;
/// Firmware that the emulator claims.
const FIRMWARE: i64 = 45;

/// Who may write a register, and when.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Access {
    /// Only the servo itself.
    ReadOnly,
    /// Kept without power; locked while the torque is on.
    Eeprom,
    /// Forgotten without power.
    Ram,
}

/// One register.
#[derive(Debug, Clone, Copy)]
pub(super) struct Spec {
    pub register: ControlRegister,
    pub access: Access,
    /// Least and largest value that may be written.
    pub range: (i64, i64),
    /// Value from the factory, or at power-on.
    pub initial: i64,
}

/// Largest goal in extended position mode: 256 turns to either side [ticks].
const EXTENDED_GOAL: i64 = 1_048_575;
/// All bits of the drive mode.
const DRIVE_MODES: i64 = (drive::REVERSE | drive::TIME_BASED | drive::TORQUE_ON_BY_GOAL) as i64;
/// Largest homing offset [ticks].
const HOMING: i64 = 1_044_479;

/// All registers of such a servo, in order of their addresses.
pub(super) fn specs(model: &ServoModel, has_full_loop: bool) -> Vec<Spec> {
    use Access::{Eeprom, Ram, ReadOnly};
    let row = |register, access, range, initial| Spec { register, access, range, initial };
    let read = |register, initial| row(register, ReadOnly, (i64::MIN, i64::MAX), initial);
    let pwm = i64::from(xl430::PWM_MAX);
    let [volts_min, volts_max] = model.voltage.map(i64::from);
    let [p, i, d] = model.gains.map(i64::from);
    let (pwm_min, ki_max, profile_max) = if has_full_loop { (0, 16_383, 32_767) } else { (pwm, 0, 0) };
    let pwm_goal_min = if has_full_loop { -pwm } else { pwm };
    let turn = i64::from(xl430::TICKS_PER_TURN);
    let velocity = i64::from(model.velocity);
    let last_mode = i64::from(mode::EXTENDED_POSITION);
    let mut specs = vec![
        read(xl430::MODEL_NUMBER, i64::from(model.number)),
        read(xl430::MODEL_INFORMATION, 0),
        read(xl430::FIRMWARE, FIRMWARE),
        row(xl430::ID, Eeprom, (0, 252), 1),
        row(xl430::BAUD, Eeprom, (0, 7), 1),
        row(xl430::RETURN_DELAY, Eeprom, (0, 254), 250),
        row(xl430::DRIVE_MODE, Eeprom, (0, DRIVE_MODES), 0),
        row(xl430::OPERATING_MODE, Eeprom, (i64::from(mode::POSITION), last_mode), i64::from(mode::POSITION)),
        row(xl430::SECONDARY_ID, Eeprom, (0, 255), 255),
        row(xl430::PROTOCOL, Eeprom, (2, 2), 2),
        row(xl430::HOMING_OFFSET, Eeprom, (-HOMING, HOMING), 0),
        row(xl430::MOVING_THRESHOLD, Eeprom, (0, 1023), 10),
        row(xl430::TEMPERATURE_LIMIT, Eeprom, (0, 100), i64::from(model.temperature)),
        row(xl430::MAX_VOLTAGE, Eeprom, (volts_min, volts_max), volts_max),
        row(xl430::MIN_VOLTAGE, Eeprom, (volts_min, volts_max), volts_min),
        row(xl430::PWM_LIMIT, Eeprom, (pwm_min, pwm), pwm),
        row(xl430::VELOCITY_LIMIT, Eeprom, (0, 1023.max(velocity)), velocity),
        row(xl430::MAX_POSITION, Eeprom, (0, turn - 1), turn - 1),
        row(xl430::MIN_POSITION, Eeprom, (0, turn - 1), 0),
        row(xl430::STARTUP, Eeprom, (0, 3), 0),
        row(xl430::SHUTDOWN, Eeprom, (0, 63), i64::from(model.shutdown)),
        row(xl430::TORQUE_ENABLE, Ram, (0, 1), 0),
        row(xl430::LED, Ram, (0, 1), 0),
        row(xl430::STATUS_RETURN, Ram, (0, 2), 2),
        read(xl430::REGISTERED, 0),
        read(xl430::HARDWARE_ERROR, 0),
        row(xl430::VELOCITY_I_GAIN, Ram, (0, 16_383), i64::from(model.velocity_gains[0])),
        row(xl430::VELOCITY_P_GAIN, Ram, (0, 16_383), i64::from(model.velocity_gains[1])),
        row(xl430::POSITION_D_GAIN, Ram, (0, 16_383), d),
        row(xl430::POSITION_I_GAIN, Ram, (0, ki_max), i),
        row(xl430::POSITION_P_GAIN, Ram, (0, 16_383), p),
        row(xl430::FEEDFORWARD_2ND_GAIN, Ram, (0, 16_383), 0),
        row(xl430::FEEDFORWARD_1ST_GAIN, Ram, (0, 16_383), 0),
        row(xl430::BUS_WATCHDOG, Ram, (0, 127), 0),
        row(xl430::GOAL_PWM, Ram, (pwm_goal_min, pwm), pwm),
        row(xl430::GOAL_VELOCITY, Ram, (-1023, 1023), 0),
        row(xl430::PROFILE_ACCELERATION, Ram, (0, profile_max), 0),
        row(xl430::PROFILE_VELOCITY, Ram, (0, profile_max), 0),
        row(xl430::GOAL_POSITION, Ram, (-EXTENDED_GOAL, EXTENDED_GOAL), 0),
        read(xl430::REALTIME_TICK, 0),
        read(xl430::MOVING, 0),
        read(xl430::MOVING_STATUS, 0),
        read(xl430::PRESENT_PWM, 0),
        read(xl430::PRESENT_LOAD, 0),
        read(xl430::PRESENT_VELOCITY, 0),
        read(xl430::PRESENT_POSITION, 0),
        read(xl430::VELOCITY_TRAJECTORY, 0),
        read(xl430::POSITION_TRAJECTORY, 0),
        read(xl430::PRESENT_VOLTAGE, 0),
        read(xl430::PRESENT_TEMPERATURE, 0),
        read(xl430::BACKUP_READY, 0),
    ];
    if let Some(limit) = model.current_limit.map(i64::from) {
        specs.push(row(xl430::CURRENT_LIMIT, Eeprom, (0, limit), limit));
        specs.push(row(xl430::GOAL_CURRENT, Ram, (-limit, limit), limit));
    }
    if let Some(slope) = model.pwm_slope {
        specs.push(row(xl430::PWM_SLOPE, Eeprom, (1, 255), i64::from(slope)));
    }
    let last = TABLE_LEN as i64 - 1;
    for (addresses, data) in INDIRECT {
        for k in 0..data.size {
            let address = ControlRegister { address: addresses.address + 2 * u16::from(k), size: 2 };
            let points_to = i64::from(data.address) + i64::from(k);
            specs.push(row(address, Ram, (i64::from(xl430::TORQUE_ENABLE.address), last), points_to));
        }
        for k in 0..data.size {
            let byte = ControlRegister { address: data.address + u16::from(k), size: 1 };
            specs.push(row(byte, Ram, (0, 255), 0));
        }
    }
    specs.sort_by_key(|spec| spec.register.address);
    specs
}

/// Both blocks of indirect addresses, with the bytes that they give a second place.
pub(super) const INDIRECT: [(ControlRegister, ControlRegister); 2] =
    [(xl430::INDIRECT_ADDRESS, xl430::INDIRECT_DATA), (xl430::INDIRECT_ADDRESS_2, xl430::INDIRECT_DATA_2)];

#[cfg(test)]
mod tests {
    use super::*;
    use hysteron_rig::bus::model::{XL330_M288, XL430_W250, XM430_W350};

    #[test]
    fn registers_lie_in_order_and_do_not_overlap() {
        for pair in specs(&XL430_W250, true).windows(2) {
            let [before, after] = [pair[0].register, pair[1].register];
            assert!(before.address + u16::from(before.size) <= after.address, "{before:?} {after:?}");
        }
        let last =
            specs(&XL430_W250, true).last().map(|spec| spec.register.address + u16::from(spec.register.size));
        assert_eq!(last.map(usize::from), Some(TABLE_LEN));
    }

    #[test]
    fn the_driver_s_table_has_every_register_and_no_other() {
        use hysteron_rig::bus::registers::TABLE;
        let is_indirect = |register: ControlRegister| register.address >= xl430::INDIRECT_ADDRESS.address;
        for model in [&XL430_W250, &XM430_W350, &XL330_M288] {
            let emulated: Vec<ControlRegister> = specs(model, true)
                .iter()
                .map(|spec| spec.register)
                .filter(|one| !is_indirect(*one))
                .collect();
            let known: Vec<ControlRegister> = TABLE
                .iter()
                .filter(|spec| spec.is_of(model) && !is_indirect(spec.register))
                .map(|spec| spec.register)
                .collect();
            assert_eq!(emulated, known, "{}", model.name);
        }
    }

    #[test]
    fn what_the_driver_takes_for_the_factory_s_value_is_that() {
        for model in [&XL430_W250, &XM430_W350, &XL330_M288] {
            let emulated = specs(model, true);
            for (spec, factory) in
                hysteron_rig::bus::registers::stored().filter(|(spec, _)| spec.is_of(model))
            {
                let found = emulated.iter().find(|one| one.register == spec.register).map(|one| one.initial);
                assert!(factory(model).is_none() || factory(model) == found, "{}: {}", model.name, spec.name);
            }
        }
    }

    #[test]
    fn every_initial_value_may_be_written() {
        for (model, has_full_loop) in [(&XL430_W250, true), (&XM430_W350, false), (&XL330_M288, false)] {
            for spec in specs(model, has_full_loop) {
                assert!((spec.range.0..=spec.range.1).contains(&spec.initial), "{spec:?}");
            }
        }
    }
}
