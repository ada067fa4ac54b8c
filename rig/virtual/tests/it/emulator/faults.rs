//! Injected faults: each has its documented effect, and is logged.

use super::{Bench, PATIENCE};
use dynamixel2::ReadError;
use hysteron_base::json;
use hysteron_rig::bus::xl430::*;
use hysteron_virtual_rig::emulator::{BusFault, FAULTS_LOG, FaultKind, FaultMoment, Faults, TORQUE_LOG};
use std::time::{Duration, Instant};

impl Bench {
    /// Breaks something now, and waits until it is broken.
    fn inject(&mut self, fault: BusFault) {
        let n_before = self.n(FaultMoment::Began);
        self.emulator.inject(fault).unwrap();
        self.wait_for("the fault", |bench| bench.n(FaultMoment::Began) > n_before);
    }

    fn n(&self, moment: FaultMoment) -> usize {
        self.emulator.fault_log().iter().filter(|record| record.moment == moment).count()
    }
}

#[test]
fn dropped_answers_are_missing_and_only_those_of_the_servo() {
    let mut bench = Bench::new();
    bench.inject(BusFault::new(0.0, FaultKind::DropPacket).of_servo(2).times(2));
    bench.ask(1, 1, &[]).unwrap();
    for _ in 0..2 {
        bench.say(2, 1, &[]);
        assert!(bench.is_silent());
    }
    bench.ask(2, 1, &[]).unwrap();
    assert_eq!(bench.n(FaultMoment::Struck), 2);
}

#[test]
fn a_lost_instruction_is_not_carried_out() {
    let mut bench = Bench::new();
    bench.inject(BusFault::new(0.0, FaultKind::DropInstruction).of_servo(3));
    bench.say(0xfe, 0x83, &[65, 0, 1, 0, 2, 1, 3, 1]);
    assert_eq!((bench.read(2, LED), bench.read(3, LED)), (1, 0));
}

#[test]
fn a_damaged_answer_is_noticed_by_the_host() {
    let mut bench = Bench::new();
    for round in 0..20 {
        bench.inject(BusFault::new(0.0, FaultKind::CorruptPacket));
        let n_before = bench.emulator.counts().answers;
        bench.say(1, 2, &[132, 0, 4, 0]);
        bench.wait_for("the answer", |bench| bench.emulator.counts().answers > n_before);
        let answer = bench.host.read_status_response_deadline(Instant::now() + Duration::from_millis(20));
        match answer {
            Err(ReadError::InvalidMessage(_) | ReadError::Io(_) | ReadError::BufferFull(_)) => {}
            other => panic!("{round}: {other:?}"),
        }
        assert_eq!(bench.read(1, ID), 1);
    }
}

#[test]
fn a_delayed_answer_comes_late() {
    let mut bench = Bench::new();
    bench.inject(BusFault { delay_ms: Some(80.0), ..BusFault::new(0.0, FaultKind::DelayPacket) });
    let start = Instant::now();
    bench.ask(1, 1, &[]).unwrap();
    assert!(start.elapsed() >= Duration::from_millis(80));
}

#[test]
fn noise_before_an_answer_is_survived() {
    let mut bench = Bench::new();
    bench.inject(BusFault::new(0.0, FaultKind::Noise).times(50));
    bench.ask(1, 1, &[]).unwrap();
}

#[test]
fn an_unplugged_bus_comes_back_under_the_same_name() {
    let mut bench = Bench::new();
    bench.torque(true);
    bench.inject(BusFault::new(0.0, FaultKind::UnplugBus).lasting(1.0));
    let link = bench.emulator.servo_port().to_owned();
    assert!(!link.exists());
    let start = Instant::now();
    bench
        .host
        .write_instruction(1, 1, 0, |_| {})
        .map_err(drop)
        .and_then(|()| bench.host.read_status_response_deadline(start + PATIENCE).map(drop).map_err(drop))
        .unwrap_err();
    assert!(start.elapsed() < PATIENCE, "the host waited for a port that is gone");
    bench.wait_for("the port", |bench| bench.emulator.servo_port().exists());
    bench.host = Bench::open(&bench.emulator, 1_000_000);
    // The servos kept their power.
    assert_eq!(bench.read(1, TORQUE_ENABLE), 1);
}

#[test]
fn an_unplugged_servo_comes_back_without_torque() {
    let mut bench = Bench::new();
    bench.torque(true);
    bench.inject(BusFault::new(0.0, FaultKind::UnplugServo).of_servo(4).lasting(0.2));
    bench.wait_for("the loss", |bench| bench.emulator.torque_on() == [true, true, true, false]);
    bench.say(4, 1, &[]);
    assert!(bench.is_silent());
    bench.wait_awake(4);
    assert_eq!(bench.read(4, TORQUE_ENABLE), 0);
    assert_eq!(bench.n(FaultMoment::Ended), 1);
}

#[test]
fn a_brown_out_resets_all_servos() {
    let mut bench = Bench::new();
    bench.torque(true);
    bench.write(3, PROFILE_VELOCITY, 9).unwrap();
    bench.inject(BusFault::new(0.0, FaultKind::BrownOut));
    bench.wait_for("the reset", |bench| bench.emulator.torque_on() == [false; 4]);
    bench.wait_awake(3);
    assert_eq!(bench.read(3, PROFILE_VELOCITY), 0);
    assert_eq!(bench.read(3, PRESENT_VOLTAGE), 120);
}

#[test]
fn a_shallow_dip_is_only_an_alert() {
    let mut bench = Bench::new();
    bench.torque(true);
    bench.inject(BusFault { volts: Some(5.4), ..BusFault::new(0.0, FaultKind::BrownOut) }.lasting(1.0));
    bench.wait_for("the alert", |bench| bench.ask(1, 1, &[]).unwrap().0);
    bench.wait_for("its end", |bench| !bench.ask(1, 1, &[]).unwrap().0);
    assert_eq!(bench.emulator.torque_on(), [true; 4]);
}

#[test]
fn faults_of_the_tracker_reach_the_sender_of_its_poses() {
    let mut bench = Bench::new();
    let tracker = bench.emulator.tracker_faults();
    assert!(!tracker.is_active(FaultKind::TrackerFreeze));
    bench.inject(BusFault::new(0.0, FaultKind::TrackerFreeze).lasting(1.0));
    bench.wait_for("the fault", |_| tracker.is_active(FaultKind::TrackerFreeze));
    bench.wait_for("its end", |_| !tracker.is_active(FaultKind::TrackerFreeze));
}

#[test]
fn a_script_runs_at_its_times_and_everything_is_logged() {
    let text = "format = \"hysteron-faults\"\nversion = 1\n\
                [[fault]]\nat_s = 0.2\nkind = \"tracker_dropout\"\nduration_s = 0.1\n\
                [[fault]]\nat_s = 0.1\nkind = \"unplug_servo\"\nservo = 1\n";
    let faults = Faults::parse(text).unwrap();
    let mut bench = Bench::with(|options| options.faults = faults);
    bench.write(1, TORQUE_ENABLE, 1).unwrap();
    bench.wait_for("the script", |bench| bench.n(FaultMoment::Ended) == 1);
    let log: Vec<serde_json::Value> =
        bench.text(FAULTS_LOG).lines().map(|line| json::from_text(line).unwrap()).collect();
    let times: Vec<f64> = log.iter().map(|line| line["time_s"].as_f64().unwrap()).collect();
    for (time, expected) in times.iter().zip([0.1, 0.2, 0.3]) {
        assert!((expected..expected + 0.5).contains(time), "{time} for {expected}");
    }
    assert_eq!(log[0]["kind"], "unplug_servo");
    assert_eq!(log[2]["moment"], "ended");
    let torque = bench.text(TORQUE_LOG);
    assert!(torque.contains("[true,false,false,false]"), "{torque}");
    assert!(torque.lines().last().unwrap().contains("[false,false,false,false]"), "{torque}");
}

#[test]
fn impossible_faults_are_refused() {
    let bench = Bench::new();
    let bad = bench.emulator.inject(BusFault::new(0.0, FaultKind::Overload)).unwrap_err();
    assert_eq!((bad.place.as_str(), bad.found.as_str()), ("servo", "nothing"));
}
