//! A rig on its ports: servos on a serial bus, the tip by OpenIGTLink. Whether there is hardware or an emulator behind
//! them cannot be told from here.

use crate::bus::{BusCounts, ServoBus, ServoReport};
use crate::config::RigConfig;
use crate::tracker::{Client, Settings};
use crate::{Event, Hardware, Pose, Result, ServoSample, SlowSample};
use std::time::{Duration, Instant};

/// How long to wait for the tracker's first pose [s].
const TRACKER_PATIENCE: f64 = 5.0;

/// A rig on its ports.
#[derive(Debug)]
pub struct LiveRig {
    bus: ServoBus,
    tracker: Option<Client>,
    rig: RigConfig,
    clock: Instant,
}

impl LiveRig {
    /// Opens the ports of a rig. Nothing moves.
    ///
    /// # Errors
    /// `Bus` or `Tracker` if one does not open, `BadInput` if the tracker's address is none.
    pub fn open(rig: &RigConfig) -> Result<Self> {
        let clock = Instant::now();
        let bus = ServoBus::open(&rig.servos, &rig.ids(), clock)?;
        let tracker = rig.tracker.as_ref().map(|tracker| {
            let mut settings = Settings::new(&tracker.address);
            settings.device = Some(tracker.device.clone()).filter(|device| !device.is_empty());
            settings.latency = tracker.latency;
            settings.stale_after = tracker.stale;
            settings.limits.speed = tracker.speed_max;
            Client::connect(settings, clock)
        });
        Ok(Self { bus, tracker: tracker.transpose()?, rig: rig.clone(), clock })
    }

    /// The servo bus.
    pub fn bus(&mut self) -> &mut ServoBus {
        &mut self.bus
    }

    /// The tracker, if the rig has one.
    pub fn tracker(&self) -> Option<&Client> {
        self.tracker.as_ref()
    }
}

impl Hardware for LiveRig {
    fn now(&self) -> f64 {
        self.clock.elapsed().as_secs_f64()
    }

    fn wait_until(&mut self, time: f64) {
        let left = time - self.now();
        if left > 0.0 {
            std::thread::sleep(Duration::from_secs_f64(left));
        }
    }

    fn n_servos(&self) -> usize {
        self.bus.ids().len()
    }

    fn prepare(&mut self) -> Result<Vec<ServoReport>> {
        let reports = self.bus.self_check(&self.rig)?;
        self.bus.configure()?;
        if let Some(tracker) = &self.tracker {
            tracker.wait_for_pose(TRACKER_PATIENCE)?;
        }
        Ok(reports)
    }

    fn write_goals(&mut self, goals: &[i32]) -> Result<()> {
        self.bus.write_goals(goals)
    }

    fn read_servos(&mut self, samples: &mut [Option<ServoSample>]) -> Result<()> {
        self.bus.read_servos(samples)
    }

    fn read_slow(&mut self, samples: &mut [Option<SlowSample>]) -> Result<()> {
        self.bus.read_slow(samples)
    }

    fn set_torque(&mut self, on: bool) -> Result<()> {
        self.bus.set_torque(on)
    }

    fn hold(&mut self) -> Result<()> {
        self.bus.stop_watchdog()
    }

    fn take_poses(&mut self, poses: &mut Vec<Pose>) {
        if let Some(tracker) = &self.tracker {
            tracker.take_poses(poses);
        }
    }

    fn take_events(&mut self, events: &mut Vec<Event>) {
        self.bus.take_events(events);
        if let Some(tracker) = &self.tracker {
            tracker.take_events(events);
        }
    }

    fn counts(&self) -> BusCounts {
        self.bus.counts()
    }

    fn processor_time(&self) -> Option<f64> {
        let time = rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime);
        Some(time.tv_sec as f64 + 1e-9 * time.tv_nsec as f64)
    }

    fn bus_time(&self) -> (f64, f64) {
        (self.bus.last_bus_time, self.bus.cycle_wire_time())
    }
}
