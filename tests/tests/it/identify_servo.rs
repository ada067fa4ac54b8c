//! `hysteron identify-servo`: the parameters of the virtual rig's servos come back from recordings of it, and
//! errors of bad recordings name the reason.

use std::path::Path;

use hysteron_base::{Channel, Metadata, Recording, json};
use hysteron_tests::run;
use serde_json::Value;

const NO_FORCE: &str = "time_s,tip_force_x_n,tip_force_y_n,tip_force_z_n\n0,0,0,0\n";
/// Names of the recordings of the plan `quick`.
const QUICK: [&str; 5] = ["circle", "diagonal", "ellipse", "sinusoid", "square"];

/// Records `quick` with tensions.
fn record(folder: &Path, rig: &str, seed: &str, out: &str) {
    std::fs::write(folder.join("none.csv"), NO_FORCE).unwrap();
    let rig = ["record", "--rig", rig, "--plan", "quick", "--tip-force", "none.csv", "--seed", seed];
    run(folder, &[&rig[..], &["--out", out]].concat()).succeeded();
}

/// The same recordings with every channel changed by `change`, without those for which it gives nothing.
fn changed(folder: &Path, from: &str, to: &str, change: &dyn Fn(&Channel) -> Option<Vec<f64>>) {
    std::fs::create_dir_all(folder.join(to)).unwrap();
    for name in QUICK {
        let recording = Recording::read(folder.join(from).join(format!("{name}.parquet"))).unwrap();
        let channels = recording.channels().iter();
        let channels = channels.filter_map(|c| Some(Channel::new(c.name.clone(), change(c)?))).collect();
        let time = recording.time().to_vec();
        let new = Recording::new(time, channels, recording.gap().to_vec(), Metadata::default()).unwrap();
        new.write(folder.join(to).join(format!("{name}.parquet"))).unwrap();
    }
}

fn read(path: &Path) -> Value {
    json::from_text(std::fs::read(path).unwrap()).unwrap()
}

/// Value and standard error of a number of a servo.
fn estimate(servo: &Value, name: &str) -> [Option<f64>; 2] {
    let rows = servo["estimates"].as_array().unwrap();
    let row = rows.iter().find(|row| row["name"] == name).unwrap_or_else(|| panic!("no {name}: {servo}"));
    ["value", "standard_error"].map(|key| row[key].as_f64())
}

/// Those of the presets: torque of full load, which is the stall torque and the friction at standstill; Coulomb friction; backlash.
const RIGS: [(&str, [f64; 3]); 2] =
    [("virtual:typical", [1.445, 0.045, 0.10]), ("virtual:harsh", [1.46, 0.06, 0.20])];
/// Back EMF and viscous friction of both: (1.445 - 0.045 - 0.01 · 5.97)/5.97 + 0.01.
const VISCOUS: f64 = 0.2345;
const NAMES: [&str; 3] = ["load_scale_n_m", "coulomb_n_m", "backlash_mm"];

#[test]
fn servos_of_virtual_rigs_come_back_within_their_standard_errors() {
    let place = tempfile::tempdir().unwrap();
    let folder = place.path();
    let mut distances = Vec::new();
    for (rig, truth) in RIGS {
        for seed in ["1", "2", "3"] {
            let out = format!("{}-{seed}", &rig[8..]);
            record(folder, rig, seed, &out);
            run(folder, &["identify-servo", &out, "--out", "servos.json", "--overwrite"]).succeeded();
            let found = read(&folder.join("servos.json"));
            let servos = found["servos"].as_array().unwrap();
            assert_eq!(servos.len(), 4);
            for servo in servos {
                for (name, truth) in NAMES.iter().zip(truth) {
                    let [value, error] = estimate(servo, name).map(Option::unwrap);
                    // No number is so vague that anything would do.
                    assert!(error < 0.3 * truth, "{rig} {name}: {value} ± {error}");
                    distances.push((value - truth) / error);
                }
                // Their Stribeck speed of 0.1 rad/s is below what goals of whole ticks can show.
                for name in ["stribeck_velocity_rad_s", "breakaway_excess_n_m"] {
                    assert_eq!(estimate(servo, name), [None, None]);
                }
                let [viscous, _] = estimate(servo, "viscous_n_m_s_per_rad");
                // Loads are read just before each goal, in the trough of the ripple that goals make of the duty: goals step by v · 10 ms, the
                // loop answers with 14.4 N m/rad, and the load is smoothed over 20 ms, so it is low by up to a quarter of 0.072 v.
                let short = 1.0 - viscous.unwrap() / VISCOUS;
                assert!((-0.01..0.018 / VISCOUS).contains(&short), "{rig}: {viscous:?}");
            }
        }
    }
    let covered = |most: f64| distances.iter().filter(|d| d.abs() < most).count();
    // Of 72 numbers, 95 % within 1.96 standard errors leaves four outside on average and nine in one of a hundred such tests.
    assert!(covered(1.96) >= 63, "{} of {}: {distances:.2?}", covered(1.96), distances.len());
    assert_eq!(covered(5.0), distances.len(), "{distances:.2?}");
}

#[test]
fn slack_tendons_identify_friction_and_the_rest_is_named_with_what_to_record() {
    let place = tempfile::tempdir().unwrap();
    let folder = place.path();
    run(folder, &["record", "--rig", "virtual:typical", "--plan", "quick", "--out", "quick"]).succeeded();
    let identified = run(
        folder,
        &[
            "identify-servo",
            "quick",
            "--stall-torque",
            "1.445",
            "--out",
            "s.json",
            "--figures",
            "s",
            "--json",
        ],
    )
    .succeeded();
    let value: Value = json::from_text(&identified.stdout).unwrap();
    for servo in value["servos"].as_array().unwrap() {
        let [coulomb, error] = estimate(servo, "coulomb_n_m").map(Option::unwrap);
        // Slack is estimated from loads alone, with some tendons among it that are hardly taut.
        assert!((coulomb - 0.045).abs() < 0.003 && error < 0.004, "{servo}");
        assert_eq!(estimate(servo, "load_scale_n_m"), [Some(1.445), None]);
        assert_eq!(estimate(servo, "backlash_mm"), [None, None]);
        let text = servo.to_string();
        assert!(text.contains("record tension_k_n") && text.contains("record tension_1_n, .."), "{text}");
    }
    let page = std::fs::read_to_string(folder.join("s/report.html")).unwrap();
    assert!(page.contains("Servo 4") && page.contains("Residuals over speed"));
    // A map of any shape is the same curve where there is data.
    run(folder, &["identify-servo", "quick", "--law", "learned-map", "--servos", "2", "--out", "m.json"])
        .succeeded();
    let map = read(&folder.join("m.json"));
    assert_eq!(map["servos"].as_array().unwrap().len(), 1);
    assert!(map["servos"][0]["rms_n_m"].as_f64().unwrap() < 0.002, "{map}");
}

#[test]
fn recordings_without_information_are_refused() {
    let place = tempfile::tempdir().unwrap();
    let folder = place.path();
    record(folder, "virtual:typical", "1", "good");
    let values = |c: &Channel| Some(c.values.clone());
    let scaled = |stem: &'static str, factor: f64| {
        move |c: &Channel| {
            let factor = if c.name.starts_with(stem) { factor } else { 1.0 };
            Some(c.values.iter().map(|x| factor * x).collect())
        }
    };
    let without =
        |stem: &'static str| move |c: &Channel| (!c.name.starts_with(stem)).then(|| c.values.clone());
    type Change<'a> = &'a dyn Fn(&Channel) -> Option<Vec<f64>>;
    let cases: [(&str, Change, &[&str]); 8] = [
        (
            "percent",
            &scaled("load_", 100.0),
            &["servo 1: load: expected shares of the largest", "divide by 100"],
        ),
        ("counts", &scaled("load_", 1000.0), &["divide by 1000"]),
        ("still", &scaled("tick_present_", 0.0), &["steady motion, pulling, got 0", "record a plan"]),
        ("dead", &scaled("load_", 0.0), &["expected loads that change, got 0 throughout"]),
        ("flat", &scaled("true_tension_", 0.0), &["expected tensions that change", "remove the columns"]),
        ("idle", &scaled("tick_goal_", 0.0), &["tick_goal_1: expected goals that change"]),
        ("no-loads", &without("load_"), &["circle.parquet: recording: expected a channel load_1"]),
        ("no-ticks", &without("tick_"), &["expected a channel tick_present_1"]),
    ];
    for (name, change, parts) in cases {
        changed(folder, "good", name, change);
        let refused = run(folder, &["identify-servo", name, "--out", "never.json"]);
        let error = refused.error(2);
        parts.iter().for_each(|part| assert!(error.contains(part), "{name}: no {part:?} in {error}"));
    }
    // A recording that another rig made.
    changed(folder, "good", "other", &values);
    let circle = Recording::read(folder.join("good/circle.parquet")).unwrap();
    let wider = |c: &Channel| {
        let factor = if c.name.starts_with("stroke_") { 2.0 } else { 1.0 };
        Channel::new(c.name.clone(), c.values.iter().map(|x| factor * x).collect())
    };
    let channels = circle.channels().iter().map(wider).collect();
    let other = Recording::new(circle.time().to_vec(), channels, Vec::new(), Metadata::default()).unwrap();
    other.write(folder.join("other/circle.parquet")).unwrap();
    let refused = run(folder, &["identify-servo", "other", "--out", "never.json"]);
    let error = refused.error(2);
    assert!(error.contains("tick_goal_1: expected the same stroke for a tick in all recordings"), "{error}");
    for (option, value, part) in [
        ("--stall-torque", "-1", "--stall-torque: expected a finite number > 0"),
        ("--law", "m6", "--law: expected one of stribeck"),
        ("--servos", "9", "--servos: expected 1 to 4, got 9"),
    ] {
        let refused = run(folder, &["identify-servo", "good", option, value, "--out", "never.json"]);
        let error = refused.error(2);
        assert!(error.contains(part), "{error}");
    }
    assert!(!folder.join("never.json").exists());
}
