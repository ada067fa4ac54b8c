#![allow(clippy::unwrap_used)] // a test may stop where it stands
use super::*;
use std::path::Path;

fn rig() -> RigConfig {
    RigConfig::from_toml(crate::config::RIG_FILE, Path::new("")).unwrap()
}

fn example() -> RigCalibration {
    let mut calibration = provisional(&rig(), &[100, -200, 3000, 4095]);
    calibration.date = "2026-11-21T10:00:00Z".into();
    calibration.registration = Some(Registration::new([0.6, 0.8, 0.0, 0.0], [0.1, -0.2, 0.3]).unwrap());
    calibration.registration_residual = 0.01;
    calibration.registers = vec![StoredRegisters::factory(&XL430_W250); 4];
    calibration
}

fn reports() -> Vec<ServoReport> {
    let report = |id| ServoReport {
        id,
        model: XL430_W250.number,
        firmware: 45,
        mode: 4,
        voltage_v: 12.0,
        temperature_degc: 30.0,
        hardware_error: 0,
        torque_on: false,
        position: 0,
        registers: StoredRegisters::factory(&XL430_W250),
    };
    (1..=4).map(report).collect()
}

#[test]
fn a_turn_winds_the_pulley_s_circumference() {
    let channel = example().channels[0];
    let turn = channel.stroke(channel.zero + 4096) - channel.stroke(channel.zero);
    assert!((turn - TAU * 0.01).abs() < 1e-15);
    let reversed = ChannelMap { winds: WindingDirection::Negative, ..channel };
    assert_eq!(reversed.stroke(channel.zero + 10), -channel.stroke(channel.zero + 10));
}

#[test]
fn ticks_and_strokes_are_inverse_to_each_other() {
    for channel in example().channels {
        for ticks in [-5000, -1, 0, 77, 4096] {
            assert_eq!(channel.ticks(channel.stroke(ticks)), ticks);
        }
    }
}

#[test]
fn a_lost_turn_is_found_again() {
    let calibration = example();
    // Strokes of +5 mm are 326 ticks; the servo woke up two turns lower.
    let positions: Vec<i32> =
        calibration.channels.iter().map(|channel| channel.zero + 326 - 2 * 4096).collect();
    let moved = calibration.unwrapped(&positions);
    for (channel, position) in moved.channels.iter().zip(positions) {
        assert_eq!(position - channel.zero, 326);
    }
}

#[test]
fn a_file_gives_back_what_was_written() {
    let calibration = example();
    let read = RigCalibration::from_toml(&calibration.to_toml()).unwrap();
    assert_eq!(read.channels, calibration.channels);
    assert_eq!(read.date, calibration.date);
    assert_eq!(read.registers, calibration.registers);
    let mut again = read.clone();
    for _ in 0..5 {
        again = RigCalibration::from_toml(&again.to_toml()).unwrap();
        assert_eq!(again.hash(), calibration.hash());
    }
    again.channels[2].zero += 1;
    assert_ne!(again.hash(), calibration.hash());
    let (a, b) = (read.registration.unwrap(), calibration.registration.unwrap());
    assert!(a.angle_to(&b) < 1e-12);
    assert!((read.registration_residual - 0.01).abs() < 1e-15);
}

#[test]
fn every_bound_rejects() {
    let text = example().to_toml();
    for (from, to, place) in [
        ("hysteron-calibration", "hysteron-rig", "format"),
        ("version = 1", "version = 9", "version"),
        ("ticks_per_turn = 4096", "ticks_per_turn = 0", "channel[1].ticks_per_turn"),
        ("pulley_radius_mm = 10.0", "pulley_radius_mm = -10.0", "channel[1].pulley_radius_mm"),
        ("zero_ticks = 100", "zero_ticks = 99999999999", "channel[1].zero_ticks"),
        ("rotation_wxyz = [0.6", "rotation_wxyz = [0.7", "registration.rotation_wxyz"),
        ("residual_deg = ", "residual_deg = -", "registration.residual_deg"),
    ] {
        assert!(text.contains(from), "{from} in {text}");
        let bad = RigCalibration::from_toml(&text.replacen(from, to, 1)).unwrap_err();
        assert!(bad.place.ends_with(place), "{bad}");
    }
}

#[test]
fn other_servos_are_refused() {
    let (calibration, rig) = (example(), rig());
    calibration.check(&rig, &reports()).unwrap();

    let mut other_model = reports();
    other_model[2].model = 1020;
    let error = calibration.check(&rig, &other_model).unwrap_err().to_string();
    assert!(error.contains("servo 3: expected model 1060, got 1020"), "{error}");

    let error = calibration.check(&rig, &reports()[..3]).unwrap_err().to_string();
    assert!(error.contains("servo 4 is not on the bus"), "{error}");

    let mut other_rig = rig;
    other_rig.tendons.swap(0, 1);
    let error = calibration.check(&other_rig, &reports()).unwrap_err().to_string();
    assert!(error.contains("[1, 2, 3, 4]") && error.contains("[2, 1, 3, 4]"), "{error}");
}

#[test]
fn a_calibration_without_registers_reads_and_keeps_its_hash() {
    let mut old = example();
    old.registers.clear();
    assert!(!old.to_toml().contains("registers"));
    let read = RigCalibration::from_toml(&old.to_toml()).unwrap();
    assert!(read.registers.is_empty() && read.hash() == old.hash() && read.hash() != example().hash());
    assert_eq!(read.register_baseline(), RegisterBaseline::Factory);
    old.check(&rig(), &reports()).unwrap();
}

#[test]
fn registers_that_cannot_be_are_refused_by_key() {
    let text = example().to_toml();
    for (from, to, place, found) in [
        ("homing_offset = 0", "homing_ofset = 0", "channel[1].registers.homing_ofset", "another name"),
        ("drive_mode = 0", "drive_mode = 256", "channel[1].registers.drive_mode", "256"),
        ("pwm_limit = 885", "pwm_limit = -1", "channel[1].registers.pwm_limit", "-1"),
    ] {
        assert!(text.contains(from), "{from} in {text}");
        let bad = RigCalibration::from_toml(&text.replacen(from, to, 1)).unwrap_err();
        assert!(bad.place.ends_with(place) && bad.found == found, "{bad}");
    }
    let mut some = example();
    some.registers.truncate(1);
    let bad = RigCalibration::from_toml(&some.to_toml()).unwrap_err();
    assert!(bad.place.ends_with("channel[2].registers"), "{bad}");
}

#[test]
fn other_registers_are_refused() {
    let (calibration, rig) = (example(), rig());
    let mut touched = reports();
    let offset = [("homing_offset".to_owned(), 200)].into();
    touched[1].registers =
        touched[1].registers.clone().with(&StoredRegisters::from_keys("", &offset).unwrap());
    let error = calibration.check(&rig, &touched).unwrap_err().to_string();
    assert!(error.contains("servo 2: Homing Offset (register 20): expected 0, got 200"), "{error}");
}

#[test]
fn numbers_that_no_rig_has_and_the_calibration_of_another_rig_are_refused_on_reading() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("calibration.toml");
    let refused = |text: &str| {
        std::fs::write(&path, text).unwrap();
        let error = RigCalibration::read(&path, &rig()).unwrap_err();
        error.bad_input().unwrap().to_string()
    };
    let text = example().to_toml();
    for (from, to, part) in [
        (
            "pulley_radius_mm = 10.0",
            "pulley_radius_mm = 10000.0",
            "channel[1].pulley_radius_mm: expected 1 to 100",
        ),
        ("slack_end_mm = 0.0", "slack_end_mm = 1e6", "channel[1].slack_end_mm"),
        ("residual_deg = ", "residual_deg = 1", "registration.residual_deg"),
        ("pulley_radius_mm = 10.0", "pulley_radius_mm = 12.0", "channel[1]: expected pulley"),
        ("winds = \"positive\"", "winds = \"negative\"", "channel[1]: expected pulley"),
        ("servo_id = 1", "servo_id = 7", "expected servos [1, 2, 3, 4]"),
    ] {
        assert!(text.contains(from), "{from}");
        let to = if part.starts_with("registration") { "residual_deg = 500.0 # " } else { to };
        let bad = refused(&text.replacen(from, to, 1));
        assert!(bad.contains(part), "{bad}");
    }
}
