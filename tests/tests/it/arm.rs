//! Rigid-body arms through the built program.

use hysteron_base::json;
use hysteron_tests::{measured, names_in, root, run};

/// A place like the root of the repository, with what the page on arms reads.
fn place() -> tempfile::TempDir {
    let place = tempfile::tempdir().unwrap();
    for folder in ["arm/dynamics/robots", "arm/dynamics/tests/data"] {
        std::fs::create_dir_all(place.path().join(folder)).unwrap();
        for name in names_in(&root().join(folder)) {
            let at = root().join(folder).join(&name);
            if at.is_file() {
                std::fs::copy(at, place.path().join(folder).join(&name)).unwrap();
            }
        }
    }
    place
}

#[test]
fn the_commands_of_its_page_work_as_typed() {
    let place = place();
    let page = std::fs::read_to_string(root().join("docs/arm.md")).unwrap();
    let commands = page.lines().filter_map(|line| line.strip_prefix("    cargo run --release -- "));
    let mut n_run = 0;
    for line in commands {
        run(place.path(), &line.split_whitespace().collect::<Vec<_>>()).succeeded();
        n_run += 1;
    }
    assert_eq!(n_run, 5);
    let report = std::fs::read_to_string(place.path().join("out/arm/report.html")).unwrap();
    for part in
        ["Motion of three_link", "Torques", "Energies", "Coriolis", "hysteron arm simulate three-link"]
    {
        assert!(report.contains(part), "no {part:?}");
    }
    let metrics = std::fs::read(place.path().join("out/arm/metrics.json")).unwrap();
    let metrics: serde_json::Value = json::from_text(&metrics).unwrap();
    assert_eq!(metrics["joints"].as_array().unwrap().len(), 3);
    assert!(metrics["joints"][0]["fastest"].as_f64().unwrap() > 0.0, "{metrics}");
    let metrics = std::fs::read(place.path().join("out/arm/exciting/metrics.json")).unwrap();
    let metrics: serde_json::Value = json::from_text(&metrics).unwrap();
    let [condition, before] =
        ["condition_number", "condition_number_before"].map(|key| metrics[key].as_f64().unwrap());
    assert!(condition > 1.0 && condition < before, "{metrics}");
}

#[test]
fn a_robot_is_exported_and_read_again() {
    let place = tempfile::tempdir().unwrap();
    let arm = |words: &[&str]| run(place.path(), &[&["arm"], words].concat());
    arm(&["export", "panda", "--out", "panda.csv"]).succeeded();
    for out in ["panda.urdf", "panda.xml"] {
        arm(&["export", "panda", "--parameters", "panda.csv", "--out", out]).succeeded();
        let info = arm(&["info", out]).succeeded().stdout;
        assert!(info.contains("9 joints") && info.contains("panda_joint7"), "{info}");
        // What it made itself it makes again.
        arm(&["export", "panda", "--parameters", "panda.csv", "--out", out]).succeeded();
    }
    arm(&["export", "so101", "--joints", "--out", "joints.xml"]).succeeded();
    let before = names_in(place.path());
    std::fs::write(place.path().join("three.csv"), "joint,mass_kg\na,1\nb,-1\nc,1\n").unwrap();
    for (words, part) in [
        (&["export", "panda", "--out", "panda.obj"][..], "--out: expected a file .urdf, .xml or .csv"),
        (&["export", "panda", "--joints", "--out", "panda2.urdf"], "--out: expected a file .xml"),
        (&["export", "panda", "--parameters", "three.csv", "--out", "p.urdf"], "three.csv: rows: expected 9"),
        (
            &["export", "three-link", "--parameters", "three.csv", "--out", "p.urdf"],
            "three.csv: line 3: mass_kg of",
        ),
        (
            &["export", "panda", "--parameters", "panda.csv", "--out", "panda.csv"],
            "another file than the input",
        ),
        (&["excite", "three-link", "--out", "e.csv"], "joint joint_1: expected a limit of speed > 0"),
        (
            &["excite", "panda", "--shape", "quintic", "--out", "e.csv"],
            "--from: expected 9 finite coordinates",
        ),
        (
            &["excite", "panda", "--rate", "0", "--generations", "1", "--out", "e.csv"],
            "rate: expected a rate",
        ),
        (&["excite", "panda", "--limits", "2", "--out", "e.csv"], "limits: expected a part from 0 to 1"),
    ] {
        let outcome = arm(words);
        assert!(outcome.error(2).contains(part), "{part:?} in {:?}", outcome.stderr);
    }
    std::fs::remove_file(place.path().join("three.csv")).unwrap();
    assert_eq!(names_in(place.path()), before);
}

#[test]
fn no_input_is_written_over_and_no_result_of_another_command() {
    let place = place();
    let torques = "arm/dynamics/tests/data/torques.csv";
    let simulate = |more: &[&str]| {
        run(place.path(), &[&["arm", "simulate", "three-link", "--torques", torques], more].concat())
    };
    let input = std::fs::read(place.path().join(torques)).unwrap();
    let error = simulate(&["--out", torques]).error(2).to_owned();
    assert!(error.contains("--out: expected another file than the input"), "{error}");
    assert_eq!(std::fs::read(place.path().join(torques)).unwrap(), input);
    simulate(&["--out", "motion.csv"]).succeeded();
    let motion = std::fs::read(place.path().join("motion.csv")).unwrap();
    let error = simulate(&["--out", "motion.csv", "--start", "0.1,0,0"]).error(2).to_owned();
    assert!(error.contains("motion.csv") && error.contains("--overwrite"), "{error}");
    assert_eq!(std::fs::read(place.path().join("motion.csv")).unwrap(), motion);
    simulate(&["--out", "motion.csv", "--start", "0.1,0,0", "--overwrite"]).succeeded();
    assert_ne!(std::fs::read(place.path().join("motion.csv")).unwrap(), motion);
    let error = run(
        place.path(),
        &["arm", "dynamics", "three-link", "--states", "motion.csv", "--out", "motion.csv"],
    );
    assert!(error.error(2).contains("--out: expected another file than the input"), "{:?}", error.stderr);
}

#[test]
fn a_study_of_estimators_is_reported_and_found_again() {
    let place = tempfile::tempdir().unwrap();
    let study = || run(place.path(), &["study", "wrist", "--seeds", "1", "--out", "wrist"]).succeeded();
    study();
    let read = |name: &str| std::fs::read_to_string(place.path().join("wrist").join(name)).unwrap();
    let (report, metrics) = (read("report.html"), read("metrics.json"));
    let numbers = [
        "(figure 5)",
        "(figure 6)",
        "(figure 7)",
        "(figure 8)",
        "(figure 9)",
        "(figure 10b)",
        "(figure 11b)",
    ];
    for part in numbers.into_iter().chain(["Table 4: force-sensor, friction +15 %", "momentum-observer"]) {
        assert!(report.contains(part), "no {part:?}");
    }
    assert_eq!(json::from_text::<serde_json::Value>(&metrics).unwrap()["cells"].as_array().unwrap().len(), 6);
    study();
    assert_eq!(read("metrics.json"), metrics);
}

#[test]
fn studies_are_listed_with_their_durations_and_older_names_still_work() {
    let place = tempfile::tempdir().unwrap();
    let list = run(place.path(), &["study", "--help"]).succeeded().stdout;
    for name in ["sofa", "coreact", "ablation", "simulated", "wrist", "force", "neural-networks", "cloning"] {
        assert!(list.contains(&format!("  {name} ")), "no {name} in {list}");
    }
    for older in [&["arm", "study", "force"][..], &["study", "ladder"], &["study", "delan"]] {
        let help = run(place.path(), &[older, &["--help"]].concat()).succeeded().stdout;
        assert!(help.contains("--out <DIR>"), "{older:?}: {help}");
    }
}

const COLUMNS: &str = r#"
format = "hysteron-columns"
version = 1
[columns]
time_s = "t"
"q_*_rad" = "q*"
"tau_*_n_m" = "i*"
"#;

/// A log at 100 Hz of two joints in which row 5 reads `text`.
fn log(text: &str) -> String {
    let row = |k: usize| match k {
        5 => format!("{text}\n"),
        _ => format!("{},{},{},1,2\n", 0.01 * k as f64, 0.1 * k as f64, 0.2),
    };
    format!("t,q1,q2,i1,i2\n{}", (0..40).map(row).collect::<String>())
}

#[test]
fn an_imported_recording_is_simulated_and_a_bad_one_refused() {
    let place = tempfile::tempdir().unwrap();
    let write = |name: &str, content: &[u8]| std::fs::write(place.path().join(name), content).unwrap();
    let import = |file: &str, more: &[&str]| {
        run(place.path(), &[&["import", file, "--map", "c.toml", "--out", "rec.csv"], more].concat())
    };
    write("c.toml", COLUMNS.as_bytes());
    write("log.csv", log("0.05,0.5,0.2,1,2").as_bytes());
    let outcome = import("log.csv", &[]).succeeded();
    assert!(outcome.stdout.contains("40 rows at 100.000 Hz, 0 of them gaps"), "{:?}", outcome.stdout);
    run(place.path(), &["arm", "simulate", "scara", "--torques", "rec.csv", "--out", "motion.csv"])
        .succeeded();
    std::fs::remove_file(place.path().join("rec.csv")).unwrap();
    std::fs::remove_file(place.path().join("motion.csv")).unwrap();
    let before = names_in(place.path());
    for (row, part) in [
        ("0.05,NaN,0.2,1,2", "log.csv: line 7: q1: expected a finite number"),
        ("0.05,0.5,0.2,1", "log.csv: line 7: expected 5 cells"),
        ("0.03,0.5,0.2,1,2", "log.csv: line 7: time: expected one after 0.04 s"),
        (
            "0.05,500,0.2,1,2",
            "q_1_rad, rows 6: expected numbers in the unit that is stated, got 500.0000 in row 6",
        ),
    ] {
        write("log.csv", log(row).as_bytes());
        let outcome = import("log.csv", &[]);
        assert!(outcome.error(2).contains(part), "{part:?} in {:?}", outcome.stderr);
        assert_eq!(names_in(place.path()), before);
    }
    write("log.csv", log("0.05,0.5,0.2,1,2").replace("q2,", "tip,").as_bytes());
    let outcome = import("log.csv", &[]);
    assert!(
        outcome.error(2).contains("q_2_rad: expected this channel of all 2 joints"),
        "{:?}",
        outcome.stderr
    );
    write("log.csv", log("0.05,0.5,0.2,1,2").as_bytes());
    let outcome = import("log.csv", &["--model", "three-link"]);
    assert!(
        outcome.error(2).contains("joints: expected 3, as \"three_link\" has, got 2"),
        "{:?}",
        outcome.stderr
    );
    for more in [&["--rate", "-1"][..], &["--rate", "1e300"], &["--where", "x"], &["--where", "q1=77"]] {
        import("log.csv", more).error(2);
    }
    let garbage: Vec<u8> = (0..10_u32 << 20).map(|k| (k.wrapping_mul(2_654_435_761) >> 24) as u8).collect();
    for name in ["garbage.csv", "garbage.json", "garbage.npz", "garbage.parquet", "garbage.npy"] {
        write(name, &garbage);
        let (outcome, megabytes) = measured(place.path(), &["import", name, "--out", "rec.csv"]);
        assert!(outcome.error(2).contains(name), "{:?}", outcome.stderr);
        assert!(megabytes < 400, "{megabytes} MB for {name}");
        std::fs::remove_file(place.path().join(name)).unwrap();
    }
    let error = run(place.path(), &["import", "log.csv", "--map", "c.toml", "--out", "log.csv"]);
    assert!(error.error(2).contains("--out: expected another file than the input"), "{:?}", error.stderr);
}

#[test]
fn an_import_reads_its_arm_with_the_options_of_a_robot_file() {
    let place = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(place.path().join(name), text).unwrap();
    write(
        "floats.xml",
        "<mujoco><worldbody><body name=\"base\"><freejoint/><geom size=\"0.1\" mass=\"1\"/><body name=\"link\">\
         <joint name=\"hinge\" axis=\"0 1 0\"/><geom size=\"0.1\" mass=\"1\" pos=\"0 0 0.3\"/></body></body></worldbody></mujoco>",
    );
    let row = |k: i32| format!("{},{}\n", 0.01 * f64::from(k), (0.05 * f64::from(k)).sin());
    write("log.csv", &format!("time_s,q_1_rad\n{}", (0..100).map(row).collect::<String>()));
    let map = "time_s=time_s; q_1_rad=q_1_rad";
    let import = ["import", "log.csv", "--map", map, "--model", "floats.xml", "--out", "log.parquet"];
    let error = run(place.path(), &import).error(2).to_owned();
    assert!(error.contains("--fix-base"), "{error}");
    let held = run(place.path(), &[&import[..], &["--fix-base"]].concat()).succeeded();
    assert!(held.stdout.contains("is held at zero"), "{}", held.stdout);
    assert!(place.path().join("log.parquet").exists());
}
