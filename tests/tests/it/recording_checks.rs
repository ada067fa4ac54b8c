//! Recordings are checked before they are used: by themselves, and by every verb that works with them.

use hysteron_base::{Channel, Metadata, Recording, normal, rng};
use hysteron_tests::{Workplace, root};
use serde_json::Value;

const N: usize = 1500;

/// Two tendons and a tip that swing, with the noise of a tracker; `scale` is the unit of the tip in metres.
fn recording(seed: u64, scale: f64) -> Recording {
    let mut stream = rng(seed, "recording checks");
    let time: Vec<f64> = (0..N).map(|i| 0.01 * i as f64).collect();
    let swing = |rate: f64, t: f64| (rate * t + 0.2 * seed as f64).sin();
    let stroke = |rate: f64| time.iter().map(|t| 4e-3 * swing(rate, *t)).collect();
    let mut tip = |rate: f64| -> Vec<f64> {
        time.iter().map(|t| scale * (30e-3 * swing(rate, *t) + 5e-5 * normal(&mut stream))).collect()
    };
    let channels = vec![
        Channel::new("tip_x_m", tip(1.7)),
        Channel::new("tip_y_m", tip(2.3)),
        Channel::new("stroke_1_m", stroke(1.7)),
        Channel::new("stroke_2_m", stroke(2.3)),
    ];
    Recording::new(time, channels, Vec::new(), Metadata::default()).unwrap()
}

fn write(place: &Workplace, name: &str, recording: &Recording) {
    recording.write(place.path().join(name)).unwrap();
}

#[test]
fn check_reads_recordings_and_refuses_what_cannot_be() {
    let place = Workplace::new();
    write(&place, "clean.parquet", &recording(1, 1.0));
    let clean = place.run(&["check", "clean.parquet"]).succeeded();
    assert!(clean.stdout.contains("1500 rows") && clean.stdout.contains("no warnings"), "{}", clean.stdout);
    write(&place, "copy.csv", &recording(1, 1.0));
    write(&place, "metres.parquet", &recording(2, 1e3));
    let outcome = place.run(&["check", "clean.parquet", "copy.csv", "metres.parquet", "--json"]);
    assert_eq!(outcome.code, Some(2), "{}", outcome.stderr);
    let found: Value = serde_json::from_str(&outcome.stdout).unwrap();
    assert_eq!((found["errors"].as_u64(), found["recordings"].as_array().map(Vec::len)), (Some(1), Some(3)));
    let kinds: Vec<(&str, &str)> = found["findings"]
        .as_array()
        .unwrap()
        .iter()
        .map(|one| (one["recording"].as_str().unwrap(), one["kind"].as_str().unwrap()))
        .collect();
    assert!(
        kinds.contains(&("metres", "unit")) && kinds.contains(&("copy", "copy_of_recording")),
        "{kinds:?}"
    );
    assert!(outcome.stderr.contains("60") && outcome.stderr.contains("hint"), "{}", outcome.stderr);
    // The body of a scene bounds what its tip can do.
    let scene = root().join("meshes/tpu80/scene.toml").display().to_string();
    write(&place, "far.parquet", &recording(3, 4.0));
    place.run(&["check", "far.parquet"]).succeeded();
    let outcome = place.run(&["check", &scene, "far.parquet"]);
    assert!(outcome.error(2).contains("reaches over"), "{}", outcome.stderr);
}

#[test]
fn a_verb_prints_its_warnings_and_adds_them_to_its_report() {
    let place = Workplace::new();
    let clean = recording(1, 1.0);
    write(&place, "a.parquet", &clean);
    write(&place, "b.parquet", &clean);
    let evaluate =
        ["evaluate", "--target", "circle:30", "--geometry", "a.parquet", "b.parquet", "--out", "report"];
    let outcome = place.run(&evaluate).succeeded();
    assert!(outcome.stderr.contains("to the last bit"), "{}", outcome.stderr);
    let metrics: Value = serde_json::from_slice(&place.read("report/metrics.json")).unwrap();
    assert_eq!(metrics["recording_warnings"][0]["kind"], "copy_of_recording");
    let page = String::from_utf8(place.read("report/report.html")).unwrap();
    assert!(page.contains("Warnings about the recordings") && page.trim_end().ends_with("</html>"));
    write(&place, "frozen.parquet", &{
        let channels = clean.channels().iter().map(|channel| match channel.name.starts_with("tip") {
            true => Channel::new(&channel.name, vec![0.01; N]),
            false => channel.clone(),
        });
        Recording::new(clean.time().to_vec(), channels.collect(), Vec::new(), Metadata::default()).unwrap()
    });
    let outcome =
        place.run(&["evaluate", "--target", "circle:30", "--geometry", "frozen.parquet", "--out", "none"]);
    assert!(outcome.error(2).contains("never changes"), "{}", outcome.stderr);
    assert!(!place.path().join("none").exists());
}

#[test]
fn a_path_without_times_is_scored_by_its_geometry_wherever_it_begins() {
    let place = Workplace::new();
    let n = 400;
    let path = |first: usize| -> String {
        let row = |i: usize| {
            let angle = std::f64::consts::TAU * ((first + i) % n) as f64 / n as f64;
            format!("{},{}\n", 16.0 * angle.cos(), 16.0 * angle.sin())
        };
        format!("x_mm,y_mm\n{}", (0..=n).map(row).collect::<String>())
    };
    std::fs::write(place.path().join("a.csv"), path(0)).unwrap();
    std::fs::write(place.path().join("b.csv"), path(137)).unwrap();
    let outcome = place.run(&["evaluate", "--target", "circle:30", "a.csv", "b.csv", "--json"]).succeeded();
    let found: Value = serde_json::from_str(&outcome.stdout).unwrap();
    for row in found["recordings"].as_array().unwrap() {
        // A circle of 32 mm around one of 30: 1 mm everywhere, to the chords' sagitta and the samples of both.
        for key in ["frechet_m", "hausdorff_m"] {
            assert!((row[key].as_f64().unwrap() - 1e-3).abs() < 2e-5, "{key} in {row}");
        }
        assert!(
            row["lag_s"].is_null() && (row["iou"].as_f64().unwrap() - (15.0f64 / 16.0).powi(2)).abs() < 1e-3
        );
    }
}
