//! A servo of a simulated arm compared with a measured one.

use std::path::Path;

use hysteron_actuator::CatalogueDrive;
use hysteron_arm_dynamics::Model;
use hysteron_arm_estimation::{ArmProperties, ImportOptions, import};
use hysteron_arm_learning::neural::{
    FeatureLayout, Motors, RolloutServo, Segment, Trajectory, Unlabelled, trajectory_of,
};
use hysteron_base::{BadInput, Metadata};
use hysteron_fuzz::recorded;

/// The weight that bam's XL330 swings.
const PENDULUM: &str = include_str!("../data/pendulum.urdf");

const ALONE: FeatureLayout = FeatureLayout { joints: 1, gripper: None };
const PERIOD: f64 = 0.01;

fn swung(path: &Path, drive: &CatalogueDrive) -> Result<Trajectory, BadInput> {
    let options = ImportOptions {
        arm: ArmProperties { drive: Some(drive), ..Default::default() },
        rate_hz: Some(1.0 / PERIOD),
        ..ImportOptions::default()
    };
    let recording = import(path, &options, Metadata::default()).unwrap().recording;
    trajectory_of(&recording, &ALONE, PERIOD, Unlabelled::Unknown)
}

/// Mean absolute error of rollouts from the first sample on [rad].
fn error(servo: &RolloutServo, arm: &Model, asked: &[Trajectory]) -> f64 {
    let one = |one: &Trajectory| {
        let states = servo.run(arm, (&ALONE, PERIOD), &[Segment::recorded(one, 0)], one.len() - 1).unwrap();
        let off = states.chunks_exact(2).zip(one.states.chunks_exact(2)).map(|(a, b)| (a[0] - b[0]).abs());
        off.sum::<f64>() / one.len() as f64
    };
    asked.iter().map(one).sum::<f64>() / asked.len() as f64
}

#[test]
fn a_measured_servo_is_predicted_better_with_its_position_gains() {
    let name = "a_measured_servo_is_predicted_better_with_its_position_gains";
    let Some(folder) = recorded(name, "arms/bam/xl330") else { return };
    let drive = CatalogueDrive::named("xl330-m288").unwrap();
    let mut paths: Vec<_> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    let all: Vec<Trajectory> = paths.iter().map(|path| swung(path, &drive).unwrap()).collect();
    let at = |gains: [f64; 2]| -> Vec<Trajectory> {
        let is_asked = |one: &&Trajectory| gains.iter().any(|gain| one.position_gain == Some(*gain));
        all.iter().filter(is_asked).cloned().collect()
    };
    let (known, asked) = (at([100.0, 400.0]), at([200.0, 800.0]));
    assert_eq!((known.len(), asked.len()), (4, 4));
    let arm = Model::from_urdf(PENDULUM, "pendulum").unwrap();
    let motors = Motors { armature: Some(0.0024), torque_limit: Some(0.63), ..Motors::default() };
    let fit = |known: &[Trajectory]| {
        RolloutServo::fit(&arm, (&ALONE, PERIOD, &motors), known, &|_, _| true).unwrap()
    };
    let without = |all: &[Trajectory]| -> Vec<Trajectory> {
        all.iter().map(|one| Trajectory { position_gain: None, ..one.clone() }).collect()
    };
    let informed = error(&fit(&known), &arm, &asked);
    let uninformed = error(&fit(&without(&known)), &arm, &without(&asked));
    // Duties of the eight logs follow gain times error with slopes of 0.996 to 1.001; without gains, stiffness is wrong by two either way.
    assert!(informed < uninformed, "{informed} {uninformed}");
}

#[test]
fn a_log_in_which_the_torque_goes_off_is_refused() {
    let name = "a_log_in_which_the_torque_goes_off_is_refused";
    let Some(path) = recorded(name, "arms/bam/data_raw_feetech/2024-10-26_12h23m42.json") else { return };
    let error = swung(&path, &CatalogueDrive::named("sts3250").unwrap()).unwrap_err().to_string();
    assert!(error.contains("torque_on_1_ratio: expected 1 at all times"), "{error}");
}
