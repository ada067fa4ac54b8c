//! Every limit trips, the robot is brought to rest or its torque goes off as in `safety.rs`, and the recorded rows are kept.

use super::probe::Rig;
use super::small_circle;
use super::stage::{MOMENT, Mishap, Stage};
use hysteron_base::{Metadata, Recording};
use hysteron_rig::session::{Outcome, RecordOptions, RigRecorder, RigSession, Stop};
use hysteron_rig::{Error, EventKind, ShutdownAction};
use hysteron_virtual_rig::emulator::{BusFault, FaultKind};
use std::cell::Cell;

/// A busy machine answers late, which is not what is tested here.
const PATIENT: (&str, &str) = ("reply_timeout_ms = 4.0", "reply_timeout_ms = 400.0");

/// Records on the simulated rig; the run must end by a limit with `part` in its message and this shutdown action.
fn trips(replace: &[(&str, &str)], mishap: Mishap, part: &str, shutdown: ShutdownAction) {
    let (mut stage, outcome) = Stage::record(replace, &small_circle(400), mishap);
    let Some(Stop::Limit(violation)) = &outcome.stopped else { panic!("{part}: {:?}", outcome.stopped) };
    assert!(violation.message.contains(part), "{part}: {violation:?}");
    assert_eq!(violation.shutdown, shutdown, "{violation:?}");
    assert_eq!(stage.goals.last() == Some(&stage.rest), shutdown == ShutdownAction::ToRest, "{part}");
    assert!(!stage.is_under_torque(), "{part}");
    assert!(outcome.n_rows > 0 && outcome.n_rows < 400, "{} rows: {violation:?}", outcome.n_rows);
    let limits = outcome.events.iter().filter(|event| event.kind == EventKind::Limit);
    assert_eq!(limits.count(), 1, "{part}: {:?}", outcome.events);
}

#[test]
fn a_circle_within_its_limits_passes_none() {
    let (mut stage, outcome) = Stage::record(&[], &small_circle(400), Mishap::None);
    assert!(outcome.stopped.is_none(), "{:?}", outcome.stopped);
    assert_eq!((outcome.n_rows, stage.is_under_torque()), (400, false));
}

#[test]
fn commands_out_of_bounds_go_back_to_rest() {
    let stroke = [("stroke_max_mm = 16.0", "stroke_max_mm = 0.5")];
    trips(&stroke, Mishap::None, "stroke, commanded", ShutdownAction::ToRest);
    let rate = [
        ("stroke_rate_max_mm_s = 12.0", "stroke_rate_max_mm_s = 1.5"),
        ("slew_mm_s = 3.0", "slew_mm_s = 1.0"),
    ];
    trips(&rate, Mishap::None, "stroke rate, commanded", ShutdownAction::ToRest);
}

#[test]
fn a_computer_that_stands_still_for_longer_than_the_watchdog_lets_go() {
    trips(&[], Mishap::ToTheWorld(|world| world.advance(0.5)), "standstill", ShutdownAction::TorqueOff);
}

/// Something pulls at the first pulley with more than the servo can hold.
const PULLED: Mishap = Mishap::ToTheWorld(|world| world.set_disturbance(0, -2.0));
/// No limit of what a pull trips.
const UNLIMITED: [(&str, &str); 3] = [
    ("stroke_rate_max_mm_s = 12.0", "stroke_rate_max_mm_s = 500.0"),
    ("load_max_percent = 70.0\nload_limit_percent = 68.0", "load_max_percent = 100.0"),
    ("lag_max_mm = 3.0", "lag_max_mm = 50.0"),
];

#[test]
fn a_pulley_under_an_external_pull_trips_with_any_limit() {
    let [rate, load, lag] = UNLIMITED;
    let stroke =
        [("stroke_max_mm = 16.0", "stroke_max_mm = 2.3"), ("stroke_min_mm = -16.0", "stroke_min_mm = -2.3")];
    trips(&[rate, load, lag, stroke[0], stroke[1]], PULLED, "stroke, measured", ShutdownAction::ToRest);
    trips(&[load, lag], PULLED, "stroke rate, measured", ShutdownAction::ToRest);
    trips(&[rate, load], PULLED, "lag", ShutdownAction::TorqueOff);
    trips(
        &[rate, lag, ("load_max_percent = 70.0\nload_limit_percent = 68.0", "load_max_percent = 40.0")],
        PULLED,
        "load",
        ShutdownAction::TorqueOff,
    );
}

#[test]
fn a_tendon_near_the_load_limit_is_wound_no_further_until_the_plan_comes_back() {
    let (free, _) = Stage::record(&[], &small_circle(400), Mishap::None);
    let run = |hold: f64| {
        let percent = |name: &str, part: f64| format!("{name} = {:?}", 100.0 * part * free.load_max);
        let (max, hold) = (percent("load_max_percent", 0.9), percent("load_limit_percent", hold));
        let replace = [("load_max_percent = 70.0", &max[..]), ("load_limit_percent = 68.0", &hold)];
        Stage::record(&replace, &small_circle(400), Mishap::None)
    };
    let held =
        |outcome: &Outcome| outcome.events.iter().filter(|event| event.kind == EventKind::Hold).count();
    // Held only at the limit is held too late.
    let (_, late) = run(0.9);
    assert!(matches!(&late.stopped, Some(Stop::Limit(limit)) if limit.message.contains("load")), "{late:?}");

    let (mut stage, outcome) = run(0.75);
    assert!(outcome.stopped.is_none(), "{:?}", outcome.stopped);
    assert!(outcome.n_rows == 400 && stage.load_max <= 0.9 * free.load_max);
    // Every tendon that was held went on.
    assert!(held(&outcome) > 0 && held(&outcome).is_multiple_of(2), "{:?}", outcome.events);
    let differ = |(a, b): (&Vec<i32>, &Vec<i32>)| a != b;
    let n_held = stage.goals.iter().zip(&free.goals).filter(|goals| differ(*goals)).count();
    assert!(n_held > 0 && n_held < 400, "{n_held}");
    assert!(stage.goals.last() == free.goals.last() && !stage.is_under_torque());

    // A tendon that stays behind by more than a servo may lag is blocked.
    let percent = format!("load_limit_percent = {:?}", 40.0 * free.load_max);
    let lag = ("lag_max_mm = 3.0", "lag_max_mm = 0.4");
    let replace = [lag, ("load_limit_percent = 68.0", &percent[..])];
    let (mut stage, blocked) = Stage::record(&replace, &small_circle(400), Mishap::None);
    let Some(Stop::Limit(violation)) = &blocked.stopped else { panic!("{:?}", blocked.stopped) };
    assert!(
        violation.message.contains("held back") && violation.shutdown == ShutdownAction::TorqueOff,
        "{violation:?}"
    );
    assert!(!stage.is_under_torque());
}

#[test]
fn heat_and_a_wrong_supply_switch_torque_off() {
    // 24 degrees C of the room, a little of the motor's own, and this much more.
    trips(&[], Mishap::Heat(45.0), "temperature: expected at most 65", ShutdownAction::TorqueOff);
    trips(
        &[],
        Mishap::ToTheWorld(|world| world.set_supply(9.4)),
        "supply: expected 9.5",
        ShutdownAction::TorqueOff,
    );
    trips(
        &[],
        Mishap::ToTheWorld(|world| world.set_supply(14.1)),
        "supply: expected 9.5",
        ShutdownAction::TorqueOff,
    );
}

#[test]
fn a_servo_that_restarts_lets_all_others_go() {
    trips(&[], Mishap::ToTheWorld(|world| world.power_cycle(2)), "torque is off", ShutdownAction::TorqueOff);
}

#[test]
fn a_tip_out_of_bounds_or_sight_goes_back_to_rest() {
    let narrow = [("tip_max_mm = [60.0, 60.0, 95.0]", "tip_max_mm = [60.0, 5.0, 95.0]")];
    trips(&narrow, Mishap::None, "tip: expected y", ShutdownAction::ToRest);
    let narrow = [("tip_min_mm = [-60.0, -60.0, 10.0]", "tip_min_mm = [-5.0, -60.0, 10.0]")];
    trips(&narrow, Mishap::None, "tip: expected x", ShutdownAction::ToRest);
    let gone = Mishap::ToTheWorld(|world| world.set_tracker_connected(false));
    trips(&[], gone, "no pose to trust", ShutdownAction::ToRest);
}

#[test]
fn a_limit_before_the_first_row_leaves_a_log_and_no_recording() {
    let rig = Rig::new(&[PATIENT]);
    let outcome = recorded(
        &rig,
        50,
        &[BusFault { volts: Some(9.0), ..BusFault::new(0.0, FaultKind::BrownOut) }.lasting(2.0)],
        0,
    );
    assert!(
        matches!(&outcome.stopped, Some(Stop::Limit(limit)) if limit.message.contains("supply")),
        "{outcome:?}"
    );
    assert_eq!(outcome.n_rows, 0);
    assert!(!rig.out().exists() && !rig.out().with_extension("journal").exists());
    assert!(rig.out().with_extension("events.jsonl").exists());
    assert!(rig.comes_to_be_released());
}

/// Records on an emulated rig, and breaks these before row `at`.
fn recorded(rig: &Rig, n: usize, faults: &[BusFault], at: usize) -> Outcome {
    recorded_until(rig, n, faults, at, usize::MAX)
}

/// The same, asked to stop after so many rows.
fn recorded_until(rig: &Rig, n: usize, faults: &[BusFault], at: usize, stop: usize) -> Outcome {
    let (mut hardware, servos) = rig.ready();
    let calibration = rig.calibration(&servos);
    let break_all = || faults.iter().for_each(|fault| rig.emulator.inject(fault.clone()).unwrap());
    if at == 0 {
        break_all();
    }
    let options = RecordOptions::new(rig.out(), Metadata::default());
    let recorder = RigRecorder::begin(&rig.config, &calibration, options).unwrap();
    let session = RigSession::start(&mut hardware, &rig.config, &calibration, 100.0).unwrap();
    let done = Cell::new(0);
    let progress = &mut |row| {
        if row == at {
            break_all();
        }
        done.set(row);
    };
    recorder.run(session, &small_circle(n), &|| done.get() >= stop, progress).unwrap()
}

#[test]
fn a_servo_with_an_error_of_its_own_lets_all_go() {
    let rig = Rig::new(&[PATIENT]);
    let outcome = recorded(&rig, 300, &[BusFault::new(0.0, FaultKind::Overload).of_servo(2)], MOMENT);
    let Some(Stop::Limit(violation)) = &outcome.stopped else { panic!("{:?}", outcome.stopped) };
    assert_eq!((violation.tendon, violation.shutdown), (Some(1), ShutdownAction::TorqueOff));
    assert_eq!(violation.message, "the servo reports overload");
    assert!(
        rig.comes_to_be_released()
            && Recording::read(&outcome.out).unwrap().n_samples() >= MOMENT
            && !rig.out().exists()
    );
}

#[test]
fn a_servo_that_is_silent_is_lost_and_the_others_switch_torque_off() {
    let rig = Rig::new(&[("reply_timeout_ms = 4.0", "reply_timeout_ms = 100.0")]);
    let outcome = recorded(&rig, 300, &[BusFault::new(0.0, FaultKind::UnplugServo).of_servo(3)], MOMENT);
    assert!(
        matches!(&outcome.stopped, Some(Stop::Failed(Error::Bus(why))) if why.contains("servo 3 has not answered")),
        "{:?}",
        outcome.stopped
    );
    assert!(outcome.events.iter().any(|e| e.kind == EventKind::ServoLost && e.servo == Some(3)));
    // It cannot be asked, and has no power.
    assert!(!outcome.is_torque_settled && rig.comes_to_be_released());
    assert!(Recording::read(&outcome.out).unwrap().n_samples() >= MOMENT && !rig.out().exists());
}

const HOLD: (&str, &str) = ("at_end = \"release\"", "at_end = \"hold\"");

/// Whether all servos are under torque and stay so although the bus is silent.
fn is_held(rig: &Rig) -> bool {
    use hysteron_rig::bus::xl430::BUS_WATCHDOG;
    let mut hardware = rig.open();
    // No instruction for longer than the watchdog's 2 s.
    std::thread::sleep(std::time::Duration::from_millis(2200));
    let watchdogs: Vec<u32> = (1..=4).map(|id| hardware.bus().read(id, BUS_WATCHDOG).unwrap()).collect();
    watchdogs == [0; 4] && rig.emulator.torque_on() == [true; 4]
}

#[test]
fn a_rig_that_shall_hold_holds_after_a_run_that_came_to_its_end() {
    let rig = Rig::new(&[PATIENT, HOLD]);
    let outcome = recorded(&rig, 50, &[], usize::MAX);
    assert!(outcome.stopped.is_none() && outcome.is_torque_settled, "{:?}", outcome.stopped);
    assert!(is_held(&rig));
}

#[test]
fn a_rig_that_shall_hold_lets_go_after_any_other_end() {
    let rig = Rig::new(&[PATIENT, HOLD]);
    let outcome = recorded(&rig, 300, &[BusFault::new(0.0, FaultKind::Overload).of_servo(1)], 50);
    assert!(matches!(outcome.stopped, Some(Stop::Limit(_))));
    assert!(rig.comes_to_be_released());
    drop(rig);

    let rig = Rig::new(&[PATIENT, HOLD]);
    let outcome = recorded_until(&rig, 300, &[], usize::MAX, 50);
    assert!(matches!(outcome.stopped, Some(Stop::Asked)) && outcome.is_torque_settled);
    assert!(rig.comes_to_be_released());

    // A limit after which the robot first goes back to rest.
    let narrow = ("tip_max_mm = [60.0, 60.0, 95.0]", "tip_max_mm = [60.0, 5.0, 95.0]");
    let (mut stage, outcome) = Stage::record(&[HOLD, narrow], &small_circle(400), Mishap::None);
    assert!(matches!(&outcome.stopped, Some(Stop::Limit(limit)) if limit.shutdown == ShutdownAction::ToRest));
    assert!(stage.goals.last() == Some(&stage.rest) && !stage.is_under_torque());
}
