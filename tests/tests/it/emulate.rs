//! The virtual rig as a program of its own: where it listens, how it ends, what it refuses.

#![cfg(unix)]

use std::io::{BufRead, BufReader};
use std::process::{Command, Stdio};

use hysteron_tests::{names_in, program, run};

/// On whatever TCP port is free.
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
    for (arguments, part) in [
        (&["--faults", "faults.toml"][..], "faults.toml: fault[1].servo: expected this key"),
        (&["--faults", "none.toml"], "none.toml: expected a file"),
        (&["--baud", "12345"], "baud: expected one of 9600"),
        (&["--return-delay-us", "600"], "return delay"),
        (&["--for-s", "-1"], "--for-s"),
    ] {
        let outcome = run(folder.path(), &[&EMULATE[..], &["--dir", "."], arguments].concat());
        assert!(outcome.error(2).contains(part), "{}", outcome.stderr);
        assert!(!folder.path().join("servos").is_symlink());
    }
}
