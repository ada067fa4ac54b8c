//! Torque of all servos: on one by one, each confirmed; off by one instruction to all, and only then confirmed.

use super::wire::{BROADCAST, Failure, instruction, range};
use super::xl430::{self, Register};
use super::{Error, Result, ServoBus, all_done};

/// Values of the torque register.
const OFF: u8 = 0;
const ON: u8 = 1;

impl ServoBus {
    /// Switches the torque of all servos on, reads it back, and starts their watchdogs.
    ///
    /// # Errors
    /// `Bus` naming the servos that did not confirm; the others are then under torque.
    pub fn enable_torque(&mut self) -> Result<()> {
        let mut failed = Vec::new();
        for id in self.ids.clone() {
            let switched = self.write(id, xl430::BUS_WATCHDOG, 0).and_then(|()| self.switch(id, ON));
            failed.extend(switched.err().map(Error::reason));
        }
        all_done(&failed)?;
        let watchdog = (self.config.bus_watchdog / xl430::WATCHDOG_UNIT).round() as u32;
        if watchdog > 0 {
            for id in self.ids.clone() {
                self.write(id, xl430::BUS_WATCHDOG, watchdog)?;
            }
        }
        Ok(())
    }

    /// Switches the torque of all servos off.
    ///
    /// One sync write, to which nobody answers, reaches all at once: a silent servo keeps no other waiting. Then
    /// each is asked once, and only those that did not confirm are told again one by one, with retries. Their
    /// watchdogs end.
    ///
    /// # Errors
    /// `Bus` naming the servos that did not confirm.
    pub fn disable_torque(&mut self) -> Result<()> {
        let mut sent = self.write_to_all(xl430::TORQUE_ENABLE, OFF);
        if sent.is_err() {
            // A port that was plugged in again is opened by the next transfer.
            sent = self.write_to_all(xl430::TORQUE_ENABLE, OFF);
        }
        sent?;
        self.write_to_all(xl430::BUS_WATCHDOG, 0)?;
        let (mut silent, mut failed) = (Vec::new(), Vec::new());
        for id in self.ids.clone() {
            match self.look(id) {
                Ok(OFF) => {}
                Ok(_) => failed.extend(self.switch(id, OFF).err().map(Error::reason)),
                Err(_) => silent.push(id),
            }
        }
        for id in silent {
            failed.extend(self.switch(id, OFF).err().map(Error::reason));
        }
        all_done(&failed)
    }

    /// Switches one servo and reads it back, with retries.
    fn switch(&mut self, id: u8, wanted: u8) -> Result<()> {
        self.write(id, xl430::TORQUE_ENABLE, u32::from(wanted))?;
        if self.read(id, xl430::TORQUE_ENABLE)? == u32::from(wanted) {
            return Ok(());
        }
        Err(Error::Bus(format!("servo {id} did not switch")))
    }

    /// Writes a register of one byte of all servos in one packet, without an answer.
    fn write_to_all(&mut self, register: Register, value: u8) -> Result<()> {
        let mut parameters = range(register.address, 1).to_vec();
        parameters.extend(self.ids.iter().flat_map(|id| [*id, value]));
        let sent = self.with_wire(|wire| wire.send(BROADCAST, instruction::SYNC_WRITE, &parameters));
        sent.map_err(|failure| Error::Bus(failure.to_string()))
    }

    /// Asks one servo once whether its torque is on.
    fn look(&mut self, id: u8) -> std::result::Result<u8, Failure> {
        let parameters = range(xl430::TORQUE_ENABLE.address, 1);
        let read =
            self.with_wire(|wire| wire.ask(id, instruction::READ, &parameters, 1).map(|a| a.parameters[0]));
        if let Err(failure) = &read
            && !matches!(failure, Failure::Port(_))
        {
            self.note(Some(id), failure);
        }
        read
    }
}
