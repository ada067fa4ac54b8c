//! The self-check: who is on the bus, expected against found, everything wrong in one message.

use super::baseline::Examined;
use super::duplicates::Presence;
use super::model::ServoModel;
use super::registers::StoredRegisters;
use super::wire::{BROADCAST, STATUS_BYTES, TransferFailure, instruction, range};
use super::{ReplyPatience, ServoBounds, ServoBus, xl430};
use crate::{Error, Result};
use serde::Serialize;

/// Identity and state of a servo, as read from its registers.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ServoReport {
    /// Id on the bus.
    pub id: u8,
    /// Model number, see [`ServoModel`].
    pub model: u16,
    /// Version of the firmware.
    pub firmware: u8,
    /// Operating mode, as the register states it.
    pub mode: u8,
    /// Supply voltage [V].
    pub voltage_v: f64,
    /// Temperature [°C].
    pub temperature_degc: f64,
    /// Register of hardware errors.
    pub hardware_error: u8,
    /// Whether its torque is on.
    pub torque_on: bool,
    /// Position [ticks].
    pub position: i32,
    /// Registers that a calibration stores; empty for servos that have none.
    pub registers: StoredRegisters,
}

/// Status return level at which a servo answers everything.
const ANSWER_ALL: u8 = 2;
/// How long all servos of a bus take to answer a broadcast, each at its own time [s]: the manual's 3 ms a servo.
const BROADCAST_WAIT: f64 = 3e-3 * 16.0;

impl ServoBus {
    /// Ids, models and firmwares of all servos that answer a broadcast.
    ///
    /// # Errors
    /// `Bus` if the port is gone.
    pub fn discover(&mut self) -> Result<Vec<(u8, u16, u8)>> {
        let found = self.with_wire(|wire| {
            let mut found = Vec::new();
            wire.send(BROADCAST, instruction::PING, &[])?;
            let deadline = wire.deadline(10, 16 * (STATUS_BYTES + 3))
                + std::time::Duration::from_secs_f64(BROADCAST_WAIT);
            loop {
                match wire.receive(3, deadline) {
                    Ok(answer) => {
                        let [low, high, firmware] = [0, 1, 2].map(|i| answer.parameters[i]);
                        found.push((answer.id, u16::from_le_bytes([low, high]), firmware));
                    }
                    Err(failure @ TransferFailure::Port(_)) => return Err(failure),
                    // The end is an ordinary timeout.
                    Err(TransferFailure::Timeout) => {
                        wire.counts.timeouts -= 1;
                        return Ok(found);
                    }
                    Err(_) => {}
                }
            }
        });
        found.map_err(|failure| Error::Bus(failure.to_string()))
    }

    /// Restarts a servo: clears a hardware error whose cause is gone. Its settings in RAM are lost.
    ///
    /// # Errors
    /// `Bus` if it does not confirm.
    pub fn reboot(&mut self, id: u8) -> Result<()> {
        let done = self.persist((id, ReplyPatience::Retries), |wire| {
            wire.ask(id, instruction::REBOOT, &[], 0).map(|_| ())
        });
        done.map_err(|failure| Error::Bus(format!("servo {id}: reboot: {failure}")))
    }

    /// Reads the registers of every servo and compares them with their expected values: its model, in the order of
    /// [`ServoBus::ids`], and its bounds. Its registers are read, and compared by [`ServoBus::accept_registers`].
    ///
    /// # Errors
    /// `Bus` with everything that is wrong, one line each.
    pub fn self_check(
        &mut self,
        expected: &[(&'static ServoModel, ServoBounds)],
    ) -> Result<Vec<ServoReport>> {
        self.examined.clear();
        self.is_accepted = false;
        let found = self.discover()?;
        let mut wrong = Vec::new();
        let mut reports = Vec::new();
        let mut present = Vec::new();
        for id in self.ids().to_vec() {
            self.make_answer(id)?;
            present.push((id, self.presence(id)?));
        }
        wrong.extend(self.describe_duplicates(&present));
        for ((id, presence), (model, bounds)) in present.iter().zip(expected) {
            if *presence == Presence::Silent {
                wrong.push(format!("servo {id}: expected an {} to answer, got silence", model.name));
            }
            if *presence != Presence::Alone {
                continue;
            }
            match self.report(*id, model) {
                Ok(report) => {
                    wrong.extend(deviations(&report, model, bounds));
                    reports.push(report);
                }
                Err(error) => wrong.push(error.reason()),
            }
        }
        if wrong.is_empty() {
            return Ok(reports);
        }
        let others: Vec<String> = found
            .iter()
            .filter(|(id, ..)| !self.ids().contains(id))
            .map(|(id, model, _)| format!("{id} (model {model})"))
            .collect();
        if !others.is_empty() {
            wrong.push(format!("also on the bus: servo {}", others.join(", servo ")));
        }
        if found.is_empty() && present.iter().all(|(_, presence)| *presence == Presence::Silent) {
            wrong.push(format!(
                "no servo answers at {} baud (hint: is the supply on? new servos come with id 1 and 57600 baud)",
                self.config.baud
            ));
        }
        Err(Error::Bus(format!("{}: self-check failed:\n  {}", self.port().display(), wrong.join("\n  "))))
    }

    /// Sets a servo to answer everything, by a write that needs no answer: at a lower status return level it would
    /// seem silent. The register is forgotten without power, and every run sets it.
    fn make_answer(&mut self, id: u8) -> Result<()> {
        let mut parameters = range(xl430::STATUS_RETURN.address, 1).to_vec();
        parameters.extend([id, ANSWER_ALL]);
        let sent = self.with_wire(|wire| wire.send(BROADCAST, instruction::SYNC_WRITE, &parameters));
        sent.map_err(|failure| Error::Bus(failure.to_string()))
    }

    fn report(&mut self, id: u8, model: &'static ServoModel) -> Result<ServoReport> {
        let image = self.read_image(id)?;
        let mut byte = |register| self.read(id, register).map(|value| (value & 0xff) as u8);
        let mode = byte(xl430::OPERATING_MODE)?;
        let hardware_error = byte(xl430::HARDWARE_ERROR)?;
        let torque_on = byte(xl430::TORQUE_ENABLE)? == 1;
        let temperature = byte(xl430::PRESENT_TEMPERATURE)?;
        let firmware = byte(xl430::FIRMWARE)?;
        let number = self.read(id, xl430::MODEL_NUMBER)?;
        let registers = image.stored(model);
        self.examined.push(Examined { model, image });
        Ok(ServoReport {
            id,
            model: u16::try_from(number).unwrap_or(u16::MAX),
            firmware,
            mode,
            voltage_v: xl430::VOLTAGE_UNIT * f64::from(self.read(id, xl430::PRESENT_VOLTAGE)?),
            temperature_degc: f64::from(temperature),
            hardware_error,
            torque_on,
            position: self.read(id, xl430::PRESENT_POSITION)?.cast_signed(),
            registers,
        })
    }
}

/// Deviations of a servo from its expected state. A mode other than the rig's is set before a run, so it is
/// none.
fn deviations(found: &ServoReport, model: &ServoModel, bounds: &ServoBounds) -> Vec<String> {
    let id = found.id;
    let mut wrong = Vec::new();
    if found.model != model.number {
        let (number, name) = (model.number, model.name);
        wrong.push(format!("servo {id}: expected model {number} ({name}), got {}", found.model));
    }
    if !(bounds.voltage_min..=bounds.voltage_max).contains(&found.voltage_v) {
        wrong.push(format!(
            "servo {id}: expected {} to {} V, got {:.1} V (hint: check the supply and its plug)",
            bounds.voltage_min, bounds.voltage_max, found.voltage_v
        ));
    }
    if found.temperature_degc > bounds.temperature_max {
        wrong.push(format!(
            "servo {id}: expected at most {} degrees C, got {} (hint: let it cool)",
            bounds.temperature_max, found.temperature_degc
        ));
    }
    if found.hardware_error != 0 {
        wrong.push(format!(
            "servo {id}: expected no hardware error, got {} (hint: remove the cause, then `hysteron rig check --reboot`)",
            xl430::describe_errors(found.hardware_error)
        ));
    }
    wrong
}
