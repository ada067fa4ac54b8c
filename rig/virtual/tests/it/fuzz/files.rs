//! Files that people type: rigs, calibrations, virtual robots, faults, plans.

use super::text::{slipped, slips};
use super::{MEMORY_MAX, assert_in_house_form, assert_memory_is_bounded, corpus, drive};
use hysteron_base::{BadInput, Metadata};
use hysteron_control::MotionPlan;
use hysteron_rig::calibration::RigCalibration;
use hysteron_rig::config::RigConfig;
use hysteron_rig::teleoperation::{ARMS_FILE, ArmsConfig};
use hysteron_virtual_rig::emulator::Faults;
use hysteron_virtual_rig::virtual_arm::{VirtualArm, data_set};
use hysteron_virtual_rig::virtual_rig::{VirtualRobot, World};
use std::path::Path;

const RIG: &str = hysteron_rig::config::RIG_FILE;
const CALIBRATION: &str = include_str!("corpus/calibration/valid.toml");
const FAULTS: &str = include_str!("corpus/faults/valid.toml");
/// More strokes than this are not drawn up here, only counted.
const STROKES_MAX: usize = 1_000_000;

fn refused(outcome: Result<(), BadInput>) {
    if let Err(bad) = outcome {
        assert_in_house_form(Some(&bad), &bad);
    }
}

/// The text as a rig; what is accepted can be worked with.
fn rig(text: &str) -> Result<(), BadInput> {
    let rig = RigConfig::from_toml(text, Path::new("folder"))?;
    assert_eq!(rig.ids().len(), rig.tendons.len());
    assert!(rig.servos.reply_timeout <= 1.0);
    Ok(())
}

/// The text as a file of two arms.
fn arms(text: &str) -> Result<(), BadInput> {
    ArmsConfig::from_toml(text, Path::new("folder")).map(drop)
}

/// The text as a calibration; what is accepted maps any position and any stroke, and can be written.
fn calibration(text: &str) -> Result<(), BadInput> {
    let calibration = RigCalibration::from_toml(text)?;
    for positions in [[i32::MIN; 4], [0; 4], [i32::MAX; 4]] {
        let moved = calibration.unwrapped(&positions);
        let mut strokes = [0.0; 4];
        moved.strokes_into(&positions, &mut strokes);
        assert!(strokes.iter().all(|stroke| !stroke.is_nan()), "{strokes:?}");
        for channel in &moved.channels {
            for stroke in [0.0, -1e300, f64::INFINITY, f64::NAN] {
                channel.ticks(stroke);
            }
        }
    }
    let again = RigCalibration::from_toml(&calibration.to_toml()).unwrap();
    assert_eq!(again.channels.len(), calibration.channels.len());
    Ok(())
}

/// The text as a robot; what is accepted lives.
fn robot(text: &str) -> Result<(), BadInput> {
    let robot = VirtualRobot::from_toml(text, "robot.toml").map_err(|error| {
        assert_in_house_form(error.bad_input(), &error);
        error.bad_input().unwrap().clone()
    })?;
    let mut world = World::new(&robot.draw(3), 1);
    for k in 0..world.n_servos() {
        let command = world.command_mut(k);
        command.goal += 40;
        command.torque_on = true;
    }
    world.advance(0.02);
    let mut poses = Vec::new();
    world.take_poses(&mut poses);
    assert!(poses.len() < 100);
    Ok(())
}

/// The text as a virtual arm; what is accepted is recorded, or refused for what it does.
fn arm(text: &str) -> Result<(), BadInput> {
    let bad = |error: hysteron_rig::Error| {
        assert_in_house_form(error.bad_input(), &error);
        error.bad_input().unwrap().clone()
    };
    let arm = VirtualArm::from_toml(text, "arm.toml").map_err(bad)?.individual(3);
    let short = data_set().into_iter().find(|one| one.task == "z_minus").unwrap();
    let recording = arm.record(&short.trial, 1, &short.name(), Metadata::default()).map_err(bad)?;
    assert!(recording.n_samples() < 20_000);
    Ok(())
}

fn faults(text: &str) -> Result<(), BadInput> {
    let faults = Faults::parse(text)?;
    assert!(faults.list.windows(2).all(|pair| pair[0].at_s <= pair[1].at_s));
    Ok(())
}

/// The text as a plan; what is accepted has strokes, all finite.
fn plan(text: &str) -> Result<(), BadInput> {
    let plan = MotionPlan::from_toml(text, "plan.toml").map_err(|error| {
        assert_in_house_form(error.bad_input(), &error);
        error.bad_input().unwrap().clone()
    })?;
    for trajectory in plan.trajectories() {
        let n = trajectory.n_samples() * trajectory.tendons.angles.len();
        if n > STROKES_MAX {
            assert!(trajectory.strokes_at(trajectory.time(1)).iter().all(|stroke| stroke.is_finite()));
        } else {
            trajectory.commands().unwrap();
        }
    }
    Ok(())
}

fn read_corpus(folder: &str, read: fn(&str) -> Result<(), BadInput>) {
    for (name, bytes) in corpus(folder) {
        let text = String::from_utf8(bytes).unwrap();
        let outcome = read(&text);
        assert_eq!(outcome.is_ok(), name.ends_with("valid.toml"), "{name}: {outcome:?}");
        refused(outcome);
    }
    assert_memory_is_bounded();
}

#[test]
fn corpus_of_typed_files_is_refused_in_the_house_form() {
    read_corpus("rig", rig);
    read_corpus("calibration", calibration);
    read_corpus("robot", robot);
    read_corpus("faults", faults);
    read_corpus("plan", plan);
}

/// Tries a reader on slips of a text.
fn tried(name: &str, usual: u32, text: &str, read: fn(&str) -> Result<(), BadInput>) {
    drive(name, usual, MEMORY_MAX, slips(), |slips| refused(read(&slipped(text, &slips))));
}

#[test]
fn no_slip_in_a_rig_file_does_harm() {
    tried("rig file", 2000, RIG, rig);
}

#[test]
fn no_slip_in_a_file_of_arms_does_harm() {
    tried("file of arms", 2000, ARMS_FILE, arms);
}

#[test]
fn no_slip_in_a_calibration_does_harm() {
    tried("calibration", 2000, CALIBRATION, calibration);
}

#[test]
fn no_slip_in_a_fault_file_does_harm() {
    tried("faults", 2000, FAULTS, faults);
}

#[test]
fn no_slip_in_a_plan_does_harm() {
    tried("plan, drawn up", 500, MotionPlan::text("quick").unwrap(), plan);
}

#[test]
fn no_slip_in_a_virtual_robot_does_harm() {
    tried("virtual robot", 500, VirtualRobot::preset_text("typical").unwrap(), robot);
}

#[test]
fn no_slip_in_a_virtual_arm_does_harm() {
    tried("virtual arm", 200, VirtualArm::preset_text("open-manipulator-x").unwrap(), arm);
}
