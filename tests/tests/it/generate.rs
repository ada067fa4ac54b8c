//! Data of a twin, and a twin that is adapted.

use hysteron_base::{Recording, json};
use hysteron_tests::Workplace;

/// Three short trajectories, one fixed and two drawn.
const PLAN: &str = r#"
format = "hysteron-plan"
version = 1
name = "short"
seed = 5
rate_hz = 100
tendon_angles_deg = [0, 90, 180, 270]
release = 1.0
rest_before_s = 0.1
rest_after_s = 0.1
stroke_max_mm = 6
stroke_rate_max_mm_s = 20

[[trajectory]]
name = "line"
role = "training"
family = "sinusoid"
amplitude_mm = 3
frequency_hz = 0.5
orientation_deg = 0
attack_s = 1
sustain_s = 1
decay_s = 1

[[draw]]
name = "wide"
role = "training"
family = "circle"
count = 2
amplitude_mm = [2, 5]
period_s = [4, 5]
attack_s = 1
sustain_s = 1
decay_s = 1
"#;

#[test]
fn parts_made_on_several_machines_are_the_whole() {
    let place = Workplace::new();
    place.write("short.toml", PLAN);
    let generate = ["generate", "scene.toml", "--plan", "short.toml", "--out", "data"];
    place.run(&generate).succeeded();
    let names = ["line", "wide-1", "wide-2"].map(|name| format!("{name}.parquet"));
    let whole = names.each_ref().map(|name| place.read(&format!("data/{name}")));
    let again = place.run(&generate).succeeded();
    assert!(again.stderr.contains("0 samples to do; 3 are there already"), "{}", again.stderr);
    // What was made with another mesh is made again.
    let mesh = place.read("tpu80.msh");
    place.write("tpu80.msh", [&mesh[..], b"\n"].concat());
    let again = place.run(&generate).succeeded();
    assert!(again.stderr.contains("; 0 are there already"), "{}", again.stderr);
    let changed = place.read("data/line.parquet");
    assert_ne!(changed, whole[0]);
    place.write("tpu80.msh", mesh);
    place.run(&generate).succeeded();
    assert_eq!(place.read("data/line.parquet"), whole[0]);

    // The same command elsewhere, in two parts: the same bytes.
    let other = Workplace::new();
    other.write("short.toml", PLAN);
    for (shard, n) in [("1/2", 2), ("2/2", 3)] {
        other.run(&[&generate[..], &["--shard", shard]].concat()).succeeded();
        let there = names.iter().filter(|name| other.path().join("data").join(name).exists()).count();
        assert_eq!(there, n, "{shard}");
    }
    assert_eq!(names.each_ref().map(|name| other.read(&format!("data/{name}"))), whole);

    let found = Recording::read(place.path().join("data/wide-1.parquet")).unwrap();
    for stem in ["tip_x_per_stroke", "tip_y_per_stroke"] {
        assert_eq!(found.numbered(stem, "ratio").len(), 4, "{stem}");
    }
    let card: serde_json::Value = json::from_text(place.read("data/metrics.json")).unwrap();
    assert_eq!((card["made"].as_u64(), card["dropped"].as_u64()), (Some(3), Some(0)));
    let train = ["train", "data", "--out", "inverse.safetensors", "--epochs", "1", "--hidden", "8"];
    let trained = place.run(&train).succeeded();
    assert!(trained.stdout.contains("0 real and 3 synthetic"), "{}", trained.stdout);
}

#[test]
fn a_plan_of_the_tip_leads_the_tip() {
    let place = Workplace::new();
    let circles = PLAN.find("[[draw]]").unwrap();
    place.write("tip.toml", PLAN[..circles].replace("seed = 5", "seed = 5\nspace = \"tip\""));
    place.run(&["generate", "scene.toml", "--plan", "tip.toml", "--out", "data"]).succeeded();
    let found = Recording::read(place.path().join("data/line.parquet")).unwrap();
    let (x, y) = (found.require("tip_x_m").unwrap(), found.require("tip_y_m").unwrap());
    // The plan's own line: 3 mm · sin(2π 0.5 Hz t) at full size, from t = 1 s of the motion on.
    let at = |t: f64| 3e-3 * (std::f64::consts::PI * t).sin();
    let off = |i: usize| (x[i] - at(found.time()[i] - 0.1)).hypot(y[i]);
    let worst = (115..205).map(off).fold(0.0, f64::max);
    // What steering leaves over: a few samples' way, at 10 mm/s and 100 Hz.
    assert!(worst < 0.3e-3, "{worst} m");
    let strokes = found.strokes();
    assert!(strokes.iter().all(|stroke| stroke.last() == Some(&0.0)), "the way home is part of it");
    // A rig has no twin to find strokes with.
    let record = ["record", "--rig", "virtual:typical", "--plan", "tip.toml", "--out", "recorded"];
    let outcome = place.run(&record);
    assert!(outcome.error(2).contains("expected tendons, got tip"), "{}", outcome.stderr);
}

/// The scene with another line for every tendon.
fn with_tendons(place: &Workplace, line: &str) -> String {
    let text = String::from_utf8(place.read("scene.toml")).unwrap();
    text.replace("ring_mm = 0.85", &format!("ring_mm = 0.85\n{line}"))
}

#[test]
fn a_robot_that_rests_aside_has_synthetic_data_too() {
    let place = Workplace::new();
    place.write("short.toml", PLAN);
    place.write("tip.toml", PLAN.replace("seed = 5", "seed = 5\nspace = \"tip\""));
    let scene = with_tendons(&place, "zero_mm = 0.3");
    // The first tendon is pulled by a millimetre more, and it hangs sideways: the tip rests some millimetres aside.
    let scene = scene.replacen("zero_mm = 0.3", "zero_mm = 1.3", 1);
    place.write("aside.toml", scene.replace("_m_s2 = [0.0, 0.0, 0.0]", "_m_s2 = [0.0, -9.81, 0.0]"));
    for plan in ["short.toml", "tip.toml"] {
        place.run(&["generate", "aside.toml", "--plan", plan, "--out", "data"]).succeeded();
        let card: serde_json::Value = json::from_text(place.read("data/metrics.json")).unwrap();
        assert_eq!((card["made"].as_u64(), card["dropped"].as_u64()), (Some(3), Some(0)), "{plan}");
        if plan == "short.toml" {
            let found = Recording::read(place.path().join("data/line.parquet")).unwrap();
            let x = found.require("tip_x_m").unwrap();
            assert!(x[0].abs() > 0.8e-3, "a rest that tests nothing: {} m", x[0]);
            // 0.1 s of rest at its beginning.
            assert!((x[5] - x[0]).abs() < 1e-6, "{} m", x[5] - x[0]);
        }
        std::fs::remove_dir_all(place.path().join("data")).unwrap();
    }
}

#[test]
fn an_empty_set_is_reported_and_not_drawn() {
    let place = Workplace::new();
    place.write("short.toml", PLAN);
    let scene = String::from_utf8(place.read("scene.toml")).unwrap();
    place.write("weak.toml", scene.replace("tension_max_n = 200.0", "tension_max_n = 0.5"));
    let outcome = place.run(&["generate", "weak.toml", "--plan", "short.toml", "--out", "data", "--png"]);
    let error = outcome.error(1);
    assert!(error.contains("none of the 3 trajectories") && error.contains("largest tension"), "{error}");
    let card: serde_json::Value = json::from_text(place.read("data/metrics.json")).unwrap();
    assert_eq!((card["made"].as_u64(), card["dropped"].as_u64()), (Some(0), Some(3)));
    let report = String::from_utf8(place.read("data/report.html")).unwrap();
    assert!(report.contains("No figure") && !report.contains("NaN") && !report.contains("<svg"), "{report}");
    for name in ["coverage.svg", "coverage.png"] {
        assert!(!place.path().join("data").join(name).exists(), "{name}");
    }
}

#[test]
fn what_cannot_be_generated_is_refused() {
    let place = Workplace::new();
    place.write("short.toml", PLAN);
    place.write("three.toml", PLAN.replace("[0, 90, 180, 270]", "[0, 120, 240]"));
    place.write("turned.toml", PLAN.replace("[0, 90, 180, 270]", "[0, 90, 180, 280]"));
    for (plan, words) in [
        ("three.toml", ["tendon_angles_deg", "4 tendons, as scene tpu80"]),
        ("turned.toml", ["tendon_angles_deg[3]", "270.0"]),
        ("nowhere", ["synthetic", "nowhere"]),
    ] {
        let outcome = place.run(&["generate", "scene.toml", "--plan", plan, "--out", "data"]);
        let error = outcome.error(2);
        assert!(words.iter().all(|word| error.contains(word)), "{words:?} in {error}");
        assert!(!place.path().join("data").exists());
    }
    for (shard, words) in [("3/2", "1 <= I <= N"), ("4/4", "at most 3 parts")] {
        let shard = ["generate", "scene.toml", "--plan", "short.toml", "--out", "data", "--shard", shard];
        let outcome = place.run(&shard);
        assert!(outcome.error(2).contains(words), "{}", outcome.stderr);
    }
}

#[test]
fn a_twin_learns_what_its_network_does_not_know() {
    let place = Workplace::new();
    place.write("short.toml", PLAN);
    place.run(&["record", "--rig", "virtual:typical", "--plan", "short.toml", "--out", "data"]).succeeded();
    place
        .run(&["identify", "scene-coreact.toml", "data", "--rounds", "1", "--out", "identified"])
        .succeeded();
    // The robot of the network's training, with its first tendon released by 0.8 mm: it does with a stroke
    // what it did with less.
    std::fs::create_dir(place.path().join("changed")).unwrap();
    for name in ["line", "wide-1", "wide-2"] {
        let recorded = Recording::read(place.path().join(format!("data/{name}.parquet"))).unwrap();
        let mut channels = recorded.channels().to_vec();
        let first = channels.iter_mut().find(|channel| channel.name == "stroke_1_m").unwrap();
        first.values.iter_mut().for_each(|stroke| *stroke += 0.8e-3);
        let changed = Recording::new(
            recorded.time().to_vec(),
            channels,
            recorded.gap().to_vec(),
            recorded.meta().clone(),
        );
        changed.unwrap().write(place.path().join(format!("changed/{name}.parquet"))).unwrap();
    }
    let fit =
        ["fit-residual", "identified", "--out", "residual.safetensors", "--epochs", "2", "--members", "1"];
    place.run(&fit).succeeded();
    let adapt = [
        "adapt",
        "residual.safetensors",
        "changed",
        "--scene",
        "scene-coreact.toml",
        // After two epochs the error in validation is as large as that of the change.
        "--reference",
        "data",
        "--out",
        "new.safetensors",
    ];
    let adapted = place.run(&adapt).succeeded();
    let lines: Vec<&str> = adapted.stdout.lines().filter(|line| line.contains("tip off by")).collect();
    assert_eq!(lines.len(), 3, "{}", adapted.stdout);
    // What it learns is a least-squares fit of all recordings together.
    let mut squares = [0.0; 2];
    for line in &lines {
        let numbers: Vec<f64> =
            line.split_whitespace().filter_map(|word| word.parse().ok()).take(2).collect();
        assert_eq!(numbers.len(), 2, "{line}");
        squares.iter_mut().zip(&numbers).for_each(|(sum, rms)| *sum += rms * rms);
    }
    assert!(squares[1] < squares[0], "{lines:?}");
    // It is kept because test motion confirms it.
    let metrics: serde_json::Value = json::from_text(place.read("new/metrics.json")).unwrap();
    let held_out = |kept: &serde_json::Value| {
        let all = metrics["held_out"].as_array().unwrap();
        all.iter().find(|one| one["kept"] == *kept).unwrap()["rms_m"].as_f64().unwrap()
    };
    let [nothing, kept] = [&hysteron_base::json!("nothing"), &metrics["kept"]].map(held_out);
    assert!(kept < 0.9 * nothing, "{kept} {nothing}");
    assert!(adapted.stdout.contains("kept: "), "{}", adapted.stdout);
    // The adapted parts are in the checkpoint.
    let simulate = |checkpoint: &str, out: &str| {
        let arguments = ["simulate", "scene-coreact.toml", "--strokes", "data/line.parquet"];
        place.run(&[&arguments[..], &["--residual", checkpoint, "--out", out]].concat()).succeeded();
        Recording::read(place.path().join(out)).unwrap()
    };
    let [before, after] = [("residual.safetensors", "old.parquet"), ("new.safetensors", "new.parquet")]
        .map(|(checkpoint, out)| simulate(checkpoint, out));
    assert_ne!(before.tip().unwrap()[0], after.tip().unwrap()[0]);
    // What was left out in learning says how far the tip may be off, until the robot is another.
    assert!(before.require("tip_band_m").unwrap().iter().all(|radius| *radius > 0.0 && *radius < 0.1));
    assert!(after.channel("tip_band_m").is_none());
    let refused = place.run(&[
        "adapt",
        "residual.safetensors",
        "data",
        "--scene",
        "scene.toml",
        "--out",
        "x.safetensors",
    ]);
    assert!(refused.error(2).contains("auxiliary tendons"), "{}", refused.stderr);

    // The network belongs to the mesh, too.
    let mesh = place.read("tpu80.msh");
    place.write("tpu80.msh", [&mesh[..], b"\n"].concat());
    let scene = ["scene-coreact.toml", "--residual", "residual.safetensors"];
    for arguments in [
        [&["simulate", "--strokes", "data/line.parquet", "--out", "x.parquet"][..], &scene].concat(),
        [&["identify"][..], &scene, &["data", "--out", "x"]].concat(),
        [&["generate", "--plan", "short.toml", "--out", "x"][..], &scene].concat(),
        [
            &["command", "--target", "circle:10", "--out", "x.csv", "residual.safetensors", "--scene"][..],
            &scene[..1],
        ]
        .concat(),
        [&adapt[..5], &["--out", "x.safetensors"]].concat(),
    ] {
        let outcome = place.run(&arguments);
        assert!(outcome.error(2).contains("residual.safetensors: scene_sha256"), "{}", outcome.stderr);
    }
    let again =
        place.run(&["identify", "scene-coreact.toml", "data", "--rounds", "1", "--out", "identified"]);
    assert!(again.succeeded().stderr.contains("; 0 recordings are there already"));
}
