//! `hysteron arm identify` through the built program: numbers that come back, and recordings without
//! information.

use hysteron_base::json;
use std::fmt::Write;
use std::path::Path;

use hysteron_actuator::identify::{Pendulum, PendulumRun, rollout};
use hysteron_actuator::{CatalogueDrive, Drive, Supply};
use hysteron_tests::{Outcome, measured, run};
use serde_json::Value;

/// A recording of one joint: speeds that go up and down, friction with an offset.
fn friction(path: &Path, rows: usize, torque: impl Fn(f64, usize) -> f64) {
    let mut text = String::from("time_s,dq_1_rad_s,tau_1_n_m\n");
    for k in 0..rows {
        let v = 1.2 * (0.021 * k as f64).sin();
        writeln!(text, "{},{v},{}", 0.01 * k as f64, torque(v, k)).unwrap();
    }
    std::fs::write(path, text).unwrap();
}

/// One clear error with all these parts, and exit code 2.
fn refused(outcome: &Outcome, parts: &[&str]) {
    let error = outcome.error(2);
    parts.iter().for_each(|part| assert!(error.contains(part), "no {part:?} in {error}"));
}

fn json(path: &Path) -> Value {
    json::from_text(std::fs::read(path).unwrap()).unwrap()
}

fn value(found: &Value, name: &str) -> f64 {
    let rows = found["estimates"].as_array().unwrap();
    rows.iter().find(|row| row["name"] == name).unwrap()["value"].as_f64().unwrap()
}

#[test]
fn friction_of_a_joint_comes_back_by_every_method_and_its_report_is_there() {
    let place = tempfile::tempdir().unwrap();
    for (name, shift) in [("a.csv", 0), ("b.csv", 7)] {
        // A deterministic ripple in place of noise: no multiple of the path's own period.
        let torque =
            |v: f64, k: usize| 0.4 * v.signum() + 0.25 * v + 0.1 + 0.01 * (1.7 * (k + shift) as f64).sin();
        friction(&place.path().join(name), 900, torque);
    }
    let identify = |more: &[&str]| {
        let words =
            ["arm", "identify", "friction", "a.csv", "b.csv", "--law", "coulomb-viscous", "--folds", "2"];
        run(place.path(), &[&words[..], more].concat())
    };
    for method in ["least-squares", "pso", "de", "anfis"] {
        let out = format!("{method}.json");
        let done = identify(&["--method", method, "--out", &out, "--figures", method, "--png"]).succeeded();
        assert!(done.stdout.contains("coulomb_n_m"), "{}", done.stdout);
        let found = json(&place.path().join(&out));
        // Populations end within a thousandth of their bounds, which are twice the largest torque; the ripple is 0.01.
        assert!((value(&found, "coulomb_n_m") - 0.4).abs() < 0.02, "{method}: {found}");
        assert!((value(&found, "viscous_n_m_s_per_rad") - 0.25).abs() < 0.03, "{method}: {found}");
        assert!((value(&found, "offset_n_m") - 0.1).abs() < 0.02, "{method}: {found}");
        assert_eq!(found["folds_rms_n_m"].as_array().unwrap().len(), 2);
        for file in ["report.html", "metrics.json", "friction.svg", "friction.png", "residuals-speed.svg"] {
            assert!(place.path().join(method).join(file).is_file(), "{method}: no {file}");
        }
    }
    // The same command may do it again; another may not.
    identify(&[
        "--out",
        "least-squares.json",
        "--figures",
        "least-squares",
        "--method",
        "least-squares",
        "--png",
    ]);
    refused(&identify(&["--seed", "3", "--out", "least-squares.json"]), &["least-squares.json"]);
}

#[test]
fn recordings_of_friction_that_say_nothing_are_refused() {
    let place = tempfile::tempdir().unwrap();
    let at = |name: &str| place.path().join(name);
    friction(&at("constant.csv"), 400, |_, _| 0.3);
    friction(&at("good.csv"), 400, |v, _| 0.4 * v.signum() + 0.2 * v);
    std::fs::write(at("empty.csv"), "time_s,dq_1_rad_s,tau_1_n_m\n").unwrap();
    let rows = (0..200).map(|k| 0.01 * f64::from(k)).map(|t| format!("{t},{},{}\n", 0.1 + t, 0.5 + 0.2 * t));
    let one_way = format!("time_s,dq_1_rad_s,tau_1_n_m\n{}", rows.collect::<String>());
    std::fs::write(at("one-way.csv"), one_way).unwrap();
    let check = |words: &[&str], parts: &[&str]| {
        let words = [&["arm", "identify", "friction"], words, &["--out", "out.json"]].concat();
        let (outcome, megabytes) = measured(place.path(), &words);
        refused(&outcome, parts);
        assert!(megabytes < 300, "{megabytes} MB");
        assert!(!at("out.json").exists());
    };
    check(&["constant.csv"], &["torque", "changes", "record"]);
    check(&["empty.csv"], &["empty.csv"]);
    check(&["good.csv", "--joint", "2"], &["--joint", "1 to 1"]);
    check(&["good.csv", "--law", "m4"], &["--law", "coulomb-viscous"]);
    check(&["good.csv", "--method", "magic"], &["--method", "least-squares"]);
    check(&["good.csv", "--folds", "2"], &["--folds", "two or more recordings"]);
    check(&["good.csv", "--huber", "-1"], &["--huber"]);
    check(&["good.csv", "--huber", "0.1", "--method", "pso"], &["--huber"]);
    check(&["one-way.csv", "--method", "anfis"], &["10 or more", "reverse", "both directions"]);
    check(&["missing.csv"], &["missing.csv"]);
    friction(&at("clipped.csv"), 400, |v, _| (0.1 * v.signum() + 0.5 * v).clamp(-0.4, 0.4));
    for (name, part) in [("one-way.csv", "both directions"), ("clipped.csv", "at its limit")] {
        let done =
            run(place.path(), &["arm", "identify", "friction", name, "--out", &format!("{name}.json")]);
        assert!(done.succeeded().stdout.contains(part), "{name}");
    }
    std::fs::copy(at("good.csv"), at("out.json")).unwrap();
    let same = run(place.path(), &["arm", "identify", "friction", "good.csv", "--out", "good.csv"]);
    refused(&same, &["--out", "input"]);
}

/// Joints that swing, with the torques of `torque(joint, q, dq, ddq)`.
fn motion(path: &Path, n_joints: usize, header: &str, torque: impl Fn(usize, [f64; 3]) -> f64) {
    swinging(path, n_joints, header, &[(0.6, 1.0)], |_| 0.0, torque);
}

/// The same along sines of these amplitudes [rad] and multiples of a joint's frequency, with torques that come late by `delay(joint)` [s].
fn swinging(
    path: &Path,
    n_joints: usize,
    header: &str,
    sines: &[(f64, f64)],
    delay: impl Fn(usize) -> f64,
    torque: impl Fn(usize, [f64; 3]) -> f64,
) {
    let mut text = String::from("time_s");
    for stem in ["q_*_rad", "dq_*_rad_s", header] {
        (1..=n_joints).for_each(|k| write!(text, ",{}", stem.replace('*', &k.to_string())).unwrap());
    }
    text.push('\n');
    let state = |j: usize, t: f64| -> [f64; 3] {
        let (w, p) = (1.3 + 0.7 * j as f64, 0.4 * j as f64);
        let mut sums = [0.0; 3];
        for (amplitude, multiple) in sines {
            let w = w * multiple;
            let (sin, cos) = (w * t + p).sin_cos();
            let of = [sin, w * cos, -w * w * sin];
            sums.iter_mut().zip(of).for_each(|(sum, x)| *sum += amplitude * x);
        }
        sums
    };
    for s in 0..800 {
        let t = 0.01 * f64::from(s);
        write!(text, "{t}").unwrap();
        (0..n_joints).for_each(|j| write!(text, ",{}", state(j, t)[0]).unwrap());
        (0..n_joints).for_each(|j| write!(text, ",{}", state(j, t)[1]).unwrap());
        (0..n_joints).for_each(|j| write!(text, ",{}", torque(j, state(j, t - delay(j)))).unwrap());
        text.push('\n');
    }
    std::fs::write(path, text).unwrap();
}

#[test]
fn bodies_are_identified_and_recordings_that_say_nothing_are_refused() {
    let place = tempfile::tempdir().unwrap();
    let at = |name: &str| place.path().join(name);
    let plain = |_: usize, [q, dq, ddq]: [f64; 3]| 2.0 * ddq + 0.3 * dq + 0.5 * dq.signum() + 1.5 * q;
    motion(&at("good.csv"), 3, "tau_*_n_m", plain);
    motion(&at("clipped.csv"), 3, "tau_*_n_m", |j, state| plain(j, state).clamp(-1.0, 1.0));
    motion(&at("two.csv"), 2, "tau_*_n_m", plain);
    motion(&at("current.csv"), 3, "current_*_a", |j, state| plain(j, state) / 2.0);
    motion(&at("milli.csv"), 3, "current_*_a", |j, state| 500.0 * plain(j, state));
    motion(&at("still.csv"), 3, "tau_*_n_m", |_, _| 0.7);
    let identify = |words: &[&str]| {
        let words = [&["arm", "identify", "inertia", "three-link"], words, &["--out", "found.json"]].concat();
        measured(place.path(), &words).0
    };
    let check = |words: &[&str], parts: &[&str]| {
        refused(&identify(words), parts);
        assert!(!at("found.json").exists());
    };
    check(&["clipped.csv"], &["clipped.csv", "tau_1", "saturated", "slower"]);
    check(&["still.csv"], &["still.csv", "tau_1", "not all alike"]);
    check(&["two.csv"], &["two.csv", "3 joints", "--lock"]);
    check(&["current.csv"], &["current.csv", "tau_1_n_m", "torque constants"]);
    check(&["current.csv", "--torque-constants", "1,2"], &["torque constants", "3 finite numbers"]);
    check(&["milli.csv", "--torque-constants", "2,2,2"], &["current_1_a", "mA"]);
    check(&["good.csv", "--hold-out", "0.95"], &["--hold-out"]);
    check(&["good.csv", "--hold-out", "0.3", "--test", "good.csv"], &["--hold-out"]);
    check(&["good.csv", "--lock", "nobody"], &["nobody"]);
    check(&["good.csv", "--prior", "0"], &["prior"]);
    check(&["good.csv", "--cutoff", "-3"], &["--cutoff"]);
    check(&["good.csv", "--robot", "robot.txt"], &["--robot", ".urdf"]);
    identify(&["good.csv", "--hold-out", "0.3", "--figures", "report", "--robot", "robot.xml"]).succeeded();
    let info = run(place.path(), &["arm", "info", "robot.xml"]).succeeded().stdout;
    assert!(info.contains("3 joints"), "{info}");
    let found = json(&at("found.json"));
    assert_eq!(found["test_rms_n_m"].as_array().unwrap().len(), 3);
    // Offset and gravity of joints that swing about zero, spring and gravity: named, not hidden.
    assert!(found["estimates"].as_array().unwrap().iter().any(|row| row["note"] != ""));
    for file in
        ["friction.svg", "measured-predicted.svg", "residuals.svg", "residuals-speed.svg", "terms.svg"]
    {
        assert!(at("report").join(file).is_file(), "no {file}");
    }
    assert!(found["response"].is_null());
    // Torques of joint 2 as they were 20 ms ago.
    let sines = [(0.6, 1.0), (0.2, 2.7), (0.1, 4.6)];
    swinging(&at("late.csv"), 3, "tau_*_n_m", &sines, |j| if j == 1 { 0.02 } else { 0.0 }, plain);
    identify(&["late.csv", "--hold-out", "0.3", "--response", "--overwrite"]).succeeded();
    let found = json(&at("found.json"));
    let list = |value: &Value| -> Vec<f64> {
        value.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect()
    };
    let response = &found["response"];
    let lead = list(&response["lead_s"]);
    // Bodies that were fitted to late torques have taken a part of it.
    assert!((-0.02..-0.005).contains(&lead[1]), "{lead:?}");
    assert!(lead[0].abs() < 1e-3 && lead[2].abs() < 1e-3, "{lead:?}");
    let [with, without] = [&response["test_rms_n_m"], &found["test_rms_n_m"]].map(list);
    assert!(with[1] < 0.9 * without[1], "{with:?} {without:?}");
    run(
        place.path(),
        &["arm", "identify", "inertia", "three-link", "good.csv", "--out", "found.json", "--overwrite"],
    )
    .succeeded();
    let from_currents = [
        "arm",
        "identify",
        "inertia",
        "three-link",
        "current.csv",
        "--torque-constants",
        "2,2,2",
        "--out",
        "by.json",
    ];
    run(place.path(), &from_currents).succeeded();
    let [a, b] = ["found.json", "by.json"].map(|name| value(&json(&at(name)), "coulomb_1_n_m"));
    assert!((a - b).abs() < 0.1, "{a} {b}");
}

/// A log of bam: what the XL330 of the catalogue does at this gain with a weight on a rod when its goal swings, or is constant.
fn log(path: &Path, swings: bool, gain: f64) {
    let entry = CatalogueDrive::named("xl330-m288").unwrap();
    let drive = Drive { supply: Supply { voltage: 7.3, ..entry.drive.supply }, ..entry.drive };
    let time: Vec<f64> = (0..400).map(|k| 0.01 * f64::from(k)).collect();
    let goal: Vec<f64> = time.iter().map(|t| if swings { 1.1 * (1.3 * t).sin() } else { 0.0 }).collect();
    let run = PendulumRun {
        name: "simulated".into(),
        position: vec![0.0; time.len()],
        torque_on: vec![true; time.len()],
        temperature: 28.0,
        gain,
        pendulum: Pendulum { mass: 0.49, length: 0.1, offset: 0.0 },
        time,
        goal,
    };
    let position = rollout(&drive, 0.0, &run, 1e-3).position;
    let entry = |k: usize| {
        let speed = (position[k] - position[k.saturating_sub(1)]) / 0.01;
        hysteron_base::json!({"position": position[k], "speed": speed, "load": 0, "input_volts": 7.3, "temp": 28,
            "timestamp": run.time[k], "goal_position": run.goal[k], "torque_enable": true})
    };
    let entries: Vec<Value> = (0..run.time.len()).map(entry).collect();
    let log = hysteron_base::json!({"mass": 0.49, "length": 0.1, "kp": gain, "vin": 7.4, "motor": "xl330", "entries": entries});
    std::fs::write(path, log.to_string()).unwrap();
}

#[test]
fn a_servo_is_identified_and_wrong_drives_are_refused() {
    let place = tempfile::tempdir().unwrap();
    let at = |name: &str| place.path().join(name);
    log(&at("swing.json"), true, 400.0);
    log(&at("still.json"), false, 400.0);
    let servo = |words: &[&str]| {
        let words = [&["arm", "identify", "servo"], words, &["--out", "servo.json"]].concat();
        measured(place.path(), &words).0
    };
    let check = |words: &[&str], parts: &[&str]| {
        refused(&servo(words), parts);
        assert!(!at("servo.json").exists());
    };
    check(&["still.json"], &["still.json", "position", "motion"]);
    check(&["swing.json", "--drive", "xl999"], &["--drive", "xl330-m288"]);
    check(&["swing.json", "--law", "m9"], &["--law", "m6"]);
    check(&["swing.json", "--mass-kg", "-1"], &["--mass-kg"]);
    check(&["swing.json", "--step", "1"], &["--step"]);
    std::fs::write(at("drive.toml"), "format = \"hysteron-drive\"\nversion = 1\nname = \"x\"\n").unwrap();
    check(&["swing.json", "--drive", "drive.toml"], &["drive.toml", "source"]);
    friction(&at("friction.csv"), 300, |v, _| v);
    check(&["friction.csv"], &["friction.csv", "goal_1_rad"]);
    let whole = ["swing.json", "--figures", "report", "--drive-out", "found.toml"];
    servo(&whole).succeeded();
    // The same command makes the same again; another leaves the file alone.
    servo(&whole).succeeded();
    refused(
        &servo(&["swing.json", "--step", "0.002", "--drive-out", "found.toml"]),
        &["found.toml", "made by"],
    );
    let found = json(&at("servo.json"));
    // What is written is read, and is the drive that was found.
    let written = CatalogueDrive::parse(&std::fs::read_to_string(at("found.toml")).unwrap()).unwrap();
    let constant = value(&found, "torque_constant_n_m_per_a");
    assert!((written.drive.motor.torque_constant() / constant - 1.0).abs() < 1e-12);
    assert!(written.source.contains("arm identify servo swing.json"), "{}", written.source);
    // The fit starts at the drive that made the log.
    assert!(found["error_rad"].as_f64().unwrap() < 2e-3, "{found}");
    for file in
        ["motion-1.svg", "friction.svg", "drive-backdrive.svg", "parameters.svg", "residuals-speed.svg"]
    {
        assert!(at("report").join(file).is_file(), "no {file}");
    }
}

const PENDULUM: &str = include_str!("../../../arm/learning/tests/data/pendulum.urdf");

#[test]
fn logs_without_currents_at_two_gains_become_a_neural_actuator() {
    let place = tempfile::tempdir().unwrap();
    let at = |name: &str| place.path().join(name);
    std::fs::write(at("pendulum.urdf"), PENDULUM).unwrap();
    let import = |name: &str, more: &[&str]| {
        let (log, out) = (format!("{name}.json"), format!("{name}.csv"));
        run(place.path(), &[&["import", &log, "--out", &out, "--map", "bam-feetech"], more].concat())
    };
    for (name, gain) in [("a", 200.0), ("b", 400.0), ("c", 300.0)] {
        log(&at(&format!("{name}.json")), true, gain);
    }
    let fit = |prior: &str, more: &[&str]| {
        let words = format!(
            "arm fit neural a.csv b.csv --model pendulum.urdf --period-s 0.01 --prior {prior} --width 8 --layers 1 --warm-start 0 \
             --updates 2 --horizons 16 --rollouts 2 --torque-limit-n-m 0.63 --out {prior}.safetensors"
        );
        let words: Vec<&str> = words.split_whitespace().collect();
        run(place.path(), &[&words[..], more].concat())
    };
    import("a", &[]).succeeded();
    import("b", &[]).succeeded();
    refused(&fit("servo", &[]), &["a.csv", "current_1_a"]);
    refused(&import("c", &["--drive", "xl999"]), &["--drive", "xl330-m288"]);
    for name in ["a", "b", "c"] {
        import(name, &["--drive", "xl330-m288", "--overwrite"]).succeeded();
    }
    refused(&fit("servo", &["--armature-kg-m2", "0"]), &["armature", "kg m²"]);
    refused(&fit("servo", &["--drive", "xl330-m288"]), &["--drive", "--prior drive"]);
    fit("servo", &["--armature-kg-m2", "0.0024"]).succeeded();
    let errors = |actuator: &str| {
        let out = format!("{actuator}.json");
        let asked = ["arm", "evaluate", actuator, "c.csv", "--robot", "pendulum.urdf", "--out", &out];
        run(place.path(), &asked).succeeded();
        let found = &json(&at(&out))["mean_deg"];
        ["servo identified by rollout", "copy the goal"].map(|method| found[method]["300"].as_f64().unwrap())
    };
    // A gain between those of the training: the servo knows what a third more of it does, the goal knows nothing.
    let [servo, goal] = errors("servo.safetensors");
    assert!(servo < 0.5 * goal, "{servo} {goal}");

    refused(&fit("drive", &[]), &["--drive"]);
    refused(&fit("drive", &["--drive", "xm430-w350"]), &["gear.backlash_deg", "0.25"]);
    let mut drive = CatalogueDrive::named("xl330-m288").unwrap();
    drive.drive.supply.voltage = 7.3;
    std::fs::write(at("drive.toml"), String::from(drive)).unwrap();
    fit("drive", &["--drive", "drive.toml"]).succeeded();
    // The drive that made the logs: what is left is steps and filters of the import.
    let [drive, _] = errors("drive.safetensors");
    assert!(drive < 0.1 * servo, "{drive} {servo}");
    let text = std::fs::read_to_string(at("a.csv")).unwrap();
    assert!(text.contains("position_gain"));
    std::fs::write(at("a.csv"), text.replace("position_gain", "position_gone")).unwrap();
    std::fs::remove_file(at("b.csv")).unwrap();
    std::fs::copy(at("a.csv"), at("b.csv")).unwrap();
    refused(&fit("drive", &["--drive", "drive.toml", "--overwrite"]), &["a.csv", "position_gain"]);
}
