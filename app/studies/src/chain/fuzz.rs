//! Damaged study files.
#![allow(clippy::unwrap_used)] // a test may stop where it stands

use std::path::Path;

use hysteron_fem::{Layers, MshEncoding, Order, Tube, write_mesh};
use hysteron_fuzz::drive;
use hysteron_fuzz::text::{slipped, slips};

use super::definition::Study;
use hysteron_workflow::is_bad_input;

/// Most memory of this process, the other tests in it included [bytes].
const MEMORY_MAX: u64 = 500_000_000;

/// A body of the robot's size whose twin is built in a moment, as every study read builds it.
fn coarse() -> Tube {
    Tube {
        profile: vec![[0.0, 6e-3], [80e-3, 6e-3]],
        bore_radius: 0.0,
        channels: Vec::new(),
        outer_divisions: 8,
        bore_divisions: 0,
        channel_divisions: 0,
        layers: Layers::Count(2),
        order: Order::Linear,
    }
}

#[test]
fn no_slip_in_a_study_does_harm() {
    let folder = tempfile::tempdir().unwrap();
    let studies = Path::new(env!("CARGO_MANIFEST_DIR")).join("../cli/studies/demo");
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../meshes/tpu80/scene-typical-friction.toml");
    let robot = folder.path().join("robot");
    std::fs::create_dir(&robot).unwrap();
    for name in ["plan.toml", "more.toml"] {
        std::fs::copy(studies.join(name), folder.path().join(name)).unwrap();
    }
    std::fs::copy(scene, robot.join("scene.toml")).unwrap();
    write_mesh(&robot.join("tpu80.msh"), &coarse().mesh().unwrap(), 1e-3, MshEncoding::Binary).unwrap();
    let text = std::fs::read_to_string(studies.join("study.toml")).unwrap();
    let path = folder.path().join("study.toml");
    std::fs::write(&path, &text).unwrap();
    Study::read(&path).unwrap();
    drive("study", 50, MEMORY_MAX, slips(), |slips| {
        std::fs::write(&path, slipped(&text, &slips)).unwrap();
        if let Err(error) = Study::read(&path) {
            let message = format!("{error:#}");
            assert!(is_bad_input(&error), "{message}");
            assert!(message.contains(": expected ") && message.len() < 3000, "{message}");
        }
    });
}
