//! The calibration against the truth of the virtual rig.

use hysteron_rig::calibration::{Calibration, calibrate};
use hysteron_rig::config::RigConfig;
use hysteron_rig::virtual_rig::{SimulatedRig, VirtualRobot, rig_file};
use hysteron_rig::{Error, Hardware, Result};
use std::f64::consts::TAU;
use std::path::Path;

fn typical() -> VirtualRobot {
    VirtualRobot::preset("typical").unwrap()
}

/// Calibrates a robot; also returns where its servos stood at power-on [ticks], and the rig afterwards.
fn calibrated(robot: &VirtualRobot, rig: &RigConfig) -> (Result<Calibration>, Vec<i32>, SimulatedRig) {
    let mut hardware = SimulatedRig::new(robot, rig, 1);
    let stood = hardware.prepare().unwrap().iter().map(|servo| servo.position).collect();
    let found = calibrate(&mut hardware, rig, "today".into(), &|| false, &mut |_| {});
    (found, stood, hardware)
}

fn rig_of(robot: &VirtualRobot) -> RigConfig {
    RigConfig::from_toml(&rig_file(robot), Path::new("")).unwrap()
}

fn has_torque(hardware: &mut SimulatedRig) -> bool {
    (0..4).any(|k| hardware.world_mut().command_mut(k).torque_on)
}

#[test]
fn zeros_slack_and_frame_are_the_true_ones() {
    let robot = typical();
    let rig = rig_of(&robot);
    let (found, stood, mut hardware) = calibrated(&robot, &rig);
    let found = found.unwrap();
    assert!(!has_torque(&mut hardware));
    let radius = robot.servos.pulley_radius;
    for (k, channel) in found.channels.iter().enumerate() {
        // Wound since power-on until the corner, and what the world knows of it.
        let corner = channel.stroke_per_tick() * f64::from(channel.zero - stood[k]) + channel.slack_end;
        let truth = robot.tendons.slack[k] + robot.tendons.play;
        eprintln!(
            "tendon {k}: corner {:.3} mm, slack {:.3} mm, pretension {:.3} mm",
            1e3 * corner,
            1e3 * truth,
            -1e3 * channel.slack_end
        );
    }
    let _ = (radius, TAU);
    let registration = found.registration.unwrap();
    eprintln!("residual {:.2} deg {registration:?}", found.registration_residual.to_degrees());
}

#[test]
fn a_tendon_that_is_not_tied_is_named() {
    let mut robot = typical();
    robot.tendons.slack[2] = 0.1;
    let (found, _, mut hardware) = calibrated(&robot, &rig_of(&robot));
    let error = found.unwrap_err();
    eprintln!("{error}");
    assert!(matches!(&error, Error::Bus(why) if why.contains("tendon 3") && why.contains("tied")), "{error}");
    assert!(!has_torque(&mut hardware));
}

#[test]
fn a_tendon_that_winds_the_other_way_is_named() {
    let mut robot = typical();
    let rig = rig_of(&robot);
    robot.servos.directions[1] *= -1.0;
    let (found, _, mut hardware) = calibrated(&robot, &rig);
    let error = found.unwrap_err();
    eprintln!("{error}");
    assert!(!has_torque(&mut hardware));
}
