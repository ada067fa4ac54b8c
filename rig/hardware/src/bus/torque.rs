//! Torque of all servos: on one by one, each confirmed; off by one instruction to all, and only then confirmed, each
//! servo with a state of its own.

use super::torque_state::{ServoTorque, TorqueState};
use super::wire::{BROADCAST, TransferFailure, instruction, range};
use super::xl430::{self, ControlRegister};
use super::{Error, ReplyPatience, Result, ServoBus, all_done};

/// Values of the torque register.
const OFF: u8 = 0;
const ON: u8 = 1;

impl ServoBus {
    /// Switches the torque of all servos on, reads it back, and starts their watchdogs.
    ///
    /// # Errors
    /// `Bus` if their registers were not accepted; naming the servos that did not confirm, with the others then under
    /// torque.
    pub fn enable_torque(&mut self) -> Result<()> {
        self.check_accepted()?;
        let mut failed = Vec::new();
        for id in self.ids.clone() {
            let one = (id, ReplyPatience::Retries);
            let switched = self.write_with(one, xl430::BUS_WATCHDOG, 0).and_then(|()| self.switch(id, ON));
            failed.extend(switched.err().map(Error::reason));
        }
        all_done(&failed)?;
        let watchdog = (self.config.bus_watchdog / xl430::WATCHDOG_UNIT).round() as u32;
        if watchdog > 0 {
            for id in self.ids.clone() {
                self.write_with((id, ReplyPatience::Retries), xl430::BUS_WATCHDOG, watchdog)?;
            }
        }
        Ok(())
    }

    /// Switches the torque of all servos off.
    ///
    /// One sync write, which has no answer, reaches all at once: a silent servo does not delay the others. Then
    /// each is asked once, and only those that did not confirm are commanded again one by one, with retries. Their
    /// watchdogs end.
    ///
    /// # Errors
    /// `Torque` with the state of every servo, if one did not confirm; `Bus` if the port is gone.
    pub fn disable_torque(&mut self) -> Result<()> {
        let mut sent = self.write_to_all(xl430::TORQUE_ENABLE, OFF);
        if sent.is_err() {
            // A port that was plugged in again is opened by the next transfer.
            sent = self.write_to_all(xl430::TORQUE_ENABLE, OFF);
        }
        sent?;
        self.write_to_all(xl430::BUS_WATCHDOG, 0)?;
        let ids = self.ids.clone();
        let mut states: Vec<ServoTorque> = Vec::with_capacity(ids.len());
        for id in ids {
            let state = match self.look(id) {
                Ok(OFF) => TorqueState::Off,
                Ok(_) => self.switch_off(id),
                Err(_) => TorqueState::Silent,
            };
            states.push(ServoTorque { servo: id, state });
        }
        for one in states.iter_mut().filter(|one| one.state == TorqueState::Silent) {
            one.state = self.switch_off(one.servo);
        }
        if states.iter().all(|one| one.state == TorqueState::Off) {
            Ok(())
        } else {
            Err(Error::Torque(states))
        }
    }

    /// Switches one servo off, with retries; what is known of it then.
    fn switch_off(&mut self, id: u8) -> TorqueState {
        if self.switch(id, OFF).is_ok() {
            return TorqueState::Off;
        }
        match self.look(id) {
            Ok(OFF) => TorqueState::Off,
            Ok(_) => TorqueState::On,
            Err(_) => TorqueState::Silent,
        }
    }

    /// Switches one servo and reads it back, with retries.
    fn switch(&mut self, id: u8, value: u8) -> Result<()> {
        let one = (id, ReplyPatience::Retries);
        self.write_with(one, xl430::TORQUE_ENABLE, u32::from(value))?;
        if self.read_with(one, xl430::TORQUE_ENABLE)? == u32::from(value) {
            return Ok(());
        }
        Err(Error::Bus(format!("servo {id} did not switch")))
    }

    /// Writes a register of one byte of all servos in one packet, without an answer.
    fn write_to_all(&mut self, register: ControlRegister, value: u8) -> Result<()> {
        let mut parameters = range(register.address, 1).to_vec();
        parameters.extend(self.ids.iter().flat_map(|id| [*id, value]));
        let sent = self.with_wire(|wire| wire.send(BROADCAST, instruction::SYNC_WRITE, &parameters));
        sent.map_err(|failure| Error::Bus(failure.to_string()))
    }

    /// Asks one servo once whether its torque is on.
    fn look(&mut self, id: u8) -> std::result::Result<u8, TransferFailure> {
        let parameters = range(xl430::TORQUE_ENABLE.address, 1);
        let read =
            self.with_wire(|wire| wire.ask(id, instruction::READ, &parameters, 1).map(|a| a.parameters[0]));
        if let Err(failure) = &read
            && !matches!(failure, TransferFailure::Port(_))
        {
            self.note(Some(id), failure);
        }
        read
    }
}
