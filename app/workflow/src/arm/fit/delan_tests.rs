//! `arm fit delan`, and what a learned model is good for: torques of a motion, external torques; recordings that are refused.
#![allow(clippy::unwrap_used)] // a test may stop where it stands

use std::path::{Path, PathBuf};

use hysteron_arm_learning::lagrangian::{LearnedDynamics, Variant, samples_of};
use hysteron_base::Recording;

use super::delan;
use crate::Context;
use crate::arm::{self, estimate};

/// Two joints of 1 kg m² each, uncoupled, the first under gravity: τ = q̈ + (5 sin q_1, 0).
fn text(n: usize, rows: impl Fn(usize, &mut Vec<String>)) -> String {
    let mut text = "time_s,q_1_rad,q_2_rad,dq_1_rad_s,dq_2_rad_s,tau_1_n_m,tau_2_n_m\n".to_owned();
    for i in 0..n {
        let t = i as f64 / 50.0;
        let q = [t.sin(), (0.7 * t).sin()];
        let values = [t, q[0], q[1], t.cos(), 0.7 * (0.7 * t).cos(), 5.0 * q[0].sin() - q[0], -0.49 * q[1]];
        let mut row: Vec<String> = values.iter().map(f64::to_string).collect();
        rows(i, &mut row);
        text.push_str(&row.join(","));
        text.push('\n');
    }
    text
}

fn options(recordings: Vec<PathBuf>, out: PathBuf) -> delan::Options {
    delan::Options {
        recordings,
        out,
        variant: Variant::StructuredLagrangian,
        hidden: 8,
        products: 0,
        squares: 0,
        polish: 0,
        epochs: 60,
        cutoff: 10.0,
        seed: 1,
    }
}

fn write(folder: &Path, name: &str, text: &str) -> PathBuf {
    let path = folder.join(name);
    std::fs::write(&path, text).unwrap();
    path
}

#[test]
fn recordings_that_nothing_can_be_learned_from_are_refused_one_by_one() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("model.safetensors");
    let set = |column: usize, value: &'static str| {
        move |_: usize, row: &mut Vec<String>| value.clone_into(&mut row[column])
    };
    let late = |i: usize, row: &mut Vec<String>| row[0] = (i as f64 / 25.0).to_string();
    let back = |i: usize, row: &mut Vec<String>| {
        if i == 200 {
            row[0] = "3".to_owned();
        }
    };
    let missing = |i: usize, row: &mut Vec<String>| {
        if i == 100 {
            row[2] = "nan".to_owned();
        }
    };
    let cases: [(&str, String, &str); 6] = [
        ("nan.csv", text(400, missing), "line 102: q_2_rad: expected a finite number"),
        ("constant.csv", text(400, set(6, "0.5")), "tau: joint 2: expected values that change"),
        ("rate.csv", text(400, late), "rate: expected 25 Hz, got 50"),
        ("back.csv", text(400, back), "line 202: time_s: expected a time after 3.98 s"),
        ("short.csv", text(12, |_, _| ()), "expected more than 18 samples for the low-pass filter, got 12"),
        ("lacking.csv", text(400, |_, _| ()).replace("tau_2_n_m", "tau_3_n_m"), "of all"),
    ];
    for (name, text, expected) in cases {
        let path = write(folder.path(), name, &text);
        let bad = delan::run(&options(vec![path], out.clone()), &Context::silent("test")).unwrap_err();
        assert!(bad.to_string().contains(expected), "{name}: {bad}");
        assert!(!out.exists(), "{name}");
    }
    let good = write(folder.path(), "good.csv", &text(400, |_, _| ()));
    let other = text(400, |_, row| {
        row.extend(["0.1".to_owned(), "0.2".to_owned(), "0.3".to_owned()]);
    });
    let other = other.replace("tau_2_n_m\n", "tau_2_n_m,q_3_rad,dq_3_rad_s,tau_3_n_m\n");
    let other = write(folder.path(), "three.csv", &other);
    let bad = delan::run(&options(vec![good, other], out.clone()), &Context::silent("test")).unwrap_err();
    assert!(
        bad.to_string().contains("three.csv: recording: expected 2 joints, as in the others, got 3"),
        "{bad}"
    );
    assert!(!out.exists());
}

#[test]
fn squares_and_a_second_order_method_find_digits_that_adam_does_not() {
    let folder = tempfile::tempdir().unwrap();
    let recording = write(folder.path(), "good.csv", &text(2000, |_, _| ()));
    let fitted = |name: &str, products: u32, squares: u32, polish: u32| {
        let plain = options(vec![recording.clone()], folder.path().join(name));
        let options = delan::Options { products, squares, polish, ..plain };
        let found = delan::run(&options, &Context::silent("test")).unwrap();
        assert_eq!(found.steps > 0, polish > 0, "{found:?}");
        found.validation
    };
    let (rough, fine) = (fitted("rough.safetensors", 0, 0, 0), fitted("fine.safetensors", 2, 4, 40));
    assert!(fine < 0.5 * rough, "{fine} {rough}");
}

#[test]
fn a_joint_that_slides_is_learned_as_a_length_and_no_model_takes_the_other_kind() {
    let folder = tempfile::tempdir().unwrap();
    let sliding = |text: &str| {
        let units = [("q_2_rad", "q_2_m"), ("dq_2_rad_s", "dq_2_m_s"), ("tau_2_n_m", "tau_2_n")];
        units.iter().fold(text.to_owned(), |text, (turning, sliding)| {
            let columns = |line: &str| {
                line.split(',')
                    .map(|c| if c == *turning { *sliding } else { c })
                    .collect::<Vec<_>>()
                    .join(",")
            };
            text.lines().map(columns).collect::<Vec<_>>().join("\n")
        })
    };
    // A spring of 1.24 N/m on the second joint, which goes 8 m to either side: no function of sin q and cos q.
    let far = |i: usize, row: &mut Vec<String>| {
        let t = 0.7 * i as f64 / 50.0;
        let (q, dq) = (8.0 * t.sin(), 5.6 * t.cos());
        (row[2], row[4], row[6]) = (q.to_string(), dq.to_string(), (0.75 * q).to_string());
    };
    let turns = write(folder.path(), "turns.csv", &text(2000, far));
    let slides = write(folder.path(), "slides.csv", &sliding(&text(2000, far)));
    let context = Context::silent("test");
    let fitted = |recording: &PathBuf, name: &str| {
        let out = folder.path().join(name);
        let asked = delan::Options { epochs: 150, ..options(vec![recording.clone()], out.clone()) };
        let found = delan::run(&asked, &context).unwrap();
        (out, found.validation)
    };
    let ((angle, bad), (length, good)) = (fitted(&turns, "a.safetensors"), fitted(&slides, "b.safetensors"));
    assert!(good < 0.1 * bad, "{good} {bad}");
    for (model, recording, expected) in [(&angle, &slides, "q_2_rad"), (&length, &turns, "q_2_m")] {
        let samples = samples_of(&Recording::read(recording).unwrap(), 10.0).unwrap();
        let bad = LearnedDynamics::read(model).unwrap().decompose(&samples).unwrap_err();
        assert!(bad.to_string().contains(&format!("expected {expected}, as the model has")), "{bad}");
    }
    let both = options(vec![turns, slides], folder.path().join("c.safetensors"));
    let bad = delan::run(&both, &context).unwrap_err();
    assert!(bad.to_string().contains("expected q_2_rad, as in the others, got q_2_m"), "{bad}");
}

#[test]
fn a_learned_model_gives_torques_for_a_motion_and_finds_what_else_acts() {
    let folder = tempfile::tempdir().unwrap();
    let context = Context::silent("test");
    let recording = write(folder.path(), "good.csv", &text(2000, |_, _| ()));
    let model = folder.path().join("model.safetensors");
    delan::run(&options(vec![recording.clone()], model.clone()), &context).unwrap();

    // The same motion with its accelerations, without torques.
    let motion = text(2000, |i, row| {
        let t = i as f64 / 50.0;
        row[5] = (-t.sin()).to_string();
        row[6] = (-0.49 * (0.7 * t).sin()).to_string();
    });
    let motion = motion.replace("tau_1_n_m,tau_2_n_m", "ddq_1_rad_s2,ddq_2_rad_s2");
    let states = write(folder.path(), "motion.csv", &motion);
    let out = folder.path().join("torques.csv");
    let dynamics = arm::dynamics::Options {
        model: model.display().to_string(),
        robot_options: crate::arm::RobotOptions::default(),
        states,
        out: out.clone(),
        frame: None,
        derivatives: false,
    };
    arm::dynamics::run(&dynamics, &context).unwrap();
    let [found, measured] = [&out, &recording].map(|path| Recording::read(path).unwrap());
    let [found, measured] = [&found, &measured].map(|r| r.require("tau_1_n_m").unwrap().to_vec());
    let mse = found.iter().zip(&measured).map(|(a, b)| (a - b).powi(2)).sum::<f64>() / 2000.0;
    let size = measured.iter().map(|v| v * v).sum::<f64>() / 2000.0;
    assert!(mse < 0.01 * size, "{mse} of {size}");

    // A push of 2 N m on the first joint from 20 s on, which its motor works against.
    let pushed = text(2000, |i, row| {
        if i >= 1000 {
            row[5] = (row[5].parse::<f64>().unwrap() - 2.0).to_string();
        }
    });
    let pushed = write(folder.path(), "pushed.csv", &pushed);
    let out = folder.path().join("external.csv");
    let estimate = estimate::Options {
        actuator: model.clone(),
        recording: Some(pushed.clone()),
        live: None,
        seconds: None,
        out: out.clone(),
        robot: String::new(),
        robot_options: crate::arm::RobotOptions::default(),
        gain: 10.0,
    };
    estimate::run(&estimate, &context).unwrap();
    let external = Recording::read(&out).unwrap();
    let external = external.require("tau_ext_1_n_m").unwrap();
    let mean = |rows: std::ops::Range<usize>| external[rows.clone()].iter().sum::<f64>() / rows.len() as f64;
    assert!((mean(1100..2000) - 2.0).abs() < 0.4 && mean(100..1000).abs() < 0.4, "{}", mean(1100..2000));
    let other = arm::dynamics::Options { derivatives: true, ..dynamics };
    let bad = arm::dynamics::run(&other, &context).unwrap_err().to_string();
    assert!(bad.contains("--derivatives: expected a robot file"), "{bad}");
    let none = estimate::Options { gain: 0.0, ..estimate };
    assert!(
        estimate::run(&none, &context).unwrap_err().to_string().contains("--gain: expected a number > 0")
    );
}
