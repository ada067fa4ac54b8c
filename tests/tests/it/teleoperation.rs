//! `hysteron arm emulate` and `arm record` as processes: a whole recording goes into the other verbs; a killed one leaves no torque.

#![cfg(unix)]

use hysteron_base::Recording;
use hysteron_tests::emulated::{EmulatedArms, signal, wait_until};
use hysteron_tests::run;

#[test]
fn a_recording_of_both_arms_has_what_other_verbs_read() {
    let arms = EmulatedArms::start(&[]);
    let record = ["arm", "record", "--arms", "arms/patient.toml", "--payload-g", "200"];
    run(arms.path(), &[&record[..], &["--seconds", "2", "--out", "out.parquet"]].concat()).succeeded();
    assert!(!arms.is_under_torque());
    let recording = Recording::read(arms.path().join("out.parquet")).unwrap();
    assert!(recording.n_samples() > 90, "{}", recording.n_samples());
    assert_eq!(recording.meta().extra["payload_kg"], "0.2");
    assert_eq!(recording.meta().extra["position_gain"], "800");
    // Once more to the same name: a measurement is never overwritten.
    let again = run(arms.path(), &[&record[..], &["--seconds", "2", "--out", "out.parquet"]].concat());
    assert!(again.error(2).contains("one that exists"));
    // The channels are those of the data set, less what only a simulation knows.
    let generate = [
        "arm",
        "generate",
        "--subsets",
        "force_unlabeled",
        "--tasks",
        "sweep_1",
        "--splits",
        "test",
        "--out",
        "nad",
    ];
    run(arms.path(), &generate).succeeded();
    let nad = Recording::read(arms.path().join("nad/force_unlabeled/sweep_1/test/001.parquet")).unwrap();
    let names = |recording: &Recording| -> Vec<String> {
        recording.channels().iter().map(|channel| channel.name.clone()).collect()
    };
    let known: Vec<String> = names(&nad).into_iter().filter(|name| !name.starts_with("truth_")).collect();
    assert_eq!(names(&recording), known);
    for key in ["joint_names", "condition"] {
        assert_eq!(recording.meta().extra[key], nad.meta().extra[key], "{key}");
    }
}

#[test]
fn a_recorder_that_is_killed_leaves_no_torque_and_its_rows_open() {
    let arms = EmulatedArms::start(&[]);
    let long = ["arm", "record", "--arms", "arms/patient.toml", "--seconds", "20"];
    let mut recorder = arms.at_work(&long, "out.parquet");
    signal(&recorder, "KILL");
    recorder.wait().unwrap();
    wait_until("released", || !arms.is_under_torque());
    // The next recording to the same name opens what the killed one left.
    let record = ["arm", "record", "--arms", "arms/patient.toml", "--seconds", "1", "--out", "out.parquet"];
    run(arms.path(), &record).succeeded();
    for name in ["out.crashed-1.parquet", "out.parquet"] {
        assert!(Recording::read(arms.path().join(name)).unwrap().n_samples() > 20, "{name}");
    }
    assert!(!arms.path().join("out.journal").exists() && !arms.is_under_torque());
}

#[test]
fn the_emulated_follower_has_the_fault_of_the_trajectory() {
    let folder = tempfile::tempdir().unwrap();
    let generate =
        ["arm", "generate", "--subsets", "motor_faults", "--splits", "test", "--payloads-g", "200"];
    let own = ["--trajectories", "1", "--seed", "5", "--out", "nad"];
    run(folder.path(), &[&generate[..], &own].concat()).succeeded();
    for (kind, found) in [("band", "rubber band"), ("friction", "dry friction"), ("lost_tooth", "backlash")] {
        let name = format!("motor_faults/pick_place_200g_{kind}/test/001");
        let recording = Recording::read(folder.path().join(format!("nad/{name}.parquet"))).unwrap();
        let emulate =
            ["arm", "emulate", "--dir", "arms", "--for-s", "0", "--seed", "5", "--trajectory", &name];
        let stdout = run(folder.path(), &emulate).succeeded().stdout;
        let fault = &recording.meta().extra["fault"];
        assert!(fault.contains(found), "{fault}");
        assert!(
            stdout.contains(&format!("\nthe follower has joint 3: {}\n", &fault[9..])),
            "{fault} {stdout}"
        );
    }
    let healthy = "motor_faults/pick_place_200g_healthy/test/001";
    let emulate = ["arm", "emulate", "--dir", "arms", "--for-s", "0", "--trajectory", healthy];
    assert!(!run(folder.path(), &emulate).succeeded().stdout.contains("the follower has"));
}

#[test]
fn wrong_arguments_are_reported_before_a_port_is_opened() {
    let folder = tempfile::tempdir().unwrap();
    let emulate = |arguments: &[&str]| {
        run(folder.path(), &[&["arm", "emulate", "--dir", "arms", "--for-s", "0"], arguments].concat())
    };
    assert!(emulate(&["--trajectory", "weight/none"]).error(2).contains("SUBSET/TASK/SPLIT/NUMBER"));
    assert!(emulate(&["--begins-s", "-1"]).error(2).contains("--begins-s"));
    let fault =
        "format = \"hysteron-faults\"\nversion = 1\n[[fault]]\nat_s = 1.0\nkind = \"overload\"\nservo = 3\n";
    std::fs::write(folder.path().join("faults.toml"), fault).unwrap();
    assert!(emulate(&["--faults", "faults.toml"]).error(2).contains("11 to 15"));
    emulate(&[]).succeeded();
    let record = |arguments: &[&str]| {
        run(folder.path(), &[&["arm", "record", "--arms", "arms/arms.toml"], arguments].concat())
    };
    assert!(record(&["--out", "a.mat"]).error(2).contains("--out"));
    assert!(record(&["--out", "a.csv", "--seconds", "0"]).error(2).contains("--seconds"));
    assert!(record(&["--out", "a.csv", "--payload-g", "-5"]).error(2).contains("--payload-g"));
    // The emulator has ended: its ports are gone.
    assert!(record(&["--out", "a.csv"]).error(1).contains("leader"));
}
