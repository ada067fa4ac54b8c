//! Health of servos in `hysteron record` and `hysteron track`: the faults of a worn virtual rig are reported,
//! and of a sound one none.

use hysteron_base::json;
use std::path::Path;

use hysteron_tests::{root, run};
use serde_json::Value;

/// Friction and play of the preset `typical`, as its file has them.
const COULOMB: &str = "coulomb_friction_n_m = 0.045";
const PLAY: &str = "play_mm = 0.10";
/// That friction as a part of the full load, which is stall torque 1.4 and friction at standstill [%].
const SOUND: f64 = 100.0 * 0.045 / 1.445;

/// Writes a rig like `typical` with another friction and play.
fn rig(folder: &Path, name: &str, friction: f64, play: f64) -> String {
    let text = std::fs::read_to_string(root().join("rig/virtual/presets/typical.toml")).unwrap();
    assert!(text.contains(COULOMB) && text.contains(PLAY));
    let text = text.replace(COULOMB, &format!("coulomb_friction_n_m = {friction}"));
    let breakaway = "breakaway_friction_n_m = ";
    let at = text.find(breakaway).unwrap() + breakaway.len();
    let end = at + text[at..].find(|c: char| !(c.is_ascii_digit() || c == '.')).unwrap();
    let before: f64 = text[at..end].parse().unwrap();
    let text = format!("{}{}{}", &text[..at], before + friction - 0.045, &text[end..]);
    let file = format!("{name}.toml");
    std::fs::write(folder.join(&file), text.replace(PLAY, &format!("play_mm = {play}"))).unwrap();
    format!("virtual:{file}")
}

/// Health as `record` of the plan `quick` has it in its metrics.
fn record(folder: &Path, rig: &str, seed: &str, out: &str, baseline: &[&str]) -> Vec<Value> {
    let record = ["record", "--rig", rig, "--plan", "quick", "--seed", seed, "--out", out];
    run(folder, &[&record[..], baseline].concat()).succeeded();
    let metrics = std::fs::read(folder.join(out).join("metrics.json")).unwrap();
    let metrics: Value = json::from_text(&metrics).unwrap();
    metrics["health"]["servos"].as_array().unwrap().clone()
}

fn estimate(servo: &Value, path: &str) -> [f64; 2] {
    ["value", "standard_error"].map(|key| {
        let found = servo.pointer(&format!("/{path}/{key}")).and_then(Value::as_f64);
        found.unwrap_or_else(|| panic!("no {path}: {servo}"))
    })
}

#[test]
fn worn_servos_are_distinguished_from_sound_ones_and_quantified() {
    let place = tempfile::tempdir().unwrap();
    let folder = place.path();
    record(folder, "virtual:typical", "1", "before", &[]);
    let baseline = ["--baseline", "before/metrics.json"];
    let condition = |servo: &Value| servo["condition"].as_f64().unwrap();

    // Sound: other noise, the same servos. Nothing is worn.
    let mut conditions = Vec::new();
    for seed in ["2", "3", "4", "5"] {
        let servos = record(folder, "virtual:typical", seed, &format!("sound-{seed}"), &baseline);
        assert_eq!(servos.len(), 4);
        conditions.extend(servos.iter().map(condition));
        for servo in &servos {
            // Beyond noise: the ripple of the goals lowers the viscous part by 2.8 % (docs/actuator.md), 0.13 % of full load, and not in
            // proportion to the speed alone.
            for direction in ["pulling", "releasing"] {
                let [percent, error] = estimate(servo, &format!("friction_{direction}_percent"));
                assert!((percent - SOUND).abs() < 4.0 * error + 0.03, "{direction}: {servo}");
            }
            assert!(servo["temperature_max_degc"].as_f64().unwrap() >= 20.0);
        }
    }
    let least = conditions.iter().copied().fold(1.0, f64::min);
    assert!(least > 0.05, "false alarms: {conditions:.3?}");

    // Half again as much friction.
    let worn = rig(folder, "rubs", 1.5 * 0.045, 0.10);
    for servo in &record(folder, &worn, "2", "rubs", &baseline) {
        assert!(condition(servo) < 0.05, "{servo}");
        for direction in ["pulling", "releasing"] {
            let [change, error] = estimate(servo, &format!("change/friction_{direction}_percent"));
            // A load of 1 is more torque too: friction at standstill is overcome.
            let truth = 100.0 * 1.5 * 0.045 / (1.445 + 0.5 * 0.045) / SOUND - 1.0;
            assert!((change - truth).abs() < 4.0 * error && error < 0.1, "{direction}: {servo}");
        }
    }

    // Gaps wider by 0.3 mm each. Their mean is observable from the tip; tendons that are opposite share their
    // lag, so that one alone may have half of it.
    let worn = rig(folder, "plays", 0.045, 0.40);
    let before: Value = json::from_text(std::fs::read(folder.join("before/metrics.json")).unwrap()).unwrap();
    let servos = record(folder, &worn, "2", "plays", &baseline);
    let lost = |servo: &Value| estimate(servo, "lost_motion_mm")[0];
    let grown = |k: usize| lost(&servos[k]) - lost(&before["health"]["servos"][k]);
    let grown: Vec<f64> = (0..4).map(grown).collect();
    assert!((grown.iter().sum::<f64>() / 4.0 - 0.3).abs() < 0.05, "{grown:?}");
    assert!(servos.iter().filter(|servo| condition(servo) < 0.05).count() >= 2, "{servos:?}");

    // The report has it, and a baseline by identify-servo is one of friction.
    let page = std::fs::read_to_string(folder.join("plays/report.html")).unwrap();
    assert!(page.contains("Lost motion [mm]") && page.contains("Condition"));
    let identify = ["identify-servo", "before", "--stall-torque", "1.445", "--out", "servos.json"];
    run(folder, &identify).succeeded();
    let servos = record(folder, "virtual:rubs.toml", "3", "again", &["--baseline", "servos.json"]);
    assert!(servos.iter().all(|servo| condition(servo) < 0.05), "{servos:?}");
}

#[test]
fn a_wrong_baseline_is_refused_before_anything_moves() {
    let place = tempfile::tempdir().unwrap();
    let folder = place.path();
    let strokes =
        ["record", "--rig", "virtual:typical", "--plan", "quick", "--only", "circle", "--out", "one"];
    run(folder, &strokes).succeeded();
    let refused = |file: &str, text: &str| {
        std::fs::write(folder.join(file), text).unwrap();
        let out = ["--out", "never", "--baseline", file];
        let outcome = run(folder, &[&strokes[..7], &out[..]].concat());
        assert!(!folder.join("never").exists());
        outcome.error(2).to_owned()
    };
    assert!(refused("a.json", "{}").contains("identify-servo"));
    assert!(refused("b.json", "no").contains("b.json"));
    let servo = "{\"servo\": 2, \"estimates\": []}";
    assert!(refused("c.json", &format!("{{\"servos\": [{servo}]}}")).contains("from 1 on"));
    let few = "{\"health\": {\"servos\": [{}]}}";
    std::fs::write(folder.join("d.json"), few).unwrap();
    let outcome = run(folder, &[&strokes[..7], &["--out", "never", "--baseline", "d.json"][..]].concat());
    assert!(outcome.error(2).contains("a baseline of 4 servos"), "{}", outcome.stderr);
}
