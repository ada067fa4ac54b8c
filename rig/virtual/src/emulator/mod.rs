//! Servos on a pseudo-terminal, in real time, which a driver for servos of the X series cannot distinguish from real ones.
//!
//! One thread reads the bytes of the host, lets the world live on to the present moment, and answers when the last
//! bit of the answer would have come over the wire. Between instructions it lets the world live on in small ticks.

mod chain;
mod faults;
mod injector;
mod port;
mod pose_delivery;
mod pose_server;
mod protection;
mod record;
mod registers;
mod servo;
mod table;
mod thread;
mod world;

pub use faults::{BusFault, FaultKind, Faults};
pub use port::Timing;
pub use pose_delivery::PoseDelivery;
pub use pose_server::{DeviceClock, Format, PoseFaults, PoseServer, PoseServerSettings};
pub use record::{
    FAULTS_LOG, FaultMoment, FaultRecord, TORQUE_LOG, TorqueRecord, TrackerFaults, TrafficCounts,
};
pub use world::{ServoReadings, ServoWorld};

use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Sender, channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use crate::virtual_rig::World;
use hysteron_base::{BadInput, rng};
use hysteron_rig::bus::xl430;
use hysteron_rig::{Error, Result};

/// How to emulate.
#[derive(Debug, Clone)]
pub struct Options {
    /// Name under which a host opens the port; a link, made and removed by the emulator.
    pub link: PathBuf,
    /// Id of the first servo; the others follow.
    pub first_id: u8,
    /// Baud of the servos; one of [`xl430::BAUDS`].
    pub baud: u32,
    /// Return delay of the servos [s], in steps of 2 µs up to 508 µs.
    pub return_delay: f64,
    /// How exactly answers keep the times of the wire.
    pub timing: Timing,
    /// Longest pause of the world without traffic.
    pub tick: Duration,
    /// Faults to inject, with their times.
    pub faults: Faults,
    /// Seed of damaged bits and noise.
    pub seed: u64,
    /// Folder for the logs of faults and torques; it must exist.
    pub logs: Option<PathBuf>,
}

impl Options {
    /// 1 Mbaud and the return delay of the factory, exact timing, no faults, no logs.
    pub fn new(link: impl Into<PathBuf>) -> Self {
        Self {
            link: link.into(),
            first_id: 1,
            baud: 1_000_000,
            return_delay: 250.0 * xl430::RETURN_DELAY_UNIT,
            timing: Timing::Wire,
            tick: Duration::from_millis(5),
            faults: Faults::default(),
            seed: 0,
            logs: None,
        }
    }
}

/// State shared by the thread of the emulator and its owner.
#[derive(Debug)]
struct EmulatorState<W> {
    world: Arc<Mutex<W>>,
    record: Mutex<record::TrafficRecorder>,
    is_stopped: AtomicBool,
}

impl<W> EmulatorState<W> {
    fn world(&self) -> MutexGuard<'_, W> {
        self.world.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn record(&self) -> MutexGuard<'_, record::TrafficRecorder> {
        self.record.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Servos that run on a thread of their own. Dropping it stops them and removes the port.
#[derive(Debug)]
pub struct ServoEmulator<W = World> {
    link: PathBuf,
    shared: Arc<EmulatorState<W>>,
    faults: Sender<BusFault>,
    thread: Option<std::thread::JoinHandle<()>>,
}

impl<W: ServoWorld + 'static> ServoEmulator<W> {
    /// Puts the servos of a world on a port, in real time from now on.
    ///
    /// # Errors
    /// `BadInput` for options that make no sense, `Bus` if the system gives no pseudo-terminal, `File` for logs.
    pub fn start(mut world: W, options: Options) -> Result<Self> {
        let chain = thread::chain(&mut world, &options)?;
        let nominal_supply = if world.n_servos() == 0 { 0.0 } else { world.servo(0).voltage };
        let rng = rng(options.seed, "rig/emulator");
        let injector = injector::Injector::new(options.faults.list.clone(), nominal_supply, rng);
        let record = record::TrafficRecorder::new(options.logs.as_deref())?;
        let port = port::EmulatedPort::open(&options.link)?;
        let shared = Arc::new(EmulatorState {
            world: Arc::new(Mutex::new(world)),
            record: Mutex::new(record),
            is_stopped: AtomicBool::new(false),
        });
        let (faults, receiver) = channel();
        let link = port.link().to_owned();
        let mut bus = thread::Bus::new(chain, injector, port, &options, Arc::clone(&shared), receiver);
        let thread = std::thread::Builder::new()
            .name("servos".to_owned())
            .spawn(move || bus.run())
            .map_err(|error| Error::Bus(format!("no thread for the emulated servos: {error}")))?;
        Ok(Self { link, shared, faults, thread: Some(thread) })
    }

    /// Where a host finds the servos.
    pub fn servo_port(&self) -> &Path {
        &self.link
    }

    /// The world, which lives in real time.
    pub fn world(&self) -> Arc<Mutex<W>> {
        Arc::clone(&self.shared.world)
    }

    /// Whether each servo drives its motor now (n_servos).
    pub fn torque_on(&self) -> Vec<bool> {
        self.shared.record().torques.last().map(|last| last.torque_on.clone()).unwrap_or_default()
    }

    /// Which servos were under torque when, from the beginning.
    pub fn torque_log(&self) -> Vec<TorqueRecord> {
        self.shared.record().torques.clone()
    }

    /// Counts of the bus traffic so far.
    pub fn counts(&self) -> TrafficCounts {
        self.shared.record().counts
    }

    /// Faults so far, with their times.
    pub fn fault_log(&self) -> Vec<FaultRecord> {
        self.shared.record().faults.clone()
    }

    /// Faults of the tracker, for the sender of its poses.
    pub fn tracker_faults(&self) -> TrackerFaults {
        self.shared.record().tracker.clone()
    }

    /// Breaks something, at its time or, if that is past, at once.
    ///
    /// # Errors
    /// `BadInput` if it makes no sense.
    pub fn inject(&self, fault: BusFault) -> std::result::Result<(), BadInput> {
        fault.check()?;
        // The thread ends only when this is dropped.
        let _ = self.faults.send(fault);
        Ok(())
    }

    /// Whether it still runs; it ends before its time only if the world itself failed.
    pub fn is_running(&self) -> bool {
        self.thread.as_ref().is_some_and(|thread| !thread.is_finished())
    }
}

impl ServoEmulator {
    /// Serves the poses of the world's tracker, with the active faults; also returns the address.
    ///
    /// # Errors
    /// `Tracker` if the port is taken.
    pub fn serve_poses(&self, settings: PoseServerSettings) -> Result<(PoseDelivery, SocketAddr)> {
        let server = PoseServer::start(settings)?;
        let address = server.address();
        let faults = self.tracker_faults();
        let is = move |kind| faults.is_active(kind);
        let delivery = PoseDelivery::start(self.world(), server, move || PoseFaults {
            unplugged: is(FaultKind::UnplugTracker),
            silent: is(FaultKind::TrackerDropout),
            invalid: is(FaultKind::TrackerInvalid),
            frozen: is(FaultKind::TrackerFreeze),
            displaced: is(FaultKind::TrackerJump),
            damaged: is(FaultKind::TrackerCorrupt),
        })?;
        Ok((delivery, address))
    }
}

impl<W> Drop for ServoEmulator<W> {
    fn drop(&mut self) {
        self.shared.is_stopped.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}
