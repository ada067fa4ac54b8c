//! What stands in the repository works as typed.

use hysteron_base::Recording;
use hysteron_tests::{root, run};

#[test]
fn the_main_job_runs_in_full() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("tip.parquet");
    let strokes = root().join("meshes/tpu80/strokes-circle.csv");
    let [out_text, strokes_text] = [&out, &strokes].map(|path| path.to_str().unwrap());
    run(root(), &["simulate", "meshes/tpu80/scene.toml", "--strokes", strokes_text, "--out", out_text])
        .succeeded();
    let (strokes, tip) = (Recording::read(&strokes).unwrap(), Recording::read(&out).unwrap());
    assert_eq!(tip.time(), strokes.time());
    assert_eq!(tip.strokes(), strokes.strokes());
    // Paper 003 reports some 25 mm to every side for this kind of robot.
    let [x, y, _] = tip.tip().unwrap();
    for values in [x, y] {
        let (low, high) = values.iter().fold((0.0f64, 0.0f64), |(low, high), v| (low.min(*v), high.max(*v)));
        assert!((-30e-3..-15e-3).contains(&low) && (15e-3..30e-3).contains(&high), "{low} {high}");
    }
    // Back at rest, straight.
    let last = tip.n_samples() - 1;
    assert!(x[last].abs() < 1e-4 && y[last].abs() < 1e-4);
}

#[test]
fn help_teaches_every_verb() {
    let help = run(root(), &["--help"]).succeeded().stdout;
    assert!(help.contains("Exit codes"));
    for verb in ["simulate", "mesh", "check"] {
        assert!(help.contains(verb), "{verb}");
        let help = run(root(), &[verb, "--help"]).succeeded().stdout;
        for part in ["Exit codes", "Example", &format!("hysteron {verb} ")] {
            assert!(help.contains(part), "{part} in the help of {verb}");
        }
    }
}
