//! The thread of the emulator: bytes in, time on, answers out.

use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::sync::mpsc::Receiver;
use std::time::{Duration, Instant};

use super::chain::{Reply, ServoChain, overlaid};
use super::faults::BusFault;
use super::injector::Injector;
use super::port::{EmulatedPort, Timing};
use super::servo::EmulatedServo;
use super::world::ServoWorld;
use super::{EmulatorState, Options};
use hysteron_base::BadInput;
use hysteron_rig::Result;
use hysteron_rig::bus::packet::{BROADCAST, DecodedPacket, PacketDecoder};
use hysteron_rig::bus::xl430;

/// Bits of a byte on the wire: start, eight of data, stop.
const BITS_PER_BYTE: f64 = 10.0;
/// Longest time that the world lives through at once [s]; of longer gaps the rest is lost.
const LONGEST_STEP: f64 = 0.25;
/// A packet that stays unfinished so long is discarded.
const BROKEN_OFF: Duration = Duration::from_millis(20);
/// Largest id on a bus.
const ID_MAX: usize = 252;

/// The servos of a world, with ids from the first on.
///
/// # Errors
/// `BadInput` for a baud or return delay that no servo can have, or more servos than ids.
pub(super) fn chain(world: &mut dyn ServoWorld, options: &Options) -> Result<ServoChain> {
    let baud = xl430::BAUDS.iter().position(|baud| *baud == options.baud);
    let bauds = || xl430::BAUDS.map(|baud| baud.to_string()).join(", ");
    let baud =
        baud.ok_or_else(|| BadInput::new("baud", format!("one of {}", bauds()), options.baud.to_string()))?;
    let delay = options.return_delay / xl430::RETURN_DELAY_UNIT;
    if !(0.0..=254.0).contains(&delay) {
        let found = format!("{} us", 1e6 * options.return_delay);
        return Err(BadInput::new("return delay", "0 to 508 us", found).into());
    }
    let mut servos = Vec::with_capacity(world.n_servos());
    for k in 0..world.n_servos() {
        let id = k + usize::from(options.first_id);
        if id > ID_MAX {
            return Err(
                BadInput::new("servos", format!("ids up to {ID_MAX}"), format!("an id of {id}")).into()
            );
        }
        let eeprom =
            [(xl430::ID, id as i64), (xl430::BAUD, baud as i64), (xl430::RETURN_DELAY, delay.round() as i64)];
        servos.push(EmulatedServo::new(k, &eeprom, world));
    }
    Ok(ServoChain { hears: vec![true; servos.len()], servos })
}

/// Traffic on the bus since the last poll.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Heard {
    Silence,
    Bytes,
}

/// All that the thread owns.
pub(super) struct Bus<W> {
    chain: ServoChain,
    injector: Injector,
    port: EmulatedPort,
    decoder: PacketDecoder,
    shared: Arc<EmulatorState<W>>,
    faults: Receiver<BusFault>,
    timing: Timing,
    tick: Duration,
    /// When the world was at `start_time`.
    start: Instant,
    /// Time of the world then [s].
    start_time: f64,
    /// When the wire is free again.
    free_at: Instant,
    heard_at: Instant,
}

impl<W: ServoWorld> Bus<W> {
    pub fn new(
        chain: ServoChain,
        injector: Injector,
        port: EmulatedPort,
        options: &Options,
        shared: Arc<EmulatorState<W>>,
        faults: Receiver<BusFault>,
    ) -> Self {
        let now = Instant::now();
        let start_time = shared.world().time();
        let mut bus = Self {
            chain,
            injector,
            port,
            decoder: PacketDecoder::default(),
            shared,
            faults,
            timing: options.timing,
            tick: options.tick,
            start: now,
            start_time,
            free_at: now,
            heard_at: now,
        };
        bus.live_on(Heard::Silence);
        bus
    }

    /// Runs until the stop flag is set.
    pub fn run(&mut self) {
        let mut buffer = [0; 1024];
        while !self.shared.is_stopped.load(Ordering::Relaxed) {
            let n = self.port.read(&mut buffer, self.tick);
            let now = Instant::now();
            self.live_on(if n > 0 { Heard::Bytes } else { Heard::Silence });
            if n > 0 {
                self.heard_at = now;
                self.decoder.push(&buffer[..n]);
                while let Some(found) = self.decoder.next_packet() {
                    self.serve(found, now);
                }
            } else if self.decoder.is_waiting() && now - self.heard_at > BROKEN_OFF {
                self.decoder.clear();
            }
        }
    }

    /// Lets the world live on to the present. Where this thread was kept waiting, bytes that lie in the port have come
    /// meanwhile: a real servo has heard them in time, so its watchdog must not count that silence.
    fn live_on(&mut self, heard: Heard) {
        let mut world = self.shared.world();
        let mut record = self.shared.record();
        let step = self.start_time + self.start.elapsed().as_secs_f64() - world.time();
        if step > LONGEST_STEP {
            self.start_time -= step - LONGEST_STEP;
            record.counts.slipped_ms += (1e3 * (step - LONGEST_STEP)) as u64;
        }
        drop(record);
        if step > 0.0 {
            world.advance(step.min(LONGEST_STEP));
        }
        if heard == Heard::Bytes {
            self.chain.hear(world.time());
        }
        self.chain.refresh(&mut *world);
        self.faults.try_iter().for_each(|fault| self.injector.add(fault));
        let mut record = self.shared.record();
        self.injector.step(&mut self.port, &mut self.chain, &mut *world, &mut record);
        record.torque(world.time(), self.chain.servos.iter().map(EmulatedServo::is_torque_on));
    }

    /// Carries out a packet that came at that time, and answers it.
    fn serve(&mut self, found: DecodedPacket, came_at: Instant) {
        let reply = {
            let (DecodedPacket::Packet { id, wire_len, .. } | DecodedPacket::BadChecksum { id, wire_len }) =
                &found;
            let (id, wire_len) = (*id, *wire_len);
            self.listen(id);
            self.free_at = self.free_at.max(came_at) + self.wire_time(wire_len);
            let mut world = self.shared.world();
            let mut record = self.shared.record();
            let time = world.time();
            self.injector.instruction_passed(id, BROADCAST, time, &mut record);
            let reply = match found {
                DecodedPacket::Packet { body, .. } => {
                    record.counts.instructions += 1;
                    self.chain.handle(id, &body, &mut *world)
                }
                DecodedPacket::BadChecksum { .. } => {
                    record.counts.bad_packets += 1;
                    self.chain.checksum_error(id)
                }
            };
            record.torque(time, self.chain.servos.iter().map(EmulatedServo::is_torque_on));
            reply
        };
        self.send(reply);
    }

    /// Decides which servos receive an instruction to this id.
    fn listen(&mut self, to: u8) {
        let host_baud = self.port.host_baud();
        for (servo, hears) in self.chain.servos.iter().zip(&mut self.chain.hears) {
            let baud = xl430::BAUDS.get(servo.table.unsigned(xl430::BAUD) as usize).copied();
            *hears = servo.is_awake()
                && (host_baud.is_none() || host_baud == baud)
                && !self.injector.is_deaf(servo.id(), to, BROADCAST);
        }
    }

    fn send(&mut self, reply: Reply) {
        let mut n_whole = 0;
        let n_answers = reply.answers.len();
        for mut answer in overlaid(reply.answers, self.wire_time(1).as_secs_f64()) {
            let time = self.shared.world().time();
            let damage = self.injector.damage(answer.id, time, &mut self.shared.record());
            let wait = answer.delay + damage.delay;
            self.free_at += Duration::from_secs_f64(wait) + self.wire_time(answer.bytes.len());
            if damage.is_corrupt {
                self.injector.corrupt(&mut answer.bytes);
            }
            if damage.is_dropped {
                continue;
            }
            self.timing.wait_until(self.free_at);
            self.port.send(&answer.bytes);
            n_whole += usize::from(!damage.is_corrupt);
        }
        let mut record = self.shared.record();
        record.counts.answers += n_answers as u64;
        if let Some(n_asked) = reply.n_asked {
            if n_whole == n_asked {
                record.counts.complete_rounds += 1;
            } else {
                record.counts.broken_rounds += 1;
            }
        }
    }

    /// Time that so many bytes take on the wire.
    fn wire_time(&self, n_bytes: usize) -> Duration {
        let baud = self.port.host_baud().unwrap_or(xl430::BAUDS[3]);
        Duration::from_secs_f64(n_bytes as f64 * BITS_PER_BYTE / f64::from(baud.max(1)))
    }
}
