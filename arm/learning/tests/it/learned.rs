//! Learned inverse dynamics and the simple models next to it, on simulated arms and on public recordings
//! where they are.

use hysteron_arm_dynamics::{Data, Model, mass_matrix};
use hysteron_arm_learning::baselines::{RigidFeatures, fit_rigid_body};
use hysteron_arm_learning::datasets::{
    BAXTER_ARM, BaxterTraining, baxter, characters, kuka, kuka_arm, panda,
};
use hysteron_arm_learning::lagrangian::{
    ArmSamples, InputForm, LearnedDynamics, NetworkShape, Scales, Sinusoids, TorqueScores, TrainingOptions,
    Variant, decompose, sinusoids, train,
};
use hysteron_base::json;
use hysteron_fuzz::recorded;
use hysteron_learn::{Activation, TrainingProgress, TrainingSession};

fn shape(variant: Variant, training: &ArmSamples, hidden: usize) -> NetworkShape {
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

fn learn(variant: Variant, sets: [&ArmSamples; 2], options: &TrainingOptions) -> LearnedDynamics {
    let shape = shape(variant, sets[0], 24);
    let mut session = TrainingSession { file: None, progress: &mut |_: &TrainingProgress| true };
    let found = train(&shape, sets, options, 1, &mut session).unwrap();
    LearnedDynamics { shape, parameters: found.parameters }
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
        let r2 = TorqueScores::of(3, &validation.tau, &parts.torque).mean_r2();
        // The mean of the training torques has zero.
        assert!(r2 > 0.8, "{variant:?}: {r2}");
        let sum: Vec<f64> = (0..parts.torque.len())
            .map(|i| parts.inertial[i] + parts.coriolis[i] + parts.gravity[i] + parts.other[i])
            .collect();
        let rest = TorqueScores::of(3, &parts.torque, &sum).sum_nmse();
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
    let mut session = TrainingSession { file: None, progress: &mut |_: &TrainingProgress| true };
    let found = train(&shape, [&training, &validation], &options, 1, &mut session).unwrap();
    let parts = decompose(&shape, &found.parameters, &validation);
    let nmse = |truth: &[f64], found: &[f64]| TorqueScores::of(3, truth, found).sum_nmse();
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
            // Gravity makes the spreads too large.
            assert!(spread.powi(power) > 3.0 * high, "{spread} {high}");
        }
    }
}

#[test]
fn a_model_reads_back_from_its_file_and_streams_the_same_outputs() {
    let model = Model::builtin("three-link").unwrap();
    let (samples, _) = sinusoids(&model, &Sinusoids { duration: 1.0, ..Sinusoids::published(3) }, 1, "test");
    let shape = shape(Variant::Augmented, &samples, 8);
    let parameters = shape.initial_parameters(2);
    let learned = LearnedDynamics { shape, parameters };
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("model.safetensors");
    learned.write(&path, &json!({ "from": "test" })).unwrap();
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
    let other = ArmSamples::new(2);
    let bad = learned.decompose(&other).unwrap_err().to_string();
    assert_eq!(bad, "recording: expected 3 joints, as the model has, got 2");
}

#[test]
fn baxters_arm_is_identified_as_well_as_is_known() {
    let Some(folder) = recorded("baxters_arm_is_identified_as_well_as_is_known", "arms/baxter") else {
        return;
    };
    let set = baxter(&folder, "circle_XY_T2_r10_ang_vel_torq.csv", BaxterTraining::All).unwrap();
    assert_eq!((set.training.len(), set.test.len()), (5661 + 62_220, 5651));
    let model = Model::from_urdf(BAXTER_ARM, "baxter_arm.urdf").unwrap();
    let features = RigidFeatures::new(&model, &set.training);
    let (parameters, ..) = fit_rigid_body(&features, &set.training, 16, &mut || true).unwrap().unwrap();
    let scores = TorqueScores::of(7, &set.test.tau, &features.predict(&parameters, &set.test));
    // An independent fit of such a model leaves .88 N² m² and a mean R² of .832.
    assert!(scores.sum_mse() < 0.88 && scores.mean_r2() > 0.81, "{scores:?}");
}

#[test]
fn kuka_and_panda_are_read_in_blocks() {
    let Some(folder) = recorded("kuka_and_panda_are_read_in_blocks", "arms/kuka-lwr4") else { return };
    let set = kuka(&folder).unwrap();
    assert_eq!((set.training.len(), set.test.len(), set.training.trajectories.len()), (5027, 5027, 8));
    // Friction below zero, which its file has, is no reason to refuse an arm whose bodies are identified again.
    assert_eq!(kuka_arm(&folder).unwrap().n_joints(), 7);
    let Some(folder) = recorded("kuka_and_panda_are_read_in_blocks", "arms/panda-gaz") else { return };
    let set = panda(&folder).unwrap();
    assert!(set.training.len() > 2 * set.test.len() && set.test.trajectories.len() == 8);
}

#[test]
fn written_characters_have_the_parts_of_their_torques() {
    let name = "written_characters_have_the_parts_of_their_torques";
    let Some(file) = recorded(name, "arms/delan-characters/characters.csv") else { return };
    let [(training, _), (test, truth)] = characters(&file).unwrap();
    assert_eq!((training.trajectories.len(), test.trajectories.len()), (17, 3));
    let sum: Vec<f64> =
        (0..test.tau.len()).map(|i| truth.inertial[i] + truth.coriolis[i] + truth.gravity[i]).collect();
    // They are printed to sixteen digits.
    assert!(TorqueScores::of(2, &test.tau, &sum).sum_nmse() < 1e-20);
}
