//! The servo in the loop: what it refuses, and friction that holds.
#![allow(clippy::unwrap_used)] // a test may stop where it stands

use hysteron_actuator::CatalogueDrive;
use hysteron_actuator::identify::{Pendulum, PendulumRun, rollout};

use super::drive_model::DriveModel;
use super::tests::{arm, features, with_servo};
use super::*;
use hysteron_arm_dynamics::Model;

#[test]
fn a_servo_for_other_motors_or_out_of_range_is_refused() {
    let whole = with_servo().options().clone();
    let refused = |change: &dyn Fn(&mut RolloutServo)| {
        let mut servo = whole.servo.clone().unwrap();
        change(&mut servo);
        let options = SimulationOptions { servo: Some(servo), ..whole.clone() };
        ArmSimulation::new(&arm(), &features(), &options).unwrap_err().to_string()
    };
    let found = refused(&|servo| servo.stiffness.truncate(4));
    assert!(found.contains("servo.stiffness: expected 5 finite numbers, zero or more"), "{found}");
    assert!(refused(&|servo| servo.friction[2] = f64::NAN).contains("servo.friction"));
    assert!(refused(&|servo| servo.damping = -1.0).contains("servo.damping"));
    for shares in [vec![0.1; 4], vec![0.5; 5], vec![f64::NAN; 5], vec![-0.1; 5]] {
        let found = refused(&|servo| servo.load_friction.clone_from(&shares));
        assert!(found.contains("servo.load_friction: expected none, or 5 from 0 to 0.45"), "{found}");
    }
    let creeps = refused(&|servo| (servo.holds, servo.load_friction) = (false, vec![0.1; 5]));
    assert!(creeps.contains("of friction that holds"), "{creeps}");
}

#[test]
fn friction_that_holds_keeps_a_loaded_joint_and_brakes_as_by_coulomb() {
    let m = features().motors();
    let mut options = with_servo().options().clone();
    let servo = options.servo.as_mut().unwrap();
    (servo.stiffness, servo.friction) = (vec![0.0; m], vec![2.0; m]);
    (options.damping, servo.damping) = (0.0, 0.0);
    let arm = ArmSimulation::new(&arm(), &features(), &options).unwrap();
    // Gravity moves no joint that its friction holds: not at all.
    let mut still = vec![0.0; 2 * m];
    still[1] = 0.8;
    let (nothing, mut state, mut next) = (vec![0.0; m], still.clone(), vec![0.0; 2 * m]);
    let command = MotorCommand { goals: &nothing, gains: &[1.0], windings: &[], torques: &nothing };
    for _ in 0..100 {
        arm.step(&state, command, &mut next);
        state.copy_from_slice(&next);
    }
    assert_eq!(state, still);
    // The gripper's motor, which nothing else moves, loses F/A of its speed in a second, and then stops.
    let (motor, slower) = (m - 1, options.period * 2.0 / options.armature);
    let mut speed = 2.5 * slower;
    state[m + motor] = speed;
    for _ in 0..5 {
        arm.step(&state, command, &mut next);
        state.copy_from_slice(&next);
        speed = (speed - slower).max(0.0);
        assert!((state[m + motor] - speed).abs() < 1e-12, "{} {speed}", state[m + motor]);
    }
    assert_eq!(state[m + motor], 0.0);
    // Friction that creeps lets the arm sink.
    options.servo.as_mut().unwrap().holds = false;
    let creeps = ArmSimulation::new(arm.model(), &features(), &options).unwrap();
    creeps.step(&still, command, &mut next);
    assert!((next[1] - still[1]).abs() > 1e-4, "{}", next[1] - still[1]);
}

#[test]
fn friction_under_load_holds_a_weight_between_the_torques_of_lifting_and_of_letting_go() {
    let share = 0.15;
    let servo = RolloutServo { load_friction: vec![share], ..swings(0.0, 0.0) };
    let arm = Model::from_urdf(PENDULUM, "pendulum").unwrap();
    let still = [0.7, 0.0];
    let weight = super::baselines::gravity_at(&arm, &ALONE, &still[..1])[0];
    let simulation = ArmSimulation::new(&arm, &ALONE, &SimulationOptions::with_servo(&servo, 0.01)).unwrap();
    let moved = |torque: f64| {
        let mut next = [0.0; 2];
        let command = MotorCommand { goals: &[0.7], gains: &[0.0], windings: &[], torques: &[torque] };
        simulation.step(&still, command, &mut next);
        next[0] - still[0]
    };
    // |τ − b| = μ |τ + b|: the same factor (1 + μ)/(1 − μ) up and down.
    let factor = (1.0 + share) / (1.0 - share);
    let [lifts, lets_go] = [weight * factor, weight / factor];
    assert!(moved(0.999 * lifts) == 0.0 && moved(1.001 * lifts) * weight > 0.0);
    assert!(moved(1.001 * lets_go) == 0.0 && moved(0.999 * lets_go) * weight < 0.0);
}

/// A weight on a rod.
const PENDULUM: &str = include_str!("../../tests/data/pendulum.urdf");

/// One joint without a gripper.
const ALONE: FeatureLayout = FeatureLayout { joints: 1, gripper: None };

/// A servo that swings the weight, of this stiffness and friction.
fn swings(stiffness: f64, friction: f64) -> RolloutServo {
    RolloutServo {
        stiffness: vec![stiffness],
        friction: vec![friction],
        load_friction: Vec::new(),
        damping: 0.04,
        rms: 0.0,
        holds: true,
        motors: Motors { armature: Some(0.0024), torque_limit: Some(0.6), ..Motors::default() },
        position_gain: Some(250.0),
    }
}

/// A recording of a servo that is sent to and fro at a gain of its position loop, and has not moved yet.
fn sent(gain: f64, (rows, period): (usize, f64)) -> Trajectory {
    let mut inputs = vec![0.0; rows * ALONE.len()];
    for (row, to) in inputs.chunks_exact_mut(ALONE.len()).enumerate() {
        let t = period * row as f64;
        to[FeatureLayout::GOALS] = 0.9 * (2.0 * t).sin() + 0.5 * (7.0 * t + gain).sin();
        to[ALONE.temperatures()] = 28.0;
    }
    Trajectory {
        name: format!("gain {gain}"),
        inputs,
        states: vec![0.0; 2 * rows],
        voltage: None,
        force: vec![None; rows],
        is_healthy: None,
        position_gain: Some(gain),
        gap: vec![false; rows],
    }
}

/// Trajectory that a servo swinging the weight would report, at a gain of its position loop.
fn swung(servo: &RolloutServo, gain: f64) -> Trajectory {
    let (rows, period) = (300, 0.01);
    let still = sent(gain, (rows, period));
    let arm = Model::from_urdf(PENDULUM, "pendulum").unwrap();
    let segment = Segment::recorded(&still, 0);
    let states = servo.run(&arm, (&ALONE, period), &[segment], rows - 1).unwrap();
    Trajectory { states, ..still }
}

#[test]
fn a_servo_is_found_from_recordings_at_several_gains_and_followed_at_another() {
    is_found_and_followed(false);
    is_found_and_followed(true);
}

fn is_found_and_followed(load_friction: bool) {
    let motors =
        Motors { armature: Some(0.0024), torque_limit: Some(0.6), load_friction, ..Motors::default() };
    let load = vec![0.15; usize::from(load_friction)];
    let truth = RolloutServo { load_friction: load, motors, ..swings(0.8, 0.02) };
    let arm = Model::from_urdf(PENDULUM, "pendulum").unwrap();
    let known = [100.0, 400.0].map(|gain| swung(&truth, gain));
    let found = RolloutServo::fit(&arm, (&ALONE, 0.01, &motors), &known, &|_, _| true).unwrap();
    assert_eq!(found.position_gain, Some(250.0));
    // The recordings are exact: what is left is the tolerance of the search, 1e-3 of the residuals.
    let numbers = |servo: &RolloutServo| {
        [&servo.stiffness[..], &servo.friction, &servo.load_friction, &[servo.damping]].concat()
    };
    assert_eq!(numbers(&found).len(), 3 + usize::from(load_friction));
    for (found, truth) in numbers(&found).into_iter().zip(numbers(&truth)) {
        assert!((found / truth - 1.0).abs() < 0.01, "{found} {truth}");
    }
    let other = swung(&truth, 800.0);
    let segment = Segment::recorded(&other, 0);
    let states = found.run(&arm, (&ALONE, 0.01), &[segment], other.len() - 1).unwrap();
    let worst = states.iter().zip(&other.states).step_by(2).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(worst < 2e-3, "{worst}");
    // A recording without its gain among others with theirs is not taken for one of the usual gain.
    let mixed = [known[0].clone(), Trajectory { position_gain: None, ..known[1].clone() }];
    let error =
        RolloutServo::fit(&arm, (&ALONE, 0.01, &motors), &mixed, &|_, _| true).unwrap_err().to_string();
    assert!(error.contains("position_gain in all recordings or in none, got 1 of 2"), "{error}");
}

/// How far a drive in the loop is from the bench of `hysteron_actuator` at most, over 3 s at this period [rad]; and how warm it gets [°C].
fn off_the_bench(drive: &CatalogueDrive, gain: f64, period: f64) -> (f64, f64) {
    let rows = (3.0 / period) as usize;
    let still = sent(gain, (rows, period));
    let options = SimulationOptions::with_drive(drive, &Motors::default(), period);
    let arm = ArmSimulation::new(&Model::from_urdf(PENDULUM, "pendulum").unwrap(), &ALONE, &options).unwrap();
    let states = super::baselines::run_alone(&arm, &[Segment::recorded(&still, 0)], rows - 1);
    // Inertia and weight of that file, at the bench's gravity.
    let (inertia, weight) = (0.49 * 0.01 + 1e-5, 0.49 * 0.1 * 9.81 / 9.80665);
    let run = PendulumRun {
        name: still.name.clone(),
        time: (0..rows).map(|row| period * row as f64).collect(),
        goal: still.inputs.iter().step_by(ALONE.len()).copied().collect(),
        position: vec![0.0; rows],
        torque_on: vec![true; rows],
        temperature: 28.0,
        gain,
        pendulum: Pendulum { mass: weight * weight / inertia, length: inertia / weight, offset: 0.0 },
    };
    let bench = rollout(&drive.drive, 0.0, &run, 2e-5);
    let off = states.chunks_exact(2).zip(&bench.position).map(|(state, q)| (state[0] - q).abs());
    (off.fold(0.0, f64::max), bench.winding_temperature)
}

#[test]
fn a_drive_in_the_loop_swings_a_weight_as_it_does_on_its_bench() {
    let mut drive = CatalogueDrive::named("xl330-m288").unwrap();
    drive.drive.supply.voltage = 7.3;
    for gain in [150.0, 600.0] {
        let [(rough, warm), (fine, _)] = [0.004, 0.001].map(|period| off_the_bench(&drive, gain, period));
        assert!(warm > 30.0, "{warm} degC: heat takes no part");
        // Both are of first order: a quarter of the step leaves a quarter of the distance.
        assert!((fine / rough - 0.25).abs() < 0.03 && rough < 0.01, "gain {gain}: {rough} {fine}");
    }
}

#[test]
fn windings_are_as_warm_as_what_came_before_a_segment_made_them() {
    let mut drive = CatalogueDrive::named("xl330-m288").unwrap();
    drive.drive.supply.voltage = 7.3;
    let period = 0.01;
    let options = SimulationOptions::with_drive(&drive, &Motors::default(), period);
    let arm = ArmSimulation::new(&Model::from_urdf(PENDULUM, "pendulum").unwrap(), &ALONE, &options).unwrap();
    let still = sent(400.0, (300, period));
    let states = super::baselines::run_alone(&arm, &[Segment::recorded(&still, 0)], 299);
    let whole = Trajectory { states, ..still };
    // From its own states the rest of a rollout is that of the whole: no other memory than heat.
    let rest = super::baselines::run_alone(&arm, &[Segment::recorded(&whole, 200)], 99);
    let worst = rest.iter().zip(&whole.states[400..]).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(worst < 1e-12, "{worst}");
    let cold = whole.rows(200..300);
    let begun = super::baselines::run_alone(&arm, &[Segment::recorded(&cold, 0)], 99);
    let worst = begun.iter().zip(&whole.states[400..]).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(worst > 1e-4, "{worst}: heat is no part of this motion");
}

#[test]
fn what_friction_leaves_is_what_balances_it() {
    let servo = RolloutServo { load_friction: vec![0.2], ..swings(1.0, 0.03) };
    for (torque, speed) in [(0.3, 2.0), (0.3, -2.0), (-0.1, 2.0), (-0.1, -2.0)] {
        let left = DriveModel::Servo(&servo).left_by_friction(0, torque, speed);
        // τ − b = s (F + μ |τ + b|), where the sign of the motor's torque is that of what goes through the gear.
        let friction = 0.03 + 0.2 * (torque + left).abs();
        assert!((torque - left - speed.signum() * friction).abs() < 1e-12, "{torque} {speed}: {left}");
    }
}

#[test]
fn motors_that_cannot_be_are_refused() {
    for (motors, place) in [
        (Motors { armature: Some(0.0), ..Motors::default() }, "armature"),
        (Motors { armature: Some(1e300), ..Motors::default() }, "armature"),
        (Motors { damping: Some(-1.0), ..Motors::default() }, "damping"),
        (Motors { torque_limit: Some(f64::NAN), ..Motors::default() }, "torque limit"),
    ] {
        let error = motors.check().unwrap_err().to_string();
        assert!(error.starts_with(place), "{error}");
    }
}
