//! The virtual rig as a program of its own: where it listens, how it ends, what it refuses.

#![cfg(unix)]

use std::io::{BufRead, BufReader};
use std::process::{Command, Stdio};

use hysteron_tests::{names_in, program, run};

/// On any free TCP port.
const EMULATE: [&str; 4] = ["rig", "emulate", "--port-tracker", "0"];

#[test]
fn the_port_is_there_until_the_time_is_over() {
    let folder = tempfile::tempdir().unwrap();
    let outcome = run(
        folder.path(),
        &[&EMULATE[..], &["--dir", "rig", "--for-s", "0.2", "--draw-faults", "3"]].concat(),
    )
    .succeeded();
    assert!(outcome.stdout.starts_with("servos 1 to 4 at rig/servos, 1000000 baud\n"), "{}", outcome.stdout);
    assert!(outcome.stdout.contains("faults to come: 3"), "{}", outcome.stdout);
    assert_eq!(names_in(&folder.path().join("rig")), ["faults.jsonl", "rig.toml", "torque.jsonl"]);
}

#[test]
fn a_polite_end_removes_the_port() {
    let folder = tempfile::tempdir().unwrap();
    let mut emulator = Command::new(program())
        .args(EMULATE)
        .args(["--dir", "."])
        .current_dir(folder.path())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let mut lines = BufReader::new(emulator.stdout.take().unwrap()).lines();
    assert!(lines.next().unwrap().unwrap().starts_with("servos 1 to 4"));
    assert!(folder.path().join("servos").exists());
    let asked = Command::new("kill").arg(emulator.id().to_string()).status().unwrap();
    assert!(asked.success());
    assert!(emulator.wait().unwrap().success());
    assert!(!folder.path().join("servos").is_symlink());
    assert!(lines.any(|line| line.unwrap().contains("instructions")));
}

#[test]
fn bad_input_starts_nothing() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(
        folder.path().join("faults.toml"),
        "format = \"hysteron-faults\"\nversion = 1\n[[fault]]\nat_s = 1\nkind = \"unplug_servo\"\n",
    )
    .unwrap();
    std::fs::write(
        folder.path().join("nobody.toml"),
        "format = \"hysteron-faults\"\nversion = 1\n[[fault]]\nat_s = 1\nkind = \"overload\"\nservo = 99\n",
    )
    .unwrap();
    for (arguments, part) in [
        (&["--faults", "faults.toml"][..], "faults.toml: fault[1].servo: expected this key"),
        (&["--faults", "none.toml"], "none.toml: expected a file"),
        (&["--baud", "12345"], "baud: expected one of 9600"),
        (&["--return-delay-us", "600"], "return delay"),
        (&["--for-s", "-1"], "--for-s"),
        (&["--for-s", "1e12"], "--for-s"),
        (&["--for-s", "1", "--draw-faults", "4000000000"], "--draw-faults"),
        (
            &["--faults", "nobody.toml"],
            "nobody.toml: the fault at 1 s: servo: expected a servo that is there, 1 to 4",
        ),
    ] {
        let outcome = run(folder.path(), &[&EMULATE[..], &["--dir", "."], arguments].concat());
        assert!(outcome.error(2).contains(part), "{}", outcome.stderr);
        assert!(!folder.path().join("servos").is_symlink());
    }
}

#[test]
fn a_second_emulator_leaves_the_first_one_its_folder() {
    let folder = tempfile::tempdir().unwrap();
    let mut first = Command::new(program())
        .args(EMULATE)
        .args(["--dir", "rig"])
        .current_dir(folder.path())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let mut lines = BufReader::new(first.stdout.take().unwrap()).lines();
    assert!(lines.next().unwrap().unwrap().starts_with("servos 1 to 4"));
    let link = folder.path().join("rig/servos");
    let device = std::fs::read_link(&link).unwrap();
    let file = std::fs::read(folder.path().join("rig/rig.toml")).unwrap();
    let second = run(folder.path(), &[&EMULATE[..], &["--dir", "rig", "--for-s", "0.2"]].concat());
    assert!(second.error(2).contains(&format!("process {} is writing", first.id())), "{}", second.stderr);
    assert_eq!(std::fs::read_link(&link).unwrap(), device);
    assert!(std::fs::read(folder.path().join("rig/rig.toml")).unwrap() == file);
    // Killed, it leaves its link and its lock behind; the next one takes both over.
    first.kill().unwrap();
    first.wait().unwrap();
    run(folder.path(), &[&EMULATE[..], &["--dir", "rig", "--for-s", "0.2"]].concat()).succeeded();
    assert_eq!(names_in(&folder.path().join("rig")), ["faults.jsonl", "rig.toml", "torque.jsonl"]);
}

#[test]
fn a_rig_file_of_somebody_else_is_not_overwritten() {
    let folder = tempfile::tempdir().unwrap();
    let emulate =
        |more: &[&str]| run(folder.path(), &[&EMULATE[..], &["--dir", ".", "--for-s", "0.1"], more].concat());
    emulate(&[]).succeeded();
    // The same robot on another port, and at another speed.
    emulate(&["--baud", "3000000"]).succeeded();
    let path = folder.path().join("rig.toml");
    let own = std::fs::read_to_string(&path).unwrap().replace("slew_mm_s = 3.0", "slew_mm_s = 2.0");
    std::fs::write(&path, &own).unwrap();
    assert!(emulate(&[]).error(2).contains("rig.toml: expected the rig file of this virtual robot"));
    assert_eq!(std::fs::read_to_string(&path).unwrap(), own);
}
