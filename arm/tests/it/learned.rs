//! Learned inverse dynamics and the simple models beside it, on simulated arms and on public recordings where they are.

use hysteron_arm::baselines::{RigidFeatures, fit_rigid_body};
use hysteron_arm::datasets::{BAXTER_ARM, BaxterTraining, baxter, characters, kuka, kuka_arm, panda};
use hysteron_arm::lagrangian::{
    InputForm, LearnedDynamics, NetworkShape, Samples, Scales, Scores, Sinusoids, TrainingOptions, Variant,
    decompose, sinusoids, train,
};
use hysteron_arm::study::{RealOptions, SimulatedStudy, Units, real_study, shown_samples, simulated_study};
use hysteron_arm::{Data, Model, mass_matrix};
use hysteron_learn::{Activation, Progress, Session};
use serde_json::json;

use super::import::data;

fn shape(variant: Variant, training: &Samples, hidden: usize) -> NetworkShape {
    NetworkShape {
        variant,
        hidden: vec![hidden; 2],
        activation: Activation::Softplus,
        epsilon: 1e-4,
        scales: Scales::of(training, variant, InputForm::SinesAndCosines),
        lengths: vec![None; training.n_joints],
        inputs: InputForm::SinesAndCosines,
        squares: 0,
    }
}

fn learn(variant: Variant, sets: [&Samples; 2], options: &TrainingOptions) -> LearnedDynamics {
    let shape = shape(variant, sets[0], 24);
    let mut session = Session { file: None, progress: &mut |_: &Progress| true };
    let found = train(&shape, sets, options, 1, &mut session).unwrap();
    LearnedDynamics { shape, parameters: found.parameters, details: json!({}) }
}

#[test]
fn structured_models_learn_a_simulated_arm_from_few_motions() {
    let model = Model::builtin("three-link").unwrap();
    let plan = Sinusoids { duration: 2.0, ..Sinusoids::published(24) };
    let (all, _) = sinusoids(&model, &plan, 1, "test");
    let (training, validation) = (all.select(0..20), all.select(20..24));
    let options = TrainingOptions { polish: 0, learning_rate: 5e-3, ..TrainingOptions::normalised(60) };
    // Models without structure need more than twenty motions: the black-box Hamiltonian does hardly better than the mean here.
    let variants = [
        Variant::StructuredLagrangian,
        Variant::StructuredHamiltonian,
        Variant::Friction,
        Variant::Augmented,
    ];
    for variant in variants {
        let found = learn(variant, [&training, &validation], &options);
        let parts = decompose(&found.shape, &found.parameters, &validation);
        let r2 = Scores::of(3, &validation.tau, &parts.torque).mean_r2();
        // The mean of the training torques has zero.
        assert!(r2 > 0.8, "{variant:?}: {r2}");
        let sum: Vec<f64> = (0..parts.torque.len())
            .map(|i| parts.inertial[i] + parts.coriolis[i] + parts.gravity[i] + parts.other[i])
            .collect();
        let rest = Scores::of(3, &parts.torque, &sum).sum_nmse();
        // Squares of some roundings.
        assert!(rest < 1e-20, "{variant:?}: parts are not the whole by {rest}");
    }
}

/// A structured Lagrangian trained by Levenberg and Marquardt's method on a short set; nMSE of its torque and inertial part on other motions.
fn polished(squares: usize) -> [f64; 2] {
    let model = Model::builtin("three-link").unwrap();
    let plan = Sinusoids { rate: 5.0, ..Sinusoids::published(60) };
    let (all, truth) = sinusoids(&model, &plan, 1, "test");
    let (training, validation) = (all.select(0..50), all.select(50..60));
    let (variant, inputs) = (Variant::StructuredLagrangian, InputForm::Products(3));
    let shape = NetworkShape {
        hidden: vec![2, 2],
        activation: Activation::Tanh,
        scales: Scales::of(&training, variant, inputs),
        inputs,
        squares,
        ..shape(variant, &training, 2)
    };
    let options = TrainingOptions {
        learning_rate: 5e-3,
        polish: 100,
        ..TrainingOptions::normalised(3).with_levenberg_marquardt()
    };
    let mut session = Session { file: None, progress: &mut |_: &Progress| true };
    let found = train(&shape, [&training, &validation], &options, 1, &mut session).unwrap();
    let parts = decompose(&shape, &found.parameters, &validation);
    let nmse = |truth: &[f64], found: &[f64]| Scores::of(3, truth, found).sum_nmse();
    [nmse(&validation.tau, &parts.torque), nmse(&truth.inertial[3 * training.len()..], &parts.inertial)]
}

#[test]
fn squares_in_the_kinetic_energy_hold_a_rigid_arm() {
    // Six squares are the components of three centres' velocities, whose entries the linear path holds: what is left is what the search has
    // not come to yet. A Cholesky factor has no such form.
    let [with, without] = [6, 0].map(polished);
    assert!(with[0] < 1e-7 && with[1] < 1e-4, "{with:?}");
    assert!(without[0] > 100.0 * with[0] && without[1] > 100.0 * with[1], "{with:?} {without:?}");
}

#[test]
fn the_scale_of_a_mass_matrix_is_that_of_its_diagonal() {
    let model = Model::builtin("three-link").unwrap();
    let (samples, _) = sinusoids(&model, &Sinusoids::published(20), 1, "test");
    let mut data = Data::new(&model, 0.0);
    let (mut h, mut range) = ([0.0; 9], [[f64::INFINITY, 0.0]; 3]);
    for q in samples.q.chunks_exact(3) {
        mass_matrix(&model, &mut data, q, &mut h);
        (0..3).for_each(|i| range[i] = [range[i][0].min(h[4 * i]), range[i][1].max(h[4 * i])]);
    }
    for (variant, power) in [(Variant::StructuredLagrangian, 2), (Variant::StructuredHamiltonian, -2)] {
        let [spreads, found] = [0, 3].map(|joints| Scales::of(&samples, variant, InputForm::of(joints)));
        for ((d, spread), [low, high]) in found.factor.iter().zip(&spreads.factor).zip(range) {
            // A regression that takes H for constant: of its order.
            assert!((low / 2.0..2.0 * high).contains(&d.powi(power)), "{d} {low} {high}");
            // Gravity makes what spreads say too large.
            assert!(spread.powi(power) > 3.0 * high, "{spread} {high}");
        }
    }
}

#[test]
fn a_model_comes_back_from_its_file_and_streams_what_it_says() {
    let model = Model::builtin("three-link").unwrap();
    let (samples, _) = sinusoids(&model, &Sinusoids { duration: 1.0, ..Sinusoids::published(3) }, 1, "test");
    let shape = shape(Variant::Augmented, &samples, 8);
    let parameters = shape.initial_parameters(2);
    let learned = LearnedDynamics { shape, parameters, details: json!({ "from": "test" }) };
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("model.safetensors");
    learned.write(&path).unwrap();
    assert_eq!(LearnedDynamics::read(&path).unwrap(), learned);
    let torque = learned.decompose(&samples).unwrap().torque;
    let (mut stream, mut tau) = (learned.stream(), [0.0; 3]);
    for i in [0, 50, 149] {
        let of = |values: &'_ [f64]| values[3 * i..3 * i + 3].to_vec();
        stream.torque([&of(&samples.q), &of(&samples.dq), &of(&samples.ddq)], &mut tau);
        for j in 0..3 {
            let size = torque.iter().fold(1e-3f64, |m, v| m.max(v.abs()));
            assert!((tau[j] - torque[3 * i + j]).abs() < 1e-5 * size, "{i} {j}");
        }
    }
    let other = Samples::new(2);
    let bad = learned.decompose(&other).unwrap_err().to_string();
    assert_eq!(bad, "recording: expected 3 joints, as the model has, got 2");
}

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
fn a_study_that_was_ended_goes_on_to_the_same_rows() {
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
    // Ended before the first epoch there is nothing yet; either way the same call goes on.
    assert!(ended.map_or(0, |rows| rows.len()) < 2);
    let again = simulated_study(&study, &model, &parts, &mut |_| true).unwrap();
    for (a, b) in whole.iter().zip(&again) {
        assert_eq!((a.variant, a.seed, &a.parts, a.validation), (b.variant, b.seed, &b.parts, b.validation));
    }
    let other = SimulatedStudy { hidden: Some(vec![7, 7]), ..study };
    let bad = simulated_study(&other, &model, &parts, &mut |_| true).unwrap_err().to_string();
    assert!(bad.contains("expected a cell of this study, got one of other settings"), "{bad}");
}

#[test]
fn baxters_arm_is_identified_as_well_as_is_known() {
    let Some(folder) = data("baxters_arm_is_identified_as_well_as_is_known", "baxter") else { return };
    let set = baxter(&folder, "circle_XY_T2_r10_ang_vel_torq.csv", BaxterTraining::All).unwrap();
    assert_eq!((set.training.len(), set.test.len()), (5661 + 62_220, 5651));
    let model = Model::from_urdf(BAXTER_ARM, "baxter_arm.urdf").unwrap();
    let features = RigidFeatures::new(&model, &set.training);
    let (parameters, ..) = fit_rigid_body(&features, &set.training, 16, &mut || true).unwrap().unwrap();
    let scores = Scores::of(7, &set.test.tau, &features.predict(&parameters, &set.test));
    // An independent fit of such a model leaves .88 N² m² and a mean R² of .832.
    assert!(scores.sum_mse() < 0.88 && scores.mean_r2() > 0.81, "{scores:?}");
}

#[test]
fn kuka_and_panda_are_read_in_blocks() {
    let Some(folder) = data("kuka_and_panda_are_read_in_blocks", "kuka-lwr4") else { return };
    let set = kuka(&folder).unwrap();
    assert_eq!((set.training.len(), set.test.len(), set.training.trajectories.len()), (5027, 5027, 8));
    // Friction below zero, which its file has, is no reason to refuse an arm whose bodies are identified anew.
    assert_eq!(kuka_arm(&folder).unwrap().n_joints(), 7);
    let Some(folder) = data("kuka_and_panda_are_read_in_blocks", "panda-gaz") else { return };
    let set = panda(&folder).unwrap();
    assert!(set.training.len() > 2 * set.test.len() && set.test.trajectories.len() == 8);
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
    let Some(folder) = data(name, "panda-gaz") else { return };
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
fn a_study_of_a_recorded_arm_ends_within_its_simple_models_and_goes_on() {
    let name = "a_study_of_a_recorded_arm_ends_within_its_simple_models_and_goes_on";
    let Some(folder) = data(name, "panda-gaz") else { return };
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

#[test]
fn written_characters_have_the_parts_of_their_torques() {
    let name = "written_characters_have_the_parts_of_their_torques";
    let Some(file) = data(name, "delan-characters/characters.csv") else { return };
    let [(training, _), (test, truth)] = characters(&file).unwrap();
    assert_eq!((training.trajectories.len(), test.trajectories.len()), (17, 3));
    let sum: Vec<f64> =
        (0..test.tau.len()).map(|i| truth.inertial[i] + truth.coriolis[i] + truth.gravity[i]).collect();
    // They are printed to sixteen digits.
    assert!(Scores::of(2, &test.tau, &sum).sum_nmse() < 1e-20);
}
