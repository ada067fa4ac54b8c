//! The study on small trajectories: all cells, found again, resumed.
#![allow(clippy::unwrap_used)] // a test may stop where it stands

use std::path::Path;

use hysteron_arm_fixtures::recordings::{Case, JOINTS, PERIOD, recording};
use hysteron_base::json;

use super::cells::{NETWORKS, NetworkKind, NeuralScope, NeuralSize};
use super::study::{ActuatorOf, study_with};
use super::{NeuralCell, NeuralData, NeuralStudy, Sample, Split};
use crate::runner::StudyProgress;
use hysteron_arm_dynamics::Model;
use hysteron_arm_learning::neural::{
    ActuatorOptions, EVIDENCE, FeatureLayout, SensingOptions, Trajectory, Unlabelled, trajectory_of,
};

fn features() -> FeatureLayout {
    FeatureLayout { joints: JOINTS, gripper: None }
}

fn trajectory(seed: u64, case: Case) -> Trajectory {
    let unlabelled = if case == Case::Free { Unlabelled::Free } else { Unlabelled::Unknown };
    trajectory_of(&recording(seed, 400, case), &features(), PERIOD, unlabelled).unwrap()
}

fn data() -> NeuralData {
    let tasks = [
        ("force_unlabeled/free", Case::Free),
        ("weight/lift_500g", Case::Loaded(4.9)),
        ("weight/lift_200g", Case::Loaded(2.0)),
        ("weight/lift_300g", Case::Loaded(2.9)),
        ("motor_condition/empty_healthy", Case::Healthy),
        ("motor_condition/empty_degraded", Case::Worn),
        ("motor_faults/empty_healthy", Case::Healthy),
        ("motor_faults/empty_band", Case::Worn),
        ("motor_faults/empty_friction", Case::Worn),
        ("motor_faults/200g_healthy", Case::Healthy),
        ("motor_faults/200g_band", Case::Worn),
        ("motor_faults/200g_friction", Case::Worn),
        ("motor_faults/200g_lost_tooth", Case::Worn),
        ("motor_faults/empty_lost_tooth", Case::Worn),
    ];
    let splits = [Split::Training, Split::Training, Split::Validation, Split::Test];
    let mut samples = Vec::new();
    for (task, case) in tasks {
        for (seed, split) in splits.into_iter().enumerate() {
            let mut own = trajectory(seed as u64, case);
            own.name = format!("{task}/{seed}");
            samples.push(Sample { task: task.to_owned(), split, trajectory: own });
        }
    }
    NeuralData { features: features(), period: PERIOD, samples }
}

/// As the quick size, and quicker.
fn tiny(kind: &NetworkKind, seed: u64) -> ActuatorOptions {
    let mut options = NeuralSize::Quick.actuator(kind, seed, PERIOD);
    options.width = 8;
    options.training.updates = 3;
    options.training.warm_start = options.training.warm_start.min(2);
    options.training.rollouts = 4;
    options.training.horizons = vec![(0, 8)];
    let small = SensingOptions { width: 8, layers: 1, tokens: 5, ..SensingOptions::small(20, 0.3, seed) };
    options.sensing = options.sensing.map(|_| small);
    options
}

fn run(folder: &Path, data: &NeuralData, identity: &&str, last: usize) -> (Option<NeuralStudy>, usize) {
    let model = Model::builtin("open-manipulator-x").unwrap();
    let mut reports = 0;
    let mut listener = |p: &StudyProgress<'_>| {
        reports += usize::from(p.training.is_some());
        reports < last
    };
    let found =
        study_with(folder, (&model, data, identity), (&tiny, NeuralScope::Whole, 0..1), &mut listener)
            .unwrap();
    (found, reports)
}

#[test]
fn every_cell_is_computed_once_and_an_interrupted_study_resumes_to_the_same_numbers() {
    let (data, identity) = (data(), "small");
    let folders = [tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap()];
    let (whole, reports) = run(folders[0].path(), &data, &identity, usize::MAX);
    let whole = whole.unwrap();
    assert!(reports > 0);
    assert_eq!(
        (whole.published.len(), whole.left_out.len(), whole.networks.len()),
        (1, 2, NETWORKS.len() - 1)
    );
    let tasks =
        |cell: &NeuralCell| -> Vec<String> { cell.tasks.iter().map(|task| task.task.clone()).collect() };
    assert_eq!(tasks(&whole.published[0]).len(), 6);
    // No test task is in training, and all of them are evaluated.
    assert_eq!(tasks(&whole.left_out[0][0]), ["weight/lift_500g"]);
    assert_eq!(whole.left_out[0][0].tasks[0].trajectories, 4);
    for cell in whole.published.iter().chain(whole.left_out.iter().flatten()) {
        let [network, _, observer, _] = cell.forces.values();
        assert!(network.unwrap().loaded_axis_n > 0.0 && observer.unwrap().loaded_axis_n > 0.0);
    }
    assert_eq!(whole.published[0].detectors.as_ref().unwrap().len(), 6);
    // Faults that the published set does not have are in training in their own cells alone.
    let [all, left_out] = [0, 1].map(|k: usize| &whole.faults[k][0]);
    assert_eq!([all.trained_on, left_out.trained_on], [28, 18]);
    assert_eq!([all.tests, left_out.tests], [8, 16]);
    for cell in [all, left_out] {
        for found in cell.detectors.values() {
            let evidence = found.iter().find(|one| one.name == EVIDENCE).unwrap();
            assert!(evidence.area > 0.95, "{:?}", cell.detectors);
        }
    }
    // Those without a network of force give it in the loop only where they fit it there: not next to a servo.
    assert!(whole.networks[0][0].forces.force_gmo_drive.is_none());

    let (again, trained) = run(folders[0].path(), &data, &identity, usize::MAX);
    assert!(json!(again.unwrap()) == json!(whole) && trained == 0, "{trained} reports of a training");
    let (stopped, _) = run(folders[1].path(), &data, &identity, 4 * reports / 7);
    assert!(stopped.is_none());
    let (resumed, _) = run(folders[1].path(), &data, &identity, usize::MAX);
    assert!(json!(resumed.unwrap()) == json!(whole), "other numbers after an interruption");
    let left: Vec<_> = std::fs::read_dir(folders[1].path())
        .unwrap()
        .filter(|entry| entry.as_ref().unwrap().path().to_string_lossy().ends_with("training"))
        .collect();
    assert!(left.is_empty(), "{left:?}");

    let model = Model::builtin("open-manipulator-x").unwrap();
    let networks = (&tiny as ActuatorOf<'_>, NeuralScope::Networks, 0..1);
    // The ablation alone has the same cells, and its own of the first network, which knows no force.
    let about = (&model, &data, &identity);
    let alone = study_with(folders[0].path(), about, networks.clone(), &mut |_| true).unwrap().unwrap();
    assert!(json!(alone.networks) == json!(whole.networks));
    assert_eq!(alone.published[0].mean_deg, whole.published[0].mean_deg);
    assert!(alone.published[0].forces.force_gmo_drive.is_none());
    assert!(alone.left_out.iter().all(Vec::is_empty) && alone.faults.iter().all(Vec::is_empty));

    let other = "another";
    let about = (&model, &data, &other);
    let refused = study_with(folders[0].path(), about, networks, &mut |_| true).unwrap_err().to_string();
    assert!(refused.contains("a cell of this study"), "{refused}");
}
