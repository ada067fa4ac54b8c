//! A set of data made by several workers, in any order, killed and resumed: the same set.

use std::collections::BTreeMap;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::Barrier;
use std::time::Duration;

use hysteron_base::{Recording, TrajectoryShard, json};
use hysteron_tests::{Workplace, measured, program};
use hysteron_workflow::Context;
use hysteron_workflow::tendon::shards::work;
use rand::RngExt;

/// Two short trajectories of its own, and `count` drawn ones.
fn plan(count: usize) -> String {
    format!(
        r#"
format = "hysteron-plan"
version = 1
name = "short"
seed = 5
rate_hz = 100
tendon_angles_deg = [0, 90, 180, 270]
release = 1.0
rest_before_s = 0.05
rest_after_s = 0.05
stroke_max_mm = 9
stroke_rate_max_mm_s = 40

[[trajectory]]
name = "line"
role = "training"
family = "sinusoid"
amplitude_mm = 3
frequency_hz = 0.5
orientation_deg = 0
attack_s = 0.4
sustain_s = 0.2
decay_s = 0.4

[[draw]]
name = "wide"
role = "training"
family = "circle"
count = {count}
amplitude_mm = [2, 5]
period_s = [4, 5]
attack_s = 0.4
sustain_s = 0.2
decay_s = 0.4
"#
    )
}

/// A place with a set of this many drawn trajectories, planned in `set`.
fn planned(count: usize, shards: &str) -> Workplace {
    let place = Workplace::new();
    place.write("short.toml", plan(count));
    let arguments = ["shards", "plan", "scene.toml", "--plan", "short.toml", "--to", "set", "--measure", "0"];
    place.run(&[&arguments[..], &["--shards", shards]].concat()).succeeded();
    place
}

/// All objects of the set by their names; those that are still being written are not among them.
fn objects(place: &Workplace) -> BTreeMap<String, Vec<u8>> {
    fn add(root: &Path, folder: &Path, found: &mut BTreeMap<String, Vec<u8>>) {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            let name = path.strip_prefix(root).unwrap().display().to_string();
            if path.is_dir() {
                add(root, &path, found);
            } else if !name.contains('#') {
                found.insert(name, std::fs::read(&path).unwrap());
            }
        }
    }
    let (mut found, root) = (BTreeMap::new(), place.path().join("set"));
    add(&root, &root, &mut found);
    found
}

/// The recordings of all shards, by the number of their trajectory.
fn rows(place: &Workplace) -> Vec<(u64, Recording)> {
    let shards = objects(place).into_keys().filter(|name| name.ends_with(".parquet"));
    let read = |name: String| TrajectoryShard::read(place.path().join("set").join(name)).unwrap();
    shards.map(read).flat_map(|shard| shard.parts().to_vec()).collect()
}

fn working(place: &Workplace) -> Child {
    let mut command = Command::new(program());
    command.args(["shards", "work", "set"]).current_dir(place.path()).env_remove("RUST_LOG");
    command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap()
}

#[test]
fn workers_in_any_order_make_the_set_of_one() {
    let one = planned(6, "4");
    one.run(&["shards", "work", "set"]).succeeded();
    let whole = objects(&one);
    assert_eq!(whole.len(), 1 + 3 + 4 + 4);

    let three = planned(6, "4");
    for part in ["3/3", "1/3"] {
        three.run(&["shards", "work", "set", "--worker", part]).succeeded();
    }
    let status = three.run(&["shards", "status", "set"]).succeeded();
    assert!(status.stdout.contains("3 of 4 shards are done"), "{}", status.stdout);
    assert!(status.stdout.contains("1 are missing: 1\n"), "{}", status.stdout);
    let merge = ["shards", "merge", "set", "--out", "card"];
    let error = three.run(&merge);
    assert!(error.error(2).contains("expected all 4 shards, got 3 of them; 1 missing: 1 (hint"), "{error:?}");
    assert!(!three.path().join("card").exists());
    let partial = three.run(&[&merge[..], &["--partial"]].concat()).succeeded();
    assert!(partial.stdout.contains("Incomplete: 1 of 4 shards are missing (1)"), "{}", partial.stdout);
    let last = three.run(&["shards", "work", "set", "--threads", "1"]).succeeded();
    assert!(last.stdout.contains("1 shards made, 3 already there"), "{}", last.stdout);
    assert!(objects(&three) == whole);
    // What is there is made again by nobody; what is lost is made again as it was.
    let shard = three.path().join("set/shards/000000/000000002.parquet");
    std::fs::remove_file(shard).unwrap();
    let again = three.run(&["shards", "work", "set"]).succeeded();
    assert!(again.stdout.contains("1 shards made, 3 already there"), "{}", again.stdout);
    assert!(objects(&three) == whole);

    // The rows are those of `generate`, which makes a file of each trajectory.
    one.run(&["generate", "scene.toml", "--plan", "short.toml", "--out", "data"]).succeeded();
    let rows = rows(&one);
    assert!(rows.iter().map(|(number, _)| *number).eq(0..7));
    for (_, found) in rows {
        let name = &found.meta().extra["plan.trajectory"];
        let expected = Recording::read(one.path().join(format!("data/{name}.parquet"))).unwrap();
        assert_eq!(found.time(), expected.time());
        assert_eq!(found.channels(), expected.channels());
        assert_eq!(found.gap(), expected.gap());
        let mut meta = found.meta().clone();
        meta.command.clone_from(&expected.meta().command);
        assert_eq!(&meta, expected.meta());
    }
}

#[test]
fn the_card_has_the_numbers_of_all_rows() {
    let place = planned(6, "3");
    place.run(&["shards", "work", "set"]).succeeded();
    place.run(&["shards", "merge", "set", "--out", "card"]).succeeded();
    let card: serde_json::Value = json::from_text(place.read("card/metrics.json")).unwrap();
    let rows = rows(&place);
    let samples: usize = rows.iter().map(|(_, one)| one.n_samples()).sum();
    assert_eq!((card["made"].as_u64(), card["complete"].as_bool()), (Some(7), Some(true)));
    assert_eq!(card["samples"].as_u64(), Some(samples as u64));
    assert_eq!(card["families"]["circle"]["samples"].as_u64(), Some((samples / 7 * 6) as u64));
    let channels = card["channels"].as_object().unwrap();
    assert_eq!(channels.len(), rows[0].1.channels().len());
    for (name, found) in channels {
        let mut values: Vec<f64> =
            rows.iter().flat_map(|(_, one)| one.channel(name).unwrap().iter().copied()).collect();
        values.sort_by(f64::total_cmp);
        let n = values.len() as f64;
        let mean = values.iter().sum::<f64>() / n;
        let deviation = (values.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / n).sqrt();
        let largest = values[0].abs().max(values[values.len() - 1].abs());
        // Rounding of sums of some thousand numbers.
        let is_near = |key: &str, exact: f64| (found[key].as_f64().unwrap() - exact).abs() <= 1e-12 * largest;
        assert!(is_near("smallest", values[0]) && is_near("largest", values[values.len() - 1]), "{name}");
        assert!(is_near("mean", mean) && is_near("deviation", deviation), "{name}");
        for (k, part) in [0.01, 0.5, 0.99].into_iter().enumerate() {
            let exact = values[(part * (n - 1.0)).round() as usize];
            let found = found["quantiles"][k].as_f64().unwrap();
            assert!((found - exact).abs() <= exact.abs() / 16.0 + 1e-12, "{name}: {found} {exact}");
        }
    }
    let report = String::from_utf8(place.read("card/report.html")).unwrap();
    assert!(report.contains("Complete: 7 trajectories") && report.contains("<svg"));
    // A lost file is noticed, and nothing of another's is written over.
    place.write("card/report.html", "mine");
    let error = place.run(&["shards", "merge", "set", "--out", "card"]);
    assert!(error.error(2).contains("which hysteron has not made"), "{error:?}");
}

#[test]
fn of_sixteen_workers_of_one_shard_one_wins() {
    let place = planned(1, "1");
    let url = place.path().join("set").display().to_string();
    let barrier = Barrier::new(16);
    let work = || {
        barrier.wait();
        let options = work::Options { url: url.clone(), worker: None };
        work::run(&options, &Context::silent("a test")).unwrap()
    };
    let outcomes: Vec<work::Outcome> = std::thread::scope(|scope| {
        let workers: Vec<_> = (0..16).map(|_| scope.spawn(work)).collect();
        workers.into_iter().map(|worker| worker.join().unwrap()).collect()
    });
    assert_eq!(outcomes.iter().map(|one| one.made).sum::<usize>(), 1);
    assert!(outcomes.iter().all(|one| one.made + one.made_twice + one.already_there == 1));
    let one = planned(1, "1");
    one.run(&["shards", "work", "set"]).succeeded();
    assert!(objects(&one) == objects(&place));
}

#[test]
fn killed_workers_leave_a_set_that_others_complete() {
    let kills = std::env::var("HYSTERON_KILLS").map_or(10, |text| text.parse().unwrap());
    let one = planned(40, "20");
    one.run(&["shards", "work", "set"]).succeeded();
    let whole = objects(&one);
    let place = planned(40, "20");
    let (mut random, mut n_midway) = (rand::rng(), 0);
    for _ in 0..kills {
        let mut workers = [working(&place), working(&place)];
        std::thread::sleep(Duration::from_millis(random.random_range(200..800)));
        workers[0].kill().unwrap();
        workers[0].wait().unwrap();
        workers[1].kill().unwrap();
        workers[1].wait().unwrap();
        // All that is there is as one worker makes it; complete or not.
        let there = objects(&place);
        assert!(there.iter().all(|(name, bytes)| whole[name] == *bytes));
        n_midway += usize::from(there.len() > 4 && there.len() < whole.len());
        if there.len() == whole.len() {
            for folder in ["shards", "sketches"] {
                std::fs::remove_dir_all(place.path().join("set").join(folder)).unwrap();
            }
        }
    }
    place.run(&["shards", "work", "set"]).succeeded();
    assert!(objects(&place) == whole);
    assert!(n_midway > 0, "no worker was killed midway");
}

#[test]
fn a_million_shards_need_little_memory() {
    let place = Workplace::new();
    place.write("short.toml", plan(999_999));
    let plan = ["shards", "plan", "scene.toml", "--plan", "short.toml", "--to", "set", "--measure", "0"];
    for arguments in [
        &[&plan[..], &["--shards", "1000000"]].concat()[..],
        &["shards", "status", "set"],
        &["shards", "merge", "set", "--out", "card", "--partial"],
    ] {
        let (outcome, megabytes) = measured(place.path(), arguments);
        let outcome = outcome.succeeded();
        assert!(outcome.stdout.contains("000000 shards"), "{}", outcome.stdout);
        assert!(megabytes < 200, "{arguments:?}: {megabytes} MB");
    }
    assert!(place.read("set/manifest.json").len() < 2000);
}

/// The object of an input of the set.
fn input(place: &Workplace, name: &str) -> String {
    let manifest: serde_json::Value = json::from_text(place.read("set/manifest.json")).unwrap();
    format!("set/inputs/{}", manifest[name]["sha256"].as_str().unwrap())
}

#[test]
fn what_does_not_fit_is_refused_by_name() {
    let place = planned(3, "2");
    let plan = ["shards", "plan", "scene.toml", "--plan", "short.toml", "--to", "set", "--measure", "0"];
    let again = place.run(&[&plan[..], &["--shards", "2"]].concat()).succeeded();
    assert!(again.stdout.contains("in 2 shards, as before"), "{}", again.stdout);
    let refused = |arguments: &[&str], words: &str| {
        let outcome = place.run(arguments);
        let error = outcome.error(2);
        assert!(error.contains(words) && error.contains("hint: "), "{words}: {error}");
    };
    let work = ["shards", "work", "set"];
    // Another plan, another number of shards, another robot at the same place.
    refused(&[&plan[..], &["--shards", "3"]].concat(), "manifest.json: rule.shards: expected 2, as the set");
    place.write("other.toml", self::plan(3).replace("seed = 5", "seed = 6"));
    refused(&[&plan[..4], &["other.toml"], &plan[5..]].concat(), "manifest.json: plan.sha256: expected");
    // Nothing there, a part of it, or something else.
    refused(&["shards", "work", "nowhere"], "expected a folder with a set of shards, got nothing there");
    std::fs::create_dir(place.path().join("empty")).unwrap();
    refused(&["shards", "status", "empty"], "empty/manifest.json: expected the manifest");
    let manifest = String::from_utf8(place.read("set/manifest.json")).unwrap();
    let changed = |from: &str, to: &str, words: &str| {
        assert!(manifest.contains(from), "{from}");
        place.write("set/manifest.json", manifest.replacen(from, to, 1));
        refused(&work, words);
        place.write("set/manifest.json", &manifest);
    };
    changed("\"version\": 1", "\"version\": 2", "expected hysteron-shards 1, got hysteron-shards 2");
    changed("\"program\": \"", "\"program\": \"7.", "manifest.json: program: expected hysteron 7.");
    changed("\"trajectories\": 4", "\"trajectories\": 5", "rule.trajectories: expected 4, got 5");
    changed("tpu80.msh", "/tmp/tpu80.msh", "expected a path relative to the scene");
    for name in ["mesh", "plan"] {
        let object = input(&place, name);
        let bytes = place.read(&object);
        place.write(&object, [&bytes[..], b"\n"].concat());
        refused(&work, "with the SHA-256 of its name");
        std::fs::remove_file(place.path().join(&object)).unwrap();
        refused(&work, "got nothing there (hint: run the command of `hysteron shards plan` again)");
        place.write(&object, bytes);
    }
    // A manifest that was changed after shards were made.
    place.run(&["shards", "work", "set", "--worker", "1/2"]).succeeded();
    changed("\"shards\": 2", "\"shards\": 4", "the manifest was changed after shards were made");
    place.write("set/manifest.json", manifest.replacen("\"shards\": 2", "\"shards\": 1", 1));
    refused(&["shards", "merge", "set", "--out", "card"], "the manifest was changed after shards were made");
    place.write("set/manifest.json", &manifest);
    place.run(&work).succeeded();
}
