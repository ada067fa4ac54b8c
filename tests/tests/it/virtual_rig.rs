//! Data sets from the virtual rig in the program's own process.

use std::path::Path;

use hysteron_base::Recording;
use hysteron_tests::{names_in, run};

const RECORD: [&str; 6] = ["record", "--rig", "virtual:typical", "--plan", "quick", "--out"];

fn recordings(folder: &Path) -> Vec<String> {
    names_in(folder).into_iter().filter(|name| name.ends_with(".parquet")).collect()
}

#[test]
fn one_command_makes_a_data_set_with_all_its_files() {
    let place = tempfile::tempdir().unwrap();
    let outcome = run(place.path(), &[&RECORD[..], &["data", "--png"]].concat()).succeeded();
    assert!(outcome.stdout.contains("recordings: 5"), "{}", outcome.stdout);
    let folder = place.path().join("data");
    let names = names_in(&folder);
    for name in [
        "calibration.toml",
        "plan.toml",
        "rig.toml",
        "robot.toml",
        "report.html",
        "metrics.json",
        "command-tip.png",
    ] {
        assert!(names.iter().any(|found| found == name), "{name} in {names:?}");
    }
    assert!(!names.iter().any(|name| name.ends_with(".journal")), "{names:?}");
    let circle = Recording::read(folder.join("circle.parquet")).unwrap();
    let [x, y, z] = circle.tip().unwrap();
    // Upright at first, then bent all around.
    assert!(x[0].hypot(y[0]) < 2e-3 && (z[0] - 0.08).abs() < 2e-3);
    for c in [x, y] {
        assert!(
            c.iter().copied().fold(0.0, f64::max) > 0.01 && c.iter().copied().fold(0.0, f64::min) < -0.01
        );
    }
    // The same data can be made again from the files next to it.
    let again = ["record", "--rig", "virtual:data/robot.toml", "--plan", "data/plan.toml"];
    let rest = ["--calibration", "data/calibration.toml", "--only", "circle", "--out", "again.parquet"];
    run(place.path(), &[&again[..], &rest[..]].concat()).succeeded();
    let again = Recording::read(place.path().join("again.parquet")).unwrap();
    assert_eq!(again.strokes(), circle.strokes());
    // The robot has the past that calibration left it, and its servos the gains that it set.
    for (again, first) in again.channels().iter().zip(circle.channels()) {
        assert!(again == first, "{}", first.name);
    }
    assert_eq!(again.channels().len(), circle.channels().len());
}

#[test]
fn threads_change_no_byte_and_another_seed_changes_the_noise() {
    let place = tempfile::tempdir().unwrap();
    let record =
        |arguments: &[&str]| run(place.path(), &[arguments, &RECORD[..], &["data"]].concat()).succeeded();
    let bytes = || -> Vec<Vec<u8>> {
        let folder = place.path().join("data");
        let all =
            recordings(&folder).into_iter().map(|name| std::fs::read(folder.join(name)).unwrap()).collect();
        std::fs::remove_dir_all(folder).unwrap();
        all
    };
    record(&["--threads", "1"]);
    let one = bytes();
    assert_eq!(one.len(), 5);
    record(&["--threads", "2"]);
    assert!(bytes() == one);
    run(place.path(), &[&RECORD[..], &["data", "--seed", "2"]].concat()).succeeded();
    assert!(bytes().iter().zip(&one).all(|(a, b)| a != b));
}

#[test]
fn a_data_set_resumes_where_it_stopped() {
    let place = tempfile::tempdir().unwrap();
    let record = || run(place.path(), &[&RECORD[..], &["data"]].concat());
    record().succeeded();
    let lost = place.path().join("data/square.parquet");
    let bytes = std::fs::read(&lost).unwrap();
    std::fs::remove_file(&lost).unwrap();
    let outcome = record().succeeded();
    assert!(outcome.stderr.contains("4 are there already"), "{}", outcome.stderr);
    assert!(std::fs::read(&lost).unwrap() == bytes);
}

#[test]
fn a_run_that_a_limit_ends_keeps_its_rows_under_another_name() {
    let place = tempfile::tempdir().unwrap();
    run(place.path(), &[&RECORD[..], &["data"]].concat()).succeeded();
    let text = std::fs::read_to_string(place.path().join("data/robot.toml")).unwrap();
    // At 80 poses a second, some of which are late too, 24 lost ones in a row end a run: at four in five, soon.
    let lossy = text.replace("dropout_probability = 0.001", "dropout_probability = 0.8");
    assert_ne!(lossy, text);
    std::fs::write(place.path().join("lossy.toml"), lossy).unwrap();
    let record = ["record", "--rig", "virtual:lossy.toml", "--calibration", "data/calibration.toml"];
    let circle = ["--plan", "quick", "--only", "circle", "--out", "circle.parquet"];
    let stopped = run(place.path(), &[&record[..], &circle].concat());
    let error = stopped.error(1);
    assert!(error.contains("limit passed") && error.contains("circle.partial-1.parquet"), "{error}");
    assert!(!place.path().join("circle.parquet").exists());
    let kept = Recording::read(place.path().join("circle.partial-1.parquet")).unwrap();
    let log = std::fs::read_to_string(place.path().join("circle.partial-1.events.jsonl")).unwrap();
    assert!(error.contains(&format!("({} rows", kept.n_samples())) && log.contains("no pose"), "{error}");
}

#[test]
fn bad_input_moves_nothing() {
    let place = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(place.path().join(name), text).unwrap();
    write("plan.toml", "format = \"hysteron-plan\"\nversion = 1\nname = \"x\"\nsede = 1\n");
    write("other.parquet", "no parquet");
    for (arguments, parts) in [
        (
            &["--rig", "virtual:none", "--plan", "quick", "--out", "out"][..],
            &["--rig", "virtual:typical"][..],
        ),
        (&["--rig", "none.toml", "--plan", "quick", "--out", "out"], &["none.toml", "a file"]),
        (&["--rig", "virtual:typical/x", "--plan", "quick", "--out", "out"], &["--rig"]),
        (&["--rig", "virtual:typical", "--plan", "none", "--out", "out"], &["one of paper, quick"]),
        (
            &["--rig", "virtual:typical", "--plan", "plan.toml", "--out", "out"],
            &["plan.toml: line 4: sede", "seed"],
        ),
        (&["--rig", "virtual:typical", "--plan", "quick", "--out", "out.parquet"], &["a folder, for 5"]),
        (
            &["--rig", "virtual:typical", "--plan", "quick", "--only", "oval", "--out", "out"],
            &["--only", "\"oval\""],
        ),
        (
            &["--rig", "virtual:typical", "--plan", "quick", "--only", "circle", "--out", "other.parquet"],
            &["other.parquet", "a whole parquet file"],
        ),
    ] {
        let outcome = run(place.path(), &[&["record"], arguments].concat());
        let error = outcome.error(2);
        assert!(parts.iter().all(|part| error.contains(part)), "{error}");
        assert!(!place.path().join("out").exists());
    }
}

#[test]
fn a_recording_of_another_plan_is_not_overwritten() {
    let place = tempfile::tempdir().unwrap();
    let record = |plan: &'static str| {
        let only = ["--only", if plan == "quick" { "circle" } else { "circle-1" }];
        let arguments = ["record", "--rig", "virtual:mild", "--plan", plan, "--out", "one.parquet"];
        run(place.path(), &[&arguments[..], &only].concat())
    };
    record("quick").succeeded();
    let bytes = std::fs::read(place.path().join("one.parquet")).unwrap();
    assert!(record("paper").error(2).contains("one of other commands"));
    assert!(std::fs::read(place.path().join("one.parquet")).unwrap() == bytes);
}

/// Every file of a folder and its bytes.
fn content(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let read = |name: String| {
        let bytes = std::fs::read(folder.join(&name)).unwrap();
        (name, bytes)
    };
    names_in(folder).into_iter().map(read).collect()
}

#[test]
fn a_folder_of_another_rig_seed_or_plan_is_refused_and_left_as_it_is() {
    let place = tempfile::tempdir().unwrap();
    let record = |arguments: &[&str]| run(place.path(), &[&["record"], arguments].concat());
    let only = ["--only", "circle", "--out", "data"];
    record(&[&["--rig", "virtual:typical", "--plan", "quick"], &only[..]].concat()).succeeded();
    let folder = place.path().join("data");
    let before = content(&folder);
    let robot = std::fs::read_to_string(folder.join("robot.toml")).unwrap();
    let softer = robot.replace("axial_stiffness_n = 1050.0", "axial_stiffness_n = 1000.0");
    assert_ne!(softer, robot);
    std::fs::write(place.path().join("softer.toml"), softer).unwrap();
    // The circle is there, and another trajectory is not: neither may be mixed.
    for name in ["circle", "square"] {
        let only = ["--only", name, "--out", "data"];
        for (other, part) in [
            (&["--rig", "virtual:typical", "--plan", "quick", "--seed", "2"][..], "another"),
            (&["--rig", "virtual:harsh", "--plan", "quick"], "another"),
            (&["--rig", "virtual:typical/3", "--plan", "quick"], "another"),
            (&["--rig", "virtual:softer.toml", "--plan", "quick"], "another"),
        ] {
            let outcome = record(&[other, &only[..]].concat());
            let error = outcome.error(2);
            let is_named = error.contains(part) || error.contains("sha256") || error.contains("virtual.seed");
            assert!(is_named && error.contains("choose another --out"), "{error}");
            assert!(content(&folder) == before, "{other:?} {name}");
        }
    }
    // The same command changes nothing, and goes on with the calibration that it left.
    let again = ["--rig", "virtual:typical", "--plan", "quick", "--calibration", "data/calibration.toml"];
    record(&[&again[..], &only[..]].concat()).succeeded();
    assert_eq!(recordings(&folder), ["circle.parquet"]);
    record(
        &[&["--rig", "virtual:typical", "--plan", "quick"][..], &["--only", "square", "--out", "data"]]
            .concat(),
    )
    .succeeded();
    assert_eq!(recordings(&folder), ["circle.parquet", "square.parquet"]);
}

#[test]
fn files_of_a_person_in_the_folder_are_not_overwritten() {
    for name in ["plan.toml", "rig.toml", "robot.toml", "calibration.toml", "report.html", "metrics.json"] {
        let place = tempfile::tempdir().unwrap();
        std::fs::create_dir(place.path().join("data")).unwrap();
        std::fs::write(place.path().join("data").join(name), "# mine\n").unwrap();
        let outcome = run(place.path(), &[&RECORD[..], &["data", "--only", "circle"]].concat());
        assert!(outcome.error(2).contains(name), "{}", outcome.stderr);
        let text = std::fs::read_to_string(place.path().join("data").join(name)).unwrap();
        assert_eq!(text, "# mine\n");
        assert_eq!(names_in(&place.path().join("data")), [name]);
    }
}

#[test]
fn a_name_with_the_log_of_another_recording_is_refused() {
    let place = tempfile::tempdir().unwrap();
    let record = |out: &str| run(place.path(), &[&RECORD[..], &[out, "--only", "circle"]].concat());
    record("one.parquet").succeeded();
    let before = content(place.path());
    assert!(record("one.csv").error(2).contains("that of one.parquet"));
    assert!(content(place.path()) == before);
}

#[test]
fn a_calibration_is_replaced_by_a_calibration_alone_and_the_one_before_is_kept() {
    let place = tempfile::tempdir().unwrap();
    let calibrate = |seed: &str, out: &str| {
        run(place.path(), &["rig", "calibrate", "--rig", "virtual:typical", "--seed", seed, "--out", out])
    };
    calibrate("1", "calibration.toml").succeeded();
    let first = std::fs::read(place.path().join("calibration.toml")).unwrap();
    calibrate("2", "calibration.toml").succeeded();
    let names = names_in(place.path());
    let kept = names.iter().find(|name| *name != "calibration.toml").unwrap();
    assert!(names.len() == 2 && kept.starts_with("calibration.2"), "{names:?}");
    assert!(std::fs::read(place.path().join(kept)).unwrap() == first);
    assert!(std::fs::read(place.path().join("calibration.toml")).unwrap() != first);
    std::fs::write(place.path().join("rig.toml"), "# mine\n").unwrap();
    assert!(calibrate("1", "rig.toml").error(2).contains("expected a calibration, or a new file"));
    assert_eq!(std::fs::read_to_string(place.path().join("rig.toml")).unwrap(), "# mine\n");
}
