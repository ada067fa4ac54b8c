//! A recording without mishaps.

use super::probe::Rig;
use super::{Stand, circle, small_circle};
use hysteron_base::{Channel, Metadata, Recording};
use hysteron_rig::bus::{REGISTER_PATIENCE, xl430};
use hysteron_rig::config::{TrackerConfig, TrackerSource};
use hysteron_rig::session::{RecordOptions, RigRecorder, RigSession};
use hysteron_rig::{EventKind, Hardware, LiveRig};
use hysteron_virtual_rig::emulator::{BusFault, FaultKind};
use std::time::{Duration, Instant};

#[test]
fn every_cycle_becomes_a_row_and_the_torque_is_off_in_the_end() {
    let stand = Stand::new();
    let n = 300;
    let mut rows = 0;
    let outcome = stand.record(n, &|| false, &mut |done| rows = done).unwrap();
    assert!(outcome.stopped.is_none(), "{outcome:?}");
    // A busy machine may miss a cycle; its row is then there, and marked.
    assert_eq!((outcome.n_rows - outcome.n_gaps, rows), (n, n));
    assert_eq!(stand.emulator.torque_on(), [false; 4]);

    let recording = Recording::read(stand.out()).unwrap();
    assert!((recording.rate_hz().unwrap() - 100.0).abs() < 1e-6);
    let commands = circle(n);
    let measured: Vec<usize> = (0..recording.n_samples()).filter(|i| !recording.gap()[*i]).collect();
    // A recorded command is the goal of the servo, to half a tick.
    let half_tick = 0.5 * std::f64::consts::TAU * 0.01 / 4096.0;
    for (recorded, planned) in recording.strokes().iter().zip(commands.strokes()) {
        for (i, planned) in measured.iter().zip(planned) {
            assert!((recorded[*i] - planned).abs() <= half_tick * (1.0 + 1e-9));
        }
    }
    let kinds: Vec<EventKind> = outcome.events.iter().map(|event| event.kind).collect();
    assert!(
        kinds.iter().all(|kind| matches!(kind, EventKind::Run | EventKind::Late)),
        "{:?}",
        outcome.events
    );
    assert!(outcome.stats.summary().bus.lost == 0);
}

#[test]
fn a_run_that_is_asked_to_stop_keeps_what_it_has() {
    let stand = Stand::new();
    let done = std::cell::Cell::new(0);
    let outcome = stand.record(300, &|| done.get() >= 50, &mut |rows| done.set(rows)).unwrap();
    assert_eq!(outcome.n_rows - outcome.n_gaps, 50);
    assert!(outcome.out.ends_with("run.partial-1.parquet") && !stand.out().exists());
    assert_eq!(Recording::read(&outcome.out).unwrap().n_samples(), outcome.n_rows);
    assert_eq!(stand.emulator.torque_on(), [false; 4]);
}

#[test]
fn a_replayed_tip_is_recorded_as_it_was() {
    let mut stand = Stand::new();
    // 20 s of a tip that moves along a line, for as long as the run takes.
    let time: Vec<f64> = (0..2000).map(|i| 0.01 * f64::from(i)).collect();
    let along = |x: f64| Channel::new("", time.iter().map(|t| x * t).collect());
    let channels = [("tip_x_m", 1e-3), ("tip_y_m", -2e-3), ("tip_z_m", 3e-3)]
        .map(|(name, speed)| Channel { name: name.into(), ..along(speed) })
        .to_vec();
    let tip = Recording::new(time.clone(), channels, vec![], Metadata::default()).unwrap();
    let path = stand.out().with_file_name("tip.parquet");
    tip.write(&path).unwrap();
    stand.rig.tracker = Some(TrackerConfig {
        source: TrackerSource::Replay(path),
        device: String::new(),
        rate: 100.0,
        latency: 0.0,
        stale: 1.0,
        speed_max: 1.0,
        tip_rest: [0.0; 3],
    });
    // Its line leaves the box that a robot of 80 mm is given.
    (stand.rig.limits.tip_min, stand.rig.limits.tip_max) = ([-1.0; 3], [1.0; 3]);
    let outcome = stand.record(100, &|| false, &mut |_| {}).unwrap();
    assert!(outcome.stopped.is_none(), "{outcome:?}");
    let recording = Recording::read(stand.out()).unwrap();
    let [x, y, z] = recording.tip().unwrap();
    for i in 0..recording.n_samples() {
        assert!((y[i] + 2.0 * x[i]).abs() < 1e-9 && (z[i] - 3.0 * x[i]).abs() < 1e-9);
        assert!(i == 0 || ((x[i] - x[i - 1]) / 1e-5 - 1.0).abs() < 1e-6, "row {i}");
    }
}

#[test]
fn a_port_in_use_is_refused_until_it_is_free() {
    let stand = Stand::new();
    let first = LiveRig::open(&stand.rig).unwrap();
    let error = LiveRig::open(&stand.rig).unwrap_err().to_string();
    assert!(error.contains("another hysteron uses it"), "{error}");
    drop(first);
    LiveRig::open(&stand.rig).unwrap();
}

#[test]
fn a_late_answer_is_not_taken_for_that_of_the_next_question() {
    let mut stand = Stand::new();
    stand.rig.servos.reply_timeout = 4e-3;
    let mut hardware = LiveRig::open(&stand.rig).unwrap();
    // Every third answer comes after its question was given up: registers of one byte must still not be mixed up.
    for _ in 0..12 {
        let delay = BusFault {
            at_s: 0.0,
            kind: FaultKind::DelayPacket,
            servo: Some(1),
            duration_s: None,
            count: Some(1),
            delay_ms: Some(12.0),
            torque_nm: None,
            volts: None,
        };
        stand.emulator.inject(delay).unwrap();
        let mode = hardware.bus().read(1, xl430::OPERATING_MODE).unwrap();
        let error = hardware.bus().read(1, xl430::HARDWARE_ERROR).unwrap();
        assert_eq!((mode, error), (3, 0));
    }
    assert!(hardware.counts().timeouts > 0);
}

/// A servo that answers everything so much too late [s].
fn late(by: f64) -> BusFault {
    BusFault {
        delay_ms: Some(1e3 * by),
        ..BusFault::new(0.0, FaultKind::DelayPacket).of_servo(1).times(10_000)
    }
}

#[test]
fn registers_are_waited_for_while_no_torque_depends_on_it_and_only_then() {
    for by in [0.03, 0.1] {
        let mut stand = Stand::new();
        stand.rig.servos.reply_timeout = 4e-3;
        let mut hardware = LiveRig::open(&stand.rig).unwrap();
        stand.emulator.inject(late(by)).unwrap();
        std::thread::sleep(Duration::from_millis(50));
        assert_eq!(hardware.bus().read(1, xl430::OPERATING_MODE).unwrap(), 3);
        hardware.bus().write(1, xl430::LED, 1).unwrap();
        assert_eq!(hardware.bus().read(1, xl430::LED).unwrap(), 1);
        // The longest wait in a cycle: one question to all, and three more to each after the late one.
        let before = hardware.counts().timeouts;
        let mut samples = [None; 4];
        hardware.bus().read_servos(&mut samples).unwrap();
        assert!(hardware.counts().timeouts - before <= 1 + 4 * 3, "{samples:?}");
    }
}

#[test]
fn a_servo_that_never_answers_is_given_up_after_the_stated_time() {
    let mut stand = Stand::new();
    stand.rig.servos.reply_timeout = 4e-3;
    let mut hardware = LiveRig::open(&stand.rig).unwrap();
    hardware.prepare().unwrap();
    stand.emulator.inject(BusFault::new(0.0, FaultKind::UnplugServo).of_servo(1)).unwrap();
    std::thread::sleep(Duration::from_millis(50));
    let (before, start) = (hardware.counts().timeouts, Instant::now());
    let error = hardware.bus().read(1, xl430::LED).unwrap_err().to_string();
    assert!(error.contains("servo 1, register 65: no answer in time"), "{error}");
    assert!(start.elapsed() >= REGISTER_PATIENCE / 2, "{:?}", start.elapsed());
    // 4, 8, 16 … ms: ten of them are 4 s.
    let n = hardware.counts().timeouts - before;
    assert!((4..=10).contains(&n), "{n} questions");
    // Under torque, or on the way there, the rig file alone counts.
    let before = hardware.counts().timeouts;
    let error = hardware.enable_torque().unwrap_err().to_string();
    assert!(error.contains("servo 1, register") && error.contains("no answer in time"), "{error}");
    assert!(hardware.counts().timeouts - before <= u64::from(1 + stand.rig.servos.retries), "torque waits");
}

#[test]
fn a_tracker_that_repeats_its_last_pose_leaves_gaps() {
    // A busy machine may be silent for longer than a tracker should be.
    let patient =
        [("reply_timeout_ms = 4.0", "reply_timeout_ms = 400.0"), ("stale_ms = 300.0", "stale_ms = 2000.0")];
    let rig = Rig::new(&patient);
    let (mut hardware, servos) = rig.ready();
    let calibration = rig.calibration(&servos);
    let options = RecordOptions::new(rig.out(), Metadata::default());
    let recorder = RigRecorder::begin(&rig.config, &calibration, options).unwrap();
    let session = RigSession::start(&mut hardware, &rig.config, &calibration, 100.0).unwrap();
    let progress = &mut |row: usize| {
        if row.is_multiple_of(150) {
            rig.emulator.inject(BusFault::new(0.0, FaultKind::TrackerFreeze).lasting(0.2)).unwrap();
        }
    };
    let outcome = recorder.run(session, &small_circle(600), &|| false, progress).unwrap();
    assert!(outcome.stopped.is_none(), "{:?}", outcome.stopped);
    assert!(outcome.events.iter().any(|event| event.kind == EventKind::TrackerQuality));
    let recording = Recording::read(&outcome.out).unwrap();
    let (gap, [x, y, z]) = (recording.gap(), recording.tip().unwrap());
    assert!(gap.iter().filter(|gap| **gap).count() >= 3 * 15, "{} gaps", outcome.n_gaps);
    for i in (1..gap.len()).filter(|i| !gap[*i] && !gap[i - 1]) {
        assert!((x[i], y[i], z[i]) != (x[i - 1], y[i - 1], z[i - 1]), "row {i} repeats the one before");
    }
}
