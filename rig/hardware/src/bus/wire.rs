//! Single transfers with deadlines of our own, counted; the one place that talks to `dynamixel2`.
//!
//! The crate writes instructions. It does not read the answers: version 0.9.1 waits 34 ms for one, longer than three
//! cycles of a recording; panics at a stated length below 4, as the echo of a ping has it; reports a length beyond its
//! buffer again and again without taking the packet away; and leaves stuffing after FF FF FF FD, which a small negative
//! number before a byte FD makes. Here a transfer has one deadline, the time on the wire and what the rig file allows
//! beyond it, and every damaged byte is passed over once.

use super::BusCounts;
use super::packet::{DecodedPacket, PacketDecoder, STATUS};
use dynamixel2::serial2::SerialPort;
use dynamixel2::{Bus, WriteError};
use std::io::ErrorKind;
use std::path::Path;
use std::time::{Duration, Instant};

pub use dynamixel2::instructions::instruction_id as instruction;
pub use dynamixel2::instructions::packet_id::BROADCAST;

/// Bytes of an instruction packet without its parameters.
pub(crate) const INSTRUCTION_BYTES: usize = 10;
/// Bytes of a status packet without its parameters.
pub(crate) const STATUS_BYTES: usize = 11;
/// Enough for the longest instruction, stuffed.
const BUFFER: usize = 1024;
/// Silence after which no answer is to be expected any more: a U2D2 as it comes keeps bytes back for 16 ms.
const QUIET: Duration = Duration::from_millis(25);
/// The same behind answers that were late, at most.
const MAX_QUIET: Duration = Duration::from_millis(500);
/// Silence behind an answer after which no second one follows: servos wait 508 µs at most.
const NO_SECOND: Duration = Duration::from_millis(4);
/// Set in the error byte of a servo with a hardware error.
const ALERT: u8 = 0x80;

/// Failure of one attempt at a transfer.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum TransferFailure {
    /// Nothing in time.
    Timeout,
    /// Damaged, or not the answer to the request.
    Corrupt(String),
    /// The servo refused: its error number.
    Refused(u8),
    /// The port itself is gone.
    Port(String),
}

impl std::fmt::Display for TransferFailure {
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
pub struct StatusReply<'a> {
    /// Who answered.
    pub id: u8,
    /// Whether it has a hardware error.
    pub alert: bool,
    /// Parameters of the answer.
    pub parameters: &'a [u8],
}

/// How many answers one question had.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Census {
    /// Whole, and of whom was asked.
    pub whole: usize,
    /// Damaged packets, or bytes that are none.
    pub damaged: usize,
}

impl Census {
    /// As of a servo that is alone.
    pub const ONE: Self = Self { whole: 1, damaged: 0 };
}

/// An open port.
#[derive(Debug)]
pub struct Wire {
    bus: Bus<Vec<u8>, Vec<u8>>,
    /// The same port, for reading.
    port: SerialPort,
    decoder: PacketDecoder,
    /// How long to wait beyond the time on the wire.
    reply_timeout: Duration,
    /// Parameters of the last answer.
    answer: Vec<u8>,
    /// When the first of the questions was given up whose answers may still come.
    owed_since: Option<Instant>,
    pub counts: BusCounts,
}

impl Wire {
    /// Opens a port.
    pub fn open(path: &Path, baud: u32, reply_timeout: f64) -> std::io::Result<Self> {
        refuse_in_use(path)?;
        let bus = Bus::open_with_buffers(path, baud, Vec::new(), vec![0; BUFFER])?;
        // Two programs on one bus take each other's answers. Whoever dies lets the port go.
        #[cfg(unix)]
        rustix::fs::flock(bus.serial_port(), rustix::fs::FlockOperation::NonBlockingLockExclusive)?;
        let port = bus.serial_port().try_clone()?;
        let reply_timeout = Duration::from_secs_f64(reply_timeout);
        let (decoder, answer, counts) = (PacketDecoder::default(), Vec::new(), BusCounts::default());
        Ok(Self { bus, port, decoder, reply_timeout, answer, owed_since: None, counts })
    }

    /// Time that this many bytes take on the wire.
    pub fn wire_time(&self, bytes: usize) -> Duration {
        Duration::from_secs_f64(10.0 * bytes as f64 / f64::from(self.bus.baud_rate()))
    }

    /// Sends an instruction.
    pub fn send(&mut self, id: u8, instruction: u8, parameters: &[u8]) -> Result<(), TransferFailure> {
        self.counts.instructions += 1;
        // As the crate forgets what the system still holds of earlier answers.
        self.decoder.clear();
        let sent = self.bus.write_instruction(id, instruction, parameters.len(), |buffer| {
            buffer.copy_from_slice(parameters);
        });
        sent.map_err(|error| match error {
            WriteError::Write(e) | WriteError::DiscardBuffer(e) => TransferFailure::Port(e.to_string()),
            WriteError::BufferTooSmall(_) => {
                TransferFailure::Corrupt("instruction longer than the buffer".into())
            }
        })
    }

    /// When the answers to an instruction of `sent` bytes, `answered` bytes in all, must have come.
    pub fn deadline(&self, sent: usize, answered: usize) -> Instant {
        Instant::now() + self.wire_time(sent + answered) + self.reply_timeout
    }

    /// Carries out a transfer whose answers may come this much beyond their time on the wire.
    pub fn waiting<T>(&mut self, reply_timeout: Duration, transfer: impl FnOnce(&mut Self) -> T) -> T {
        let usual = std::mem::replace(&mut self.reply_timeout, reply_timeout);
        let done = transfer(self);
        self.reply_timeout = usual;
        done
    }

    /// Waits for the next answer, of `length` parameters. While answers to earlier questions are owed, one of another length is
    /// one of them.
    pub fn receive(&mut self, length: usize, deadline: Instant) -> Result<StatusReply<'_>, TransferFailure> {
        let failure = loop {
            match self.read_answer(deadline) {
                Ok((id, alert)) if self.answer.len() == length => {
                    self.counts.answers += 1;
                    return Ok(StatusReply { id, alert, parameters: &self.answer });
                }
                Ok(_) if self.owed_since.is_some() => {}
                Ok(_) => {
                    let found = self.answer.len();
                    break TransferFailure::Corrupt(format!("{found} bytes instead of {length}"));
                }
                Err(failure) => break failure,
            }
        };
        match failure {
            TransferFailure::Timeout => self.counts.timeouts += 1,
            TransferFailure::Corrupt(_) => self.counts.corrupt += 1,
            TransferFailure::Refused(_) => self.counts.refused += 1,
            TransferFailure::Port(_) => {}
        }
        Err(failure)
    }

    /// Id and alert of the next answer; its parameters are left in `answer`.
    fn read_answer(&mut self, deadline: Instant) -> Result<(u8, bool), TransferFailure> {
        let (id, body) = loop {
            match self.decoder.next_packet() {
                Some(DecodedPacket::Packet { id, body, .. }) => break (id, body),
                Some(DecodedPacket::BadChecksum { .. }) => {
                    return Err(TransferFailure::Corrupt("wrong checksum".into()));
                }
                None => {
                    self.read_bytes(deadline)?;
                }
            }
        };
        let [STATUS, error, parameters @ ..] = &body[..] else {
            return Err(TransferFailure::Corrupt("no answer but another packet".into()));
        };
        if error & !ALERT != 0 {
            return Err(TransferFailure::Refused(error & !ALERT));
        }
        self.answer.clear();
        self.answer.extend_from_slice(parameters);
        Ok((id, error & ALERT != 0))
    }

    /// Waits for more bytes; returns how many came.
    fn read_bytes(&mut self, deadline: Instant) -> Result<usize, TransferFailure> {
        let left = deadline.saturating_duration_since(Instant::now());
        if left.is_zero() {
            return Err(TransferFailure::Timeout);
        }
        let mut bytes = [0; 256];
        let read = self.port.set_read_timeout(left).and_then(|()| self.port.read(&mut bytes));
        match read {
            Ok(0) => Err(TransferFailure::Port("end of the stream".into())),
            Ok(n) => {
                self.decoder.push(&bytes[..n]);
                Ok(n)
            }
            Err(e) if e.kind() == ErrorKind::TimedOut => Err(TransferFailure::Timeout),
            Err(e) if e.kind() == ErrorKind::Interrupted => Ok(0),
            Err(e) => Err(TransferFailure::Port(e.to_string())),
        }
    }

    /// After a failed transfer, waits until the line has been silent for a while and forgets what came: an answer
    /// that is late must not be taken for that of the next question. So it does after the one that then succeeds: it may
    /// have had the answer to the question before it, and its own is still to come.
    pub fn settle_after<T>(&mut self, done: &Result<T, TransferFailure>) {
        match done {
            Err(TransferFailure::Timeout | TransferFailure::Corrupt(_)) => {
                self.owed_since.get_or_insert_with(Instant::now);
                self.settle();
            }
            // Answers to the questions before are late by no more than has passed, and no further apart.
            Ok(_) => {
                if let Some(since) = self.owed_since.take() {
                    self.settle_for(since.elapsed().clamp(QUIET, MAX_QUIET));
                }
            }
            Err(_) => {}
        }
    }

    /// Waits until the line has been silent for a while, and forgets what came.
    pub fn settle(&mut self) {
        self.settle_for(QUIET);
    }

    fn settle_for(&mut self, silence: Duration) {
        // A line that is never silent is not the fault of this servo.
        let end = Instant::now() + 10 * silence;
        while Instant::now() < end && self.read_bytes(Instant::now() + silence).is_ok() {}
        self.decoder.clear();
    }

    /// Asks one servo and waits for its answer.
    pub fn ask(
        &mut self,
        id: u8,
        instruction: u8,
        parameters: &[u8],
        length: usize,
    ) -> Result<StatusReply<'_>, TransferFailure> {
        self.send(id, instruction, parameters)?;
        let deadline = self.deadline(INSTRUCTION_BYTES + parameters.len(), STATUS_BYTES + length);
        let StatusReply { id: who, alert, .. } = self.receive(length, deadline)?;
        if who != id {
            self.counts.corrupt += 1;
            return Err(TransferFailure::Corrupt(format!("answer of servo {who}")));
        }
        Ok(StatusReply { id, alert, parameters: &self.answer })
    }

    /// Asks one servo and counts all that answer, until the line is silent; no answer comes after `patience` beyond the
    /// usual time.
    pub fn census(
        &mut self,
        id: u8,
        instruction: u8,
        parameters: &[u8],
        (length, patience): (usize, Duration),
    ) -> Result<Census, TransferFailure> {
        self.send(id, instruction, parameters)?;
        let usual = self.deadline(INSTRUCTION_BYTES + parameters.len(), STATUS_BYTES + length);
        let mut deadline = usual + patience;
        let (mut census, mut n_bytes) = (Census::default(), 0);
        loop {
            while let Some(found) = self.decoder.next_packet() {
                match found {
                    DecodedPacket::Packet { id: who, body, .. } if who == id && body.len() == length + 2 => {
                        census.whole += 1;
                    }
                    DecodedPacket::Packet { .. } | DecodedPacket::BadChecksum { .. } => census.damaged += 1,
                }
            }
            match self.read_bytes(deadline) {
                Ok(n) => {
                    n_bytes += n;
                    deadline = Instant::now() + self.wire_time(STATUS_BYTES + length) + NO_SECOND;
                }
                Err(TransferFailure::Timeout) => break,
                Err(failure) => return Err(failure),
            }
        }
        if census == Census::default() && n_bytes > 0 {
            census.damaged = 1;
        }
        self.decoder.clear();
        self.counts.answers += u64::from(census.whole > 0);
        Ok(census)
    }
}

/// Refuses a port that another program has, before anything is set or read on it.
fn refuse_in_use(path: &Path) -> std::io::Result<()> {
    #[cfg(unix)]
    {
        use rustix::fs::{FlockOperation, Mode, OFlags};
        let flags = OFlags::RDWR | OFlags::NOCTTY | OFlags::NONBLOCK | OFlags::CLOEXEC;
        let port = rustix::fs::open(path, flags, Mode::empty())?;
        rustix::fs::flock(&port, FlockOperation::NonBlockingLockExclusive)?;
    }
    #[cfg(not(unix))]
    let _ = path;
    Ok(())
}

/// Address and length as the parameters of a read.
pub fn range(address: u16, length: u16) -> [u8; 4] {
    let ([a, b], [c, d]) = (address.to_le_bytes(), length.to_le_bytes());
    [a, b, c, d]
}
