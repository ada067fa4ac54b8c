//! A rig on its ports: servos on a serial bus, the tip by OpenIGTLink. This module does not know whether hardware or an emulator is
//! behind them.

use crate::bus::{BusCounts, RegisterBaseline, ServoBus, ServoReport};
use crate::config::{RigConfig, TrackerConfig, TrackerSource};
use crate::tracker::{Client, Replay, TrackerSettings, TrackerSurvey};
use crate::{Event, EventKind, Hardware, Pose, Result, ServoSample, SlowSample};
use hysteron_base::Recording;
use std::time::{Duration, Instant};

/// How long to wait for the tracker's first pose [s].
const TRACKER_PATIENCE: f64 = 5.0;

/// Where poses come from.
#[derive(Debug)]
enum PoseSource {
    Client(Client),
    Replay(Replay),
}

fn open_tracker(config: &TrackerConfig, clock: Instant) -> Result<PoseSource> {
    let address = match &config.source {
        TrackerSource::OpenIgtLink(address) => address,
        TrackerSource::Replay(path) => {
            let recording = Recording::read(path)?;
            let replay = Replay::new(&recording, clock.elapsed().as_secs_f64());
            return Ok(PoseSource::Replay(replay.map_err(|bad| bad.within(path.display()))?));
        }
    };
    let mut settings = TrackerSettings::new(address);
    settings.device = Some(config.device.clone()).filter(|device| !device.is_empty());
    settings.latency = config.latency;
    settings.stale_after = config.stale;
    settings.limits.speed = config.speed_max;
    Ok(PoseSource::Client(Client::connect(settings, clock)?))
}

/// A rig on its ports.
#[derive(Debug)]
pub struct LiveRig {
    bus: ServoBus,
    tracker: Option<PoseSource>,
    rig: RigConfig,
    clock: Instant,
    /// Reference with which the servos' registers are compared.
    registers: RegisterBaseline,
}

impl LiveRig {
    /// Opens the ports of a rig. Nothing moves.
    ///
    /// # Errors
    /// `Bus` or `PoseSource` if one does not open, `BadInput` if the tracker's address is none.
    pub fn open(rig: &RigConfig) -> Result<Self> {
        let clock = Instant::now();
        let bus = ServoBus::open(&rig.servos, &rig.ids(), clock)?;
        let tracker = rig.tracker.as_ref().map(|tracker| open_tracker(tracker, clock)).transpose()?;
        Ok(Self { bus, tracker, rig: rig.clone(), clock, registers: RegisterBaseline::Factory })
    }

    /// The same rig, whose servos are expected to hold these registers instead of the factory's.
    pub fn expecting(self, registers: RegisterBaseline) -> Self {
        Self { registers, ..self }
    }

    /// The servo bus.
    pub fn bus(&mut self) -> &mut ServoBus {
        &mut self.bus
    }

    /// Waits for the tracker's first pose; returns at once where there is no tracker to wait for.
    ///
    /// # Errors
    /// `PoseSource` if none comes.
    pub fn wait_for_pose(&self) -> Result<()> {
        match &self.tracker {
            Some(PoseSource::Client(client)) => client.wait_for_pose(TRACKER_PATIENCE),
            Some(PoseSource::Replay(_)) | None => Ok(()),
        }
    }
}

impl LiveRig {
    /// Looks at a tracker for so long [s] while the tip rests; `None` without one on a port.
    ///
    /// # Errors
    /// `PoseSource` if no pose comes.
    pub fn survey_tracker(&mut self, seconds: f64) -> Result<Option<TrackerSurvey>> {
        let (Some(config), Some(PoseSource::Client(_))) = (self.rig.tracker.clone(), &self.tracker) else {
            return Ok(None);
        };
        self.wait_for_pose()?;
        let (mut poses, mut events) = (Vec::new(), Vec::new());
        self.wait_until(self.now() + seconds);
        self.take_poses(&mut poses);
        self.take_events(&mut events);
        let is_of_tracker =
            |event: &&Event| matches!(event.kind, EventKind::TrackerQuality | EventKind::TrackerCorrupt);
        let reason = events.iter().rev().find(is_of_tracker).map(|event| event.message.as_str());
        let mut survey = TrackerSurvey::of(&poses, &config, reason);
        let damaged = events.iter().rev().find(|event| event.kind == EventKind::TrackerCorrupt);
        survey.warnings.extend(damaged.map(|event| format!("damaged messages: {}", event.message)));
        Ok(Some(survey))
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

    fn is_real_time(&self) -> bool {
        true
    }

    fn n_servos(&self) -> usize {
        self.bus.ids().len()
    }

    fn prepare(&mut self) -> Result<Vec<ServoReport>> {
        let reports = self.bus.self_check(&self.rig.servo_bounds())?;
        self.bus.accept_registers(&self.registers)?;
        self.bus.configure()?;
        self.wait_for_pose()?;
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

    fn enable_torque(&mut self) -> Result<()> {
        self.bus.enable_torque()
    }

    fn disable_torque(&mut self) -> Result<()> {
        self.bus.disable_torque()
    }

    fn hold(&mut self) -> Result<()> {
        self.bus.stop_watchdog()
    }

    fn take_poses(&mut self, poses: &mut Vec<Pose>) {
        let now = self.now();
        match &mut self.tracker {
            Some(PoseSource::Client(client)) => client.take_poses(poses),
            Some(PoseSource::Replay(replay)) => replay.take_poses(now, poses),
            None => {}
        }
    }

    fn take_events(&mut self, events: &mut Vec<Event>) {
        self.bus.take_events(events);
        if let Some(PoseSource::Client(client)) = &self.tracker {
            client.take_events(events);
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
