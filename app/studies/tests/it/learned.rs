//! Studies of learned inverse dynamics: stopped, resumed, shared by machines, refused.

use hysteron_arm_dynamics::Model;
use hysteron_arm_learning::datasets::panda;
use hysteron_arm_learning::lagrangian::{InputForm, TrainingOptions, Variant};
use hysteron_fuzz::recorded;
use hysteron_learn::Activation;
use hysteron_studies::arm::learned::{
    RealOptions, SimulatedStudy, Units, real_study, shown_samples, simulated_study,
};

/// Small networks that learn from four trajectories.
fn small_study() -> SimulatedStudy {
    SimulatedStudy {
        variants: vec![Variant::StructuredLagrangian, Variant::FeedForward],
        seeds: 1,
        first_seed: 0,
        trajectories: vec![4],
        speeds: vec![1.0, 2.0],
        hidden: Some(vec![6, 6]),
        activation: Activation::Softplus,
        inputs: InputForm::Products(2),
        squares: 2,
        units: Units::Spread,
        training: TrainingOptions { polish: 30, polish_samples: 100, ..TrainingOptions::normalised(4) },
    }
}

#[test]
fn machines_can_share_the_seeds_of_a_study() {
    let one = SimulatedStudy { variants: vec![Variant::FeedForward], ..small_study() };
    let model = Model::builtin("three-link").unwrap();
    let folders = [(); 2].map(|()| tempfile::tempdir().unwrap());
    for (folder, first_seed) in folders.iter().zip(0..) {
        let own = SimulatedStudy { first_seed, ..one.clone() };
        let rows = simulated_study(&own, &model, folder.path(), &mut |_| true).unwrap();
        assert_eq!(rows.iter().map(|row| row.seed).collect::<Vec<_>>(), [first_seed]);
    }
    for entry in std::fs::read_dir(folders[1].path()).unwrap() {
        let path = entry.unwrap().path();
        std::fs::copy(&path, folders[0].path().join(path.file_name().unwrap())).unwrap();
    }
    let mut is_training = false;
    let rows = simulated_study(&SimulatedStudy { seeds: 2, ..one }, &model, folders[0].path(), &mut |p| {
        is_training |= p.training.is_some();
        true
    });
    assert_eq!(rows.unwrap().iter().map(|row| row.seed).collect::<Vec<_>>(), [0, 1]);
    assert!(!is_training, "cells of another machine are taken as they are");
}

#[test]
fn a_study_that_was_stopped_resumes_to_the_same_rows() {
    let study = small_study();
    let model = Model::builtin("three-link").unwrap();
    let folder = tempfile::tempdir().unwrap();
    let whole = simulated_study(&study, &model, &folder.path().join("whole"), &mut |_| true).unwrap();
    let parts = folder.path().join("parts");
    let mut calls = 0;
    let ended = simulated_study(&study, &model, &parts, &mut |_| {
        calls += 1;
        calls < 14
    });
    // Ended before the first epoch there is nothing yet; either way the same call resumes.
    assert!(ended.map_or(0, |rows| rows.len()) < 2);
    let again = simulated_study(&study, &model, &parts, &mut |_| true).unwrap();
    for (a, b) in whole.iter().zip(&again) {
        assert_eq!((a.variant, a.seed, &a.parts, a.validation), (b.variant, b.seed, &b.parts, b.validation));
    }
    let other = SimulatedStudy { hidden: Some(vec![7, 7]), ..study };
    let bad = simulated_study(&other, &model, &parts, &mut |_| true).unwrap_err().to_string();
    assert!(bad.contains("expected a cell of this study, got one of other settings"), "{bad}");
}

/// Simple models alone, small ones.
fn quick() -> RealOptions {
    RealOptions {
        variants: Vec::new(),
        members: 1,
        hidden: vec![4],
        activation: Activation::Relu,
        training: TrainingOptions::published(1),
        features: 4,
        lengths: vec![4.0],
        stride: 50,
    }
}

/// Panda without its fingers, which were not recorded.
fn recorded_panda() -> Model {
    let locked = [("panda_finger_joint1", 0.0), ("panda_finger_joint2", 0.0)];
    Model::builtin("panda").unwrap().with_locked(&locked).unwrap()
}

#[test]
fn an_arm_with_other_joints_than_recorded_is_refused() {
    let name = "an_arm_with_other_joints_than_recorded_is_refused";
    let Some(folder) = recorded(name, "arms/panda-gaz") else { return };
    let set = panda(&folder).unwrap();
    let options = quick();
    let out = tempfile::tempdir().unwrap();
    let whole = Model::builtin("panda").unwrap();
    let bad = real_study(&set, &whole, &options, out.path(), &mut |_| true).unwrap_err().to_string();
    assert!(bad.contains("expected 7 joints, as recorded, got 9"), "{bad}");
    let rows = real_study(&set, &recorded_panda(), &options, out.path(), &mut |_| true).unwrap();
    assert_eq!(rows.len(), 8);
    // Figures show the first test trajectory of every row, thinned.
    let n_shown = shown_samples(&set.test).count();
    let of = set.test.trajectories[0].len();
    assert!(n_shown <= 400 && 2 * n_shown > of.min(400), "{n_shown} of {of}");
    assert!(rows.iter().all(|row| row.shown.len() == 7 * n_shown));
}

#[test]
fn a_study_of_a_recorded_arm_ends_within_its_simple_models_and_resumes() {
    let name = "a_study_of_a_recorded_arm_ends_within_its_simple_models_and_resumes";
    let Some(folder) = recorded(name, "arms/panda-gaz") else { return };
    let (set, arm, options) = (panda(&folder).unwrap(), recorded_panda(), quick());
    let [whole, ended] = [(); 2].map(|()| tempfile::tempdir().unwrap());
    let rows = real_study(&set, &arm, &options, whole.path(), &mut |_| true).unwrap();
    let left = |most: usize| {
        let mut calls = 0;
        let found = real_study(&set, &arm, &options, ended.path(), &mut |_| {
            calls += 1;
            calls <= most
        });
        found.unwrap()
    };
    assert!(left(4).is_empty());
    // A body asks nine times, features ten times and a process five times; what is done asks once.
    for (most, rows_done) in [(9 + 15, 4), (9 + 1 + 15, 5), (9 + 2 + 10 + 3, 6)] {
        assert_eq!(left(most).len(), rows_done, "{most}");
    }
    let found = left(usize::MAX);
    assert_eq!(found.len(), rows.len());
    for (a, b) in rows.iter().zip(&found) {
        assert_eq!((&a.name, a.sum_mse, a.validation), (&b.name, b.sum_mse, b.validation));
    }
}
