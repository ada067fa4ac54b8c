//! A disk that stalls costs no cycle.

use super::small_circle;
use super::stage::{Mishap, Stage};
use hysteron_base::{JournalFile, Metadata, Recording};
use hysteron_rig::bus::{BusCounts, ServoReport};
use hysteron_rig::session::{Outcome, RecordOptions, RigRecorder, RigSession, journal_path};
use hysteron_rig::{Event, EventKind, Hardware, Pose, Result, ServoSample, SlowSample};
use hysteron_virtual_rig::virtual_rig::VirtualRobot;
use std::fs::File;
use std::io;
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};
use std::thread::ThreadId;
use std::time::Duration;

/// How long the disk stalls [s], and after how many writes or syncs it does again.
const STALL: f64 = 0.3;
const EVERY: usize = 90;

/// Time that a thread has waited for the disk [s].
#[derive(Debug)]
struct Waited {
    thread: ThreadId,
    time: Mutex<f64>,
}

/// A file on a disk that stalls; its callers wait.
#[derive(Debug)]
struct StallingFile {
    file: File,
    waited: Arc<Waited>,
    n: AtomicUsize,
}

impl StallingFile {
    fn stall(&self) {
        if std::thread::current().id() == self.waited.thread {
            *self.waited.time.lock().unwrap() += STALL;
        } else {
            std::thread::sleep(Duration::from_secs_f64(STALL));
        }
    }
}

impl JournalFile for StallingFile {
    fn append_all(&self, bytes: &[u8]) -> io::Result<()> {
        if self.n.fetch_add(1, Ordering::Relaxed) % EVERY == EVERY - 1 {
            self.stall();
        }
        self.file.append_all(bytes)
    }

    fn cut(&self, length: u64) -> io::Result<()> {
        self.file.cut(length)
    }

    fn sync(&self) -> io::Result<()> {
        self.stall();
        self.file.sync()
    }
}

/// A rig whose time goes on while the thread of its session waits for the disk.
struct Waiting {
    stage: Stage,
    waited: Arc<Waited>,
}

impl Waiting {
    fn catch_up(&mut self) {
        let waited = std::mem::take(&mut *self.waited.time.lock().unwrap());
        let now = self.stage.now();
        self.stage.wait_until(now + waited);
    }
}

impl Hardware for Waiting {
    fn now(&self) -> f64 {
        self.stage.now() + *self.waited.time.lock().unwrap()
    }

    fn wait_until(&mut self, time: f64) {
        self.catch_up();
        self.stage.wait_until(time);
    }

    fn is_real_time(&self) -> bool {
        true
    }

    fn n_servos(&self) -> usize {
        self.stage.n_servos()
    }

    fn prepare(&mut self) -> Result<Vec<ServoReport>> {
        self.stage.prepare()
    }

    fn write_goals(&mut self, goals: &[i32]) -> Result<()> {
        self.catch_up();
        self.stage.write_goals(goals)
    }

    fn read_servos(&mut self, samples: &mut [Option<ServoSample>]) -> Result<()> {
        self.stage.read_servos(samples)
    }

    fn read_slow(&mut self, samples: &mut [Option<SlowSample>]) -> Result<()> {
        self.stage.read_slow(samples)
    }

    fn enable_torque(&mut self) -> Result<()> {
        self.stage.enable_torque()
    }

    fn disable_torque(&mut self) -> Result<()> {
        self.stage.disable_torque()
    }

    fn hold(&mut self) -> Result<()> {
        self.stage.hold()
    }

    fn take_poses(&mut self, poses: &mut Vec<Pose>) {
        self.stage.take_poses(poses);
    }

    fn take_events(&mut self, events: &mut Vec<Event>) {
        self.stage.take_events(events);
    }

    fn counts(&self) -> BusCounts {
        self.stage.counts()
    }

    fn processor_time(&self) -> Option<f64> {
        None
    }

    fn bus_time(&self) -> (f64, f64) {
        self.stage.bus_time()
    }
}

/// Records a circle; the disk stalls, or not.
fn recorded(folder: &Path, is_stalling: bool) -> (Outcome, Recording) {
    let robot = VirtualRobot::preset("typical").unwrap();
    let (mut stage, config) = Stage::set(&robot, &[], Mishap::None);
    let calibration = stage.calibration();
    let waited = Arc::new(Waited { thread: std::thread::current().id(), time: Mutex::new(0.0) });
    let mut rig = Waiting { stage, waited: waited.clone() };
    let options = RecordOptions::new(folder.join("run.parquet"), Metadata::default());
    let recorder = if is_stalling {
        let file = File::create(journal_path(&options.out)).unwrap();
        let file = Arc::new(StallingFile { file, waited, n: AtomicUsize::new(0) });
        RigRecorder::begin_in(file, &config, &calibration, options).unwrap()
    } else {
        RigRecorder::begin(&config, &calibration, options).unwrap()
    };
    // What the disk takes before the torque is on costs nothing.
    rig.catch_up();
    let session = RigSession::start(&mut rig, &config, &calibration, 100.0).unwrap();
    let outcome = recorder.run(session, &small_circle(400), &|| false, &mut |_| {}).unwrap();
    assert!(!rig.stage.is_under_torque());
    let recording = Recording::read(&outcome.out).unwrap();
    (outcome, recording)
}

#[test]
fn a_disk_that_stalls_for_300_ms_costs_no_cycle_and_trips_no_watchdog() {
    let folder = tempfile::tempdir().unwrap();
    let (stalled, rows) = recorded(folder.path(), true);
    assert!(stalled.stopped.is_none(), "{:?}", stalled.stopped);
    assert!(stalled.events.iter().all(|event| event.kind == EventKind::Run), "{:?}", stalled.events);
    assert!(stalled.n_rows == 400 && stalled.stats.summary().late_max_ms < 1e-6, "{stalled:?}");
    let other = tempfile::tempdir().unwrap();
    let (smooth, expected) = recorded(other.path(), false);
    assert_eq!((smooth.n_rows, rows.channels().len()), (400, expected.channels().len()));
}
