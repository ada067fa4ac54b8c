//! The control table of one servo: bytes, the rules for writing them, and the detour over indirect addresses.

use super::registers::{Access, INDIRECT, Spec, TABLE_LEN, specs};
use hysteron_rig::bus::model::ServoModel;
use hysteron_rig::bus::xl430::{self, ControlRegister, mode};

/// Why a servo refuses an instruction: the error number of its answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Refusal {
    /// The instruction could not be run.
    Result = 1,
    /// There is no such instruction.
    Instruction = 2,
    /// The checksum is wrong.
    Checksum = 3,
    /// A value that the register can never hold.
    Range = 4,
    /// Part of a register, or parameters of the wrong length.
    Length = 5,
    /// A value beyond a limit that another register sets.
    Limit = 6,
    /// A register that cannot be written, not now, or does not exist.
    Access = 7,
}

/// Value of [`xl430::BUS_WATCHDOG`] once it has tripped.
pub(super) const WATCHDOG_TRIPPED: u32 = 0xff;
/// Value of a secondary id that means none, as do all above.
const NO_SECONDARY_ID: u32 = 253;

/// The control table of one servo.
#[derive(Debug, Clone)]
pub(super) struct ControlTable {
    bytes: Vec<u8>,
    specs: Vec<Spec>,
    /// Number of the register that each byte belongs to (`TABLE_LEN`).
    owner: Vec<Option<usize>>,
}

impl ControlTable {
    /// Of such a servo, as it leaves the factory; `has_full_loop` as a world has it.
    pub fn new(model: &ServoModel, has_full_loop: bool) -> Self {
        let specs = specs(model, has_full_loop);
        let mut owner = vec![None; TABLE_LEN];
        for (k, spec) in specs.iter().enumerate() {
            owner[span(spec.register)].fill(Some(k));
        }
        let mut table = Self { bytes: vec![0; TABLE_LEN], specs, owner };
        table.reset(|_| true);
        table
    }

    /// Resets the RAM registers, as a loss of power does.
    pub fn reset_ram(&mut self) {
        self.reset(|spec| spec.access != Access::Eeprom);
    }

    /// Resets all registers but these, as a factory reset does.
    pub fn reset_all_but(&mut self, kept: &[ControlRegister]) {
        self.reset(|spec| !kept.contains(&spec.register));
    }

    fn reset(&mut self, is_reset: impl Fn(&Spec) -> bool) {
        for k in 0..self.specs.len() {
            let spec = self.specs[k];
            if is_reset(&spec) {
                self.set(spec.register, spec.initial);
            }
        }
    }

    /// A register as an unsigned number.
    pub fn unsigned(&self, register: ControlRegister) -> u32 {
        let bytes = &self.bytes[span(register)];
        bytes.iter().rev().fold(0, |value, &byte| (value << 8) | u32::from(byte))
    }

    /// A register as a signed number.
    pub fn signed(&self, register: ControlRegister) -> i32 {
        let shift = 32 - 8 * u32::from(register.size);
        (self.unsigned(register) << shift) as i32 >> shift
    }

    /// Whether a switch is on, or a bit of errors set.
    pub fn is_set(&self, register: ControlRegister) -> bool {
        self.unsigned(register) != 0
    }

    /// Sets a register as the servo itself does, without any rule. What does not fit is cut to its size.
    pub fn set(&mut self, register: ControlRegister, value: i64) {
        let bytes = value.to_le_bytes();
        self.bytes[span(register)].copy_from_slice(&bytes[..usize::from(register.size)]);
    }

    /// The id under which only writes arrive, if there is one.
    pub fn secondary_id(&self) -> Option<u8> {
        let id = self.unsigned(xl430::SECONDARY_ID);
        (id < NO_SECONDARY_ID).then(|| id.to_le_bytes()[0])
    }

    /// Reads `count` bytes from `address` on; gaps between registers read as 0.
    ///
    /// # Errors
    /// `Access` past the end and where nothing at all is defined, `Length` for no bytes.
    pub fn read(&self, address: u16, count: u16) -> Result<Vec<u8>, Refusal> {
        let (first, end) = (usize::from(address), usize::from(address) + usize::from(count));
        if count == 0 {
            return Err(Refusal::Length);
        }
        if end > TABLE_LEN || self.owner[first..end].iter().all(Option::is_none) {
            return Err(Refusal::Access);
        }
        Ok((first..end).map(|at| self.bytes[self.target(at)]).collect())
    }

    /// Writes bytes from `address` on, all or none; returns the registers written.
    ///
    /// # Errors
    /// The first rule that any of them breaks.
    pub fn write(&mut self, address: u16, data: &[u8]) -> Result<Vec<ControlRegister>, Refusal> {
        let values = self.check(address, data)?;
        for (register, value) in &values {
            self.set(*register, *value);
        }
        Ok(values.into_iter().map(|(register, _)| register).collect())
    }

    /// Values that [`ControlTable::write`] would write, register by register.
    ///
    /// # Errors
    /// As [`ControlTable::write`].
    pub fn check(&self, address: u16, data: &[u8]) -> Result<Vec<(ControlRegister, i64)>, Refusal> {
        let first = usize::from(address);
        if data.is_empty() {
            return Err(Refusal::Length);
        }
        if first + data.len() > TABLE_LEN {
            return Err(Refusal::Access);
        }
        // Where every byte goes, and which registers that touches, in order.
        let mut goes = Vec::with_capacity(data.len());
        let mut touched = Vec::new();
        for (k, &byte) in data.iter().enumerate() {
            let at = self.target(first + k);
            let owner = self.owner[at].ok_or(Refusal::Access)?;
            goes.push((at, byte));
            touched.push(owner);
        }
        touched.sort_unstable();
        touched.dedup();
        let mut values = Vec::with_capacity(touched.len());
        for owner in touched {
            let spec = &self.specs[owner];
            let mut bytes = [0; 4];
            for (slot, at) in bytes.iter_mut().zip(span(spec.register)) {
                // If a byte is given twice, the later one counts.
                let given = goes.iter().rev().find(|(to, _)| *to == at);
                *slot = given.ok_or(Refusal::Length)?.1;
            }
            let unsigned = i64::from(u32::from_le_bytes(bytes));
            let bits = 8 * u32::from(spec.register.size);
            let is_negative = spec.range.0 < 0 && unsigned >> (bits - 1) != 0;
            let value = if is_negative { unsigned - (1 << bits) } else { unsigned };
            self.check_value(spec, value)?;
            values.push((spec.register, value));
        }
        Ok(values)
    }

    fn check_value(&self, spec: &Spec, value: i64) -> Result<(), Refusal> {
        let is_torque_on = self.is_set(xl430::TORQUE_ENABLE);
        match spec.access {
            Access::ReadOnly => return Err(Refusal::Access),
            Access::Eeprom if is_torque_on => return Err(Refusal::Access),
            Access::Eeprom | Access::Ram => {}
        }
        if !(spec.range.0..=spec.range.1).contains(&value) {
            return Err(Refusal::Range);
        }
        let limit = |register| i64::from(self.unsigned(register));
        let is_goal = [xl430::GOAL_PWM, xl430::GOAL_VELOCITY, xl430::GOAL_POSITION].contains(&spec.register);
        if is_goal && self.unsigned(xl430::BUS_WATCHDOG) == WATCHDOG_TRIPPED {
            return Err(Refusal::Range);
        }
        let is_within = match spec.register {
            xl430::GOAL_PWM => value.abs() <= limit(xl430::PWM_LIMIT),
            xl430::GOAL_VELOCITY => value.abs() <= limit(xl430::VELOCITY_LIMIT),
            xl430::GOAL_POSITION if limit(xl430::OPERATING_MODE) == i64::from(mode::POSITION) => {
                (limit(xl430::MIN_POSITION)..=limit(xl430::MAX_POSITION)).contains(&value)
            }
            _ => true,
        };
        if !is_within {
            return Err(Refusal::Limit);
        }
        // After a shutdown only a reboot helps.
        let shut_down = self.unsigned(xl430::HARDWARE_ERROR) & self.unsigned(xl430::SHUTDOWN) != 0;
        if spec.register == xl430::TORQUE_ENABLE && value == 1 && shut_down {
            return Err(Refusal::Result);
        }
        Ok(())
    }

    /// Where a byte really lies: for indirect data, where its indirect address points.
    fn target(&self, at: usize) -> usize {
        for (addresses, data) in INDIRECT {
            let range = span(data);
            if range.contains(&at) {
                let pointer = usize::from(addresses.address) + 2 * (at - range.start);
                let to = usize::from(u16::from_le_bytes([self.bytes[pointer], self.bytes[pointer + 1]]));
                return to.min(TABLE_LEN - 1);
            }
        }
        at
    }
}

fn span(register: ControlRegister) -> std::ops::Range<usize> {
    let first = usize::from(register.address);
    first..first + usize::from(register.size)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)] // a test may stop where it stands
    use super::*;
    use hysteron_rig::bus::model::XL430_W250;
    use hysteron_rig::bus::xl430::*;
    use proptest::prelude::*;

    fn written(
        table: &mut ControlTable,
        register: ControlRegister,
        value: i64,
    ) -> Result<Vec<ControlRegister>, Refusal> {
        table.write(register.address, &value.to_le_bytes()[..usize::from(register.size)])
    }

    #[test]
    fn a_new_servo_has_the_values_of_the_manual() {
        let table = ControlTable::new(&XL430_W250, true);
        assert_eq!(table.read(0, 2).unwrap(), 1060u16.to_le_bytes());
        assert_eq!(table.read(6, 4).unwrap(), [45, 1, 1, 250]);
        assert_eq!(table.unsigned(POSITION_P_GAIN), 640);
        assert_eq!(table.signed(GOAL_PWM), 885);
    }

    #[test]
    fn each_rule_has_its_error() {
        let mut table = ControlTable::new(&XL430_W250, true);
        assert_eq!(written(&mut table, MODEL_NUMBER, 1), Err(Refusal::Access));
        assert_eq!(written(&mut table, PRESENT_POSITION, 1), Err(Refusal::Access));
        assert_eq!(table.write(14, &[1]), Err(Refusal::Access), "a gap");
        assert_eq!(table.write(660, &[1, 2, 3]), Err(Refusal::Access), "past the end");
        assert_eq!(written(&mut table, OPERATING_MODE, 1), Err(Refusal::Range));
        assert_eq!(written(&mut table, TORQUE_ENABLE, 2), Err(Refusal::Range));
        assert_eq!(written(&mut table, BUS_WATCHDOG, 128), Err(Refusal::Range));
        assert_eq!(table.write(116, &[1, 2]), Err(Refusal::Length));
        assert_eq!(table.write(118, &[1, 2]), Err(Refusal::Length));
        assert_eq!(table.write(116, &[]), Err(Refusal::Length));
        assert_eq!(written(&mut table, GOAL_POSITION, 4096), Err(Refusal::Limit));
        assert_eq!(written(&mut table, GOAL_POSITION, -1), Err(Refusal::Limit));
        assert_eq!(written(&mut table, GOAL_VELOCITY, -266), Err(Refusal::Limit));
        assert_eq!(table.read(0, 0), Err(Refusal::Length));
        assert_eq!(table.read(661, 2), Err(Refusal::Access));
        assert_eq!(table.read(300, 4), Err(Refusal::Access));
    }

    #[test]
    fn extended_mode_goes_further() {
        let mut table = ControlTable::new(&XL430_W250, true);
        written(&mut table, OPERATING_MODE, 4).unwrap();
        written(&mut table, GOAL_POSITION, -5000).unwrap();
        assert_eq!(table.signed(GOAL_POSITION), -5000);
        assert_eq!(written(&mut table, GOAL_POSITION, 1_048_576), Err(Refusal::Range));
    }

    #[test]
    fn eeprom_is_locked_while_the_torque_is_on() {
        let mut table = ControlTable::new(&XL430_W250, true);
        written(&mut table, TORQUE_ENABLE, 1).unwrap();
        assert_eq!(written(&mut table, ID, 7), Err(Refusal::Access));
        written(&mut table, TORQUE_ENABLE, 0).unwrap();
        written(&mut table, ID, 7).unwrap();
        assert_eq!(table.unsigned(ID), 7);
    }

    #[test]
    fn a_tripped_watchdog_refuses_goals_until_cleared() {
        let mut table = ControlTable::new(&XL430_W250, true);
        table.set(BUS_WATCHDOG, i64::from(WATCHDOG_TRIPPED));
        assert_eq!(written(&mut table, GOAL_POSITION, 5), Err(Refusal::Range));
        written(&mut table, BUS_WATCHDOG, 0).unwrap();
        written(&mut table, GOAL_POSITION, 5).unwrap();
    }

    #[test]
    fn a_shutdown_forbids_torque() {
        let mut table = ControlTable::new(&XL430_W250, true);
        table.set(HARDWARE_ERROR, i64::from(error_bit::INPUT_VOLTAGE));
        written(&mut table, TORQUE_ENABLE, 1).unwrap();
        table.set(HARDWARE_ERROR, i64::from(error_bit::OVERLOAD));
        assert_eq!(written(&mut table, TORQUE_ENABLE, 1), Err(Refusal::Result));
    }

    #[test]
    fn indirect_data_stands_for_what_its_addresses_name() {
        for (addresses, data) in INDIRECT {
            let mut table = ControlTable::new(&XL430_W250, true);
            table.set(PRESENT_POSITION, -2);
            // Goal position, then the low half of the present position.
            let pointers = [116u16, 117, 118, 119, 132, 133].map(u16::to_le_bytes).concat();
            table.write(addresses.address, &pointers).unwrap();
            table.write(data.address, &77u32.to_le_bytes()).unwrap();
            assert_eq!(table.signed(GOAL_POSITION), 77);
            assert_eq!(table.read(data.address, 6).unwrap(), [77, 0, 0, 0, 0xfe, 0xff]);
            assert_eq!(table.write(data.address, &[1]), Err(Refusal::Length));
            assert_eq!(table.write(data.address + 4, &[1]), Err(Refusal::Length));
            assert_eq!(table.write(addresses.address, &[63, 0]), Err(Refusal::Range));
        }
    }

    #[test]
    fn one_bad_register_keeps_all_from_being_written() {
        let mut table = ControlTable::new(&XL430_W250, true);
        let data = [10u32.to_le_bytes(), 10u32.to_le_bytes(), 9999u32.to_le_bytes()].concat();
        assert_eq!(table.write(108, &data), Err(Refusal::Limit));
        assert_eq!(table.unsigned(PROFILE_ACCELERATION), 0);
    }

    #[test]
    fn a_loss_of_power_spares_the_eeprom() {
        let mut table = ControlTable::new(&XL430_W250, true);
        written(&mut table, RETURN_DELAY, 0).unwrap();
        written(&mut table, PROFILE_VELOCITY, 9).unwrap();
        table.reset_ram();
        assert_eq!((table.unsigned(RETURN_DELAY), table.unsigned(PROFILE_VELOCITY)), (0, 0));
        table.reset_all_but(&[ID]);
        assert_eq!(table.unsigned(RETURN_DELAY), 250);
    }

    proptest! {
        #[test]
        fn no_write_panics_and_what_is_accepted_is_read_back(writes in proptest::collection::vec((0u16..700, proptest::collection::vec(any::<u8>(), 0..12)), 0..40)) {
            let mut table = ControlTable::new(&XL430_W250, true);
            for (address, data) in writes {
                if table.write(address, &data).is_ok() && !(168..252).contains(&address) && !(578..662).contains(&address) {
                    prop_assert_eq!(table.read(address, data.len() as u16).unwrap(), data);
                }
                let _ = table.read(address, 8);
            }
        }
    }
}
