//! Rigid-body arms through the built program.

use hysteron_tests::{names_in, root, run};

/// A place like the root of the repository, with what the page on arms reads.
fn place() -> tempfile::TempDir {
    let place = tempfile::tempdir().unwrap();
    for folder in ["arm/robots", "arm/tests/data"] {
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
    assert_eq!(n_run, 4);
    let report = std::fs::read_to_string(place.path().join("out/arm/report.html")).unwrap();
    for part in
        ["Motion of three_link", "Torques", "Energies", "Coriolis", "hysteron arm simulate three-link"]
    {
        assert!(report.contains(part), "no {part:?}");
    }
    let metrics = std::fs::read(place.path().join("out/arm/metrics.json")).unwrap();
    let metrics: serde_json::Value = serde_json::from_slice(&metrics).unwrap();
    assert_eq!(metrics["joints"].as_array().unwrap().len(), 3);
    assert!(metrics["joints"][0]["fastest"].as_f64().unwrap() > 0.0, "{metrics}");
}

#[test]
fn no_input_is_written_over_and_no_result_of_another_command() {
    let place = place();
    let torques = "arm/tests/data/torques.csv";
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
