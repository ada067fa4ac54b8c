//! Forces without sensors, from the virtual rig to the report.

use std::fmt::Write as _;
use std::path::Path;

use hysteron_base::{Recording, json};
use hysteron_tests::{root, run};

/// Strokes [mm] of moves and holds around the circle of directions: 1.4 s to each place, 0.6 s there.
fn write_strokes(path: &Path, seconds: u32) {
    let mut text = "time_s,stroke_1_mm,stroke_2_mm,stroke_3_mm,stroke_4_mm\n".to_owned();
    let place = |k: u32| {
        let is_rest = k == 0 || k >= seconds / 2 - 1;
        let (angle, radius) = (2.4 * f64::from(k), if is_rest { 0.0 } else { 4.0 + f64::from(k % 3) * 0.5 });
        [radius * angle.cos(), radius * angle.sin()]
    };
    for i in 0..=100 * seconds {
        let (k, part) = (i / 200, (f64::from(i % 200) / 140.0).min(1.0));
        let part = part * part * (3.0 - 2.0 * part);
        let [a, b] = std::array::from_fn(|c| place(k)[c] + part * (place(k + 1)[c] - place(k)[c]));
        writeln!(text, "{},{a},{b},{},{}", f64::from(i) / 100.0, -a, -b).unwrap();
    }
    std::fs::write(path, text).unwrap();
}

/// Pushes of half a newton for a second, every five.
fn write_pushes(path: &Path, seconds: u32) {
    let mut text = "time_s,tip_force_x_n,tip_force_y_n,tip_force_z_n\n0,0,0,0\n".to_owned();
    for k in 0..seconds / 5 {
        let angle = 1.1 * f64::from(k);
        let begin = f64::from(5 * k) + 2.8;
        writeln!(text, "{begin},{},{},0\n{},0,0,0", 0.5 * angle.cos(), 0.5 * angle.sin(), begin + 1.0)
            .unwrap();
    }
    std::fs::write(path, text).unwrap();
}

#[test]
fn a_robot_without_force_sensors_estimates_tensions_and_pushes() {
    let place = tempfile::tempdir().unwrap();
    let folder = place.path();
    write_strokes(&folder.join("strokes.csv"), 60);
    write_pushes(&folder.join("pushes.csv"), 60);
    std::fs::write(folder.join("none.csv"), "time_s,tip_force_x_n,tip_force_y_n,tip_force_z_n\n0,0,0,0\n")
        .unwrap();
    let record = |force: &str, seed: &str, out: &str| {
        let what = ["record", "--rig", "virtual:typical", "--strokes", "strokes.csv", "--tip-force", force];
        run(folder, &[&what[..], &["--seed", seed, "--out", out]].concat()).succeeded();
    };
    record("none.csv", "1", "free.parquet");
    record("pushes.csv", "2", "known.parquet");
    record("pushes.csv", "3", "pushed.parquet");
    let scene = root().join("meshes/tpu80/scene-typical-friction.toml");
    let scene = scene.to_str().unwrap();
    // The scale of the loads from tensions that are known, of servos that stall at 1.4 N m beyond 0.045 N m of friction.
    run(folder, &["identify-servo", "free.parquet", "--out", "servos.json"]).succeeded();
    let fit = ["fit-sensor", scene, "free.parquet", "known.parquet"];
    run(folder, &[&fit[..], &["--servos", "servos.json", "--out", "sensor.json"]].concat()).succeeded();
    let sensor: serde_json::Value =
        json::from_text(std::fs::read(folder.join("sensor.json")).unwrap()).unwrap();
    let scale = sensor["sensor"]["servo"]["stall_torque_n_m"].as_f64().unwrap();
    assert!((scale / 1.445 - 1.0).abs() < 0.01, "{scale}");
    let wrong = run(folder, &[&fit[..], &["--servos", "sensor.json", "--out", "other.json"]].concat());
    assert!(wrong.error(2).contains("load_scale_n_m"), "{}", wrong.stderr);
    let sense = ["sense", scene, "pushed.parquet", "--sensor", "sensor.json"];
    let sensed = run(
        folder,
        &[&sense[..], &["--out", "estimates.parquet", "--figures", "estimates", "--json"]].concat(),
    )
    .succeeded();
    let value: serde_json::Value = json::from_text(&sensed.stdout).unwrap();
    let tension = |method: &str| {
        let rows = value["scores"]["tensions"].as_array().unwrap();
        let row = rows.iter().find(|row| row["method"] == method).unwrap();
        row["all"].as_f64().unwrap()
    };
    // Friction of servos hides more than half of a tension; with the twin the estimate is good to a tenth.
    assert!(tension("load alone") > 0.3, "{value}");
    assert!(tension("servos and twin") < 0.1, "{value}");
    assert!(tension("servos and twin") < tension("twin, forces scaled"), "{value}");
    let contacts = &value["scores"]["contacts"];
    assert_eq!(contacts["contacts"], 12);
    // A push of 0.5 N moves the tip by 2 mm or more, the twin without a network is off by half a millimetre.
    assert!(contacts["found_at_once"].as_f64().unwrap() > 0.8, "{value}");
    let pushed = Recording::read(folder.join("estimates.parquet")).unwrap();
    for name in [
        "tension_4_n",
        "tension_error_4_n",
        "tip_force_x_n",
        "tip_force_error_x_n",
        "free_tip_z_m",
        "contact",
    ] {
        assert!(pushed.channel(name).is_some(), "{name}");
    }
    assert!(folder.join("estimates/force.svg").exists() && folder.join("estimates/report.html").exists());

    senses_while_recording(folder, scene, &pushed);

    // The sensor belongs to its robot.
    let other = root().join("meshes/tpu80/scene-typical.toml");
    let refused = run(
        folder,
        &[
            "sense",
            other.to_str().unwrap(),
            "pushed.parquet",
            "--sensor",
            "sensor.json",
            "--out",
            "a.parquet",
        ],
    );
    assert_eq!(refused.code, Some(2), "{}", refused.stderr);
    assert!(refused.stderr.contains("sensor.json: scene_sha256"), "{}", refused.stderr);
    let text = std::fs::read_to_string(folder.join("sensor.json")).unwrap();
    std::fs::write(folder.join("damaged.json"), text.replace("\"length_m\": ", "\"length_m\": -")).unwrap();
    let refused =
        run(folder, &["sense", scene, "pushed.parquet", "--sensor", "damaged.json", "--out", "a.parquet"]);
    assert_eq!(refused.code, Some(2), "{}", refused.stderr);
    assert!(refused.stderr.contains("tip.length_m: expected a finite number > 0"), "{}", refused.stderr);
    // Pushes alone carry no information on motion without contact.
    let refused = run(folder, &["fit-sensor", scene, "known.parquet", "--out", "b.json"]);
    assert_eq!(refused.code, Some(2), "{}", refused.stderr);
    assert!(refused.stderr.contains("at least one without contact"), "{}", refused.stderr);
    assert!(!folder.join("a.parquet").exists() && !folder.join("b.json").exists());
}

/// Times at which a contact begins or ends, of the log next to a recording [s].
fn contacts(log: &Path) -> Vec<f64> {
    let text = std::fs::read_to_string(log).unwrap();
    let events = text.lines().map(|line| json::from_text::<serde_json::Value>(line).unwrap());
    let times = events.filter(|event| event["kind"] == "contact").map(|event| {
        let message = event["message"].as_str().unwrap();
        let time = message.split(" at ").nth(1).unwrap().split(" s").next().unwrap();
        time.parse::<f64>().unwrap()
    });
    times.collect()
}

/// Estimates while recording are those from the recording (`estimates`), and the recording ends where that was
/// asked for.
fn senses_while_recording(folder: &Path, scene: &str, estimates: &Recording) {
    let record = |out: &str, more: &[&str]| {
        let what =
            ["record", "--rig", "virtual:typical", "--strokes", "strokes.csv", "--tip-force", "pushes.csv"];
        let sensor = ["--seed", "3", "--out", out, "--sensor", "sensor.json", "--scene", scene];
        run(folder, &[&what[..], &sensor, more].concat())
    };
    record("live.parquet", &[]).succeeded();
    let live = Recording::read(folder.join("live.parquet")).unwrap();
    let alone = Recording::read(folder.join("pushed.parquet")).unwrap();
    assert_eq!(live.channels(), alone.channels());
    let (time, contact) = (estimates.time(), estimates.channel("contact").unwrap());
    let changes = (0..contact.len()).filter(|&i| contact[i] != if i == 0 { 0.0 } else { contact[i - 1] });
    let expected: Vec<f64> = changes.map(|i| time[i]).collect();
    let found = contacts(&folder.join("live.events.jsonl"));
    assert!(found.len() >= 12, "{found:?}");
    // Times in messages have two decimals. The last rows come when the robot is back at rest already.
    assert!(found.iter().zip(&expected).all(|(a, b)| (a - b).abs() < 0.0051), "{found:?} {expected:?}");
    assert!(expected.len() - found.len() <= 1, "{found:?} {expected:?}");

    let begin = expected[0];
    for (name, more, why, last) in [
        ("contact", &["--stop-on-contact"][..], "contact at ", begin),
        ("tension", &["--tension-max", "1"][..], "tension: expected at most 1.0 N, estimated ", begin),
    ] {
        let stopped = record(&format!("{name}.parquet"), more);
        assert_eq!(stopped.code, Some(1), "{}", stopped.stderr);
        assert!(stopped.stderr.contains(why), "{}", stopped.stderr);
        assert!(!folder.join(format!("{name}.parquet")).exists());
        let part = Recording::read(folder.join(format!("{name}.partial-1.parquet"))).unwrap();
        let end = *part.time().last().unwrap();
        // A row waits for the pose after it, 25 ms at 40 Hz.
        assert!(end < last + 0.06, "{name}: {end} after {last}");
        let log = std::fs::read_to_string(folder.join(format!("{name}.events.jsonl")))
            .or_else(|_| std::fs::read_to_string(folder.join(format!("{name}.partial-1.events.jsonl"))))
            .unwrap();
        assert!(log.contains("torque off"), "{log}");
    }
    for (more, place) in
        [(&["--tension-max", "0"][..], "--tension-max"), (&["--residual", "sensor.json"][..], "sensor.json")]
    {
        let refused = record("refused.parquet", more);
        assert_eq!(refused.code, Some(2), "{}", refused.stderr);
        assert!(refused.stderr.contains(place), "{}", refused.stderr);
    }
    let alone = ["record", "--rig", "virtual:mild", "--strokes", "strokes.csv", "--out", "refused.parquet"];
    let refused = run(folder, &[&alone[..], &["--stop-on-contact"]].concat());
    assert_eq!(refused.code, Some(2), "{}", refused.stderr);
    assert!(refused.stderr.contains("--sensor"), "{}", refused.stderr);
    assert!(!folder.join("refused.parquet").exists());
}

#[test]
fn only_a_virtual_tip_is_pushed_and_by_a_force_that_is_there() {
    let place = tempfile::tempdir().unwrap();
    write_strokes(&place.path().join("strokes.csv"), 3);
    std::fs::write(place.path().join("half.csv"), "time_s,tip_force_x_n\n0,0.1\n").unwrap();
    let record =
        ["record", "--strokes", "strokes.csv", "--out", "out.parquet", "--tip-force", "half.csv", "--rig"];
    let refused = run(place.path(), &[&record[..], &["virtual:mild"]].concat());
    assert_eq!(refused.code, Some(2), "{}", refused.stderr);
    assert!(refused.stderr.contains("expected a channel tip_force_y_n"), "{}", refused.stderr);
    assert!(!place.path().join("out.parquet").exists());
}
