//! Strokes for a path: through the twin, on the rig, and measured.

use hysteron_base::{Channel, Metadata, Recording, json};
use hysteron_tests::{Workplace, root};

#[test]
fn a_path_through_the_nominal_twin_is_carried_out_and_measured() {
    let place = Workplace::new();
    let scene = root().join("meshes/tpu80/scene.toml").display().to_string();
    let command = ["command", "--scene", &scene, "--target", "circle:20", "--out", "strokes.parquet"];
    place.run(&[&command[..], &["--figures", "figures"]].concat()).succeeded();
    let found = Recording::read(place.path().join("strokes.parquet")).unwrap();
    let [x, y] = ["x", "y"].map(|axis| {
        let of = |of: &str| found.require(&format!("{of}_{axis}_m")).unwrap().to_vec();
        of("twin").iter().zip(of("target")).map(|(a, b)| (a - b).powi(2)).sum::<f64>()
    });
    let rmse = ((x + y) / found.n_samples() as f64).sqrt();
    // What is missed fades by a quarter in every sample, and half of the goal's way, 0.2 mm a sample at most, is
    // missed again where M is wrong by half, as where a tendon goes slack: 0.5 · 0.2 mm / 0.25.
    assert!(rmse < 0.4e-3, "{rmse}");
    for strokes in found.strokes() {
        assert!(strokes[found.n_samples() - 1] == 0.0 && strokes.iter().any(|stroke| stroke.abs() > 1e-3));
    }
    let record =
        ["record", "--rig", "virtual:typical", "--strokes", "strokes.parquet", "--out", "tip.parquet"];
    place.run(&record).succeeded();
    let again = place.run(&record).succeeded();
    assert!(again.stderr.contains("1 are there already"), "{}", again.stderr);
    place.run(&["evaluate", "--target", "circle:20", "tip.parquet", "--out", "report"]).succeeded();
    let metrics: serde_json::Value = json::from_text(place.read("report/metrics.json")).unwrap();
    // The robot has friction and slack that the nominal twin does not know, and yet it goes around.
    let iou = metrics["recordings"][0]["iou"].as_f64().unwrap();
    assert!(iou > 0.5 && iou < 0.999, "{iou}");
}

#[test]
fn strokes_that_a_rig_must_not_carry_out_are_refused() {
    let place = Workplace::new();
    let write = |name: &str, n_tendons: usize, value: &dyn Fn(usize) -> f64| {
        let values: Vec<f64> = (0..400).map(value).collect();
        let channels = (1..=n_tendons).map(|k| Channel::new(format!("stroke_{k}_m"), values.clone()));
        let time = (0..400).map(|i| 0.01 * i as f64).collect();
        let recording = Recording::new(time, channels.collect(), vec![], Metadata::default()).unwrap();
        recording.write(place.path().join(name)).unwrap();
    };
    let ramp = |i: usize| 1e-5 * i.min(399 - i) as f64;
    write("three.parquet", 3, &ramp);
    write("far.parquet", 4, &|i| 10.0 * ramp(i));
    write("jump.parquet", 4, &|i| if (100..300).contains(&i) { 5e-3 } else { 0.0 });
    write("ends.parquet", 4, &|i| 5e-6 * i as f64);
    for (name, words) in [
        ("three.parquet", ["stroke columns", "4, as rig"]),
        ("far.parquet", ["stroke 1", "-16"]),
        ("jump.parquet", ["mm/s", "a slower path"]),
        ("ends.parquet", ["end at rest", "row 400"]),
    ] {
        let record = ["record", "--rig", "virtual:typical", "--strokes", name, "--out", "out.parquet"];
        let outcome = place.run(&record);
        let error = outcome.error(2);
        assert!(words.iter().all(|word| error.contains(word)), "{words:?} in {error}");
        assert!(!place.path().join("out.parquet").exists());
    }
    let neither = ["command", "--target", "circle:20", "--out", "strokes.parquet"];
    assert_eq!(place.run(&neither).code, Some(2));
}
