//! Sessions on an emulated rig, through its ports: recordings, limits, mishaps.

mod campaign;
mod campaign_calibration;
mod disk;
mod exits;
mod limits;
mod probe;
mod record;
mod stage;
mod torque;

use hysteron_base::{Channel, Metadata, Recording};
use hysteron_control::MotionPlan;
use hysteron_rig::calibration::{ChannelMap, RigCalibration};
use hysteron_rig::config::RigConfig;
use hysteron_rig::session::{Outcome, RecordOptions, RigRecorder, RigSession};
use hysteron_rig::{Hardware, LiveRig, Result};
use hysteron_virtual_rig::emulator::{Options, ServoEmulator, Timing};
use hysteron_virtual_rig::virtual_rig::World;
use std::cell::RefCell;
use std::path::PathBuf;
use std::rc::{Rc, Weak};
use std::sync::{PoisonError, RwLock, RwLockReadGuard};

/// Rigs in real time share the processor; the campaign with its many takes it for itself.
static TURN: RwLock<()> = RwLock::new(());

/// Share of the processor while the campaign is not at work.
pub type Turn = Rc<RwLockReadGuard<'static, ()>>;

thread_local! {
    static HELD: RefCell<Weak<RwLockReadGuard<'static, ()>>> = const { RefCell::new(Weak::new()) };
}

/// Waits until the campaign is not at work. A test that has its turn already keeps it for another rig: a second lock
/// would wait behind the campaign, and that for the first one.
pub fn turn() -> Turn {
    HELD.with_borrow_mut(|held| {
        held.upgrade().unwrap_or_else(|| {
            let turn = Rc::new(TURN.read().unwrap_or_else(PoisonError::into_inner));
            *held = Rc::downgrade(&turn);
            turn
        })
    })
}

#[test]
fn a_test_with_two_rigs_does_not_wait_for_the_campaign_that_waits_for_it() {
    let first = turn();
    let campaign = std::thread::spawn(|| drop(TURN.write()));
    // The writer is in the queue by now, mostly; the test passes in any order.
    std::thread::sleep(std::time::Duration::from_millis(50));
    drop(turn());
    drop(first);
    campaign.join().unwrap();
}

/// A rig without tracker, on a port.
pub struct Stand {
    _turn: Turn,
    pub emulator: ServoEmulator,
    pub rig: RigConfig,
    folder: tempfile::TempDir,
}

const RIG: &str = hysteron_rig::config::RIG_FILE;

impl Stand {
    pub fn new() -> Self {
        let _turn = turn();
        let folder = tempfile::tempdir().unwrap();
        let mut options = Options::new(folder.path().join("servos"));
        options.return_delay = 0.0;
        options.timing = Timing::Relaxed;
        let emulator = ServoEmulator::start(World::idle(4), options).unwrap();
        let (before, after) = RIG.split_once("[tracker]").unwrap();
        let text = format!("{before}[limits]{}", after.split_once("[limits]").unwrap().1);
        // A machine with other work to do answers late; that is not what is tested.
        let text = text.replace("reply_timeout_ms = 4.0", "reply_timeout_ms = 400.0");
        let text = text.replace("bus_watchdog_ms = 200.0", "bus_watchdog_ms = 2000.0");
        let rig = RigConfig::from_toml(&text, folder.path()).unwrap();
        Self { _turn, emulator, rig, folder }
    }

    pub fn out(&self) -> PathBuf {
        self.folder.path().join("run.parquet")
    }

    /// Zero at the present positions of the servos.
    pub fn calibration(&self, hardware: &mut LiveRig) -> Result<RigCalibration> {
        let servos = hardware.prepare()?;
        let channels = servos.iter().zip(&self.rig.tendons).map(|(servo, tendon)| ChannelMap {
            servo_id: servo.id,
            model: servo.model,
            ticks_per_turn: 4096,
            pulley_radius: tendon.pulley_radius,
            winds: tendon.winds,
            zero: servo.position,
            slack_end: -1e-3,
        });
        Ok(RigCalibration {
            date: "today".into(),
            rig: self.rig.name.clone(),
            channels: channels.collect(),
            registration: None,
            registration_residual: 0.0,
            registers: servos.iter().map(|servo| servo.registers.clone()).collect(),
        })
    }

    /// Records the first `n` samples of a circle.
    pub fn record(
        &self,
        n: usize,
        asked: &dyn Fn() -> bool,
        progress: &mut dyn FnMut(usize),
    ) -> Result<Outcome> {
        let commands = circle(n);
        let mut hardware = LiveRig::open(&self.rig)?;
        let calibration = self.calibration(&mut hardware)?;
        let options = RecordOptions::new(self.out(), Metadata::default());
        let recorder = RigRecorder::begin(&self.rig, &calibration, options)?;
        let session = RigSession::start(&mut hardware, &self.rig, &calibration, 100.0)?;
        recorder.run(session, &commands, asked, progress)
    }
}

/// The first `n` samples of a trajectory in which every tendon moves.
pub fn circle(n: usize) -> Recording {
    let plan = MotionPlan::named("quick").unwrap();
    let trajectory = plan.trajectories().iter().find(|t| t.name.contains("circle")).unwrap();
    let whole = trajectory.commands().unwrap();
    let cut = |values: &[f64]| values[..n].to_vec();
    let channels = whole
        .channels()
        .iter()
        .map(|channel| Channel::new(channel.name.clone(), cut(&channel.values)))
        .collect();
    Recording::new(cut(whole.time()), channels, vec![], whole.meta().clone()).unwrap()
}

/// Half the plan's circle, so that no limit is passed without a fault.
pub fn small_circle(n: usize) -> Recording {
    let whole = circle(n);
    let channels = whole
        .channels()
        .iter()
        .map(|channel| Channel::new(channel.name.clone(), channel.values.iter().map(|s| 0.5 * s).collect()));
    Recording::new(whole.time().to_vec(), channels.collect(), vec![], whole.meta().clone()).unwrap()
}
