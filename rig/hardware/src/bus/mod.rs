//! The servo bus: Dynamixel protocol 2.0 on a serial port.
//!
//! A cycle is one sync write of all goals and one sync read of one block of 12 bytes from every servo, put together
//! by indirect addresses: torque, hardware errors, load, speed, position. The first two are there so that a servo
//! that tripped, or that lost its supply for a moment and with it its settings, is seen in the same cycle.

mod arm;
mod baseline;
mod bounds;
mod check;
mod counts;
mod duplicates;
pub mod model;
pub mod packet;
mod ports;
pub mod registers;
mod torque;
mod torque_state;
mod wire;
pub mod xl430;

use crate::config::ServoConfig;
use crate::{Error, Event, EventKind, Result, ServoSample, SlowSample};
pub use arm::{ArmServoSample, ServoStatus};
use baseline::Examined;
pub use baseline::{RegisterBaseline, RegisterDifference, differences};
pub use bounds::ServoBounds;
pub use check::ServoReport;
pub use counts::BusCounts;
pub use ports::{PortInfo, find_port, list_ports};
use registers::TABLE;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
pub use torque_state::{ServoTorque, TorqueState, describe_torques};
use wire::{BROADCAST, INSTRUCTION_BYTES, STATUS_BYTES, TransferFailure, Wire, instruction, range};
use xl430::ControlRegister;

/// Registers that the indirect addresses map into one block, in this order.
const BLOCK: [ControlRegister; 5] = [
    xl430::TORQUE_ENABLE,
    xl430::HARDWARE_ERROR,
    xl430::PRESENT_LOAD,
    xl430::PRESENT_VELOCITY,
    xl430::PRESENT_POSITION,
];
const BLOCK_BYTES: usize = 12;
/// Voltage and temperature are contiguous.
const SLOW_BYTES: usize = 3;

/// Longest that a register of a servo is asked for while no torque depends on it, all questions together, where the rig
/// file's timeout and retries are not longer.
pub const REGISTER_PATIENCE: Duration = Duration::from_secs(2);

/// How often a servo that does not answer is asked again.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum ReplyPatience {
    /// As often as in the rig file: a cycle is running, or others are under torque.
    Retries,
    /// So often, and until [`REGISTER_PATIENCE`] is over, each time for twice as long: a computer with other work to do
    /// gets an answer late, and nothing moves meanwhile.
    Register,
}

/// How long to wait for a port that another program has.
const PATIENCE: Duration = Duration::from_secs(2);

/// All servos of a rig.
#[derive(Debug)]
pub struct ServoBus {
    wire: Option<Wire>,
    port: PathBuf,
    config: ServoConfig,
    ids: Vec<u8>,
    counts: BusCounts,
    events: Vec<Event>,
    clock: Instant,
    scratch: Vec<u8>,
    /// Registers that the last self-check read of every servo; empty before.
    examined: Vec<Examined>,
    /// Whether the registers are accepted: without it no torque is switched on.
    is_accepted: bool,
    /// Duration of the last cycle's transfers [s].
    pub last_bus_time: f64,
}

impl ServoBus {
    /// Opens the port. Servos are not touched.
    ///
    /// `clock` is where the times of events start.
    ///
    /// # Errors
    /// `Bus` if there is no such port or it is not a serial one.
    pub fn open(config: &ServoConfig, ids: &[u8], clock: Instant) -> Result<Self> {
        let port = find_port(&config.port)?;
        let wire = open_patiently(&port, config)
            .map_err(|e| Error::Bus(format!("{}: {e} (hint: {})", port.display(), ports::hint(&e))))?;
        Ok(Self {
            wire: Some(wire),
            port,
            config: config.clone(),
            ids: ids.to_vec(),
            counts: BusCounts::default(),
            events: Vec::new(),
            clock,
            scratch: Vec::with_capacity(128),
            examined: Vec::new(),
            is_accepted: false,
            last_bus_time: 0.0,
        })
    }

    /// The port in use.
    pub fn port(&self) -> &std::path::Path {
        &self.port
    }

    /// Ids of the servos, in the order of the tendons.
    pub fn ids(&self) -> &[u8] {
        &self.ids
    }

    /// Counts since the bus was opened.
    pub fn counts(&self) -> BusCounts {
        let mut counts = self.counts;
        if let Some(wire) = &self.wire {
            counts += wire.counts;
        }
        counts
    }

    /// Time that the bytes of a cycle take on the wire [s]: goals written, block read.
    pub fn cycle_wire_time(&self) -> f64 {
        let n = self.ids.len();
        let bytes =
            (INSTRUCTION_BYTES + 4 + 5 * n) + (INSTRUCTION_BYTES + 4 + n) + n * (STATUS_BYTES + BLOCK_BYTES);
        10.0 * bytes as f64 / f64::from(self.config.baud)
    }

    /// Makes the servos ready, with their torque off: every register that is set before a run, and the block of indirect
    /// addresses; then reads all of it back. The self-check must have accepted their registers.
    ///
    /// # Errors
    /// `Bus` naming the servo and the register.
    pub fn configure(&mut self) -> Result<()> {
        self.check_accepted()?;
        for (k, id) in self.ids.clone().into_iter().enumerate() {
            self.write(id, xl430::BUS_WATCHDOG, 0)?;
            self.write(id, xl430::TORQUE_ENABLE, 0)?;
            let servo = self.examined[k].clone();
            // The mode comes before the gains, which it resets.
            for spec in TABLE.iter().filter(|spec| spec.is_of(servo.model)) {
                if let Some(value) = self.required(&servo, spec) {
                    self.write(id, spec.register, i32::try_from(value).unwrap_or(0).cast_unsigned())?;
                }
            }
            let addresses = BLOCK.iter().flat_map(|r| r.address..r.address + u16::from(r.size));
            for (slot, address) in (0_u16..).zip(addresses) {
                let register =
                    ControlRegister { address: xl430::INDIRECT_ADDRESS.address + 2 * slot, size: 2 };
                self.write(id, register, u32::from(address))?;
            }
        }
        self.confirm_settings()
    }

    /// A motor is not driven while the meaning of one of its registers is unknown.
    fn check_accepted(&self) -> Result<()> {
        let what = "the servos' registers have not been read and compared, so no torque goes on";
        if self.is_accepted { Ok(()) } else { Err(Error::Bus(what.into())) }
    }

    /// Commands all servos [ticks].
    ///
    /// # Errors
    /// `Bus` if their registers were not accepted, or the port is gone and does not come back at once.
    pub fn write_goals(&mut self, goals: &[i32]) -> Result<()> {
        // A goal alone can switch torque on.
        self.check_accepted()?;
        let started = Instant::now();
        self.scratch.clear();
        self.scratch.extend(range(xl430::GOAL_POSITION.address, 4));
        for (id, goal) in self.ids.iter().zip(goals) {
            self.scratch.push(*id);
            self.scratch.extend(goal.to_le_bytes());
        }
        let parameters = std::mem::take(&mut self.scratch);
        let sent = self.with_wire(|wire| wire.send(BROADCAST, instruction::SYNC_WRITE, &parameters));
        self.scratch = parameters;
        self.last_bus_time = started.elapsed().as_secs_f64();
        sent.map_err(|failure| Error::Bus(failure.to_string()))
    }

    /// Reads all servos; `None` for one that did not answer although asked again.
    ///
    /// # Errors
    /// `Bus` if the port is gone and does not come back at once.
    pub fn read_servos(&mut self, samples: &mut [Option<ServoSample>]) -> Result<()> {
        let started = Instant::now();
        let read = self.sync_read(xl430::INDIRECT_DATA.address, BLOCK_BYTES, samples, servo_sample);
        self.last_bus_time += started.elapsed().as_secs_f64();
        read
    }

    /// Reads voltage and temperature of all servos; `None` as above.
    ///
    /// # Errors
    /// As [`ServoBus::read_servos`].
    pub fn read_slow(&mut self, samples: &mut [Option<SlowSample>]) -> Result<()> {
        self.sync_read(xl430::PRESENT_VOLTAGE.address, SLOW_BYTES, samples, |bytes| SlowSample {
            voltage: xl430::VOLTAGE_UNIT * f64::from(u16::from_le_bytes([bytes[0], bytes[1]])),
            temperature: f64::from(bytes[2]),
        })
    }

    /// Ends the bus watchdog of all servos, without changing their torque.
    ///
    /// # Errors
    /// `Bus` naming the servos that did not confirm.
    pub fn stop_watchdog(&mut self) -> Result<()> {
        let failed: Vec<String> = self
            .ids
            .clone()
            .into_iter()
            .filter_map(|id| self.write_with((id, ReplyPatience::Retries), xl430::BUS_WATCHDOG, 0).err())
            .map(Error::reason)
            .collect();
        all_done(&failed)
    }

    /// Appends what went wrong since the last call.
    pub fn take_events(&mut self, events: &mut Vec<Event>) {
        events.append(&mut self.events);
    }

    /// Writes a register and waits for the servo to confirm, for [`REGISTER_PATIENCE`] at most.
    ///
    /// # Errors
    /// `Bus` naming the servo and the address.
    pub fn write(&mut self, id: u8, register: ControlRegister, value: u32) -> Result<()> {
        self.write_with((id, ReplyPatience::Register), register, value)
    }

    fn write_with(
        &mut self,
        (id, patience): (u8, ReplyPatience),
        register: ControlRegister,
        value: u32,
    ) -> Result<()> {
        let mut parameters = Vec::with_capacity(6);
        parameters.extend(register.address.to_le_bytes());
        parameters.extend(&value.to_le_bytes()[..usize::from(register.size)]);
        let done = self.persist((id, patience), |wire| {
            let done = wire.ask(id, instruction::WRITE, &parameters, 0).map(|_| ());
            wire.settle_after(&done);
            done
        });
        done.map_err(|failure| at(id, register, &failure))
    }

    /// Reads a register, as an unsigned number, waiting for [`REGISTER_PATIENCE`] at most.
    ///
    /// # Errors
    /// `Bus` naming the servo and the address.
    pub fn read(&mut self, id: u8, register: ControlRegister) -> Result<u32> {
        self.read_with((id, ReplyPatience::Register), register)
    }

    fn read_with(&mut self, (id, patience): (u8, ReplyPatience), register: ControlRegister) -> Result<u32> {
        let size = usize::from(register.size);
        let parameters = range(register.address, u16::from(register.size));
        let read = self.persist((id, patience), |wire| {
            let read = wire.ask(id, instruction::READ, &parameters, size).map(|answer| {
                let mut bytes = [0; 4];
                bytes[..size].copy_from_slice(answer.parameters);
                u32::from_le_bytes(bytes)
            });
            wire.settle_after(&read);
            read
        });
        read.map_err(|failure| at(id, register, &failure))
    }

    /// One sync read; a servo whose answer is missing or damaged is asked again separately.
    fn sync_read<T>(
        &mut self,
        address: u16,
        length: usize,
        samples: &mut [Option<T>],
        parse: impl Fn(&[u8]) -> T,
    ) -> Result<()> {
        samples.iter_mut().for_each(|sample| *sample = None);
        let ids = std::mem::take(&mut self.ids);
        let count = u16::try_from(length).unwrap_or(u16::MAX);
        self.scratch.clear();
        self.scratch.extend(range(address, count));
        self.scratch.extend(&ids);
        let parameters = std::mem::take(&mut self.scratch);
        let mut troubles: Vec<TransferFailure> = Vec::new();
        let sent = self.with_wire(|wire| {
            wire.send(BROADCAST, instruction::SYNC_READ, &parameters)?;
            let answered = ids.len() * (STATUS_BYTES + length);
            let deadline = wire.deadline(INSTRUCTION_BYTES + parameters.len(), answered);
            while samples.iter().any(Option::is_none) {
                match wire.receive(length, deadline) {
                    Ok(answer) => {
                        if let Some(k) = ids.iter().position(|id| *id == answer.id) {
                            samples[k] = Some(parse(answer.parameters));
                        }
                    }
                    Err(TransferFailure::Timeout) => break,
                    Err(failure @ TransferFailure::Port(_)) => return Err(failure),
                    Err(failure) => troubles.push(failure),
                }
            }
            Ok(())
        });
        self.scratch = parameters;
        for failure in &troubles {
            self.note(None, failure);
        }
        let mut outcome = sent.map_err(|failure| Error::Bus(failure.to_string()));
        for (k, &id) in ids.iter().enumerate() {
            if outcome.is_err() || samples[k].is_some() {
                continue;
            }
            if troubles.is_empty() {
                self.note(Some(id), &TransferFailure::Timeout);
            }
            let parameters = range(address, count);
            self.counts.retries += 1;
            let again = self.persist((id, ReplyPatience::Retries), |wire| {
                wire.ask(id, instruction::READ, &parameters, length).map(|answer| parse(answer.parameters))
            });
            match again {
                Ok(sample) => samples[k] = Some(sample),
                Err(TransferFailure::Port(why)) => outcome = Err(Error::Bus(why)),
                Err(_) => self.counts.lost += 1,
            }
        }
        self.ids = ids;
        outcome
    }

    /// Tries a transfer with one servo until it succeeds, or has failed as often and as long as it may.
    fn persist<T>(
        &mut self,
        (id, patience): (u8, ReplyPatience),
        mut transfer: impl FnMut(&mut Wire) -> std::result::Result<T, TransferFailure>,
    ) -> std::result::Result<T, TransferFailure> {
        let (start, usual) = (Instant::now(), Duration::from_secs_f64(self.config.reply_timeout));
        let (mut attempt, mut timeout) = (0, usual);
        loop {
            match self.with_wire(|wire| wire.waiting(timeout, &mut transfer)) {
                Ok(done) => return Ok(done),
                Err(failure) => {
                    // The loss of the port is noted once, where it is seen.
                    if !matches!(failure, TransferFailure::Port(_)) {
                        self.note(Some(id), &failure);
                    }
                    let is_final = matches!(failure, TransferFailure::Refused(_) | TransferFailure::Port(_));
                    let mut left = Duration::ZERO;
                    if patience == ReplyPatience::Register && failure == TransferFailure::Timeout {
                        left = REGISTER_PATIENCE.saturating_sub(start.elapsed());
                        timeout = (2 * timeout).min(left.max(usual));
                    }
                    if is_final || attempt >= self.config.retries && left < usual {
                        return Err(failure);
                    }
                    attempt += 1;
                    self.counts.retries += 1;
                }
            }
        }
    }

    /// Uses the port, opening it again if it was lost; a port that fails is dropped.
    fn with_wire<T>(
        &mut self,
        mut transfer: impl FnMut(&mut Wire) -> std::result::Result<T, TransferFailure>,
    ) -> std::result::Result<T, TransferFailure> {
        if self.wire.is_none() {
            let opened = find_port(&self.config.port).map_err(|e| e.to_string()).and_then(|port| {
                Wire::open(&port, self.config.baud, self.config.reply_timeout).map_err(|e| e.to_string())
            });
            self.wire = Some(opened.map_err(TransferFailure::Port)?);
            self.counts.reopened += 1;
            self.note_event(None, EventKind::BusBack, "the port is back".into());
        }
        let Some(wire) = &mut self.wire else { return Err(TransferFailure::Port("closed".into())) };
        let done = transfer(wire);
        if let Err(failure @ TransferFailure::Port(_)) = &done {
            self.counts += wire.counts;
            self.wire = None;
            self.note(None, failure);
        }
        done
    }

    fn note(&mut self, servo: Option<u8>, failure: &TransferFailure) {
        let kind = match failure {
            TransferFailure::Timeout => EventKind::Timeout,
            TransferFailure::Corrupt(_) => EventKind::Corrupt,
            TransferFailure::Refused(_) => EventKind::Refused,
            TransferFailure::Port(_) => EventKind::BusLost,
        };
        self.note_event(servo, kind, failure.to_string());
    }

    fn note_event(&mut self, servo: Option<u8>, kind: EventKind, message: String) {
        let time_s = self.clock.elapsed().as_secs_f64();
        self.events.push(Event { time_s, kind, servo, message });
    }
}

/// Opens a port as soon as no other process has it: the watchdog process of a run that died may still be running.
fn open_patiently(port: &Path, config: &ServoConfig) -> std::io::Result<Wire> {
    let start = Instant::now();
    loop {
        match Wire::open(port, config.baud, config.reply_timeout) {
            Err(e) if e.kind() == std::io::ErrorKind::WouldBlock && start.elapsed() < PATIENCE => {
                std::thread::sleep(PATIENCE / 50);
            }
            opened => return opened,
        }
    }
}

/// One error for all servos that failed.
fn all_done(failed: &[String]) -> Result<()> {
    if failed.is_empty() { Ok(()) } else { Err(Error::Bus(failed.join("; "))) }
}

fn at(id: u8, register: ControlRegister, failure: &TransferFailure) -> Error {
    Error::Bus(format!("servo {id}, register {}: {failure}", register.address))
}

/// The block that the indirect addresses put together.
fn servo_sample(bytes: &[u8]) -> ServoSample {
    let word = |at: usize| i32::from_le_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]]);
    ServoSample {
        torque_on: bytes[0] == 1,
        hardware_error: bytes[1],
        load: xl430::LOAD_UNIT * f64::from(i16::from_le_bytes([bytes[2], bytes[3]])),
        velocity: xl430::VELOCITY_UNIT * f64::from(word(4)),
        position: word(8),
    }
}
