//! Two arms through their ports: what is recorded is what both did, and every way out ends without torque.

use hysteron_actuator::{Gains, ServoCommand};
use hysteron_base::{BadInput, Metadata, Recording};
use hysteron_rig::session::{events_path, journal_path};
use hysteron_rig::teleoperation::{
    ARMS_FILE, ArmPair, ArmsConfig, ArmsOutcome, ArmsRecording, Estimates, channel_names,
};
use hysteron_virtual_rig::emulator::{BusFault, FaultKind, Options, ServoEmulator, ServoWorld, Timing};
use hysteron_virtual_rig::virtual_arm::{HeldLeader, VirtualArm, VirtualFollower, data_set};
use std::f64::consts::TAU;
use std::path::PathBuf;

/// A step of the encoders [rad].
const TICK: f64 = TAU / 4096.0;
const TRAJECTORY: &str = "force_unlabeled/backward_forward/test/001";
/// When the hand begins to move [s].
const BEGINS: f64 = 2.5;
/// Changes to the file: a busy machine answers late, which is not what is tested.
const PATIENT: [(&str, &str); 3] = [
    ("reply_timeout_ms = 4.0", "reply_timeout_ms = 100.0"),
    ("bus_watchdog_ms = 200.0", "bus_watchdog_ms = 2540.0"),
    ("approach_deg_s = 30.0", "approach_deg_s = 90.0"),
];

/// Both arms on emulated ports.
struct Bench {
    follower: ServoEmulator<VirtualFollower>,
    leader: ServoEmulator<HeldLeader>,
    config: ArmsConfig,
    /// The same leader, to ask where it was.
    hand: HeldLeader,
    arm: VirtualArm,
    folder: tempfile::TempDir,
}

impl Bench {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let arm = VirtualArm::preset("open-manipulator-x").unwrap().individual(3);
        let trial = data_set().into_iter().find(|one| one.name() == TRAJECTORY).unwrap().trial;
        let options = |name: &str, first_id| Options {
            first_id,
            return_delay: 0.0,
            timing: Timing::Relaxed,
            ..Options::new(folder.path().join(name))
        };
        let both = || arm.arms(&trial, 3, TRAJECTORY, BEGINS);
        let ((leader, follower), (hand, _)) = (both(), both());
        let leader = ServoEmulator::start(leader, options("leader", 1)).unwrap();
        let follower = ServoEmulator::start(follower, options("follower", 11)).unwrap();
        let text = PATIENT.iter().fold(ARMS_FILE.to_owned(), |text, (from, to)| {
            assert!(text.contains(from));
            text.replace(from, to)
        });
        let config = ArmsConfig::from_toml(&text, folder.path()).unwrap();
        Self { follower, leader, config, hand, arm, folder }
    }

    fn out(&self) -> PathBuf {
        self.folder.path().join("out.parquet")
    }

    fn record(
        &self,
        seconds: Option<f64>,
        asked: &dyn Fn() -> bool,
        row: &mut dyn FnMut(f64),
    ) -> ArmsOutcome {
        let mut arms = ArmPair::open(&self.config).unwrap();
        arms.prepare().unwrap();
        let recording =
            ArmsRecording::begin(&self.config, &self.out(), &Metadata::default(), Estimates::none()).unwrap();
        recording.run(&mut arms, seconds, asked, row).unwrap()
    }

    fn assert_released(&self) {
        assert!(!self.follower.torque_on().contains(&true));
        assert!(!self.leader.torque_on().contains(&true));
        assert!(!journal_path(&self.out()).exists());
        assert!(events_path(&self.out()).exists() || events_path(&self.partial()).exists());
    }

    fn partial(&self) -> PathBuf {
        self.folder.path().join("out.partial-1.parquet")
    }
}

fn columns<'a>(recording: &'a Recording, stem: &str, unit: &str) -> Vec<&'a [f64]> {
    (1..=5).map(|k| recording.channel(&format!("{stem}_{k}_{unit}")).unwrap()).collect()
}

/// Positions (5 × rows) [rad] of a follower that is sent to `goals` (5 × rows) [rad] at these times [s].
fn followed(alone: &mut VirtualFollower, time: &[f64], goals: &[&[f64]]) -> Vec<Vec<f64>> {
    let mut positions = vec![Vec::new(); goals.len()];
    for i in 0..time.len() {
        // Two seconds to come to rest at the first.
        alone.advance(if i == 0 { 2.0 } else { time[i] - time[i - 1] });
        for (k, goal) in goals.iter().enumerate() {
            let gains = Gains { p: 800, i: 0, d: 0 };
            let goal = (goal[i] / TICK).round() as i32;
            alone.command(k, &ServoCommand { torque_on: true, goal, gains, ..ServoCommand::POWER_ON });
            positions[k].push(alone.servo(k).angle);
        }
        if i == 0 {
            alone.advance(2.0);
        }
    }
    positions
}

#[test]
fn goals_are_the_leader_and_positions_the_follower_that_the_same_goals_move_without_ports() {
    let bench = Bench::new();
    // Time of the emulated world at each row, as it is asked when the row is done.
    let mut clock = Vec::new();
    let outcome = bench.record(Some(6.0), &|| false, &mut |passed| {
        clock.push(bench.leader.world().lock().unwrap().time() - passed);
    });
    assert!(outcome.stopped.is_none() && outcome.is_released && !outcome.was_interrupted);
    bench.assert_released();
    assert_eq!(outcome.out, bench.out());
    let recording = Recording::read(&outcome.out).unwrap();
    let names: Vec<&str> = recording.channels().iter().map(|channel| channel.name.as_str()).collect();
    assert_eq!(names, channel_names(&bench.config));
    let time = recording.time();
    assert!((time[time.len() - 1] - 6.0).abs() < 0.1, "{}", time[time.len() - 1]);

    // A row is done a few ms after its leader was read: at some moment of that time the leader was at its recorded position.
    let start = clock.iter().copied().fold(f64::INFINITY, f64::min);
    let latest = clock.iter().copied().fold(start, f64::max) - start;
    let goals = columns(&recording, "goal", "rad");
    for (i, t) in time.iter().enumerate() {
        for (k, goal) in goals.iter().enumerate() {
            let off = (0..60)
                .map(|step| bench.hand.at(start + t - 0.05 + (0.05 + latest) * f64::from(step) / 59.0)[k])
                .map(|angle| (angle - goal[i]).abs())
                .fold(f64::INFINITY, f64::min);
            // Rounded to ticks twice; between two of the moments tried it moves by less than two ticks.
            assert!(off < 2.0 * TICK, "row {i}, joint {}: {off}", k + 1);
        }
    }

    // The same goals at the same times, without ports.
    let trial = data_set().into_iter().find(|one| one.name() == TRAJECTORY).unwrap().trial;
    let (_, mut alone) = bench.arm.arms(&trial, 3, TRAJECTORY, BEGINS);
    let positions = columns(&recording, "q", "rad");
    let moved = followed(&mut alone, time, &goals);
    for (k, (alone, recorded)) in moved.iter().zip(&positions).enumerate() {
        let after = time.partition_point(|t| *t < 1.5);
        let off =
            alone[after..].iter().zip(&recorded[after..]).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        // Where the approach left a joint within its backlash and friction is forgotten when it has moved. What remains is what it
        // moves while a goal is on its way: a thread that waits for its turn is late by some milliseconds.
        let fastest =
            goals[k].windows(2).zip(time.windows(2)).map(|(g, t)| (g[1] - g[0]).abs() / (t[1] - t[0]));
        let most = 4.0 * TICK + 0.01 * fastest.fold(0.0, f64::max);
        assert!(off < most, "joint {}: {off} of {most}", k + 1);
    }
}

#[test]
fn a_follower_whose_servo_fails_has_its_torque_off_at_once_and_its_rows_are_kept() {
    let bench = Bench::new();
    let outcome = bench.record(Some(20.0), &|| false, &mut |passed| {
        if passed > 0.3 {
            bench.follower.inject(BusFault::new(0.0, FaultKind::Overload).of_servo(13)).unwrap();
        }
    });
    let why = outcome.stopped.unwrap().to_string();
    assert!(why.contains("joint3") && why.contains("overload"), "{why}");
    bench.assert_released();
    assert!(!bench.out().exists());
    assert!(Recording::read(bench.partial()).unwrap().n_samples() > 10);
}

#[test]
fn a_leader_that_is_lost_sends_the_follower_to_rest() {
    let bench = Bench::new();
    let outcome = bench.record(Some(20.0), &|| false, &mut |passed| {
        if passed > 0.3 {
            bench.leader.inject(BusFault::new(0.0, FaultKind::UnplugBus)).unwrap();
        }
    });
    let why = outcome.stopped.unwrap().to_string();
    assert!(why.contains("leader is lost"), "{why}");
    assert!(outcome.is_released);
    bench.assert_released();
    // It went there under torque: no joint hangs where the leader was lost.
    let log = std::fs::read_to_string(events_path(&bench.partial())).unwrap();
    assert!(log.contains("going to rest") && log.contains("torque off"), "{log}");
}

#[test]
fn who_asks_ends_an_open_recording_whole_and_one_of_a_length_early() {
    for (seconds, is_whole) in [(None, true), (Some(20.0), false)] {
        let bench = Bench::new();
        let n_rows = std::cell::Cell::new(0);
        let outcome = bench.record(seconds, &|| n_rows.get() >= 20, &mut |_| n_rows.set(n_rows.get() + 1));
        assert_eq!((outcome.n_rows, outcome.was_interrupted), (20, !is_whole));
        assert_eq!(bench.out().exists(), is_whole);
        bench.assert_released();
    }
}

#[test]
fn a_recorder_that_panics_lets_go() {
    let bench = Bench::new();
    let panicked = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| {
        bench.record(Some(20.0), &|| false, &mut |passed| assert!(passed < 0.2, "on purpose"));
    }));
    assert_eq!(panicked.unwrap_err().downcast_ref::<&str>(), Some(&"on purpose"));
    assert!(!bench.follower.torque_on().contains(&true));
    // Its rows wait in the journal.
    assert!(journal_path(&bench.out()).exists());
}

#[test]
fn exchanged_arms_are_reported_before_anything_moves() {
    let bench = Bench::new();
    let mut config = bench.config.clone();
    std::mem::swap(&mut config.leader.port, &mut config.follower.port);
    let why = ArmPair::open(&config).unwrap().prepare().unwrap_err().to_string();
    assert!(why.contains("servo 1: expected an XL330-M288 to answer, got silence"), "{why}");
    assert!(why.contains("also on the bus: servo 11 (model 1020)"), "{why}");
}

#[test]
fn keys_that_make_no_sense_are_named() {
    let cases = [
        (
            "model = \"XL330-M288\", zero_ticks = 2048, turns = \"positive\" }",
            "model = \"STS3215\", zero_ticks = 2048, turns = \"positive\" }",
            "joint[1].leader.model",
        ),
        ("id = 12", "id = 11", "joint[2].follower.id"),
        ("id = 2,", "id = 1,", "joint[2].leader.id"),
        ("rest_deg = -85.0", "rest_deg = -95.0", "joint[2].rest_deg"),
        ("rate_hz = 60.0", "rate_hz = 0.0", "rate_hz"),
        ("approach_deg_s = 30.0", "approach_deg_s = 400.0", "motion.approach_deg_s"),
        ("port = \"follower\"", "port = \"leader\"", "follower.port"),
        ("voltage_max_v = 14.8", "voltage_max_v = 9.0", "limits.voltage_max_v"),
        ("current_max_a = 2.6", "current_max_a = 2600.0", "limits.current_max_a"),
        ("retries = 2", "retries = -1", "leader.retries"),
        ("closed_deg = 1.4", "closed_deg = inf", "gripper.closed_deg"),
        ("version = 1", "version = 2", "version"),
    ];
    for (from, to, key) in cases {
        assert!(ARMS_FILE.contains(from), "{from}");
        let text = ARMS_FILE.replacen(from, to, 1);
        let bad: BadInput = ArmsConfig::from_toml(&text, "".as_ref()).unwrap_err();
        assert!(bad.to_string().contains(key), "{key}: {bad}");
    }
}
