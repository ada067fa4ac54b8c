//! Study files that nobody meant.
#![allow(clippy::unwrap_used)] // a test may stop where it stands

use std::path::Path;

use hysteron_fuzz::drive;
use hysteron_fuzz::text::{slipped, slips};

use super::Study;
use crate::is_bad_input;

/// Most memory of this process, the other tests in it included [bytes].
const MEMORY_MAX: u64 = 500_000_000;

#[test]
fn no_slip_in_a_study_does_harm() {
    let folder = tempfile::tempdir().unwrap();
    let studies = Path::new(env!("CARGO_MANIFEST_DIR")).join("../cli/studies/demo");
    let robot = Path::new(env!("CARGO_MANIFEST_DIR")).join("../meshes/tpu80");
    std::fs::create_dir(folder.path().join("robot")).unwrap();
    for name in ["plan.toml", "more.toml"] {
        std::fs::copy(studies.join(name), folder.path().join(name)).unwrap();
    }
    for (from, to) in [("scene-typical-friction.toml", "robot/scene.toml"), ("tpu80.msh", "robot/tpu80.msh")]
    {
        std::fs::copy(robot.join(from), folder.path().join(to)).unwrap();
    }
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
