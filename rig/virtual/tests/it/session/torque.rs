//! No torque stays on without a request: every exit switches it off although `at_end` is hold, and a
//! servo that is silent keeps no other under torque.

use super::Stand;
use super::stage::{MOMENT, Mishap, Stage};
use hysteron_rig::bus::TorqueState;
use hysteron_rig::calibration::calibrate;
use hysteron_rig::config::RigConfig;
use hysteron_rig::session::{RigSession, Stop};
use hysteron_rig::{Error, Hardware, LiveRig, ServoSample};
use hysteron_virtual_rig::emulator::{BusFault, FaultKind};
use hysteron_virtual_rig::virtual_rig::VirtualRobot;
use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::{Duration, Instant};

const HOLD: (&str, &str) = ("at_end = \"release\"", "at_end = \"hold\"");

fn typical() -> VirtualRobot {
    VirtualRobot::preset("typical").unwrap()
}

/// Readings of servos that end a run.
const READS: [(&str, Mishap); 7] = [
    ("overload", Mishap::Servos(|servos| with(servos, |servo| servo.hardware_error = 0x20))),
    ("torque is off", Mishap::Servos(|servos| with(servos, |servo| servo.torque_on = false))),
    ("load", Mishap::Servos(|servos| with(servos, |servo| servo.load = 0.9))),
    ("rate", Mishap::Servos(|servos| with(servos, |servo| servo.velocity = 9.0))),
    ("servo 3 has not answered", Mishap::Servos(|servos| servos[2] = None)),
    ("temperature", Mishap::Heat(45.0)),
    ("supply", Mishap::ToTheWorld(|world| world.set_supply(9.4))),
];

fn with(servos: &mut [Option<ServoSample>], change: fn(&mut ServoSample)) {
    change(servos[2].as_mut().unwrap());
}

#[test]
fn every_end_of_a_calibration_switches_the_torque_off_also_with_hold() {
    let calibrated =
        |stage: &mut Stage, config: &RigConfig, asked: &dyn Fn() -> bool, say: &mut dyn FnMut(&str)| {
            calibrate(stage, config, "today".into(), asked, say)
        };
    for (part, mishap) in READS {
        let (mut stage, config) = Stage::set(&typical(), &[HOLD], mishap);
        let error = calibrated(&mut stage, &config, &|| false, &mut |_| {}).unwrap_err().to_string();
        assert!(error.contains(part), "{part}: {error}");
        assert!(!stage.is_under_torque(), "{part}");
    }
    // Ctrl-C.
    let (mut stage, config) = Stage::set(&typical(), &[HOLD], Mishap::None);
    let n_asked = Cell::new(0);
    let asked = || n_asked.replace(n_asked.get() + 1) > MOMENT;
    let error = calibrated(&mut stage, &config, &asked, &mut |_| {}).unwrap_err().to_string();
    assert!(error.contains("interrupted") && !stage.is_under_torque(), "{error}");
    // A search that fails.
    let mut untied = typical();
    untied.tendons.slack[2] = 0.1;
    let (mut stage, config) = Stage::set(&untied, &[HOLD], Mishap::None);
    let error = calibrated(&mut stage, &config, &|| false, &mut |_| {}).unwrap_err().to_string();
    assert!(error.contains("tendon 3") && !stage.is_under_torque(), "{error}");
    // Unwinding.
    let (mut stage, config) = Stage::set(&typical(), &[HOLD], Mishap::None);
    let panicked = catch_unwind(AssertUnwindSafe(|| {
        calibrated(&mut stage, &config, &|| false, &mut |_| panic!("on purpose"))
    }));
    assert_eq!(panicked.err().unwrap().downcast_ref::<&str>(), Some(&"on purpose"));
    assert!(!stage.is_under_torque());
    // And a calibration that succeeds leaves a robot without torque.
    let (mut stage, config) = Stage::set(&typical(), &[HOLD], Mishap::None);
    calibrated(&mut stage, &config, &|| false, &mut |_| {}).unwrap();
    assert!(!stage.is_under_torque());
}

#[test]
fn a_motion_that_fails_switches_the_torque_off_before_it_returns() {
    for (part, mishap) in READS {
        let (mut stage, config) = Stage::set(&typical(), &[HOLD], mishap);
        let calibration = stage.calibration();
        let torque = stage.torque.clone();
        let mut session = RigSession::start(&mut stage, &config, &calibration, 100.0).unwrap();
        assert!(torque.get());
        let stop = session.slew(&[0.0; 4], 10.0, &|| false).unwrap_err();
        assert!(stop.to_string().contains(part), "{part}: {stop}");
        assert!(!torque.get(), "{part}: the session is still there, and so is the torque");
        let again = session.slew(&[1e-3; 4], 0.0, &|| false).unwrap_err();
        assert!(matches!(again, Stop::Failed(_)), "{part}: an ended session moved: {again}");
        drop(session);
        assert!(!stage.is_under_torque(), "{part}");
    }
}

#[test]
fn a_session_that_somebody_drops_is_not_held() {
    let (mut stage, config) = Stage::set(&typical(), &[HOLD], Mishap::None);
    let calibration = stage.calibration();
    drop(RigSession::start(&mut stage, &config, &calibration, 100.0).unwrap());
    assert!(!stage.is_under_torque());
}

/// Longest that a living servo may stay under torque when another is silent [s].
const OFF_WITHIN: f64 = 0.020;
/// A machine with other work to do is late now and then; what the protocol costs is seen in the quickest try.
const TRIES: usize = 8;

/// How long it takes until all servos but this one are off [s].
fn time_to_off(silent: u8, kind: FaultKind) -> f64 {
    let stand = Stand::new();
    let mut hardware = LiveRig::open(&stand.rig).unwrap();
    hardware.prepare().unwrap();
    hardware.enable_torque().unwrap();
    drop(hardware);
    let mut rig = stand.rig.clone();
    rig.servos.reply_timeout = 4e-3; // as in the preset
    let mut hardware = LiveRig::open(&rig).unwrap();
    let fault = BusFault::new(0.0, kind).of_servo(silent);
    let fault = if kind == FaultKind::UnplugServo { fault } else { fault.times(10_000) };
    stand.emulator.inject(fault).unwrap();
    std::thread::sleep(Duration::from_millis(50));
    let is_off = || {
        let others = stand.emulator.torque_on();
        (1_u8..).zip(others).all(|(id, on)| !on || id == silent)
    };
    assert!(!is_off(), "not under torque at first");
    std::thread::scope(|scope| {
        let start = Instant::now();
        let confirmed = scope.spawn(move || hardware.disable_torque());
        while !is_off() {
            assert!(start.elapsed() < Duration::from_secs(20), "never off");
            std::thread::sleep(Duration::from_micros(200));
        }
        let time = start.elapsed().as_secs_f64();
        let Err(Error::Torque(states)) = confirmed.join().unwrap() else { panic!("no state of each servo") };
        // The others may have been late.
        let of_silent = states.iter().find(|one| one.servo == silent).unwrap();
        assert_eq!(of_silent.state, TorqueState::Silent, "{states:?}");
        time
    })
}

#[test]
fn a_silent_servo_keeps_no_other_under_torque() {
    for silent in 1..=4 {
        // Without power; it hears but does not answer; it does not even hear.
        for kind in [FaultKind::UnplugServo, FaultKind::DropPacket, FaultKind::DropInstruction] {
            let mut times = Vec::new();
            while times.len() < TRIES && times.iter().all(|time| *time > OFF_WITHIN) {
                times.push(time_to_off(silent, kind));
            }
            assert!(times.iter().any(|time| *time < OFF_WITHIN), "servo {silent}, {kind:?}: {times:?} s");
        }
    }
}

#[test]
fn servos_that_missed_the_first_instruction_get_it_again() {
    let stand = Stand::new();
    let mut hardware = LiveRig::open(&stand.rig).unwrap();
    hardware.prepare().unwrap();
    hardware.enable_torque().unwrap();
    stand.emulator.inject(BusFault::new(0.0, FaultKind::DropInstruction).times(2)).unwrap();
    std::thread::sleep(Duration::from_millis(50));
    hardware.disable_torque().unwrap();
    assert_eq!(stand.emulator.torque_on(), [false; 4]);
}
