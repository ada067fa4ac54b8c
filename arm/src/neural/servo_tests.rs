//! The servo in the loop: what it refuses, and friction that holds.
#![allow(clippy::unwrap_used)] // a test may stop where it stands

use super::tests::{arm, features, with_servo};
use super::*;

#[test]
fn a_servo_for_other_motors_or_out_of_range_is_refused() {
    let whole = with_servo().options().clone();
    let refused = |change: &dyn Fn(&mut ServoModel)| {
        let mut servo = whole.servo.clone().unwrap();
        change(&mut servo);
        let options = SimulationOptions { servo: Some(servo), ..whole.clone() };
        Simulation::new(&arm(), &features(), &options).unwrap_err().to_string()
    };
    let found = refused(&|servo| servo.stiffness.truncate(4));
    assert!(found.contains("servo.stiffness: expected 5 finite numbers, zero or more"), "{found}");
    assert!(refused(&|servo| servo.friction[2] = f64::NAN).contains("servo.friction"));
    assert!(refused(&|servo| servo.damping = -1.0).contains("servo.damping"));
}

#[test]
fn friction_that_holds_keeps_a_loaded_joint_and_brakes_as_coulomb_says() {
    let m = features().motors();
    let mut options = with_servo().options().clone();
    let servo = options.servo.as_mut().unwrap();
    (servo.stiffness, servo.friction) = (vec![0.0; m], vec![2.0; m]);
    (options.damping, servo.damping) = (0.0, 0.0);
    let arm = Simulation::new(&arm(), &features(), &options).unwrap();
    // Gravity moves no joint that its friction holds: not at all.
    let mut still = vec![0.0; 2 * m];
    still[1] = 0.8;
    let (nothing, mut state, mut next) = (vec![0.0; m], still.clone(), vec![0.0; 2 * m]);
    for _ in 0..100 {
        arm.step(&state, [&nothing, &nothing], &mut next);
        state.copy_from_slice(&next);
    }
    assert_eq!(state, still);
    // The gripper's motor, which nothing else moves, loses F/A of its speed in a second, and then stands.
    let (motor, slower) = (m - 1, options.period * 2.0 / options.armature);
    let mut speed = 2.5 * slower;
    state[m + motor] = speed;
    for _ in 0..5 {
        arm.step(&state, [&nothing, &nothing], &mut next);
        state.copy_from_slice(&next);
        speed = (speed - slower).max(0.0);
        assert!((state[m + motor] - speed).abs() < 1e-12, "{} {speed}", state[m + motor]);
    }
    assert_eq!(state[m + motor], 0.0);
    // Friction that creeps lets the arm sink.
    options.servo.as_mut().unwrap().holds = false;
    let creeps = Simulation::new(arm.model(), &features(), &options).unwrap();
    creeps.step(&still, [&nothing, &nothing], &mut next);
    assert!((next[1] - still[1]).abs() > 1e-4, "{}", next[1] - still[1]);
}
