//! The calibration against the truth of the virtual rig.

use hysteron_rig::calibration::{RigCalibration, calibrate};
use hysteron_rig::config::RigConfig;
use hysteron_rig::session::RigSession;
use hysteron_rig::tracker::Registration;
use hysteron_rig::{Error, Hardware, Result};
use hysteron_virtual_rig::virtual_rig::{SimulatedRig, VirtualRobot, rig_file};
use std::path::Path;

fn typical() -> (VirtualRobot, RigConfig) {
    let robot = VirtualRobot::preset("typical").unwrap();
    let rig = RigConfig::from_toml(&rig_file(&robot), Path::new("")).unwrap();
    (robot, rig)
}

/// Calibrates a robot just switched on.
fn calibrated(robot: &VirtualRobot, rig: &RigConfig, seed: u64) -> (Result<RigCalibration>, SimulatedRig) {
    let mut hardware = SimulatedRig::new(robot, rig, seed);
    let found = calibrate(&mut hardware, rig, "today".into(), &|| false, &mut |_| {});
    (found, hardware)
}

fn has_torque(hardware: &mut SimulatedRig) -> bool {
    (0..4).any(|k| hardware.world_mut().command_mut(k).torque_on)
}

/// Natural curvature of a body [1/m].
fn natural_curvature(robot: &VirtualRobot) -> f64 {
    let [x, y] = robot.body.natural_curvature;
    x.hypot(y)
}

#[test]
fn zeros_lie_where_the_tendons_carry_their_pretension() {
    let (robot, rig) = typical();
    let pretension =
        rig.calibration.pretension_load * robot.servos.spec.stall_torque / robot.servos.pulley_radius;
    // All tendons together shorten the body, each stretches itself.
    let (body, tendons) = (&robot.body, &robot.tendons);
    let own_length = body.length + tendons.transmission_length;
    let give = pretension * (4.0 * body.length / body.axial_stiffness + own_length / tendons.axial_stiffness);
    // A body that is not straight gives one tendon what it takes from the opposite one; and a tension within a
    // factor of two is all that friction leaves (below), so half of the give.
    let tolerance = 0.5 * give + tendons.radius * natural_curvature(&robot) * body.length;
    for seed in 1..4 {
        let mut fresh = SimulatedRig::new(&robot, &rig, seed);
        let stood: Vec<i32> = fresh.prepare().unwrap().iter().map(|servo| servo.position).collect();
        let (found, mut hardware) = calibrated(&robot, &rig, seed);
        let found = found.unwrap();
        assert!(!has_torque(&mut hardware));
        for (k, channel) in found.channels.iter().enumerate() {
            let stroke = -channel.stroke(stood[k]);
            let expected = tendons.slack[k] + 0.5 * tendons.play + give;
            assert!((stroke - expected).abs() < tolerance, "tendon {k}: {stroke} m, expected {expected} m");
            // The slack ends before the zero, and no further than all that gives.
            assert!(channel.slack_end < 0.0 && channel.slack_end > -2.0 * give, "{channel:?}");
        }
        // At rest every tendon is taut, and none carries twice its pretension: friction of the guides (15 % over the
        // wrap at the base), play and the curved body (1.3 N from one side to the other) leave no more.
        let mut session = RigSession::start(&mut hardware, &rig, &found, 100.0).unwrap();
        session.slew(&[0.0; 4], 1.0, &|| false).unwrap();
        drop(session);
        for k in 0..4 {
            let tension = hardware.world().tension(k);
            assert!(tension > 0.0 && tension < 2.0 * pretension, "tendon {k}: {tension} N of {pretension} N");
        }
    }
}

#[test]
fn the_tracker_s_frame_is_found_to_what_the_body_s_own_asymmetry_leaves() {
    let (robot, rig) = typical();
    let body = &robot.body;
    // A body with two stiffnesses bends towards its softer axis, off the tendon's direction by this at most.
    let [a, b] = body.bending_stiffness;
    let anisotropy = (a - b).abs() / (a + b);
    // One that is curved at rest moves about its tangent there.
    let curved = natural_curvature(&robot) * body.length;
    // The tracker's slow error, over the shortest motion of the tip: half the length times the bending angle.
    let motion = 0.5 * body.length * rig.calibration.probe / robot.tendons.radius;
    let drift = 2.0 * robot.tracker.bias / motion;

    let turn = robot.tracker.robot_rotation;
    let angle = turn.iter().map(|x| x * x).sum::<f64>().sqrt();
    let [x, y, z] = turn.map(|x| -x / angle * (0.5 * angle).sin());
    let truth = Registration::new([(0.5 * angle).cos(), x, y, z], [0.0; 3]).unwrap();
    for seed in 1..4 {
        let found = calibrated(&robot, &rig, seed).0.unwrap();
        let error = found.registration.unwrap().angle_to(&truth);
        assert!(error < anisotropy + curved + drift, "{error} rad: {anisotropy} + {curved} + {drift}");
        let residual = found.registration_residual;
        assert!(residual > 0.0 && residual < anisotropy + drift, "{residual} rad: {anisotropy} + {drift}");
    }
}

#[test]
fn a_tendon_that_is_not_tied_is_named() {
    let (mut robot, rig) = typical();
    robot.tendons.slack[2] = 0.1;
    let (found, mut hardware) = calibrated(&robot, &rig, 1);
    let error = found.unwrap_err();
    assert!(matches!(&error, Error::Bus(why) if why.contains("tendon 3") && why.contains("tied")), "{error}");
    assert!(!has_torque(&mut hardware));
}

#[test]
fn a_tendon_that_winds_the_other_way_is_named_before_it_is_strained() {
    let (mut robot, rig) = typical();
    robot.servos.directions[1] *= -1.0;
    let (found, mut hardware) = calibrated(&robot, &rig, 1);
    let error = found.unwrap_err();
    assert!(
        matches!(&error, Error::Bus(why) if why.contains("tendon 2: expected its load to fall")),
        "{error}"
    );
    assert!(error.to_string().contains("tendon[2].winds"), "{error}");
    assert!(!has_torque(&mut hardware));
    // A third of the stall torque would be 47 N.
    assert!((0..4).all(|k| hardware.world().tension(k) < 47.0));
}

#[test]
fn a_mirrored_numbering_of_tendons_is_refused() {
    let (robot, mut rig) = typical();
    calibrated(&robot, &rig, 1).0.unwrap();
    let angle = rig.tendons[1].angle;
    rig.tendons[1].angle = rig.tendons[3].angle;
    rig.tendons[3].angle = angle;
    let error = calibrated(&robot, &rig, 1).0.unwrap_err();
    assert!(error.bad_input().unwrap().found.contains("mirror"), "{error}");
}

#[test]
fn tendons_that_are_exchanged_are_refused() {
    let (robot, mut rig) = typical();
    let angle = rig.tendons[0].angle;
    rig.tendons[0].angle = rig.tendons[1].angle;
    rig.tendons[1].angle = angle;
    assert!(calibrated(&robot, &rig, 1).0.unwrap_err().bad_input().is_some());
}
