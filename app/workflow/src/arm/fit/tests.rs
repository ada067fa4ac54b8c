//! `arm fit neural` and `arm evaluate` on small recordings: results, refusals, resuming.
#![allow(clippy::unwrap_used)] // a test may stop where it stands

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};

use hysteron_base::{Channel, Metadata, Recording};
use hysteron_learn::{BlockKind, TemporalForm};

use super::neural;
use crate::arm::evaluate;
use crate::{Context, Progress, ProgressSink, Silent};
use hysteron_arm_learning::neural::MotorModelKind;

const PERIOD: f64 = 0.017;

/// Four joints that follow waves late, without a gripper; a weight is held in the second half.
fn record(folder: &Path, name: &str, phase: f64, leave_out: &str) -> PathBuf {
    let n = 150;
    let time: Vec<f64> = (0..n).map(|i| PERIOD * f64::from(i)).collect();
    let home = [0.0, -0.5, 0.4, 0.6];
    let goal = |k: usize, t: f64| home[k] + 0.3 * (1.5 * t + phase + k as f64).sin();
    let late = 0.05;
    let mut channels = Vec::new();
    let mut add = |name: String, of: &dyn Fn(f64) -> f64| {
        if name != leave_out {
            channels.push(Channel::new(name, time.iter().map(|t| of(*t)).collect()));
        }
    };
    for k in 0..4 {
        add(format!("goal_{}_rad", k + 1), &|t| goal(k, t));
        add(format!("q_{}_rad", k + 1), &|t| goal(k, t - late));
        add(format!("dq_{}_rad_s", k + 1), &|t| 0.45 * (1.5 * (t - late) + phase + k as f64).cos());
        add(format!("current_{}_a", k + 1), &|t| 2.0 * (goal(k, t) - goal(k, t - late)));
        add(format!("voltage_{}_v", k + 1), &|_| 12.0);
        add(format!("temperature_{}_degc", k + 1), &|_| 30.0);
    }
    add("force_z_n".to_owned(), &|t| if t > 1.2 { -2.0 } else { 0.0 });
    add("force_z_labelled_ratio".to_owned(), &|_| 1.0);
    let path = folder.join(name);
    std::fs::create_dir_all(path.parent().unwrap()).unwrap();
    Recording::new(time, channels, Vec::new(), Metadata::default()).unwrap().write(&path).unwrap();
    path
}

/// A data set with the folders of NAD.
fn data_set(folder: &Path) -> PathBuf {
    let root = folder.join("nad");
    for (task, phase) in [("weight/lift_200g", 0.0), ("weight/lift_500g", 0.7)] {
        for (split, shift) in [("train", 0.0), ("validation", 0.2), ("test", 0.4)] {
            record(&root, &format!("{task}/{split}/001.csv"), phase + shift, "");
        }
    }
    root
}

fn options(recordings: Vec<PathBuf>, out: PathBuf) -> neural::Options {
    neural::Options {
        recordings,
        out,
        model: "open-manipulator-x".to_owned(),
        robot_options: crate::arm::RobotOptions::default(),
        leave_out: Vec::new(),
        free: Vec::new(),
        form: TemporalForm::Streaming,
        block: BlockKind::GatedPreNorm,
        width: 16,
        layers: 1,
        warm_start: 150,
        prior: MotorModelKind::None,
        pure: 0.0,
        sensing: neural::SensingForm::Loop,
        sensing_updates: 60,
        updates: 60,
        horizons: vec![16],
        rollouts: 4,
        learning_rate: 1e-3,
        ema: 0.1,
        start_noise: 0.02,
        contact_n: 0.01,
        period_s: PERIOD,
        load_friction: false,
        drive: None,
        armature_kg_m2: None,
        damping_n_m_s_per_rad: None,
        torque_limit_n_m: None,
        seed: 1,
    }
}

fn evaluation(model: PathBuf, recordings: Vec<PathBuf>) -> evaluate::Options {
    let robot = "open-manipulator-x".to_owned();
    evaluate::Options {
        model,
        recordings,
        out: None,
        figures: None,
        robot,
        robot_options: crate::arm::RobotOptions::default(),
        leave_out: Vec::new(),
        free: Vec::new(),
        detectors: Vec::new(),
        cutoff: 10.0,
    }
}

/// Stops after so many questions.
struct Impatient(AtomicUsize);

impl ProgressSink for Impatient {
    fn start(&self, _: &str, _: usize, _: usize) -> Box<dyn Progress> {
        Box::new(Silent)
    }

    fn is_cancelled(&self) -> bool {
        self.0.fetch_sub(1, Ordering::Relaxed) == 0
    }

    fn print(&self, _: &str) {}
}

#[test]
fn an_actuator_is_trained_resumed_and_compared_with_its_baselines() {
    let folder = tempfile::tempdir().unwrap();
    let root = data_set(folder.path());
    let context = Context::silent("test");
    let whole =
        neural::run(&options(vec![root.clone()], folder.path().join("a.safetensors")), &context).unwrap();
    // The fit of the servo asks too; the training is stopped somewhere within its second epoch.
    let progress = Impatient(AtomicUsize::new(0));
    let stopped = (130..).step_by(40).find_map(|patience| {
        progress.0.store(patience, Ordering::Relaxed);
        let context = Context { progress: &progress, ..Context::silent("test") };
        let found = neural::run(&options(vec![root.clone()], folder.path().join("b.safetensors")), &context);
        let is_there = folder.path().join("b.training").exists();
        (is_there || found.is_ok()).then_some(found)
    });
    assert!(stopped.unwrap().unwrap_err().to_string().contains("interrupted"));
    let resumed =
        neural::run(&options(vec![root.clone()], folder.path().join("b.safetensors")), &context).unwrap();
    assert_eq!(resumed.validation_deg, whole.validation_deg);
    assert!(!folder.path().join("b.training").exists());
    let [a, b] =
        ["a", "b"].map(|name| std::fs::read(folder.path().join(format!("{name}.safetensors"))).unwrap());
    assert!(a == b, "the same bytes after an interruption");

    let figures = folder.path().join("figures");
    let model = folder.path().join("a.safetensors");
    let found = evaluate::run(
        &evaluate::Options { figures: Some(figures.clone()), ..evaluation(model, vec![root]) },
        &context,
    )
    .unwrap();
    let evaluate::Outcome::Actuator(found) = found else { panic!("an actuator was evaluated") };
    assert_eq!(found.tasks.len(), 2);
    assert_eq!(found.tasks[0].task, "weight/lift_200g");
    // Only what is called test; half of its samples under force.
    assert_eq!((found.tasks[0].trajectories, found.forces.force.unwrap().samples[0]), (1, 298));
    let [goal, fitted] =
        [&found.mean_deg.copied_goal, &found.mean_deg.fitted_goal].map(|errors| errors.steps_100.unwrap());
    // The goal is late by 50 ms of at most 0.45 rad/s: 0.82° in the mean; a delay of three samples leaves a millisecond.
    assert!((goal - 0.82).abs() < 0.15 && fitted < 0.15 * goal, "{goal} {fitted}");
    assert!(figures.join("report.html").exists() && figures.join("metrics.json").exists());
}

#[test]
fn what_cannot_be_learned_from_is_refused_and_nothing_is_written() {
    let folder = tempfile::tempdir().unwrap();
    let root = data_set(folder.path());
    let out = folder.path().join("out/a.safetensors");
    let refusal =
        |options: &neural::Options| neural::run(options, &Context::silent("test")).unwrap_err().to_string();
    let lacking = record(folder.path(), "lacking.csv", 0.0, "current_2_a");
    let bad = refusal(&options(vec![root.clone(), lacking], out.clone()));
    assert!(bad.contains("lacking.csv") && bad.contains("current_2_a"), "{bad}");
    let alone = record(folder.path(), "alone.csv", 0.0, "");
    let bad = refusal(&options(vec![alone], out.clone()));
    assert!(bad.contains("expected two or more, one of them for validation"), "{bad}");
    let other =
        neural::Options { leave_out: vec!["nad".to_owned()], ..options(vec![root.clone()], out.clone()) };
    assert!(refusal(&other).contains("at least one file"), "{}", refusal(&other));
    let other = neural::Options { period_s: 0.01, ..options(vec![root.clone()], out.clone()) };
    assert!(refusal(&other).contains("steps of 0.01 s"), "{}", refusal(&other));
    let other =
        neural::Options { model: "three-link".to_owned(), ..options(vec![root.clone()], out.clone()) };
    assert!(refusal(&other).contains("robot: expected 4 joints or more, got 3"), "{}", refusal(&other));
    assert!(!out.exists());

    let model = folder.path().join("a.safetensors");
    let small = neural::Options { warm_start: 2, updates: 1, ..options(vec![root.clone()], model.clone()) };
    neural::run(&small, &Context::silent("test")).unwrap();
    let panda =
        evaluate::Options { robot: "panda".to_owned(), ..evaluation(model.clone(), vec![root.clone()]) };
    let bad = evaluate::run(&panda, &Context::silent("test")).unwrap_err().to_string();
    assert!(
        bad.contains("robot: expected joints joint1, joint2, joint3, joint4") && bad.contains("another arm"),
        "{bad}"
    );
    let training = evaluation(model, vec![root.join("weight/lift_200g/train")]);
    let bad = evaluate::run(&training, &Context::silent("test")).unwrap_err().to_string();
    assert!(bad.contains("only recordings in folders train and validation"), "{bad}");
}
