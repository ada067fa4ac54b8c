//! Findings of the checks in recordings of real robots, set by set, against the known faults of each; clean
//! recordings of the virtual rig have none.

use std::path::Path;

use hysteron_fuzz::recorded;
use hysteron_tests::Workplace;
use serde_json::Value;

/// Kind and channel of everything that `check` finds in these recordings.
fn found(place: &Workplace, recordings: &[&str]) -> Vec<(String, String, Value)> {
    let outcome = place.run(&[&["check"], recordings, &["--json"]].concat()).succeeded();
    let value: Value = serde_json::from_str(&outcome.stdout).unwrap();
    let text = |value: &Value| value.as_str().unwrap().to_owned();
    let findings = value["findings"].as_array().unwrap();
    findings.iter().map(|one| (text(&one["kind"]), text(&one["channel"]), one.clone())).collect()
}

/// Imports a file of a set, and compares all that is found with `expected`, kinds and channels.
#[track_caller]
fn finds(source: &Path, more: &[&str], expected: &[(&str, &str)]) -> Vec<Value> {
    let place = Workplace::new();
    let source = source.display().to_string();
    place.run(&[&["import", &source], more, &["--out", "a.parquet"]].concat()).succeeded();
    let found = found(&place, &["a.parquet"]);
    let kinds: Vec<(&str, &str)> = found.iter().map(|(kind, channel, _)| (&kind[..], &channel[..])).collect();
    assert_eq!(kinds, expected, "{source}: {found:?}");
    found.into_iter().map(|(_, _, one)| one).collect()
}

#[test]
fn ftdcr_is_moved_step_by_step() {
    let Some(folder) = recorded("ftdcr_is_moved_step_by_step", "ftdcr-v4") else { return };
    // Rows half a second apart, longer where a pattern begins; in between the tip moves by centimetres, and jumps nowhere.
    finds(&folder.join("train.csv"), &[], &[("uneven_time", "time_s")]);
    // Every tendon is pulled once and released once.
    let expected = [("uneven_time", "time_s"), ("excitation", "strokes")];
    finds(&folder.join("tendon_pull.csv"), &[], &expected);
}

#[test]
fn holds_of_the_tentacle_follow_no_order() {
    let Some(path) = recorded("holds_of_the_tentacle_follow_no_order", "tentacle/static_markers.csv") else {
        return;
    };
    finds(&path, &[], &[]);
}

/// Rows (from 1) in which a marker leaves both its neighbours by `least` [m] while these agree to a tenth of it.
fn lone_rows(text: &str, columns: [&str; 3], least: f64) -> Vec<usize> {
    let mut lines = text.lines();
    let header: Vec<&str> = lines.next().unwrap().split(',').collect();
    let at = columns.map(|name| header.iter().position(|column| *column == name).unwrap());
    let point = |line: &str| {
        let cells: Vec<&str> = line.split(',').collect();
        at.map(|k| cells[k].parse::<f64>().unwrap_or(f64::NAN))
    };
    let points: Vec<[f64; 3]> = lines.map(point).collect();
    let distance = |a: [f64; 3], b: [f64; 3]| (0..3).map(|c| (a[c] - b[c]).powi(2)).sum::<f64>().sqrt();
    let is_lone = |w: &[[f64; 3]]| {
        distance(w[0], w[2]) < 0.1 * least && distance(w[1], w[0]) > least && distance(w[1], w[2]) > least
    };
    (1..points.len() - 1).filter(|i| is_lone(&points[i - 1..=i + 1])).map(|i| i + 1).collect()
}

#[test]
fn markers_of_the_trunk_are_mistaken_for_each_other() {
    let Some(folder) = recorded("markers_of_the_trunk_are_mistaken_for_each_other", "trunk") else { return };
    let commands = folder.join("control_inputs_controlled_1.csv").display().to_string();
    for name in ["observations_controlled_1.csv", "observations_controlled_1_200g.csv"] {
        let place = Workplace::new();
        let source = folder.join(name).display().to_string();
        place.run(&["import", &source, &commands, "--map", "trunk", "--out", "a.parquet"]).succeeded();
        let found = found(&place, &["a.parquet"]);
        // The motors' angles come at a fifth of the rate.
        let held = found.iter().find(|(kind, ..)| kind == "sample_and_hold").unwrap();
        assert!(held.1.starts_with("q_1_rad") && held.2["value"] == 5.0, "{held:?}");
        // All other findings are spikes of the first two disks, and the file has such rows; the tip, the third, has none.
        let text = std::fs::read_to_string(folder.join(name)).unwrap();
        for (kind, channel, one) in found.iter().filter(|(kind, ..)| kind != "sample_and_hold") {
            assert!(
                kind == "spike" && (channel.starts_with("disk_1") || channel.starts_with("disk_2")),
                "{one}"
            );
        }
        assert!(found.iter().any(|(_, channel, _)| channel.starts_with("disk_1")), "{found:?}");
        assert_ne!(lone_rows(&text, ["x1", "y1", "z1"], 5e-3), [0; 0]);
        assert_eq!(lone_rows(&text, ["x3", "y3", "z3"], 5e-3), [0; 0]);
    }
}

#[test]
fn servos_that_creep_repeat_themselves_by_right() {
    let Some(folder) = recorded("servos_that_creep_repeat_themselves_by_right", "arms/bam/xl330") else {
        return;
    };
    // An encoder of 4096 steps read every 5 ms: a pendulum that turns is at one number for many rows.
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        // One swing sticks where it turns, twice at the same number of the encoder.
        let sticks = path.ends_with("2026-01-15_10h28m57.json");
        let expected: &[(&str, &str)] = if sticks { &[("saturation", "q_1_rad")] } else { &[] };
        finds(&path, &[], expected);
    }
}

#[test]
fn recordings_of_arms_cause_no_warnings() {
    let Some(folder) = recorded("recordings_of_arms_cause_no_warnings", "arms") else { return };
    for k in 1..=2 {
        finds(&folder.join(format!("kuka-lwr4/measurements_{k}.npz")), &[], &[]);
    }
    for part in ["train", "test"] {
        for entry in std::fs::read_dir(folder.join("baxter").join(part)).unwrap() {
            finds(&entry.unwrap().path(), &[], &[]);
        }
    }
    finds(&folder.join("nad/excerpt-omx.csv"), &[], &[]);
    // Of the tests of single joints of the UR10e only the joint of the name moves.
    for joint in 1..=4 {
        let others: Vec<String> = (1..=6).filter(|k| *k != joint).map(|k| format!("q_{k}_rad")).collect();
        let path = folder.join(format!("ur10e/ur-20_01_22-joint_{joint}.csv"));
        finds(&path, &["--map", "ur10e"], &[("excitation", &others.join(", "))]);
    }
    // Rows are missing in the stamps: in 2 % of the time an import has to fill in.
    for speed in ["slow", "middle", "high"] {
        let path = folder.join(format!("friction-franka/franka_case3_{speed}.csv"));
        finds(&path, &[], &[("gap", "gap")]);
    }
}

#[test]
fn clean_recordings_of_the_virtual_rig_cause_no_warnings() {
    let place = Workplace::new();
    for (rig, seed) in [("mild", "1"), ("typical", "2"), ("typical/7", "3"), ("wide/4", "4")] {
        let out = format!("{}-{seed}", rig.replace('/', "-"));
        let rig = format!("virtual:{rig}");
        place.run(&["record", "--rig", &rig, "--plan", "quick", "--seed", seed, "--out", &out]).succeeded();
        let names = hysteron_tests::names_in(&place.path().join(&out));
        let recordings: Vec<String> = names
            .iter()
            .filter(|name| name.ends_with(".parquet"))
            .map(|name| format!("{out}/{name}"))
            .collect();
        let recordings: Vec<&str> = recordings.iter().map(String::as_str).collect();
        assert_eq!(recordings.len(), 5, "{names:?}");
        // A virtual tracker loses the tip as a real one does: these rows are marked, and the gap is reported correctly.
        let warnings: Vec<_> =
            found(&place, &recordings).into_iter().filter(|(kind, ..)| kind != "gap").collect();
        assert_eq!(warnings, [], "{out}");
    }
}
