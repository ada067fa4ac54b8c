//! The servos on one bus: which servos an instruction addresses, its effects, and the order of their answers.
//!
//! In sync and bulk reads each servo answers when it has heard the one before it in the list, as in ROBOTIS's own
//! device code; behind one that is silent, all are.

use super::servo::EmulatedServo;
use super::table::Refusal;
use super::world::ServoWorld;
use hysteron_rig::bus::packet::{BROADCAST, STATUS, fast_status, status};
use hysteron_rig::bus::xl430::{self, ControlRegister};

mod instruction {
    pub const PING: u8 = 0x01;
    pub const READ: u8 = 0x02;
    pub const WRITE: u8 = 0x03;
    pub const REG_WRITE: u8 = 0x04;
    pub const ACTION: u8 = 0x05;
    pub const FACTORY_RESET: u8 = 0x06;
    pub const REBOOT: u8 = 0x08;
    pub const CLEAR: u8 = 0x10;
    pub const SYNC_READ: u8 = 0x82;
    pub const SYNC_WRITE: u8 = 0x83;
    pub const FAST_SYNC_READ: u8 = 0x8a;
    pub const BULK_READ: u8 = 0x92;
    pub const BULK_WRITE: u8 = 0x93;
    pub const FAST_BULK_READ: u8 = 0x9a;
}

/// Parameters of the clear instruction that forgets whole turns.
const CLEAR_TURNS: [u8; 5] = [0x01, 0x44, 0x58, 0x4c, 0x22];

/// A packet that a servo sends.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct ServoReply {
    /// Whose it is.
    pub id: u8,
    /// The packet.
    pub bytes: Vec<u8>,
    /// Time that the servo waits before it sends [s].
    pub delay: f64,
}

/// All answers to one instruction.
#[derive(Debug, Default, PartialEq)]
pub(super) struct Reply {
    /// In the order in which they are sent.
    pub answers: Vec<ServoReply>,
    /// Answers that a sync read asked for.
    pub n_asked: Option<usize>,
}

/// The servos on one bus.
#[derive(Debug)]
pub(super) struct ServoChain {
    /// All servos, whether they have power or not.
    pub servos: Vec<EmulatedServo>,
    /// Whether each receives from the bus now: baud, plug and power (n_servos).
    pub hears: Vec<bool>,
}

/// A part of a table to be read: id, address, count.
type TableRead = (u8, u16, u16);

impl ServoChain {
    /// Brings all servos up to date with the world.
    pub fn refresh(&mut self, world: &mut dyn ServoWorld) {
        self.servos.iter_mut().for_each(|servo| servo.refresh(world));
    }

    /// The bus has not been silent until now.
    pub fn hear(&mut self, time: f64) {
        self.servos.iter_mut().for_each(|servo| servo.hear(time));
    }

    /// Carries out an instruction.
    pub fn handle(&mut self, id: u8, body: &[u8], world: &mut dyn ServoWorld) -> Reply {
        let Some((&number, parameters)) = body.split_first() else { return Reply::default() };
        if number == STATUS {
            return Reply::default();
        }
        for k in 0..self.servos.len() {
            if self.hears[k] {
                self.servos[k].hear(world.time());
            }
        }
        match (number, id) {
            (instruction::SYNC_READ, BROADCAST) => {
                self.read_each(&sync_parts(parameters).unwrap_or_default(), true)
            }
            (instruction::BULK_READ, BROADCAST) => {
                self.read_each(&bulk_parts(parameters).unwrap_or_default(), false)
            }
            (instruction::FAST_SYNC_READ, BROADCAST) => {
                self.read_fast(&sync_parts(parameters).unwrap_or_default())
            }
            (instruction::FAST_BULK_READ, BROADCAST) => {
                self.read_fast(&bulk_parts(parameters).unwrap_or_default())
            }
            (instruction::SYNC_WRITE, BROADCAST) => self.write_each(sync_writes(parameters), world),
            (instruction::BULK_WRITE, BROADCAST) => self.write_each(bulk_writes(parameters), world),
            _ => self.handle_plain(id, number, parameters, world),
        }
    }

    /// A packet whose checksum is wrong: the addressed servo reports it.
    pub fn checksum_error(&self, id: u8) -> Reply {
        let answers =
            self.listening(id).filter(|k| self.servos[*k].table.unsigned(xl430::STATUS_RETURN) == 2);
        Reply { answers: answers.map(|k| self.answer(k, Err(Refusal::Checksum))).collect(), n_asked: None }
    }

    /// Servos that receive and have this id.
    fn listening(&self, id: u8) -> impl Iterator<Item = usize> {
        (0..self.servos.len()).filter(move |&k| self.hears[k] && self.servos[k].id() == id)
    }

    fn handle_plain(&mut self, id: u8, number: u8, parameters: &[u8], world: &mut dyn ServoWorld) -> Reply {
        let mut reply = Reply::default();
        let mut addressed: Vec<usize> = (0..self.servos.len())
            .filter(|&k| {
                let servo = &self.servos[k];
                let is_own = id == BROADCAST || servo.id() == id || servo.table.secondary_id() == Some(id);
                self.hears[k] && is_own
            })
            .collect();
        addressed.sort_by_key(|&k| self.servos[k].id());
        for k in addressed {
            let is_own = self.servos[k].id() == id;
            if !is_own && [instruction::READ, instruction::PING].contains(&number) && id != BROADCAST {
                continue;
            }
            // By the registers as they were: a write may change id or level.
            let level = self.servos[k].table.unsigned(xl430::STATUS_RETURN);
            let is_answered = match number {
                instruction::PING => true,
                instruction::READ => is_own && level >= 1,
                _ => is_own && level >= 2,
            };
            let delay = self.delay(k);
            let outcome = self.run_instruction(k, id == BROADCAST, number, parameters, world);
            if is_answered {
                let own = if is_own { id } else { self.servos[k].id() };
                let error = self.servos[k].error_byte(outcome.as_ref().err().copied());
                let bytes = status(own, error, &outcome.unwrap_or_default());
                reply.answers.push(ServoReply { id: own, bytes, delay });
            }
        }
        reply
    }

    /// Runs an instruction with one answer on servo `k`; returns the parameters of that.
    fn run_instruction(
        &mut self,
        k: usize,
        is_broadcast: bool,
        number: u8,
        parameters: &[u8],
        world: &mut dyn ServoWorld,
    ) -> Result<Vec<u8>, Refusal> {
        let servo = &mut self.servos[k];
        let none = Vec::new();
        let address = || match parameters {
            [low, high, rest @ ..] => Ok((u16::from_le_bytes([*low, *high]), rest)),
            _ => Err(Refusal::Length),
        };
        match number {
            instruction::PING => {
                let model = servo.read(xl430::MODEL_NUMBER.address, 2)?;
                Ok([model, servo.read(xl430::FIRMWARE.address, 1)?].concat())
            }
            instruction::READ => match address()? {
                (address, [low, high]) => servo.read(address, u16::from_le_bytes([*low, *high])),
                _ => Err(Refusal::Length),
            },
            instruction::WRITE => {
                let (address, data) = address()?;
                servo.write(address, data, world).map(|()| none)
            }
            instruction::REG_WRITE => {
                let (address, data) = address()?;
                servo.register(address, data).map(|()| none)
            }
            instruction::ACTION => servo.act(world).map(|()| none),
            instruction::REBOOT => {
                servo.restart(world);
                Ok(none)
            }
            instruction::FACTORY_RESET => {
                let kept: &[ControlRegister] = match parameters {
                    // Servos with one id could never be distinguished again.
                    [0xff] if is_broadcast => return Err(Refusal::Result),
                    [0xff] => &[],
                    [0x01] => &[xl430::ID],
                    [0x02] => &[xl430::ID, xl430::BAUD],
                    [_] => return Err(Refusal::Range),
                    _ => return Err(Refusal::Length),
                };
                servo.factory_reset(kept, world);
                Ok(none)
            }
            instruction::CLEAR if parameters == CLEAR_TURNS => servo.clear_turns(world).map(|()| none),
            instruction::CLEAR => Err(Refusal::Range),
            _ => Err(Refusal::Instruction),
        }
    }

    fn read_each(&self, parts: &[TableRead], is_sync: bool) -> Reply {
        let mut answers = Vec::with_capacity(parts.len());
        for &(id, address, count) in parts {
            // Two servos with one id answer both.
            let n_before = answers.len();
            for k in self.reading(id) {
                answers.push(self.answer(k, self.servos[k].read(address, count)));
            }
            if answers.len() == n_before {
                break;
            }
        }
        Reply { answers, n_asked: is_sync.then_some(parts.len()) }
    }

    fn read_fast(&self, parts: &[TableRead]) -> Reply {
        let mut sent = Vec::with_capacity(parts.len());
        let (mut present_len, mut delay, mut first) = (0, 0.0, None);
        let mut is_whole = true;
        for &(id, address, count) in parts {
            let k = self.reading(id).next();
            is_whole &= k.is_some();
            let outcome = k.map_or(Err(Refusal::Access), |k| self.servos[k].read(address, count));
            let error = k.map_or(0, |k| self.servos[k].error_byte(outcome.as_ref().err().copied()));
            sent.push((error, id, outcome.unwrap_or_else(|_| vec![0; usize::from(count.min(1024))])));
            if let Some(k) = k.filter(|_| is_whole) {
                present_len += sent.last().map_or(0, |(_, _, data)| data.len() + 4);
                delay += self.delay(k);
                first = first.or(Some(id));
            }
        }
        let mut reply = Reply { answers: Vec::new(), n_asked: Some(parts.len()) };
        if let Some(id) = first {
            let mut bytes = fast_status(&sent);
            bytes.truncate(8 + present_len);
            if is_whole {
                reply.n_asked = Some(1);
            }
            reply.answers.push(ServoReply { id, bytes, delay });
        }
        reply
    }

    /// The servos that answer a read of this id.
    fn reading(&self, id: u8) -> impl Iterator<Item = usize> {
        self.listening(id).filter(|&k| self.servos[k].table.unsigned(xl430::STATUS_RETURN) >= 1)
    }

    fn write_each(&mut self, writes: Option<Vec<(u8, u16, &[u8])>>, world: &mut dyn ServoWorld) -> Reply {
        for (id, address, data) in writes.unwrap_or_default() {
            for k in 0..self.servos.len() {
                let servo = &mut self.servos[k];
                let is_addressed = servo.id() == id || servo.table.secondary_id() == Some(id);
                if self.hears[k] && is_addressed {
                    // There is no answer for a refusal.
                    let _ = servo.write(address, data, world);
                }
            }
        }
        Reply::default()
    }

    fn answer(&self, k: usize, outcome: Result<Vec<u8>, Refusal>) -> ServoReply {
        let servo = &self.servos[k];
        let error = servo.error_byte(outcome.as_ref().err().copied());
        let bytes = status(servo.id(), error, &outcome.unwrap_or_default());
        ServoReply { id: servo.id(), bytes, delay: self.delay(k) }
    }

    fn delay(&self, k: usize) -> f64 {
        f64::from(self.servos[k].table.unsigned(xl430::RETURN_DELAY)) * xl430::RETURN_DELAY_UNIT
    }
}

/// Answers as the host sees them when servos with one id send at the same time. A byte takes `byte_time` [s].
pub(super) fn overlaid(answers: Vec<ServoReply>, byte_time: f64) -> Vec<ServoReply> {
    let mut seen: Vec<ServoReply> = Vec::with_capacity(answers.len());
    for answer in answers {
        match seen.last_mut().filter(|before| before.id == answer.id) {
            Some(before) if (answer.delay - before.delay).abs() < byte_time * before.bytes.len() as f64 => {
                collide(before, &answer, byte_time);
            }
            Some(before) => {
                // Each waits from the end of the question; the later one follows the earlier.
                let spent = before.delay + byte_time * before.bytes.len() as f64;
                let delay = (answer.delay - spent).max(0.0);
                seen.push(ServoReply { delay, ..answer });
            }
            None => seen.push(answer),
        }
    }
    seen
}

/// Lays one answer over another: on a line that either pulls down, a bit is 1 only where both send it.
fn collide(under: &mut ServoReply, over: &ServoReply, byte_time: f64) {
    let (first, then) = if over.delay < under.delay { (over, &*under) } else { (&*under, over) };
    let shift = ((then.delay - first.delay) / byte_time) as usize;
    let mut bytes = first.bytes.clone();
    bytes.resize(bytes.len().max(shift + then.bytes.len()), 0xff);
    for (byte, other) in bytes[shift..].iter_mut().zip(&then.bytes) {
        *byte &= other;
    }
    *under = ServoReply { id: under.id, delay: first.delay, bytes };
}

fn word(bytes: &[u8], at: usize) -> u16 {
    u16::from_le_bytes([bytes[at], bytes[at + 1]])
}

/// Parts that a sync read requests; `None` if its parameters are invalid.
fn sync_parts(parameters: &[u8]) -> Option<Vec<TableRead>> {
    let (head, ids) = parameters.split_at_checked(4)?;
    Some(ids.iter().map(|&id| (id, word(head, 0), word(head, 2))).collect())
}

fn bulk_parts(parameters: &[u8]) -> Option<Vec<TableRead>> {
    let parts = parameters.chunks_exact(5);
    parts.remainder().is_empty().then(|| parts.map(|part| (part[0], word(part, 1), word(part, 3))).collect())
}

fn sync_writes(parameters: &[u8]) -> Option<Vec<(u8, u16, &[u8])>> {
    let (head, rest) = parameters.split_at_checked(4)?;
    let parts = rest.chunks_exact(1 + usize::from(word(head, 2)));
    parts.remainder().is_empty().then(|| parts.map(|part| (part[0], word(head, 0), &part[1..])).collect())
}

fn bulk_writes(mut parameters: &[u8]) -> Option<Vec<(u8, u16, &[u8])>> {
    let mut writes = Vec::new();
    while !parameters.is_empty() {
        let (head, rest) = parameters.split_at_checked(5)?;
        let (data, rest) = rest.split_at_checked(usize::from(word(head, 3)))?;
        writes.push((head[0], word(head, 1), data));
        parameters = rest;
    }
    Some(writes)
}
