//! The version of the equations: part of the hash of every scene, so that what older programs made is not mixed with
//! what this one makes.

use hysteron_base::Recording;
use hysteron_tests::{Workplace, root};

/// Solver tolerance 1e-6 of the forces, over 0.5 s of samples, at the scale of the tip's motion of 10 mm; and 10 for
/// the memory of friction [m].
const TOLERANCE: f64 = 1e-6 * 10e-3 * 10.0;

/// Scene, and the tip after the last of 120 samples [m]. By `cargo test` of this file, of which the message shows
/// what is found.
const TIPS: [(&str, [f64; 3]); 2] = [
    ("scene.toml", [3.947934234869e-3, 5.379351445116e-3, 78.785572877921e-3]),
    ("scene-typical-friction.toml", [5.552590761167e-3, 4.498164333906e-3, 78.659386213544e-3]),
];

#[test]
fn the_same_scene_and_strokes_lead_the_tip_to_the_same_place_in_one_version_of_the_equations() {
    let place = Workplace::new();
    place.write_circle("strokes.csv", 120);
    let mut wrong = Vec::new();
    for (scene, expected) in TIPS {
        let path = root().join("meshes/tpu80").join(scene).display().to_string();
        let out = format!("{scene}.parquet");
        place.run(&["simulate", &path, "--strokes", "strokes.csv", "--out", &out]).succeeded();
        let recording = Recording::read(place.path().join(out)).unwrap();
        let tip = recording.tip().unwrap().map(|axis| axis[axis.len() - 1]);
        if (0..3).any(|c| (tip[c] - expected[c]).abs() > TOLERANCE) {
            wrong.push(format!("{scene}: {tip:?} and not {expected:?}"));
        }
    }
    assert!(
        wrong.is_empty(),
        "where that is meant, raise EQUATIONS in core/base/src/scene/mod.rs and put these tips here: {wrong:#?}"
    );
}
