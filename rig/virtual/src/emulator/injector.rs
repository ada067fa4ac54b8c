//! Faults while they last: what they do to bus, servos, supply and tracker.
//!
//! The damage at any time follows from the list of active faults alone, so that overlapping ones undo nothing of
//! each other.

use std::collections::VecDeque;

use super::chain::ServoChain;
use super::faults::{BusFault, FaultKind};
use super::port::EmulatedPort;
use super::record::{FaultMoment, TrafficRecorder};
use super::world::ServoWorld;
use hysteron_rig::bus::xl430::error_bit;
use rand::{Rng, RngExt};
use rand_chacha::ChaCha8Rng;

/// Below this supply servos lose their RAM [V].
const BROWN_OUT: f64 = 5.0;
/// Default supply in a brown-out [V].
const USUAL_DIP: f64 = 3.0;
/// Heat that makes any servo too hot [°C].
const TOO_HOT: f64 = 80.0;

#[derive(Debug)]
struct Active {
    fault: BusFault,
    /// When it ends [s]; never, if none.
    ends_at: Option<f64>,
    /// Packets that it still concerns; 0 for those that last.
    left: u32,
}

/// Damage to an answer on its way to the host.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Damage {
    pub is_dropped: bool,
    pub is_corrupt: bool,
    /// Extra delay [s].
    pub delay: f64,
}

/// Pending and active faults.
#[derive(Debug)]
pub(super) struct Injector {
    pending: VecDeque<BusFault>,
    active: Vec<Active>,
    /// Supply without any fault [V].
    nominal_supply: f64,
    rng: ChaCha8Rng,
}

impl Injector {
    /// With faults to come, in order of time.
    pub fn new(list: Vec<BusFault>, nominal_supply: f64, rng: ChaCha8Rng) -> Self {
        Self { pending: list.into(), active: Vec::new(), nominal_supply, rng }
    }

    /// Adds one, to begin at its time or at once.
    pub fn add(&mut self, fault: BusFault) {
        let at = self.pending.partition_point(|pending| pending.at_s <= fault.at_s);
        self.pending.insert(at, fault);
    }

    /// Begins and ends what is due.
    pub fn step(
        &mut self,
        port: &mut EmulatedPort,
        chain: &mut ServoChain,
        world: &mut dyn ServoWorld,
        record: &mut TrafficRecorder,
    ) {
        let time = world.time();
        let mut is_changed = false;
        self.active.retain(|active| {
            let is_over = active.ends_at.is_some_and(|end| time >= end) && active.left == 0;
            if is_over {
                record.fault(time, FaultMoment::Ended, &active.fault);
            }
            is_changed |= is_over;
            !is_over
        });
        while self.pending.front().is_some_and(|fault| fault.at_s <= time)
            && let Some(fault) = self.pending.pop_front()
        {
            record.fault(time, FaultMoment::Began, &fault);
            self.begin(fault, port, chain, world);
            is_changed = true;
        }
        if is_changed {
            self.apply(port, chain, world);
            let kinds = self.active.iter().map(|active| active.fault.kind);
            record.tracker.set(kinds.filter(|kind| kind.is_of_tracker()).collect());
        }
    }

    fn begin(
        &mut self,
        fault: BusFault,
        port: &mut EmulatedPort,
        chain: &mut ServoChain,
        world: &mut dyn ServoWorld,
    ) {
        let time = world.time();
        let count = fault.count.unwrap_or(1);
        let ends_at = fault.ends_at(time);
        let servo = chain.servos.iter_mut().find(|servo| fault.servo == Some(servo.id()));
        let left = match fault.kind {
            FaultKind::Noise => {
                let mut bytes = vec![0; count as usize];
                self.rng.fill_bytes(&mut bytes);
                port.send(&bytes);
                return;
            }
            FaultKind::Overload => {
                if let Some(servo) = servo.filter(|servo| servo.is_awake()) {
                    servo.trip(error_bit::OVERLOAD, world);
                }
                return;
            }
            FaultKind::Overheat => {
                if let Some(servo) = servo {
                    servo.warm(TOO_HOT, ends_at.unwrap_or(f64::INFINITY));
                }
                0
            }
            FaultKind::DropPacket
            | FaultKind::CorruptPacket
            | FaultKind::DelayPacket
            | FaultKind::DropInstruction => count,
            _ => 0,
        };
        self.active.push(Active { fault, ends_at, left });
    }

    /// Applies the active faults.
    fn apply(&self, port: &mut EmulatedPort, chain: &mut ServoChain, world: &mut dyn ServoWorld) {
        let active = || self.active.iter().map(|active| &active.fault);
        let is_plugged = !active().any(|fault| fault.kind == FaultKind::UnplugBus);
        if port.is_plugged() && !is_plugged {
            port.unplug();
        }
        if !port.is_plugged()
            && is_plugged
            && let Err(error) = port.plug()
        {
            tracing::error!("{error}");
        }
        let dips = active().filter(|fault| fault.kind == FaultKind::BrownOut && fault.servo.is_none());
        let supply = dips.map(|fault| fault.volts.unwrap_or(USUAL_DIP)).fold(self.nominal_supply, f64::min);
        world.set_supply(supply);
        for (k, servo) in chain.servos.iter_mut().enumerate() {
            let id = servo.id();
            let own = |kind| active().filter(move |fault| fault.kind == kind && fault.servo == Some(id));
            let is_powered = (supply >= BROWN_OUT || self.nominal_supply < BROWN_OUT)
                && own(FaultKind::UnplugServo).next().is_none()
                && own(FaultKind::BrownOut).next().is_none();
            match (servo.has_power(), is_powered) {
                (true, false) => servo.cut(world),
                (false, true) => servo.restart(world),
                _ => {}
            }
            let torque = own(FaultKind::Hold).filter_map(|fault| fault.torque_nm).sum();
            world.set_disturbance(k, torque);
        }
    }

    /// Whether a servo misses an instruction to that id, and notes it.
    pub fn is_deaf(&self, servo: u8, to: u8, broadcast: u8) -> bool {
        self.active.iter().any(|active| {
            active.fault.kind == FaultKind::DropInstruction
                && active.left > 0
                && match active.fault.servo {
                    None => true,
                    Some(id) => id == servo && (to == id || to == broadcast),
                }
        })
    }

    /// An instruction to that id has passed.
    pub fn instruction_passed(&mut self, to: u8, broadcast: u8, time: f64, record: &mut TrafficRecorder) {
        self.use_up(FaultKind::DropInstruction, time, record, |fault| {
            fault.servo.is_none() || to == broadcast || fault.servo == Some(to)
        });
    }

    /// Damage to the next answer of this servo.
    pub fn damage(&mut self, servo: u8, time: f64, record: &mut TrafficRecorder) -> Damage {
        let concerns = |fault: &BusFault| fault.servo.is_none_or(|id| id == servo);
        let delay = self.use_up(FaultKind::DelayPacket, time, record, concerns);
        Damage {
            is_dropped: self.use_up(FaultKind::DropPacket, time, record, concerns).is_some(),
            is_corrupt: self.use_up(FaultKind::CorruptPacket, time, record, concerns).is_some(),
            delay: 1e-3 * delay.and_then(|fault| fault.delay_ms).unwrap_or(0.0),
        }
    }

    /// Damages a packet: turns one bit of it round.
    pub fn corrupt(&mut self, bytes: &mut [u8]) {
        if !bytes.is_empty() {
            let at = self.rng.random_range(0..bytes.len());
            bytes[at] ^= 1 << self.rng.random_range(0..8);
        }
    }

    /// Counts down the first such fault that concerns a packet.
    fn use_up(
        &mut self,
        kind: FaultKind,
        time: f64,
        record: &mut TrafficRecorder,
        concerns: impl Fn(&BusFault) -> bool,
    ) -> Option<BusFault> {
        let found = self
            .active
            .iter_mut()
            .find(|active| active.fault.kind == kind && active.left > 0 && concerns(&active.fault))?;
        found.left -= 1;
        record.fault(time, FaultMoment::Struck, &found.fault);
        if found.left == 0 {
            found.ends_at = Some(time);
        }
        Some(found.fault.clone())
    }
}
