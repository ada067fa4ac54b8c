//! States in files, and what it takes to go on from one.

use hysteron_base::BadInput;
use hysteron_twin::{Stepper, Twin, TwinState};
use rand::RngExt;

use super::{Robot, distance, rng, scenes, strokes, tolerance};

const HASH: &str = "5ce4e0ff";

fn bent() -> Robot {
    let mut robot = Robot::new(&scenes::robot());
    robot.go(&strokes(&[2e-3, 1e-4, -3e-3, 5e-4]));
    robot
}

#[test]
fn state_survives_file_bit_for_bit() {
    let mut robot = bent();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("state.bin");
    let mut rng = rng("bits");
    for _ in 0..50 {
        robot.state.load = rng.random_range(0.0..1.0);
        for node in &mut robot.state.positions {
            for c in 0..3 {
                node[c] = rng.random_range(-1.0..1.0) * 10f64.powi(rng.random_range(-300..0));
            }
        }
        robot.state.tensions[0] = -0.0;
        robot.state.write(&path, &robot.twin, HASH, "hysteron simulate").unwrap();
        let read = TwinState::read(&path, &robot.twin, HASH).unwrap();
        let bits = |state: &TwinState| -> Vec<u64> {
            let positions = state.positions.iter().flatten().chain(&state.tensions).chain([&state.load]);
            positions.map(|number| number.to_bits()).collect()
        };
        assert_eq!(bits(&read), bits(&robot.state));
    }
}

/// Error of reading a file changed by `change`.
#[track_caller]
fn refusal(change: impl FnOnce(&mut Vec<u8>)) -> BadInput {
    let robot = bent();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("state.bin");
    robot.state.write(&path, &robot.twin, HASH, "hysteron simulate").unwrap();
    let mut bytes = std::fs::read(&path).unwrap();
    change(&mut bytes);
    std::fs::write(&path, bytes).unwrap();
    let error = TwinState::read(&path, &robot.twin, HASH).expect_err("a damaged file");
    error.bad_input().unwrap_or_else(|| panic!("{error}")).clone()
}

fn replace(bytes: &mut Vec<u8>, from: &str, to: &str) {
    let at = bytes.windows(from.len()).position(|window| window == from.as_bytes());
    let at = at.unwrap_or_else(|| panic!("{from} is in the header"));
    bytes.splice(at..at + from.len(), to.bytes());
}

#[test]
fn state_of_another_scene_is_refused() {
    let bad = refusal(|bytes| replace(bytes, HASH, "00000000"));
    assert!(bad.place.ends_with("scene_hash"), "{bad}");
    assert_eq!((bad.expected.as_str(), bad.found.as_str()), (HASH, "00000000"));
}

#[test]
fn state_of_another_version_is_refused() {
    let bad = refusal(|bytes| replace(bytes, "\"version\":3", "\"version\":4"));
    assert!(bad.place.ends_with("format"), "{bad}");
    assert!(bad.found.ends_with(" 4"), "{bad}");
}

#[test]
fn every_flipped_bit_is_noticed() {
    let robot = bent();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("state.bin");
    robot.state.write(&path, &robot.twin, HASH, "hysteron simulate").unwrap();
    let whole = std::fs::read(&path).unwrap();
    let header = whole.iter().position(|byte| *byte == b'\n').unwrap();
    // Every byte of the header, some of each number.
    for at in (0..header).chain((header..whole.len()).step_by(13)) {
        let mut bytes = whole.clone();
        bytes[at] ^= 1 << (at % 8);
        std::fs::write(&path, bytes).unwrap();
        let error = TwinState::read(&path, &robot.twin, HASH).expect_err("a damaged file");
        let bad = error.bad_input().unwrap_or_else(|| panic!("byte {at}: {error}"));
        assert!(bad.place.contains("state.bin: "), "byte {at}: {bad}");
    }
}

#[test]
fn other_files_are_refused() {
    for content in ["", "\n", "time_s,tip_x_m\n0,0\n", "{\"format\":\"hysteron-state\"}\n", "\u{0}\u{1}"] {
        let bad = refusal(|bytes| *bytes = content.as_bytes().to_vec());
        assert!(bad.place.ends_with("header"), "{bad}");
    }
    let bad = refusal(|bytes| replace(bytes, "hysteron-state", "hysteron-stale"));
    assert!(bad.place.ends_with("format"), "{bad}");
}

#[test]
fn truncated_or_padded_state_is_refused() {
    for remove in [1, 8, 100] {
        let bad = refusal(|bytes| bytes.truncate(bytes.len() - remove));
        assert!(bad.place.ends_with("size") && bad.hint.contains("truncated"), "{bad}");
    }
    assert!(refusal(|bytes| bytes.push(0)).place.ends_with("size"));
    assert!(refusal(|bytes| bytes.extend([0; 8])).place.ends_with("size"));
    // The whole body is missing, even the end of the first line.
    let bad = refusal(|bytes| {
        let end = bytes.iter().position(|byte| *byte == b'\n').unwrap();
        bytes.truncate(end);
    });
    assert!(bad.place.ends_with("size"), "{bad}");
}

#[test]
fn state_of_another_mesh_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("state.bin");
    let robot = bent();
    robot.state.write(&path, &robot.twin, HASH, "hysteron simulate").unwrap();
    let (scene, mesh) =
        scenes::robot_with(hysteron_base::MaterialLaw::Corotational, hysteron_fem::Order::Linear, 8);
    let other = Twin::new(&scene, &mesh).unwrap();
    let error = TwinState::read(&path, &other, HASH).expect_err("another mesh");
    assert!(error.bad_input().is_some_and(|bad| bad.place.ends_with("size")), "{error}");
}

#[test]
fn numbers_that_are_not_finite_are_refused() {
    for number in [f64::NAN, f64::INFINITY] {
        let bad = refusal(|bytes| {
            let at = bytes.len() - 16;
            bytes[at..at + 8].copy_from_slice(&number.to_le_bytes());
        });
        assert!(bad.place.ends_with("numbers"), "{bad}");
    }
}

#[test]
fn load_outside_its_range_is_refused() {
    for load in ["1.5", "-0.5", "1e300"] {
        let bad = refusal(|bytes| replace(bytes, "\"load\":1.0", &format!("\"load\":{load}")));
        assert!(bad.place.ends_with("load"), "{bad}");
    }
}

/// A trajectory that bends all around, with tendons going slack.
fn command(k: usize) -> Vec<hysteron_twin::Target> {
    let angle = 0.15 * k as f64;
    let (x, y) = (1.8e-3 * angle.cos(), 1.8e-3 * (0.7 * angle).sin());
    strokes(&[x, y, -x, -y])
}

#[test]
fn resumed_trajectory_is_the_uninterrupted_one() {
    let scene = scenes::robot();
    let mut whole = Robot::new(&scene);
    let mut interrupted = Robot::new(&scene);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("state.bin");
    let mut largest = 0.0f64;
    for k in 0..60 {
        whole.go(&command(k));
        interrupted.go(&command(k));
        if k == 30 {
            assert_eq!(interrupted.state, whole.state);
            interrupted.state.write(&path, &interrupted.twin, HASH, "hysteron simulate").unwrap();
            interrupted.stepper = Stepper::new(&interrupted.twin);
            interrupted.state = TwinState::read(&path, &interrupted.twin, HASH).unwrap();
        }
        largest = largest.max(distance(whole.tip(), interrupted.tip()));
    }
    println!("tip after resuming: {largest:.1e} m apart");
    // A new stepper has no history to predict from and another factor: each iteration stops elsewhere
    // within the accuracy, 1e-8 of the forces.
    assert!(largest < tolerance(1e-8), "{largest}");
}

#[test]
fn stepper_may_be_moved_to_another_state() {
    let scene = scenes::robot();
    let mut robot = Robot::new(&scene);
    let mut tips = Vec::new();
    let mut states = Vec::new();
    for k in 0..30 {
        robot.go(&command(k));
        tips.push(robot.tip());
        states.push(robot.state.clone());
    }
    // Backwards through the saved states, each time one step on: as if nothing had happened in between.
    for k in (0..29).rev().step_by(7) {
        robot.state = states[k].clone();
        robot.go(&command(k + 1));
        assert!(distance(robot.tip(), tips[k + 1]) < tolerance(1e-8), "step {k}");
    }
    robot.state = robot.twin.rest();
    robot.go(&command(0));
    assert!(distance(robot.tip(), tips[0]) < tolerance(1e-8));
}
