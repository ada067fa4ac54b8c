//! `hysteron train`: splits, reports, and what an interruption leaves.

use std::path::Path;

use hysteron_base::{Metadata, Recording, json};
use hysteron_tests::run;

const RECORD: [&str; 7] = ["record", "--rig", "virtual:typical", "--plan", "quick", "--out", "data"];
const TRAIN: [&str; 10] = [
    "train",
    "data",
    "--out",
    "inverse.safetensors",
    "--candidates",
    "network",
    "--epochs",
    "12",
    "--hidden",
    "64",
];

#[test]
fn an_interrupted_training_fails_keeps_its_best_weights_and_resumes() {
    let place = tempfile::tempdir().unwrap();
    run(place.path(), &RECORD).succeeded();
    let checkpoint = place.path().join("inverse.safetensors");
    // Of one split; in the first fold; of all data, after the folds.
    let cases = [
        (["--held-out", "circle"], "inverse.training"),
        (["--folds", "2"], "inverse.fold-1.training"),
        (["--folds", "2"], "inverse.training"),
    ];
    for (split, name) in cases {
        let (train, session) = ([&TRAIN[..], &split].concat(), place.path().join(name));
        run(place.path(), &train).succeeded();
        let whole = std::fs::read(&checkpoint).unwrap();
        std::fs::remove_file(&checkpoint).unwrap();

        // The file is there once the first epoch is done.
        let stopped = hysteron_tests::interrupt(place.path(), &train, name);
        let error = stopped.error(1);
        assert!(error.starts_with("error: interrupted") && error.contains(name), "{error}");
        assert!(session.exists() && std::fs::read(&checkpoint).unwrap() != whole);
        run(place.path(), &train).succeeded();
        assert!(!session.exists() && std::fs::read(&checkpoint).unwrap() == whole, "{split:?}");
        std::fs::remove_file(&checkpoint).unwrap();
        std::fs::remove_dir_all(place.path().join("inverse")).unwrap();
    }
}

const PLAN: &str = r#"format = "hysteron-plan"
version = 1
name = "pairs"
seed = 1
rate_hz = 100
tendon_angles_deg = [0, 90, 180, 270]
release = 1.0
rest_before_s = 0.5
rest_after_s = 0.5
stroke_max_mm = 8
stroke_rate_max_mm_s = 8
"#;

/// Two motions of each of three kinds, recorded, and written as plain tables without a plan.
fn plain_tables(place: &Path) {
    let family = |k: usize, family: &str, own: &str| {
        format!(
            "\n[[trajectory]]\nname = \"t{k}\"\nrole = \"training\"\nfamily = \"{family}\"\namplitude_mm = {}\n\
             frequency_hz = 0.2\n{own}attack_s = 1\nsustain_s = 5\ndecay_s = 1\n",
            3.0 + 0.3 * k as f64
        )
    };
    let circle = "phase_deg = 0\ndirection = \"clockwise\"\n";
    let square = "orientation_deg = 45\ndirection = \"clockwise\"\n";
    let trajectories: Vec<String> =
        [("sinusoid", "orientation_deg = 20\n"), ("circle", circle), ("square", square)]
            .iter()
            .enumerate()
            .flat_map(|(k, (name, own))| [family(2 * k, name, own), family(2 * k + 1, name, own)])
            .collect();
    std::fs::write(place.join("pairs.toml"), PLAN.to_owned() + &trajectories.concat()).unwrap();
    run(place, &["record", "--rig", "virtual:typical", "--plan", "pairs.toml", "--out", "recorded"])
        .succeeded();
    std::fs::create_dir(place.join("tables")).unwrap();
    for k in 0..6 {
        let read = Recording::read(place.join(format!("recorded/t{k}.parquet"))).unwrap();
        let is_table_column =
            |name: &str| name.starts_with("stroke_") || name.starts_with("tip_") && name.ends_with("_m");
        let columns =
            read.channels().iter().filter(|channel| is_table_column(&channel.name)).cloned().collect();
        let table =
            Recording::new(read.time().to_vec(), columns, read.gap().to_vec(), Metadata::default()).unwrap();
        table.write(place.join(format!("tables/t{k}.csv"))).unwrap();
    }
}

#[test]
fn tables_without_a_plan_are_validated_on_every_kind_of_motion_as_reported() {
    let place = tempfile::tempdir().unwrap();
    plain_tables(place.path());
    let train = ["train", "tables", "--out", "inverse.safetensors", "--epochs", "2", "--hidden", "8"];
    let alone = ["--weights", "int16", "--candidates", "network"];
    let done = run(place.path(), &[&train[..], &alone].concat()).succeeded();
    let validated = done.stdout.lines().find(|line| line.starts_with("validated on:")).unwrap();
    assert!(["(line)", "(loop)", "(polygon)"].iter().all(|kind| validated.contains(kind)), "{validated}");
    let read = |name: &str| std::fs::read_to_string(place.path().join("inverse").join(name)).unwrap();
    let metrics: serde_json::Value = json::from_text(read("metrics.json")).unwrap();
    let network = &metrics["networks"][0];
    let n = |key: &str| network[key].as_array().unwrap().len();
    assert_eq!([n("validation"), n("training"), n("curve"), n("channels")], [3, 3, 2, 4]);
    // After two epochs a network of eight units does not beat the regression everywhere, and the report names
    // where.
    let methods = network["methods"].as_array().unwrap();
    let loses = |channel: &serde_json::Value| {
        let errors: Vec<f64> =
            channel["errors"].as_array().unwrap().iter().map(|e| e.as_f64().unwrap()).collect();
        let (network, baselines) = errors.split_last().unwrap();
        baselines.iter().filter(|baseline| *baseline <= network).count()
    };
    assert!(methods.len() >= 2 && methods[methods.len() - 1] == "network");
    let n_lost: usize = network["channels"].as_array().unwrap().iter().map(loses).sum();
    assert_eq!(metrics["warnings"].as_array().unwrap().len(), n_lost);
    assert_eq!(done.stderr.matches("no better than").count(), n_lost, "{}", done.stderr);
    // What whole numbers for weights change was measured with these weights.
    let weights = &metrics["training"]["weights"];
    let changed = weights["stroke_largest_mm"].as_f64().unwrap();
    assert!(weights["format"] == "int16" && 0.0 < changed && changed < 1e-3, "{weights}");
    assert!(read("report.html").contains("Learning curve"));
}

fn chosen_of(candidates: &[serde_json::Value]) -> usize {
    candidates.iter().position(|one| one["is_chosen"] == true).unwrap()
}

#[test]
fn without_a_twin_controllers_are_compared_by_strokes_in_folds_and_the_best_learns_from_all() {
    let place = tempfile::tempdir().unwrap();
    plain_tables(place.path());
    let train = ["train", "tables", "--out", "h.safetensors", "--epochs", "3", "--hidden", "8"];
    let done = run(place.path(), &train).succeeded();
    let metrics = std::fs::read_to_string(place.path().join("h/metrics.json")).unwrap();
    let metrics: serde_json::Value = json::from_text(metrics).unwrap();
    let candidates = metrics["candidates"].as_array().unwrap();
    let names: Vec<&str> = candidates.iter().filter_map(|one| one["candidate"].as_str()).collect();
    assert_eq!(names, ["static_regression", "kernel_regression", "network"]);
    // A network of three epochs is no match for regressions.
    let chosen = &candidates[chosen_of(candidates)];
    assert!(chosen["candidate"] != "network", "{}", done.stdout);
    let training = &metrics["training"];
    let n = |key: &str| training[key].as_array().map_or(0, Vec::len);
    assert_eq!((n("trained_on"), n("held_out"), &training["folds"]), (6, 0, &3.into()));
    let strokes = training["held_out_stroke_rmse_mm"].as_array().unwrap();
    let square = strokes.iter().map(|mm| mm.as_f64().unwrap().powi(2)).sum::<f64>() / strokes.len() as f64;
    let stated = chosen["stroke_rmse_mm"].as_f64().unwrap();
    assert!((square.sqrt() - stated).abs() < 1e-9 * stated, "{stated}");
    let page = std::fs::read_to_string(place.path().join("h/report.html")).unwrap();
    assert!(page.contains("each left out of one of 3 fits") && !page.contains("Tip of the twin"));

    // One controller alone is one that streams, and a name that there is not is told with those that there are.
    let only = ["train", "tables", "--out", "k.safetensors", "--baseline", "kernel-regression"];
    run(place.path(), &only).succeeded();
    let command = ["command", "k.safetensors", "--target", "circle:10", "--out", "strokes.csv"];
    run(place.path(), &command).succeeded();
    let wrong = ["train", "tables", "--out", "w.safetensors", "--candidates", "spline"];
    let refused = run(place.path(), &wrong);
    assert!(refused.error(2).contains("kernel-regression"), "{}", refused.stderr);
}

#[test]
fn a_twin_compares_what_the_strokes_of_every_controller_do_to_its_tip() {
    let place = tempfile::tempdir().unwrap();
    run(place.path(), &RECORD).succeeded();
    let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/../meshes/tpu80/scene-typical.toml");
    let plan = PLAN.replace("pairs", "synthetic")
        + "\n[[draw]]\nname = \"rose\"\nrole = \"training\"\nfamily = \"rose\"\ncount = 2\nswings = [0.4, 2.4]\n\
           amplitude_mm = [3, 4]\nperiod_s = [6, 7]\nattack_s = 1\nsustain_s = 3\ndecay_s = 1\n";
    std::fs::write(place.path().join("roses.toml"), plan).unwrap();
    run(place.path(), &["generate", scene, "--plan", "roses.toml", "--out", "made"]).succeeded();
    let train = ["train", "data", "made", "--out", "h.safetensors", "--epochs", "2", "--hidden", "8"];
    let done = run(place.path(), &[&train[..], &["--scene", scene]].concat()).succeeded();

    let metrics = std::fs::read_to_string(place.path().join("h/metrics.json")).unwrap();
    let metrics: serde_json::Value = json::from_text(metrics).unwrap();
    let candidates = metrics["candidates"].as_array().unwrap();
    let names: Vec<&str> = candidates.iter().filter_map(|one| one["candidate"].as_str()).collect();
    assert_eq!(names, ["static_regression", "kernel_regression", "recorded_network", "network"]);
    // A network that was given up after the first fold is not in the choice.
    let tip = |one: &serde_json::Value| {
        if one["folds"] == 3 { one["tip_rmse_mm"].as_f64().unwrap() } else { f64::INFINITY }
    };
    let tips: Vec<f64> = candidates.iter().map(tip).collect();
    let least = tips.iter().copied().fold(f64::INFINITY, f64::min);
    let expected = tips.iter().position(|tip| *tip <= 1.05 * least).unwrap();
    assert!(candidates[chosen_of(candidates)]["tip_standard_error_mm"].as_f64().unwrap() > 0.0);
    let chosen = chosen_of(candidates);
    assert_eq!((chosen, &metrics["training"]["candidate"]), (expected, &candidates[chosen]["candidate"]));
    // The twin has a row of its own, and leads where its tip is closer.
    let twin = metrics["twin_tip_rmse_mm"].as_f64().unwrap();
    assert!(done.stdout.contains("the twin itself"), "{}", done.stdout);
    assert_eq!(metrics["training"]["twin"].is_null(), 1.05 * twin >= tips[chosen], "{twin} {tips:?}");
    let page = std::fs::read_to_string(place.path().join("h/report.html")).unwrap();
    assert!(page.contains("static regression") && page.contains("the twin itself"));
    let refused = run(place.path(), &[&train[..], &["--scene", scene, "--design", "paper"]].concat());
    assert!(refused.error(2).contains("--scene: expected the recurrent design"), "{}", refused.stderr);
    let refused = run(place.path(), &[&train[..], &["--residual", "r.safetensors"]].concat());
    assert!(refused.error(2).contains("--scene"), "{}", refused.stderr);
}

#[test]
fn a_twin_that_leads_the_tip_closer_than_any_controller_finds_the_strokes() {
    let place = tempfile::tempdir().unwrap();
    run(place.path(), &RECORD).succeeded();
    let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/../meshes/tpu80/scene-typical.toml");
    run(place.path(), &["identify", scene, "data", "--out", "identified"]).succeeded();
    let residual = ["fit-residual", "identified", "--out", "r.safetensors"];
    run(place.path(), &residual).succeeded();
    // After one epoch a network of eight units is far from its twin.
    let train =
        ["train", "data", "--out", "h.safetensors", "--epochs", "1", "--hidden", "8", "--held-out", "circle"];
    let done = run(place.path(), &[&train[..], &["--scene", scene, "--residual", "r.safetensors"]].concat())
        .succeeded();
    assert!(done.stdout.contains("the twin itself, leads command and track: tip"), "{}", done.stdout);
    assert!(done.stdout.contains("the twin itself leads the tip within"), "{}", done.stdout);

    let (checkpoint, target) = ("h.safetensors", "circle:10");
    let strokes = |place: &Path, checkpoint: &str, more: &[&str], out: &str| {
        let limits = ["--stroke-max-mm", "8", "--stroke-rate-max-mm-s", "12"];
        run(place, &[&["command", checkpoint, "--target", target, "--out", out], &limits[..], more].concat())
    };
    strokes(place.path(), checkpoint, &[], "best.parquet").succeeded();
    strokes(place.path(), checkpoint, &["--network"], "network.parquet").succeeded();
    strokes(place.path(), "r.safetensors", &["--scene", scene], "twin.parquet").succeeded();
    let [best, network, twin] = ["best", "network", "twin"].map(|name| {
        let read = Recording::read(place.path().join(format!("{name}.parquet"))).unwrap();
        (read.channel("twin_x_m").is_some(), read.strokes()[0].to_vec())
    });
    assert_eq!([best.0, network.0, twin.0], [true, false, true]);
    assert!(best.1 == twin.1 && best.1 != network.1);
    // A twin that is not where the checkpoint has it is named, with two ways out.
    std::fs::create_dir_all(place.path().join("a/b/c")).unwrap();
    std::fs::copy(place.path().join(checkpoint), place.path().join("a/b/c/h.safetensors")).unwrap();
    let refused = strokes(place.path(), "a/b/c/h.safetensors", &[], "no.parquet");
    assert!(refused.error(2).contains("training.twin.scene") && refused.stderr.contains("--network"));
    strokes(place.path(), "a/b/c/h.safetensors", &["--network"], "yes.parquet").succeeded();
}

#[test]
fn a_path_beyond_the_training_stands_in_the_report_of_its_tracking() {
    let place = tempfile::tempdir().unwrap();
    plain_tables(place.path());
    let train = ["train", "recorded", "--out", "inverse.safetensors", "--epochs", "1", "--hidden", "8"];
    run(place.path(), &train).succeeded();
    let track =
        ["track", "inverse.safetensors", "--rig", "virtual:typical", "--target", "circle:60", "--out", "far"];
    run(place.path(), &track).succeeded();
    let read = |name: &str| std::fs::read_to_string(place.path().join("far").join(name)).unwrap();
    let metrics: serde_json::Value = json::from_text(read("metrics.json")).unwrap();
    // Tips of 4.5 mm of stroke come some 15 mm out, the path goes 30.
    let part = metrics["commanded"]["extrapolating"].as_f64().unwrap();
    assert!(part > 0.5, "{part}");
    let shown = format!("{:.1} % of the samples", 100.0 * part);
    let html = read("report.html");
    assert!(html.contains(&shown) && html.contains("left its training range"), "{shown}");
}
