//! Networks in their files: damaged, and with errors in their metadata under a checksum that is
//! right.

use std::path::Path;

use hysteron_arm_dynamics::Model;
use hysteron_arm_learning::lagrangian::{
    InputForm, LearnedDynamics, NetworkShape, Scales, Sinusoids, Variant, sinusoids,
};
use hysteron_arm_learning::neural::{
    ActuatorDetails, CurrentModel, FeatureLayout, Heads, InputScale, NeuralActuator, SimulationOptions,
};
use hysteron_base::{Channel, Metadata, Recording, json};
use hysteron_control::inverse::{
    Axes, Dataset, Demonstration, InverseModel, RecurrentOptions, fit_recurrent, fit_windowed,
};
use hysteron_fuzz::checkpoint::{other_weights, resealed, reweighted};
use hysteron_fuzz::text::{slipped, slips};
use hysteron_fuzz::{damaged, damages, drive};
use hysteron_learn::{
    Activation, Architecture, ChannelRange, Checkpoint, HeadActivation, Network, Normaliser, SequenceOptions,
    TemporalForm, Training, TrainingSession, Transformer, TransformerShape, WindowOptions,
};
use hysteron_twin::residual::ResidualModel;

use super::{Case, MEMORY_MAX, refused};

const NO_CHECKSUM: &str = "0000000000000000000000000000000000000000000000000000000000000000";

/// A tip that follows two pairs of tendons.
fn recording(index: u32) -> Recording {
    let time: Vec<f64> = (0..300).map(|i| 0.05 * f64::from(i)).collect();
    let way = |lag: f64| time.iter().map(move |t| 3e-3 * (t * (1.0 + 0.1 * f64::from(index)) + lag).sin());
    let (a, b): (Vec<f64>, Vec<f64>) = (way(0.0).collect(), way(1.5).collect());
    let by = |values: &[f64], factor: f64| values.iter().map(|v| factor * v).collect::<Vec<_>>();
    let columns = [a.clone(), b.clone(), by(&a, -1.0), by(&b, -1.0), by(&a, 3.0), by(&b, 3.0)];
    let names = ["stroke_1_m", "stroke_2_m", "stroke_3_m", "stroke_4_m", "tip_x_m", "tip_y_m"];
    let channels = names.into_iter().zip(columns).map(|(name, values)| Channel::new(name, values)).collect();
    Recording::new(time, channels, Vec::new(), Metadata::default()).unwrap()
}

/// Bytes of an inverse controller of each design, and of a training that can go on; and a network of its shape.
fn inverse() -> ([Vec<u8>; 3], Network) {
    let one =
        |k: u32| Demonstration::new(&format!("r-{k}"), &format!("{k}"), &recording(k), Axes::Planar).unwrap();
    let data = Dataset::new((0..4).map(one).collect(), &["r-3".to_owned()], 1).unwrap();
    let default = RecurrentOptions::default();
    let learning = SequenceOptions { hidden: 4, epochs: 1, ..default.learning };
    let case = Case::new("a.safetensors");
    let training = case.path.with_extension("training");
    // Ended after its first epoch, it leaves the file to resume from.
    let mut n_calls = 0;
    let mut once = |progress: &hysteron_learn::TrainingProgress| {
        n_calls += usize::from(matches!(progress, hysteron_learn::TrainingProgress::Epoch(_)));
        n_calls == 0
    };
    let mut session = TrainingSession { file: Some(&training), progress: &mut once };
    let options = RecurrentOptions { learning: SequenceOptions { epochs: 2, ..learning }, ..default };
    let model = fit_recurrent(&data, &options, &mut session).unwrap().model;
    model.write(&case.path).unwrap();
    let recurrent = std::fs::read(&case.path).unwrap();
    let mut session = TrainingSession { file: None, progress: &mut |_| true };
    let options =
        WindowOptions { hidden: 4, epochs: 1, window: 5, stride: 50, ..hysteron_control::inverse::PUBLISHED };
    fit_windowed(&data, &options, &mut session).unwrap().model.write(&case.path).unwrap();
    ([recurrent, std::fs::read(&case.path).unwrap(), std::fs::read(&training).unwrap()], model.network)
}

/// Bytes of a residual network of the published design.
fn residual() -> Vec<u8> {
    let range = |name: String| ChannelRange { name, min: -1.0, max: 1.0 };
    let inputs = ["stroke_1_m", "stroke_2_m", "tip_x_m", "tip_y_m", "tip_z_m"].map(str::to_owned);
    let architecture = Architecture {
        inputs: 5,
        hidden: 4,
        layers: 1,
        outputs: 2,
        head: HeadActivation::Tanh,
        dropout: 0.1,
    };
    let checkpoint = Checkpoint {
        kind: "residual".to_owned(),
        network: Network::new(&architecture, 1).unwrap(),
        inputs: Normaliser::new(inputs.map(range).to_vec()).unwrap(),
        outputs: Normaliser::new(["aux_01_m", "aux_02_m"].map(|name| range(name.to_owned())).to_vec())
            .unwrap(),
        details: json!({
            "design": { "windowed": { "window": 5 } }, "n_aux": 2, "step_s": 0.01, "scene_sha256": NO_CHECKSUM,
            "adaptation": null, "training": { "epochs": 3 },
        }),
    };
    let case = Case::new("a.safetensors");
    checkpoint.write(&case.path).unwrap();
    std::fs::read(&case.path).unwrap()
}

/// Tries a reader on damaged and on slipped files.
fn tried(name: &str, bytes: &[u8], read: impl Fn(&Path) + std::panic::RefUnwindSafe) {
    let case = Case::new("a.safetensors");
    case.write(resealed(bytes, str::to_owned));
    read(&case.path);
    drive(&format!("{name}, bytes"), 500, MEMORY_MAX, damages(), |damages| {
        read(case.write(damaged(bytes, &damages)));
    });
    drive(&format!("{name}, header"), 500, MEMORY_MAX, slips(), |slips| {
        read(case.write(resealed(bytes, |text| slipped(text, &slips))));
    });
    drive(&format!("{name}, weights"), 500, MEMORY_MAX, other_weights(), |change| {
        read(case.write(reweighted(bytes, &change)));
    });
}

#[test]
fn no_damage_to_a_checkpoint_does_harm() {
    let ([recurrent, windowed, training], like) = inverse();
    for (name, bytes) in [("inverse, recurrent", recurrent), ("inverse, paper", windowed)] {
        tried(name, &bytes, |path| match InverseModel::read(path) {
            Ok(model) => drop(model.check_step(0.05)),
            Err(error) => refused(error.bad_input(), &error),
        });
    }
    tried("training", &training, |path| match Training::load::<hysteron_base::json::Value>(path, &like) {
        Ok(_) => {}
        Err(hysteron_learn::Error::BadInput(bad)) => refused(Some(&bad), &bad),
        Err(error) => refused(None, &error),
    });
    tried("residual, paper", &residual(), |path| match ResidualModel::read(path) {
        Ok(model) => drop(model.check(2, 2, 0.01)),
        Err(error) => refused(error.bad_input(), &error),
    });
}

#[test]
fn no_damage_to_learned_dynamics_does_harm() {
    let model = Model::builtin("three-link").unwrap();
    let (samples, _) = sinusoids(&model, &Sinusoids { duration: 0.2, ..Sinusoids::published(3) }, 1, "fuzz");
    for variant in [Variant::Augmented, Variant::BlackBoxLagrangian] {
        let shape = NetworkShape {
            variant,
            hidden: vec![4; 2],
            activation: Activation::Softplus,
            epsilon: 1e-4,
            scales: Scales::of(&samples, variant, InputForm::SinesAndCosines),
            lengths: vec![None; 3],
            inputs: InputForm::SinesAndCosines,
            squares: 0,
        };
        let parameters = shape.initial_parameters(1);
        let case = Case::new("a.safetensors");
        LearnedDynamics { shape, parameters }.write(&case.path, &json!({ "from": "test" })).unwrap();
        let bytes = std::fs::read(&case.path).unwrap();
        tried(&format!("dynamics, {variant:?}"), &bytes, |path| match LearnedDynamics::read(path) {
            Ok(read) => drop(read.decompose(&samples)),
            Err(hysteron_learn::Error::BadInput(bad)) => refused(Some(&bad), &bad),
            Err(error) => refused(None, &error),
        });
    }
}

#[test]
fn no_damage_to_a_neural_actuator_does_harm() {
    let features = FeatureLayout { joints: 4, gripper: None };
    let heads = Heads::sizes(&features);
    let rows: Vec<f64> = (0..3 * features.len()).map(|k| 0.1 * k as f64).collect();
    for form in [TemporalForm::Streaming, TemporalForm::Window] {
        let published = TransformerShape::published(features.len(), &heads, form);
        let shape = TransformerShape { width: 8, layers: 1, feed_forward: 8, latent: 4, ..published };
        let actuator = NeuralActuator {
            network: Transformer::new(&shape, 1).unwrap(),
            features,
            scale: InputScale::of(&features, rows.chunks_exact(features.len())).unwrap(),
            simulation: SimulationOptions::PUBLISHED,
            joints: (1..=4).map(|k| format!("joint{k}")).collect(),
            currents: CurrentModel { coefficients: vec![[0.1; 3]; features.motors()], position_gain: None },
            sensing: None,
            contact: 0.3,
            details: ActuatorDetails::default(),
        };
        let case = Case::new("a.safetensors");
        actuator.write(&case.path).unwrap();
        let bytes = std::fs::read(&case.path).unwrap();
        tried(&format!("neural actuator, {form:?}"), &bytes, |path| match NeuralActuator::read(path) {
            Ok(read) => assert_eq!(read.joints.len(), read.features.joints),
            Err(hysteron_learn::Error::BadInput(bad)) => refused(Some(&bad), &bad),
            Err(error) => refused(None, &error),
        });
    }
}
