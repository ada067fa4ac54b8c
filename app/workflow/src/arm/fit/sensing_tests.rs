//! `--prior servo --sensing observer`, `arm evaluate` and `arm estimate` on recordings of the virtual arm.
#![allow(clippy::unwrap_used)] // a test may stop where it stands

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

use hysteron_arm_learning::neural::{MotorModelKind, TaskScores};
use hysteron_base::{Metadata, Recording};
use hysteron_learn::{BlockKind, TemporalForm};
use hysteron_virtual_rig::virtual_arm::{VirtualArm, data_set};

use super::neural;
use crate::arm::{estimate, evaluate};
use crate::{Context, Progress, ProgressSink, Silent};

/// Two trajectories to learn from and one of each other kind, of three tasks.
fn recorded(root: &Path) {
    let arm = VirtualArm::preset("open-manipulator-x").unwrap().individual(3);
    let tasks = ["circular_cw", "pick_place_empty", "pick_place_object_300g", "pick_place_empty_degraded"];
    for one in data_set().into_iter().filter(|one| one.number <= 2 && tasks.contains(&one.task.as_str())) {
        let path = root.join(format!("{}.parquet", one.name()));
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        arm.record(&one.trial, 3, &one.name(), Metadata::default()).unwrap().write(&path).unwrap();
    }
}

fn options(recordings: PathBuf, out: PathBuf) -> neural::Options {
    neural::Options {
        recordings: vec![recordings],
        out,
        model: "open-manipulator-x".to_owned(),
        robot_options: crate::arm::RobotOptions::default(),
        leave_out: Vec::new(),
        free: vec!["force_unlabeled".to_owned()],
        form: TemporalForm::Streaming,
        block: BlockKind::GatedPreNorm,
        width: 8,
        layers: 1,
        warm_start: 0,
        prior: MotorModelKind::Servo,
        pure: 0.5,
        sensing: neural::SensingForm::Observer,
        sensing_updates: 30,
        updates: 4,
        horizons: vec![16],
        rollouts: 4,
        learning_rate: 1e-3,
        ema: 0.1,
        start_noise: 0.02,
        contact_n: 0.3,
        period_s: 0.017,
        load_friction: false,
        drive: None,
        armature_kg_m2: None,
        damping_n_m_s_per_rad: None,
        torque_limit_n_m: None,
        seed: 1,
    }
}

/// Asks for an end as soon as the second network is trained.
struct EndsBetween(AtomicBool);

impl ProgressSink for EndsBetween {
    fn start(&self, of: &str, _: usize, _: usize) -> Box<dyn Progress> {
        self.0.fetch_or(of.contains("force"), Ordering::Relaxed);
        Box::new(Silent)
    }

    fn is_cancelled(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }

    fn print(&self, _: &str) {}
}

#[test]
fn an_actuator_that_is_interrupted_between_its_networks_is_not_written_and_resumes() {
    let folder = tempfile::tempdir().unwrap();
    let root = folder.path().join("nad");
    recorded(&root);
    let model = folder.path().join("a.safetensors");
    let asked = options(root, model.clone());
    let progress = EndsBetween(AtomicBool::new(false));
    let context = Context { progress: &progress, ..Context::silent("test") };
    let error = neural::run(&asked, &context).unwrap_err().to_string();
    let training = folder.path().join("a.training");
    assert!(error.starts_with("interrupted; nothing is written"), "{error}");
    assert!(error.ends_with(&format!("goes on from {}", training.display())), "{error}");
    assert!(!model.exists() && training.exists());
    let context = Context::silent("test");
    neural::run(&asked, &context).unwrap();
    assert!(!training.exists());
    let resumed = std::fs::read(&model).unwrap();
    std::fs::remove_file(&model).unwrap();
    neural::run(&asked, &context).unwrap();
    assert!(std::fs::read(&model).unwrap() == resumed, "the same bytes after an interruption");
}

#[test]
fn an_actuator_with_servo_and_observer_is_fitted_evaluated_and_streams() {
    let folder = tempfile::tempdir().unwrap();
    let root = folder.path().join("nad");
    recorded(&root);
    let context = Context::silent("test");
    let model = folder.path().join("a.safetensors");
    let fitted = neural::run(&options(root.clone(), model.clone()), &context).unwrap();
    assert!(fitted.sensing_validation.unwrap() > 0.0);
    assert!(!folder.path().join("a.sensing-training").exists());

    let test = root.join("weight/pick_place_object_300g/test/001.parquet");
    let robot = "open-manipulator-x".to_owned();
    let asked = evaluate::Options {
        model: model.clone(),
        recordings: vec![root.clone()],
        out: None,
        figures: Some(folder.path().join("figures")),
        robot: robot.clone(),
        robot_options: crate::arm::RobotOptions::default(),
        leave_out: Vec::new(),
        free: vec!["force_unlabeled".to_owned()],
        detectors: Vec::new(),
        cutoff: 10.0,
    };
    let found = evaluate::run(&asked, &context).unwrap();
    let evaluate::Outcome::Actuator(found) = found else { panic!("an actuator was evaluated") };
    let [network, servo] =
        [&found.mean_deg.network, &found.mean_deg.servo].map(|errors| errors.steps_300.unwrap());
    // Four updates: hardly more than the servo that it begins with.
    assert!(network < 1.2 * servo, "{network} {servo}");
    // Five motors are simulated: that of the gripper too, by every method.
    for (k, name) in hysteron_arm_learning::neural::METHODS.iter().enumerate() {
        let own = found.mean_gripper_mm.values()[k].steps_300.unwrap();
        let of_task = |task: &TaskScores| task.poses.values()[k].steps_300.gripper_mm.unwrap();
        let mean = found.tasks.iter().map(of_task).sum::<f64>() / found.tasks.len() as f64;
        assert!(mean > 0.0 && (own - mean).abs() < 1e-12, "{name} {mean}");
        assert!(mean < 5.0, "{name}: {mean} mm of some 20");
    }
    let [network, linear, drive, pure] = found.forces.values();
    for scores in [network, linear, drive] {
        assert!(scores.unwrap().loaded_axis_n > 0.0, "{scores:?}");
    }
    let page = std::fs::read_to_string(folder.path().join("figures/report.html")).unwrap();
    assert!(page.contains("joints [deg] | aperture [mm]") && page.contains(">mean<"));
    // Nothing acts in a pure simulation.
    assert!(pure.is_none());

    let out = folder.path().join("force.csv");
    let estimate = |actuator: &Path, recording: &Path| {
        let options = estimate::Options {
            actuator: actuator.to_owned(),
            recording: Some(recording.to_owned()),
            live: None,
            seconds: None,
            out: out.clone(),
            robot: robot.clone(),
            robot_options: crate::arm::RobotOptions::default(),
            gain: 25.0,
        };
        estimate::run(&options, &context)
    };
    estimate(&model, &test).unwrap();
    let written = Recording::read(&out).unwrap();
    let gate = written.require("contact_ratio").unwrap();
    assert!(gate.iter().all(|p| (0.0..=1.0).contains(p)));
    let z = written.require("force_z_n").unwrap();
    let truth = Recording::read(&test).unwrap();
    // The arm carries 300 g for a part of the time: some of it is seen by the observer alone.
    let labelled = truth.require("force_z_labelled_ratio").unwrap();
    let mean = |is: bool| {
        let own: Vec<f64> =
            z.iter().zip(labelled).filter(|(_, l)| (**l == 1.0) == is).map(|(z, _)| *z).collect();
        own.iter().sum::<f64>() / own.len() as f64
    };
    assert!(mean(true) < mean(false) - 0.3, "{} {}", mean(true), mean(false));
    std::fs::remove_file(&out).unwrap();

    let plain = folder.path().join("b.safetensors");
    let as_published =
        neural::Options { sensing: neural::SensingForm::Loop, ..options(root.clone(), plain.clone()) };
    neural::run(&as_published, &context).unwrap();
    let refused = estimate(&plain, &test).unwrap_err().to_string();
    assert!(refused.contains("trained with --sensing observer"), "{refused}");
    assert!(!out.exists());
}
