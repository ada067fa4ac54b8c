//! `hysteron track`: feedback of the tip, and what repeats teach.

use std::path::Path;

use hysteron_base::{Recording, json};
use hysteron_tests::run;

const SCENE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../meshes/tpu80/scene.toml");

/// Tracks a circle with a scene that knows nothing of the robot's friction; gives the errors [m] by repeat.
fn errors(place: &Path, out: &str, more: &[&str]) -> Vec<f64> {
    let track = ["track", "--scene", SCENE, "--nominal", "--rig", "virtual:typical", "--target", "circle:30"];
    run(place, &[&track[..], &["--out", out], more].concat()).succeeded();
    let metrics = std::fs::read_to_string(place.join(out).join("metrics.json")).unwrap();
    let metrics: serde_json::Value = json::from_text(metrics).unwrap();
    let recordings = metrics["recordings"].as_array().unwrap();
    recordings.iter().map(|one| one["rmse_m"].as_f64().unwrap()).collect()
}

#[test]
fn repeats_teach_where_to_lead_the_tip_and_a_stopped_command_goes_on() {
    let place = tempfile::tempdir().unwrap();
    let found = errors(place.path(), "learned", &["--learn", "--repeats", "3"]);
    assert!(found[1..].iter().all(|error| *error < 0.6 * found[0]), "{found:?}");
    let read = |name: &str| Recording::read(place.path().join("learned").join(name)).unwrap();
    let [first, second] = ["strokes.parquet", "strokes-2.parquet"].map(read);
    assert_ne!(first.strokes(), second.strokes());
    // The goal stays the path that was asked for.
    let goal =
        |recording: &Recording| recording.require("target_x_m").unwrap().iter().copied().fold(0.0, f64::max);
    assert_eq!(goal(&first), goal(&second));
    // Without its last repeat the command makes this one again, from the same strokes, and no other.
    let [last, strokes] =
        ["repeat-3.parquet", "strokes-3.parquet"].map(|name| place.path().join("learned").join(name));
    let before = std::fs::read(&strokes).unwrap();
    std::fs::remove_file(last).unwrap();
    let again = errors(place.path(), "learned", &["--learn", "--repeats", "3"]);
    assert_eq!((again, std::fs::read(&strokes).unwrap()), (found, before));

    let one = [
        "track",
        "--scene",
        SCENE,
        "--rig",
        "virtual:typical",
        "--target",
        "circle:30",
        "--out",
        "x",
        "--learn",
    ];
    assert!(run(place.path(), &one).error(2).contains("--learn: expected at least two repeats"));
}

#[test]
fn feedback_takes_slow_errors_away_within_the_limits_of_the_rig() {
    let place = tempfile::tempdir().unwrap();
    let open = errors(place.path(), "open", &[]);
    let closed = errors(place.path(), "closed", &["--feedback"]);
    assert!(closed[0] < 0.6 * open[0], "{closed:?} {open:?}");
    // What was commanded is recorded: it differs from the strokes that were found, along the path alone.
    let read = |name: &str| Recording::read(place.path().join("closed").join(name)).unwrap();
    let (found, run_) = (read("strokes.parquet"), read("repeat-1.parquet"));
    let gate = found.require("feedback").unwrap();
    let first = gate.iter().position(|gate| *gate > 0.0).unwrap();
    let off = |i: usize| (found.strokes()[0][i] - run_.strokes()[0][i]).abs();
    // A tick of the servo is 15 um of tendon.
    assert!((0..first).all(|i| off(i) < 16e-6));
    assert!((first..gate.len()).map(off).fold(0.0, f64::max) > 1e-4);

    // Strokes without the channels of feedback are refused, and so are plans.
    let strokes = [
        "record",
        "--rig",
        "virtual:typical",
        "--strokes",
        "open/strokes.parquet",
        "--feedback",
        "--out",
        "r.csv",
    ];
    let refused = run(place.path(), &strokes);
    let error = refused.error(2);
    assert!(error.contains("feedback") && error.contains("hysteron track --feedback"), "{error}");
    let plan = ["record", "--rig", "virtual:typical", "--plan", "quick", "--feedback", "--out", "p"];
    assert!(run(place.path(), &plan).error(2).contains("--strokes"));
}
