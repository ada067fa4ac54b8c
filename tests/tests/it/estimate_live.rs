//! `hysteron arm estimate --live`: an emulated follower is estimated while it follows; every way out leaves whole files and no torque.

#![cfg(unix)]

use std::path::Path;

use hysteron_base::{Recording, json};
use hysteron_tests::emulated::{EmulatedArms, signal, wait_until};
use hysteron_tests::run;

/// Fits an actuator for seconds: its estimates are rough, the test is that there are estimates.
fn fit(folder: &Path) {
    let generate = ["arm", "generate", "--subsets", "force_unlabeled,weight", "--out", "nad"];
    let tasks = ["--tasks", "pick_place_empty,pick_place_object_300g", "--trajectories", "2"];
    run(folder, &[&generate[..], &tasks].concat()).succeeded();
    let fit =
        ["arm", "fit", "neural", "nad", "--prior", "servo", "--sensing", "observer", "--warm-start", "0"];
    let small = ["--updates", "1", "--width", "8", "--layers", "1", "--horizons", "16", "--contact-n", "0.3"];
    let out = ["--sensing-updates", "20", "--out", "a.safetensors"];
    run(folder, &[&fit[..], &small, &out].concat()).succeeded();
}

const NAMES: [&str; 5] = ["torque_5_n_m", "force_x_n", "force_z_n", "contact_ratio", "healthy_ratio"];

#[test]
fn an_arm_is_estimated_while_it_follows_and_any_end_is_clean() {
    let arms = EmulatedArms::start(&[]);
    let folder = arms.path();
    fit(folder);
    let live = ["arm", "estimate", "a.safetensors", "--live", "arms/patient.toml"];
    let timed = run(folder, &[&live[..], &["--seconds", "3", "--out", "out.parquet", "--json"]].concat());
    let timed = timed.succeeded();
    assert!(!arms.is_under_torque());
    let value: serde_json::Value = json::from_text(&timed.stdout).unwrap();
    let number = |path: &str| value.pointer(path).and_then(serde_json::Value::as_f64).unwrap();
    assert!((number("/rate_hz") - 60.0).abs() < 0.1);
    for times in ["step_ms", "age_ms"] {
        let [median, p95, p99, max] =
            ["median", "p95", "p99", "max"].map(|part| number(&format!("/{times}/{part}")));
        assert!(0.0 < median && median <= p95 && p95 <= p99 && p99 <= max, "{value}");
    }
    // An estimate comes after the bytes of its sample: 5 servos at 1 Mbaud are some 2 ms.
    assert!(number("/age_ms/median") > number("/step_ms/median") + 1.0, "{value}");
    let recording = Recording::read(folder.join("out.parquet")).unwrap();
    assert_eq!(recording.n_samples() as f64, number("/rows"));
    for name in NAMES {
        let values = recording.require(name).unwrap();
        assert!(values.iter().all(|value| value.is_finite()), "{name}");
        assert!(values.iter().any(|value| *value != values[0]), "{name}");
    }
    for name in ["contact_ratio", "healthy_ratio"] {
        assert!(recording.require(name).unwrap().iter().all(|p| (0.0..=1.0).contains(p)), "{name}");
    }
    // The recording has all that estimating it afterwards needs; the same estimator, at evenly spaced times,
    // gives much the same.
    run(folder, &["arm", "estimate", "a.safetensors", "out.parquet", "--out", "after.csv"]).succeeded();
    let after = Recording::read(folder.join("after.csv")).unwrap();
    for name in ["force_z_n", "healthy_ratio"] {
        let mean = |recording: &Recording| {
            let values = &recording.require(name).unwrap()[30..];
            values.iter().sum::<f64>() / values.len() as f64
        };
        let [live, after] = [&recording, &after].map(mean);
        assert!((live - after).abs() < 0.1 * live.abs() + 0.05, "{name}: {live} {after}");
    }

    // Without a length, Ctrl-C or a polite request is how it ends: whole.
    for (name, out) in [("INT", "endless.csv"), ("TERM", "asked.csv")] {
        let mut endless = arms.at_work(&live, out);
        signal(&endless, name);
        assert_eq!(endless.wait().unwrap().code(), Some(0), "{name}");
        assert!(!arms.is_under_torque() && !folder.join(out).with_extension("journal").exists(), "{name}");
        let endless = Recording::read(folder.join(out)).unwrap();
        assert!(endless.n_samples() > 20 && endless.channel("healthy_ratio").is_some(), "{name}");
    }
    // Killed, it leaves no torque, and its rows open.
    let mut killed = arms.at_work(&live, "killed.csv");
    signal(&killed, "KILL");
    killed.wait().unwrap();
    wait_until("released", || !arms.is_under_torque());
    assert!(folder.join("killed.journal").exists() && !folder.join("killed.csv").exists());
    // Before its time, Ctrl-C leaves what there is under another name.
    let early = [&live[..], &["--seconds", "60", "--out", "early.parquet"]].concat();
    let early = hysteron_tests::interrupt(folder, &early, "early.journal");
    assert!(early.error(1).contains("interrupted") && !folder.join("early.parquet").exists());
    assert!(!arms.is_under_torque());

    refusals(folder, &live);
    assert!(!arms.is_under_torque());
}

/// Refuses a changed arm file before anything moves.
fn refusals(folder: &Path, live: &[&str]) {
    let text = std::fs::read_to_string(folder.join("arms/patient.toml")).unwrap();
    let refused = |change: [&str; 2], expected: &str| {
        assert!(text.contains(change[0]), "{}", change[0]);
        std::fs::write(folder.join("arms/other.toml"), text.replace(change[0], change[1])).unwrap();
        let other = ["arm", "estimate", "a.safetensors", "--live", "arms/other.toml", "--out", "no.csv"];
        let outcome = run(folder, &other);
        assert!(outcome.error(2).contains(expected), "{}", outcome.stderr);
        assert!(!folder.join("no.csv").exists());
    };
    refused(["name = \"joint2\"", "name = \"shoulder\""], "trained on another arm");
    refused(["rate_hz = 60.0", "rate_hz = 100.0"], "58.8 Hz, as the actuator was trained");
    let of = |arguments: &[&str]| run(folder, &[live, arguments].concat());
    assert!(of(&["--out", "out.parquet"]).error(2).contains("one that exists"));
    assert!(of(&["--out", "no.mat"]).error(2).contains("--out"));
    assert!(of(&["--out", "no.csv", "--robot", "panda"]).error(2).contains("another arm"));
    assert!(of(&["--out", "no.csv", "--seconds", "-1"]).error(2).contains("--seconds"));
}
