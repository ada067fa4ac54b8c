//! Where the tip should go, whether it can, and how closely it did.

use hysteron_base::{Channel, Metadata, Recording, json};
use hysteron_tests::{Workplace, names_in};

fn metrics(place: &Workplace, folder: &str) -> serde_json::Value {
    json::from_text(place.read(&format!("{folder}/metrics.json"))).unwrap()
}

/// Writes the target in `from` as a tip that was measured, made this much larger and moved [m].
fn write_tip(place: &Workplace, from: &str, to: &str, factor: f64, away: [f64; 2]) {
    let target = Recording::read(place.path().join(from)).unwrap();
    let channel = |name: &str, away: f64| {
        let values = target.channel(name).unwrap().iter().map(|value| factor * value + away).collect();
        Channel::new(name, values)
    };
    let channels = vec![channel("tip_x_m", away[0]), channel("tip_y_m", away[1])];
    let tip = Recording::new(target.time().to_vec(), channels, vec![], Metadata::default()).unwrap();
    tip.write(place.path().join(to)).unwrap();
}

#[test]
fn recordings_are_measured_against_their_target() {
    let place = Workplace::new();
    let outcome = place.run(&["target", "circle:40", "--out", "target.parquet"]).succeeded();
    assert_eq!(outcome.stdout, "target.parquet\n");
    write_tip(&place, "target.parquet", "tips/a.csv", 1.1, [0.0; 2]);
    write_tip(&place, "target.parquet", "tips/b.parquet", 0.9, [0.0; 2]);
    let out = ["--out", "report"];
    let outcome =
        place.run(&[&["evaluate", "--target", "target.parquet", "tips"][..], &out].concat()).succeeded();
    let lines: Vec<&str> = outcome.stdout.lines().collect();
    // Wider than a terminal, the table has a line for each number; the verdict ends it.
    assert!(lines[0].starts_with("Recording") && lines[0].ends_with("CV"), "{}", outcome.stdout);
    assert!(lines.iter().any(|line| line.starts_with("NRMSE [%]")), "{}", outcome.stdout);
    assert!(lines.iter().take(10).all(|line| line.chars().count() <= 80), "{}", outcome.stdout);
    let verdict = lines.iter().find_map(|line| line.strip_prefix("verdict: ")).unwrap();
    assert!(verdict.starts_with("Usable: the tip follows the target within 1.4"), "{verdict}");

    let found = metrics(&place, "report");
    assert_eq!(found["verdict"]["sentence"], verdict);
    // 2 mm around a circle of 40: 2 / √2 along each axis. Chords of the samples cut off less than a micrometre.
    for (row, iou) in found["recordings"].as_array().unwrap().iter().zip([1.0 / 1.21, 0.81]) {
        let number = |key: &str| row[key].as_f64().unwrap();
        assert!((number("rmse_m") - 2e-3 * 0.5f64.sqrt()).abs() < 1e-6, "{row}");
        assert!((number("nrmse") - 0.05 * 0.5f64.sqrt()).abs() < 1e-4, "{row}");
        assert!((number("iou") - iou).abs() < 1e-4, "{row}");
        assert!((number("hausdorff_m") - 2e-3).abs() < 1e-6 && number("lag_s").abs() < 0.02, "{row}");
        assert_eq!(row["sha256"].as_str().unwrap().len(), 64);
    }
    assert!(found["repeatability"]["rmse_m"]["variation"].as_f64().unwrap() < 1e-3);
    let names = ["metrics.json", "report.html", "tracking-time.svg", "tracking.svg"];
    assert_eq!(names_in(&place.path().join("report")), names);
    let report = String::from_utf8(place.read("report/report.html")).unwrap();
    assert!(report.contains("hysteron evaluate --target target.parquet tips") && report.contains("<svg"));
    let svg = String::from_utf8(place.read("report/tracking.svg")).unwrap();
    for text in ["error [mm]", "a: at most 2", "b: at most 2", "x [mm]"] {
        assert!(svg.contains(text), "{text}");
    }

    // The same by name, from a robot at another place.
    write_tip(&place, "target.parquet", "moved.csv", 1.0, [0.1, -0.2]);
    let moved = ["evaluate", "--target", "circle:40", "moved.csv", "--out", "moved"];
    place.run(&moved).succeeded();
    assert!(metrics(&place, "moved")["recordings"][0]["rmse_m"].as_f64().unwrap() > 0.05);
    place.run(&[&moved[..], &["--relative-to-rest", "--overwrite"]].concat()).succeeded();
    assert!(metrics(&place, "moved")["recordings"][0]["rmse_m"].as_f64().unwrap() < 1e-6);
}

#[test]
fn a_target_within_reach_is_written_and_another_is_not() {
    let place = Workplace::new();
    let with = |named: &str, out: &str, figures: &str| {
        place.run(&["target", named, "--out", out, "--scene", "scene.toml", "--figures", figures])
    };
    let outcome = with("circle:10", "small.csv", "small").succeeded();
    assert!(outcome.stderr.contains("points within 0.1 mm"), "{}", outcome.stderr);
    let found = metrics(&place, "small");
    assert_eq!(found["reach"]["out_of_reach"], 0);
    assert!(
        found["reach"]["goals"].as_u64().unwrap() > 30
            && found["reach"]["tension_max_n"].as_f64() > Some(0.1)
    );
    let written = Recording::read(place.path().join("small.csv")).unwrap();
    assert!(written.meta().extra["target.name"] == "circle:10" && !written.meta().scene_hash.is_empty());

    // A light pull on each tendon bends the robot some of the way.
    let text = String::from_utf8(place.read("scene.toml")).unwrap();
    place.write("scene.toml", text.replace("tension_max_n = 200.0", "tension_max_n = 5.0"));
    let outcome = with("diamond:30", "out/large.csv", "large");
    let error = outcome.error(2);
    for part in ["target diamond:30", "points out of reach", "large/target.svg"] {
        assert!(error.contains(part), "{part} in {error}");
    }
    assert!(!place.path().join("out").exists());
    assert!(metrics(&place, "large")["reach"]["out_of_reach"].as_u64().unwrap() > 0);
    let svg = String::from_utf8(place.read("large/target.svg")).unwrap();
    assert!(svg.contains("out of reach") && svg.contains("path to it"));
}

#[test]
fn friction_leaves_a_target_within_reach_and_one_beyond_is_known_by_few_goals() {
    let place = Workplace::new();
    let with = |named: &str, figures: &str| {
        let out = format!("{figures}.csv");
        place.run(&["target", named, "--out", &out, "--scene", "scene-friction.toml", "--figures", figures])
    };
    with("circle:20", "near").succeeded();
    // No part of it is nearer to the clamp than the body is long: three points of it are checked.
    with("circle:200", "far").error(2);
    let [near, far] = ["near", "far"].map(|folder| metrics(&place, folder)["reach"].clone());
    assert_eq!(near["out_of_reach"], 0);
    assert!(far["goals"] == 3 && far["out_of_reach"] == 3, "{far}");
    assert!(far["largest_distance_m"].as_f64() > Some(0.02), "{far}");
}

#[test]
fn what_cannot_be_measured_is_refused() {
    let place = Workplace::new();
    place.write("short.csv", "time_s,tip_x_mm,tip_y_mm\n0,0,0\n1,1,0\n2,1,1\n");
    place.write("blind.csv", "time_s,stroke_1_mm\n0,0\n1,1\n");
    place.write("line.csv", "x_mm,y_mm\n0,0\n1,0\n");
    let before = names_in(place.path());
    for (arguments, parts) in [
        (&["evaluate", "--target", "circle:40", "short.csv", "--out", "out"][..], ["short.csv", "--whole"]),
        (&["evaluate", "--target", "circle:40", "blind.csv", "--out", "out"], ["blind.csv", "tip_x_m"]),
        (&["evaluate", "--target", "oval:40", "short.csv"], ["target", "circle:SIZE"]),
        (&["evaluate", "--target", "short.csv", "short.csv"], ["short.csv", "target.laps_s"]),
        (&["target", "line.csv", "--out", "out/a.csv"], ["line.csv", "at least three"]),
        (&["target", "circle:40", "--out", "out/a.txt"], ["--out", ".parquet or .csv"]),
        (&["target", "circle:-4", "--out", "out/a.csv"], ["size_mm", "a number from"]),
        (
            &["target", "circle:4", "--out", "out/a.csv", "--scene", "scene.toml", "--tolerance-mm", "0"],
            ["--tolerance-mm", "at least 1e-9 mm"],
        ),
    ] {
        let outcome = place.run(arguments);
        for part in parts {
            assert!(outcome.error(2).contains(part), "{part} in {}", outcome.stderr);
        }
        assert_eq!(names_in(place.path()), before);
    }
}
