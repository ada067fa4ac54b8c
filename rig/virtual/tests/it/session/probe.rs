//! A whole virtual rig on its ports, and a probe between it and the session that breaks things and takes notes.

use super::{Turn, turn};
use hysteron_rig::bus::{BusCounts, ServoReport};
use hysteron_rig::calibration::{RigCalibration, calibrate};
use hysteron_rig::config::RigConfig;
use hysteron_rig::{Event, Hardware, LiveRig, Pose, Result, ServoSample, SlowSample};
use hysteron_virtual_rig::emulator::{
    BusFault, DeviceClock, Format, Options, PoseDelivery, PoseServerSettings, ServoEmulator, Timing,
};
use hysteron_virtual_rig::virtual_rig::{SimulatedRig, VirtualRobot, World, rig_file};
use std::cell::Cell;
use std::collections::VecDeque;
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::sync::OnceLock;
use std::time::{Duration, Instant};

/// Seed of the robot: initial positions of its servos, and its noise.
const SEED: u64 = 1;

/// Calibration of the simulated rig, and positions of its servos at power-on [ticks].
pub fn simulated() -> &'static (RigCalibration, Vec<i32>) {
    static FOUND: OnceLock<(RigCalibration, Vec<i32>)> = OnceLock::new();
    FOUND.get_or_init(|| {
        let robot = VirtualRobot::preset("typical").unwrap();
        let rig = RigConfig::from_toml(&rig_file(&robot), Path::new("")).unwrap();
        let mut hardware = SimulatedRig::new(&robot, &rig, SEED);
        let stood = hardware.prepare().unwrap().iter().map(|servo| servo.position).collect();
        let found = calibrate(&mut hardware, &rig, "simulated".into(), &|| false, &mut |_| {}).unwrap();
        (found, stood)
    })
}

/// The virtual rig `typical` on its ports.
pub struct Rig {
    pub emulator: ServoEmulator,
    pub config: RigConfig,
    _poses: PoseDelivery,
    folder: tempfile::TempDir,
    #[expect(dead_code, reason = "held as long as the rig is")]
    turn: Option<Turn>,
}

impl Rig {
    /// With the example's rig file after these replacements.
    pub fn new(replace: &[(&str, &str)]) -> Self {
        let turn = turn();
        Self { turn: Some(turn), ..Self::among_others(replace) }
    }

    /// The same, in parallel with others of the campaign.
    pub fn among_others(replace: &[(&str, &str)]) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let robot = VirtualRobot::preset("typical").unwrap();
        let mut options = Options::new(folder.path().join("servos"));
        options.return_delay = 0.0;
        options.timing = Timing::Relaxed;
        let emulator = ServoEmulator::start(World::new(&robot, SEED), options).unwrap();
        let clock = DeviceClock { offset: 1000.0, drift: 2e-5 };
        let settings = PoseServerSettings { port: 0, device: "Tip".into(), clock, format: Format::Transform };
        let (poses, address) = emulator.serve_poses(settings).unwrap();
        // A thread of a busy machine may be silent for longer than a servo should wait.
        let mut text = rig_file(&robot)
            .replace("127.0.0.1:18944", &address.to_string())
            .replace("bus_watchdog_ms = 200.0", "bus_watchdog_ms = 2000.0");
        for (from, to) in replace {
            assert!(text.contains(from), "{from}");
            text = text.replace(from, to);
        }
        let config = RigConfig::from_toml(&text, folder.path()).unwrap();
        Self { emulator, config, _poses: poses, folder, turn: None }
    }

    pub fn out(&self) -> PathBuf {
        self.folder.path().join("run.parquet")
    }

    /// The simulated rig's calibration, in the ticks that these servos count: their horns may sit half a turn on.
    pub fn calibration(&self, servos: &[ServoReport]) -> RigCalibration {
        let (mut calibration, stood) = simulated().clone();
        for ((channel, servo), stood) in calibration.channels.iter_mut().zip(servos).zip(stood) {
            channel.zero += servo.position - stood;
        }
        calibration
    }

    /// Opens the ports; for a while if need be.
    pub fn open(&self) -> LiveRig {
        let start = Instant::now();
        loop {
            match LiveRig::open(&self.config) {
                Ok(rig) => return rig,
                Err(error) => assert!(start.elapsed() < Duration::from_secs(20), "{error}"),
            }
            std::thread::sleep(Duration::from_millis(20));
        }
    }

    /// Whether no servo is under torque.
    pub fn is_released(&self) -> bool {
        self.emulator.torque_on().iter().all(|on| !on)
    }

    /// The same, as soon as the emulator has come to note it.
    pub fn comes_to_be_released(&self) -> bool {
        wait_for(|| self.is_released())
    }

    /// Opens the ports and makes the servos ready, as often as a busy machine needs.
    pub fn ready(&self) -> (LiveRig, Vec<ServoReport>) {
        let mut why = String::new();
        for _ in 0..50 {
            let mut rig = self.open();
            match rig.prepare() {
                Ok(servos) => return (rig, servos),
                Err(error) => why = error.to_string(),
            }
        }
        panic!("never ready: {why}")
    }
}

/// Whether something holds in the end, after many seconds at the latest.
pub fn wait_for(mut holds: impl FnMut() -> bool) -> bool {
    let start = Instant::now();
    while !holds() {
        if start.elapsed() > Duration::from_secs(15) {
            return false;
        }
        std::thread::sleep(Duration::from_millis(10));
    }
    true
}

/// Result of a read of all servos: position [ticks] and load [-] of each.
#[derive(Debug, Clone, PartialEq)]
pub struct Read {
    pub servos: Vec<Option<(i32, f64)>>,
}

/// Injects faults at their times, and notes what the session reads.
pub struct Probe<'a> {
    pub rig: LiveRig,
    emulator: &'a ServoEmulator,
    /// Faults to come with their times on the rig's clock [s], in order.
    pub due: VecDeque<(f64, BusFault)>,
    /// Faults that were handed over, and when [s].
    pub injected: Vec<(f64, BusFault)>,
    pub reads: Vec<Read>,
    /// Number of `reads`, accessible while a session owns this.
    pub n_reads: Rc<Cell<usize>>,
    pub n_slow: u64,
}

impl<'a> Probe<'a> {
    pub fn new(rig: LiveRig, emulator: &'a ServoEmulator) -> Self {
        let (due, injected, reads, n_reads) = Default::default();
        Self { rig, emulator, due, injected, reads, n_reads, n_slow: 0 }
    }

    fn look(&mut self) {
        let now = self.rig.now();
        while self.due.front().is_some_and(|(time, _)| *time <= now)
            && let Some((_, fault)) = self.due.pop_front()
        {
            self.emulator.inject(fault.clone()).unwrap();
            self.injected.push((now, fault));
        }
    }
}

impl Hardware for Probe<'_> {
    fn now(&self) -> f64 {
        self.rig.now()
    }

    fn wait_until(&mut self, time: f64) {
        // Faults strike between cycles, too.
        while let Some((due, _)) = self.due.front()
            && *due < time
        {
            let due = *due;
            self.rig.wait_until(due);
            self.look();
        }
        self.rig.wait_until(time);
    }

    fn is_real_time(&self) -> bool {
        self.rig.is_real_time()
    }

    fn n_servos(&self) -> usize {
        self.rig.n_servos()
    }

    fn prepare(&mut self) -> Result<Vec<ServoReport>> {
        self.rig.prepare()
    }

    fn write_goals(&mut self, goals: &[i32]) -> Result<()> {
        self.look();
        self.rig.write_goals(goals)
    }

    fn read_servos(&mut self, samples: &mut [Option<ServoSample>]) -> Result<()> {
        let read = self.rig.read_servos(samples);
        let servos = samples.iter().map(|s| s.map(|s| (s.position, s.load))).collect();
        self.reads.push(Read { servos });
        self.n_reads.set(self.reads.len());
        read
    }

    fn read_slow(&mut self, samples: &mut [Option<SlowSample>]) -> Result<()> {
        self.n_slow += 1;
        self.rig.read_slow(samples)
    }

    fn enable_torque(&mut self) -> Result<()> {
        self.look();
        self.rig.enable_torque()
    }

    fn disable_torque(&mut self) -> Result<()> {
        self.look();
        self.rig.disable_torque()
    }

    fn hold(&mut self) -> Result<()> {
        self.rig.hold()
    }

    fn take_poses(&mut self, poses: &mut Vec<Pose>) {
        self.rig.take_poses(poses);
    }

    fn take_events(&mut self, events: &mut Vec<Event>) {
        self.rig.take_events(events);
    }

    fn counts(&self) -> BusCounts {
        self.rig.counts()
    }

    fn processor_time(&self) -> Option<f64> {
        None
    }

    fn bus_time(&self) -> (f64, f64) {
        self.rig.bus_time()
    }
}
