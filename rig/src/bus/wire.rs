//! The one place that talks to `dynamixel2`: single transfers with deadlines of our own, counted.
//!
//! The crate waits 34 ms for an answer, longer than three cycles of a recording; and it ends a sync read's wait per
//! servo. Here a transfer has one deadline: the time on the wire and what the rig file allows beyond it.

use super::BusCounts;
use dynamixel2::{Bus, ReadError, WriteError};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::time::{Duration, Instant};

pub use dynamixel2::instructions::instruction_id as instruction;
pub use dynamixel2::instructions::packet_id::BROADCAST;

/// Bytes of an instruction packet besides its parameters.
pub(crate) const INSTRUCTION_BYTES: usize = 10;
/// Bytes of a status packet besides its parameters.
pub(crate) const STATUS_BYTES: usize = 11;
/// Enough for a read of the whole control table, stuffed.
const BUFFER: usize = 1024;

/// What an attempt came to.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Failure {
    /// Nothing in time.
    Timeout,
    /// Damaged, or not the answer to what was asked.
    Corrupt(String),
    /// The servo refused: its error number.
    Refused(u8),
    /// The port itself is gone.
    Port(String),
}

impl std::fmt::Display for Failure {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Timeout => write!(f, "no answer in time"),
            Self::Corrupt(how) => write!(f, "damaged answer: {how}"),
            Self::Refused(number) => write!(f, "refused: {}", refusal(*number)),
            Self::Port(why) => write!(f, "port lost: {why}"),
        }
    }
}

/// Meaning of an error number of protocol 2.0.
fn refusal(number: u8) -> &'static str {
    match number {
        1 => "the instruction failed",
        2 => "no such instruction",
        3 => "the instruction's checksum was wrong",
        4 => "a value out of range",
        5 => "a value of the wrong length",
        6 => "a value beyond its limit register",
        7 => "the register cannot be written now (read-only, or torque is on)",
        _ => "an unknown error number",
    }
}

/// One answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Answer<'a> {
    /// Who answered.
    pub id: u8,
    /// Whether it has a hardware error.
    pub alert: bool,
    /// What it said.
    pub parameters: &'a [u8],
}

/// An open port.
#[derive(Debug)]
pub struct Wire {
    bus: Bus<Vec<u8>, Vec<u8>>,
    /// How long to wait beyond the time on the wire.
    reply_timeout: Duration,
    /// Parameters of the last answer.
    answer: Vec<u8>,
    pub counts: BusCounts,
}

impl Wire {
    /// Opens a port.
    pub fn open(port: &Path, baud: u32, reply_timeout: f64) -> std::io::Result<Self> {
        let bus = Bus::open_with_buffers(port, baud, vec![0; BUFFER], vec![0; BUFFER])?;
        let reply_timeout = Duration::from_secs_f64(reply_timeout);
        Ok(Self { bus, reply_timeout, answer: Vec::with_capacity(BUFFER), counts: BusCounts::default() })
    }

    /// Time that this many bytes take on the wire.
    pub fn wire_time(&self, bytes: usize) -> Duration {
        Duration::from_secs_f64(10.0 * bytes as f64 / f64::from(self.bus.baud_rate()))
    }

    /// Sends an instruction.
    pub fn send(&mut self, id: u8, instruction: u8, parameters: &[u8]) -> Result<(), Failure> {
        self.counts.instructions += 1;
        let sent = self.bus.write_instruction(id, instruction, parameters.len(), |buffer| {
            buffer.copy_from_slice(parameters);
        });
        sent.map_err(|error| match error {
            WriteError::Write(e) | WriteError::DiscardBuffer(e) => Failure::Port(e.to_string()),
            WriteError::BufferTooSmall(_) => Failure::Corrupt("instruction longer than the buffer".into()),
        })
    }

    /// When the answers to an instruction of `sent` bytes, `answered` bytes in all, must have come.
    pub fn deadline(&self, sent: usize, answered: usize) -> Instant {
        Instant::now() + self.wire_time(sent + answered) + self.reply_timeout
    }

    /// Waits for the next answer, of `length` parameters.
    pub fn receive(&mut self, length: usize, deadline: Instant) -> Result<Answer<'_>, Failure> {
        let read = self.read_packet(deadline);
        if self.answer.len() > length {
            remove_missed_stuffing(&mut self.answer);
        }
        let failure = match read {
            Ok((id, alert)) if self.answer.len() == length => {
                self.counts.answers += 1;
                return Ok(Answer { id, alert, parameters: &self.answer });
            }
            Ok(_) => Failure::Corrupt(format!("{} bytes instead of {length}", self.answer.len())),
            Err(failure) => failure,
        };
        match failure {
            Failure::Timeout => self.counts.timeouts += 1,
            Failure::Corrupt(_) => self.counts.corrupt += 1,
            Failure::Refused(_) => self.counts.refused += 1,
            Failure::Port(_) => {}
        }
        Err(failure)
    }

    /// Id and alert of the next packet; its parameters are left in `answer`.
    fn read_packet(&mut self, deadline: Instant) -> Result<(u8, bool), Failure> {
        let (bus, answer) = (&mut self.bus, &mut self.answer);
        // dynamixel2 0.9.1 subtracts 2 from the length that a packet states, and panics where that is less.
        let read = catch_unwind(AssertUnwindSafe(|| {
            let packet = bus.read_status_response_deadline(deadline)?;
            answer.clear();
            answer.extend_from_slice(packet.parameters());
            Ok((packet.packet_id(), packet.alert()))
        }));
        match read {
            Ok(Ok(packet)) => Ok(packet),
            Ok(Err(error)) => Err(failure(error)),
            Err(_) => Err(Failure::Corrupt("impossible length".into())),
        }
    }

    /// Asks one servo and waits for its answer.
    pub fn ask(
        &mut self,
        id: u8,
        instruction: u8,
        parameters: &[u8],
        length: usize,
    ) -> Result<Answer<'_>, Failure> {
        self.send(id, instruction, parameters)?;
        let deadline = self.deadline(INSTRUCTION_BYTES + parameters.len(), STATUS_BYTES + length);
        let Answer { id: who, alert, .. } = self.receive(length, deadline)?;
        if who != id {
            return Err(Failure::Corrupt(format!("answer of servo {who}")));
        }
        Ok(Answer { id, alert, parameters: &self.answer })
    }
}

fn failure(error: ReadError) -> Failure {
    match error {
        ReadError::Io(e) if e.kind() == std::io::ErrorKind::TimedOut => Failure::Timeout,
        ReadError::Io(e) => Failure::Port(e.to_string()),
        ReadError::MotorError(e) => Failure::Refused(e.error_number()),
        ReadError::InvalidMessage(e) => Failure::Corrupt(e.to_string()),
        ReadError::BufferFull(e) => Failure::Corrupt(format!("a length of {} bytes", e.required_size)),
    }
}

/// Removes stuffing that dynamixel2 0.9.1 leaves: it misses FF FF FD FD where a further FF stands before, as it does
/// whenever a small negative number is followed by a byte FD. (It is called only for an answer that is too long, and
/// the length is checked again.)
fn remove_missed_stuffing(answer: &mut Vec<u8>) {
    let mut at = 4;
    while at < answer.len() {
        if answer[at - 4..=at] == [0xff, 0xff, 0xff, 0xfd, 0xfd] {
            answer.remove(at);
        }
        at += 1;
    }
}

/// Address and length as the parameters of a read.
pub fn range(address: u16, length: u16) -> [u8; 4] {
    let ([a, b], [c, d]) = (address.to_le_bytes(), length.to_le_bytes());
    [a, b, c, d]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stuffing_that_the_library_misses_is_removed() {
        // Speed -1, position 0x0fd: FF FF FF FF FD 00 00 00, stuffed after FF FF FD.
        let mut answer = vec![0xff, 0xff, 0xff, 0xff, 0xfd, 0xfd, 0x00, 0x00, 0x00];
        remove_missed_stuffing(&mut answer);
        assert_eq!(answer, [0xff, 0xff, 0xff, 0xff, 0xfd, 0x00, 0x00, 0x00]);
    }

    #[test]
    fn other_bytes_stay() {
        for bytes in [vec![], vec![0xfd], vec![0xff, 0xff, 0xff, 0xfd, 0xfe], vec![0xff, 0xff, 0xfd, 0xfd]] {
            let mut answer = bytes.clone();
            remove_missed_stuffing(&mut answer);
            assert_eq!(answer, bytes);
        }
    }
}
