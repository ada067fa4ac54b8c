//! Force and condition by a network and a momentum observer: learning, streaming, files, refusals, on motion
//! by inverse dynamics.
#![allow(clippy::unwrap_used)] // a test may stop where it stands

use hysteron_arm_fixtures::recordings::{Case, JOINTS, PERIOD, arm, recording};
use hysteron_base::json;
use hysteron_learn::{
    DeviceCard, TrainableModel as _, TrainingProgress, TrainingSession, Transformer, TransformerShape, fit,
};

use super::*;
use hysteron_arm_dynamics::Model;
use hysteron_arm_estimation::servo_force::{BaselineObservers, observed_arm};

fn features() -> FeatureLayout {
    FeatureLayout { joints: JOINTS, gripper: None }
}

fn trajectory(seed: u64, case: Case) -> Trajectory {
    let unlabelled = if case == Case::Free { Unlabelled::Free } else { Unlabelled::Unknown };
    trajectory_of(&recording(seed, 400, case), &features(), PERIOD, unlabelled).unwrap()
}

fn set(seeds: std::ops::Range<u64>) -> Vec<Trajectory> {
    let one = |seed| {
        [Case::Free, Case::Loaded(2.0 + 0.7 * (seed % 3) as f64), Case::Worn]
            .map(|case| trajectory(seed, case))
    };
    seeds.flat_map(one).collect()
}

fn identified(observers: &BaselineObservers, training: &[Trajectory]) -> IdentifiedArm {
    IdentifiedArm::identify(&arm(), (&features(), &observers.drive, PERIOD), training).unwrap()
}

fn options() -> SensingOptions {
    SensingOptions { width: 16, layers: 1, tokens: 17, epoch: 50, ..SensingOptions::small(500, 0.3, 1) }
}

#[test]
fn a_condition_that_is_wrong_and_sure_outweighs_no_force_when_the_best_network_is_kept() {
    let training = set(0..2);
    let (model, features, options) = (arm(), features(), options());
    let observers = identified_observers(&model, (&features, PERIOD), &training).unwrap();
    let known = identified(&observers, &training);
    // All healthy, and a network that is sure of it, or of the contrary.
    let healthy = [trajectory(4, Case::Free)];
    let about = (&features, &known, PERIOD);
    let mut task = SensingTask::new(&options, &model, about, [&training, &healthy]).unwrap();
    let mut network = Transformer::<f32>::new(&options.shape(&features), 1).unwrap();
    let mut loss_at = |bias: f32| {
        // The last numbers of all are the biases of the last head, one for each motor.
        let heads = network.parameters_mut().last_mut().unwrap();
        let first = heads.len() - JOINTS;
        heads[first + Heads::new(&features).condition - (JOINTS + 4)] = bias;
        hysteron_learn::TrainingTask::validate(&mut task, &network).unwrap()
    };
    let [right, wrong] = [60.0, -60.0].map(&mut loss_at);
    // All of the weight for one of two conditions; a cross-entropy would be sixty times that.
    let expected = 0.5 * options.loss.condition;
    assert!((wrong - right - expected).abs() < 1e-6, "{right} {wrong} {expected}");
}

/// On a card where the program is built for one, and else by the operations that one would carry out.
#[test]
fn a_card_learns_from_the_same_samples() {
    let training = set(0..2);
    let (model, features) = (arm(), features());
    // Steps so small that the losses of all updates are those of the same weights.
    let options = SensingOptions { learning_rate: (1e-9, 1), epoch: 20, updates: 20, ..options() };
    let observers = identified_observers(&model, (&features, PERIOD), &training).unwrap();
    let known = identified(&observers, &training);
    let network = Transformer::<f32>::new(&options.shape(&features), 1).unwrap();
    let curve = |card: Option<DeviceCard>| {
        let about = (&features, &known, PERIOD);
        let mut task = SensingTask::new(&options, &model, about, [&training, &training]).unwrap().on(card);
        let mut session = TrainingSession { file: None, progress: &mut |_| true };
        let found = fit(&mut task, network.clone(), &json!({ "test": 3 }), &mut session).unwrap();
        found.curve[0]
    };
    let host = curve(None);
    let card = curve(Some(DeviceCard::first().unwrap().unwrap_or_else(DeviceCard::emulated)));
    // Outputs are sums of some tens of products in single precision, and so are their inputs.
    for (host, card) in host.iter().zip(card) {
        assert!((host - card).abs() < 1e-5 * host, "{host} {card}");
    }
}

#[test]
fn force_and_condition_are_learned_beyond_the_observer_and_training_resumes_bit_for_bit() {
    let (training, validation, test) = (set(0..4), set(4..6), set(6..8));
    let (model, features, options) = (arm(), features(), options());
    let observers = identified_observers(&model, (&features, PERIOD), &training).unwrap();
    let known = identified(&observers, &training);
    let about = (&features, &known, PERIOD);
    let network = Transformer::<f32>::new(&options.shape(&features), 1).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let run = |file: Option<&std::path::Path>, last: usize| {
        let mut task = SensingTask::new(&options, &model, about, [&training, &validation]).unwrap();
        let mut progress =
            |p: &TrainingProgress| !matches!(p, TrainingProgress::Epoch(epoch) if epoch.number == last);
        let mut session = TrainingSession { file, progress: &mut progress };
        let found = fit(&mut task, network.clone(), &json!({ "test": 2 }), &mut session).unwrap();
        (found, task.scale().clone())
    };
    let (whole, scale) = run(None, usize::MAX);
    let state = folder.path().join("state");
    assert!(!run(Some(&state), 3).0.is_finished);
    let (resumed, _) = run(Some(&state), usize::MAX);
    assert_eq!(resumed.model.parameters(), whole.model.parameters());
    let sensing = Sensing { network: whole.model, scale, known: known.clone() };
    let sensed: Vec<SensedTrajectory> =
        test.iter().map(|one| sensing.along(&model, (&features, PERIOD), one).unwrap()).collect();
    let estimated: Vec<_> = sensed.iter().map(|one| (one.force.clone(), one.gate.clone())).collect();
    let alone: Vec<_> = test
        .iter()
        .map(|one| {
            let forces = observers.forces(&model, &telemetry(&features, PERIOD, one).unwrap()).unwrap();
            let gate = |f: &[f64; 3]| f64::from(u8::from(length(f) > observers.contact[1]));
            (forces[1].clone(), forces[1].iter().map(gate).collect::<Vec<f64>>())
        })
        .collect();
    let [with, without] =
        [&estimated, &alone].map(|all| force_scores(&test, all, (usize::MAX, 0.3)).unwrap());
    // Errors of friction along axes that no weight acts on are learned first.
    assert!(with.loaded_mean_of_axes_n < 0.8 * without.loaded_mean_of_axes_n, "{with:?} {without:?}");
    assert!(
        with.mean_of_axes_n < 0.7 * without.mean_of_axes_n && with.false_contact < 0.1,
        "{with:?} {without:?}"
    );
    let conditions: Vec<Vec<f64>> = sensed.iter().map(|one| one.condition.clone()).collect();
    let [_, area] = condition_scores(&test, &conditions).unwrap();
    assert!(area > 0.9, "{area}");

    let mut runner = SensingRunner::new(&sensing, &model, (&features, PERIOD)).unwrap();
    let voltage = test[1].motor_voltage().unwrap();
    for row in 0..test[1].len() {
        let sample =
            [test[1].inputs_at(row as isize), test[1].state_at(row), &voltage[row * JOINTS..][..JOINTS]];
        let now = runner.update(sample);
        let pairs = now.force.into_iter().zip(sensed[1].force[row]).chain([(now.gate, sensed[1].gate[row])]);
        for (streamed, whole) in pairs {
            // Sums of f32 in another order, through two layers: some 1e-6 of values of a few newtons.
            assert!((streamed - whole).abs() < 1e-4 * whole.abs().max(1.0), "{row}: {streamed} {whole}");
        }
    }
}

#[test]
fn an_arm_that_looks_elsewhere_feels_the_same_force_in_axes_that_turned_with_it() {
    let (training, features, model, options) = (set(0..2), features(), arm(), options());
    let observers = identified_observers(&model, (&features, PERIOD), &training).unwrap();
    let known = identified(&observers, &training);
    let about = (&features, &known, PERIOD);
    let scale = SensingTask::new(&options, &model, about, [&training, &training]).unwrap().scale().clone();
    // Nobody has trained it: it shall hold by construction.
    let network = Transformer::new(&options.shape(&features), 3).unwrap();
    let sensing = Sensing { network, scale, known: known.clone() };
    let one = trajectory(5, Case::Loaded(3.0));
    let mut turned = one.clone();
    let angle = 0.8;
    turned.states.chunks_exact_mut(2 * JOINTS).for_each(|state| state[0] += angle);
    for inputs in turned.inputs.chunks_exact_mut(features.len()) {
        inputs[FeatureLayout::GOALS] += angle;
        inputs[JOINTS] += angle;
    }
    let along =
        |model: &Model, one: &Trajectory| sensing.along(model, (&features, PERIOD), one).unwrap().force;
    let apart = |model: &Model| {
        let (sin, cos) = f64::sin_cos(angle);
        let pairs = along(model, &one).into_iter().zip(along(model, &turned));
        let error = |([x, y, z], found): ([f64; 3], [f64; 3])| {
            let expected = [cos * x - sin * y, sin * x + cos * y, z];
            expected.iter().zip(found).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
        };
        pairs.map(error).fold(0.0, f64::max)
    };
    // Inputs of f32, which rounding moves by 6e-8 of up to 10 spreads, through two layers to forces of some newtons.
    assert!(apart(&model) < 1e-3, "{}", apart(&model));
    // On a wall the same turn changes what gravity does.
    let mounted = model.with_gravity([9.81, 0.0, 0.0]);
    assert!(apart(&mounted) > 0.1, "{}", apart(&mounted));
}

fn actuator(sensing: Sensing) -> NeuralActuator {
    let (features, data) = (features(), set(0..1));
    let shape = TransformerShape {
        width: 8,
        layers: 1,
        ..TransformerShape::published(
            features.len(),
            &Heads::sizes(&features),
            hysteron_learn::TemporalForm::Streaming,
        )
    };
    NeuralActuator {
        network: Transformer::new(&shape, 1).unwrap(),
        features,
        scale: InputScale::of(&features, data[0].inputs.chunks_exact(features.len())).unwrap(),
        simulation: SimulationOptions::PUBLISHED,
        joints: ["joint1", "joint2", "joint3", "joint4"].map(str::to_owned).to_vec(),
        currents: CurrentModel::fit(&features, &data).unwrap(),
        sensing: Some(sensing),
        contact: 0.3,
        details: ActuatorDetails::default(),
    }
}

#[test]
fn a_file_holds_both_networks_and_what_does_not_belong_together_is_refused() {
    let (training, features, model) = (set(0..2), features(), arm());
    let observers = identified_observers(&model, (&features, PERIOD), &training).unwrap();
    let known = identified(&observers, &training);
    let task = |options: &SensingOptions| {
        let about = (&features, &known, PERIOD);
        SensingTask::new(options, &model, about, [&training, &training]).map(|task| task.scale().clone())
    };
    let options = options();
    let scale = task(&options).unwrap();
    let network = Transformer::new(&options.shape(&features), 3).unwrap();
    let sensing = Sensing { network, scale, known: known.clone() };
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("a.safetensors");
    let whole = actuator(sensing.clone());
    whole.write(&file).unwrap();
    let read = NeuralActuator::read(&file).unwrap();
    let again = read.sensing.unwrap();
    assert_eq!(again.network.parameters(), sensing.network.parameters());
    let about = (&features, PERIOD);
    let along = |sensing: &Sensing| sensing.along(&model, about, &training[1]).unwrap();
    assert_eq!(along(&again), along(&sensing));
    let refused = |change: &dyn Fn(&mut Sensing)| {
        let mut changed = sensing.clone();
        change(&mut changed);
        actuator(changed).write(&file).unwrap();
        NeuralActuator::read(&file).unwrap_err().to_string()
    };
    let found = refused(&|sensing| sensing.known.drive.dry.truncate(3));
    assert!(found.contains("sensing: drive: dry: expected 4 finite numbers"), "{found}");
    let window = TransformerShape { form: hysteron_learn::TemporalForm::Window, ..options.shape(&features) };
    let found = refused(&|sensing| sensing.network = Transformer::new(&window, 3).unwrap());
    assert!(found.contains("sensing: shape.form: expected streaming"), "{found}");
    let wide = TransformerShape { inputs: 7, ..options.shape(&features) };
    let found = refused(&|sensing| sensing.network = Transformer::new(&wide, 3).unwrap());
    assert!(found.contains("sensing: shape: expected sizes that belong together"), "{found}");

    let refused = |change: &dyn Fn(&mut Baselines)| {
        let mut baselines = Baselines {
            lag: FirstOrderServo { lag: vec![(0, 1.0); 4], droop: vec![[0.0; 2]; 4], position_gain: None },
            servo: RolloutServo {
                stiffness: vec![9.0; 4],
                friction: vec![0.1; 4],
                load_friction: Vec::new(),
                damping: 1.0,
                rms: 0.0,
                holds: false,
                motors: Motors::default(),
                position_gain: None,
            },
            observers: Some(observers.clone()),
        };
        change(&mut baselines);
        let mut changed = actuator(sensing.clone());
        changed.details.baselines = Some(baselines);
        Baselines::of(&changed).map(|_| ()).map_err(|bad| bad.to_string())
    };
    assert_eq!(refused(&|_| {}), Ok(()));
    let of_drive =
        |baselines: &mut Baselines| baselines.observers.iter_mut().for_each(|own| own.linear.noise[0] = -1.0);
    let found = refused(&of_drive).unwrap_err();
    assert!(found.contains("rivals: observers: linear: noise: expected 4 finite numbers"), "{found}");
    assert!(refused(&|baselines| baselines.lag.droop.truncate(1)).unwrap_err().contains("lag_and_droop"));
    assert!(
        refused(&|baselines| baselines.servo.stiffness.truncate(1)).unwrap_err().contains("servo.stiffness")
    );

    let bad = SensingOptions { span: 0, ..options };
    assert!(task(&bad).unwrap_err().to_string().contains("span: expected 1 to"));
    let loaded: Vec<Trajectory> =
        training.iter().filter(|one| one.force[100] != Some([0.0; 3])).cloned().collect();
    let found = identified_observers(&model, about, &loaded).unwrap_err().to_string();
    assert!(found.contains("training recordings: expected one or more without contact"), "{found}");
    let silent = Trajectory { voltage: None, name: "x.csv".to_owned(), ..training[0].clone() };
    let found = identified_observers(&model, about, &[silent]).unwrap_err().to_string();
    assert!(found.contains("x.csv: expected channels pwm_k_ratio"), "{found}");
    let three = Model::builtin("three-link").unwrap();
    assert!(observed_arm(&three, 4).unwrap_err().to_string().contains("4 joints or more"));
    let _: BaselineObservers = json::from_text(json::to_line(&observers).unwrap()).unwrap();
}
