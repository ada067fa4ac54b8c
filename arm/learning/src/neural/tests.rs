//! Gradients of the whole closed loop against differences; training, scores and refusals on simulated servos.
#![allow(clippy::unwrap_used)] // a test may stop where it stands

use hysteron_actuator::CatalogueDrive;
use hysteron_actuator::law::Law;
use hysteron_base::{Channel, Metadata, Recording, json, rng};
use hysteron_learn::{
    BlockKind, TapePool, TemporalForm, TrainableModel as _, Training, TrainingSession, TrainingTask as _,
    Transformer, TransformerShape, fit,
};
use rand::RngExt;

use super::*;
use hysteron_arm_dynamics::Model;

const PERIOD: f64 = 0.017;

pub(crate) fn features() -> FeatureLayout {
    FeatureLayout { joints: 4, gripper: Some(GripperAxis { slope: 0.0228, offset: -0.0006 }) }
}

pub(crate) fn arm() -> Model {
    Model::builtin("open-manipulator-x").unwrap()
}

fn simulation() -> ArmSimulation {
    ArmSimulation::new(&arm(), &features(), &SimulationOptions::PUBLISHED).unwrap()
}

/// With a servo in the loop that is not quite the recorded one.
pub(crate) fn with_servo() -> ArmSimulation {
    with_friction(true, 0.0)
}

/// The same, with friction that holds or creeps, and grows with the torque through the gear.
fn with_friction(holds: bool, share: f64) -> ArmSimulation {
    let servo = RolloutServo {
        stiffness: vec![18.0, 22.0, 21.0, 14.0, 9.0],
        friction: vec![0.08; 5],
        load_friction: vec![share; if share > 0.0 { 5 } else { 0 }],
        damping: 1.2,
        rms: 0.0,
        holds,
        motors: Motors::default(),
        position_gain: Some(400.0),
    };
    ArmSimulation::new(&arm(), &features(), &SimulationOptions::with_servo(&servo, PERIOD)).unwrap()
}

/// With a drive in the loop that warms so slowly that its gradient, which takes temperatures as given, leaves nothing out.
fn with_drive() -> ArmSimulation {
    let mut one = CatalogueDrive::named("xm430-w350").unwrap();
    one.drive.winding.heat_capacity = 1e12;
    one.drive.winding.case_heat_capacity = 1e12;
    one.drive.gear.backlash = 0.0;
    one.drive.gear.law = Law::named("m4").unwrap();
    one.drive.gear.friction = vec![0.02, 0.05, 0.03, 0.1, 0.05, 0.3, 1.3];
    ArmSimulation::new(&arm(), &features(), &SimulationOptions::with_drive(&one, &Motors::default(), PERIOD))
        .unwrap()
}

/// A servo that is not the network's: stiff motors with friction that follow waves, seen 60 times a second. With a force that the
/// current of the second motor shows.
fn recording(seed: u64, rows: usize) -> Recording {
    let features = features();
    let m = features.motors();
    let mut stream = rng(seed, "goals");
    let waves: Vec<[f64; 3]> =
        (0..m).map(|_| [0.2, 1.0, 0.0].map(|least: f64| stream.random_range(least..least + 0.4))).collect();
    let home = [0.0, -0.6, 0.5, 0.6, 0.5];
    let time: Vec<f64> = (0..rows).map(|i| PERIOD * i as f64).collect();
    let goals: Vec<Vec<f64>> = (0..m)
        .map(|k| time.iter().map(|t| home[k] + waves[k][0] * (waves[k][1] * t + waves[k][2]).sin()).collect())
        .collect();
    let servo = RolloutServo {
        stiffness: vec![20.0, 25.0, 20.0, 15.0, 10.0],
        friction: vec![0.1; m],
        load_friction: Vec::new(),
        damping: 1.0,
        rms: 0.0,
        holds: true,
        motors: Motors::default(),
        position_gain: None,
    };
    let mut inputs = vec![0.0; rows * features.len()];
    for (i, row) in inputs.chunks_exact_mut(features.len()).enumerate() {
        (0..m).for_each(|k| row[k] = goals[k][i]);
    }
    let start: Vec<f64> = (0..2 * m).map(|k| if k < m { goals[k][0] } else { 0.0 }).collect();
    let known = Trajectory {
        name: String::new(),
        inputs,
        states: [start, vec![0.0; (rows - 1) * 2 * m]].concat(),
        voltage: None,
        force: vec![None; rows],
        is_healthy: None,
        position_gain: None,
        gap: vec![false; rows],
    };
    let segment = Segment::recorded(&known, 0);
    let states = servo.run(&arm(), (&features, PERIOD), &[segment], rows - 1).unwrap();
    let force = |i: usize| if (i / 60) % 2 == 1 { -3.0 } else { 0.0 };
    let mut channels = Vec::new();
    for k in 0..m {
        let q: Vec<f64> = states.iter().skip(k).step_by(2 * m).copied().collect();
        let dq = states.iter().skip(m + k).step_by(2 * m).copied().collect();
        let pushed = if k == 1 { 0.1 } else { 0.0 };
        let current = (0..rows).map(|i| 0.8 * (goals[k][i] - q[i]) + pushed * force(i)).collect();
        if k == 4 {
            channels.push(Channel::new("aperture_m", q.iter().map(|q| 0.0228 * q - 0.0006).collect()));
            channels.push(Channel::new(
                "goal_aperture_m",
                goals[k].iter().map(|q| 0.0228 * q - 0.0006).collect(),
            ));
        }
        channels.push(Channel::new(format!("q_{}_rad", k + 1), q));
        channels.push(Channel::new(format!("dq_{}_rad_s", k + 1), dq));
        channels.push(Channel::new(format!("goal_{}_rad", k + 1), goals[k].clone()));
        channels.push(Channel::new(format!("current_{}_a", k + 1), current));
        channels.push(Channel::new(format!("voltage_{}_v", k + 1), vec![12.0; rows]));
        channels.push(Channel::new(format!("temperature_{}_degc", k + 1), vec![30.0; rows]));
    }
    for (axis, share) in [("x", 0.0), ("y", 0.0), ("z", 1.0)] {
        channels.push(Channel::new(format!("force_{axis}_n"), (0..rows).map(|i| share * force(i)).collect()));
    }
    let mut meta = Metadata::default();
    meta.extra.insert(
        "condition".to_owned(),
        if seed.is_multiple_of(2) { "healthy" } else { "degraded" }.to_owned(),
    );
    Recording::new(time, channels, Vec::new(), meta).unwrap()
}

fn trajectories(seeds: std::ops::Range<u64>, rows: usize) -> Vec<Trajectory> {
    let features = features();
    seeds
        .map(|seed| trajectory_of(&recording(seed, rows), &features, PERIOD, Unlabelled::Unknown).unwrap())
        .collect()
}

fn shape(form: TemporalForm) -> TransformerShape {
    let features = features();
    TransformerShape {
        inputs: features.len(),
        heads: Heads::sizes(&features).to_vec(),
        width: 16,
        layers: 2,
        attention_heads: 2,
        feed_forward: 24,
        latent: 12,
        tokens: 5,
        block: BlockKind::GatedPreNorm,
        form,
    }
}

fn scale(trajectories: &[Trajectory]) -> InputScale {
    let features = features();
    InputScale::of(&features, trajectories.iter().flat_map(|one| one.inputs.chunks_exact(features.len())))
        .unwrap()
}

#[test]
fn there_are_thirty_six_inputs_and_a_state_changes_its_own() {
    let features = features();
    assert_eq!((features.len(), features.state()), (36, 10));
    let recorded = trajectories(0..1, 40).remove(0);
    let mut row = recorded.inputs_at(20).to_vec();
    features.set_state(recorded.state_at(20), &mut row);
    assert_eq!(row, recorded.inputs_at(20));
    // Goal − position of the second joint, and the aperture's, as the release orders them.
    assert_eq!(row[32], row[1] - row[6]);
    assert_eq!(row[35], row[30] - row[9]);
}

#[test]
fn the_gradient_of_the_closed_loop_is_that_of_differences() {
    let mut data = trajectories(0..3, 60);
    for (one, gain) in data.iter_mut().zip([200.0, 300.0, 450.0]) {
        one.position_gain = Some(gain);
    }
    let scale = scale(&data);
    let horizon = 20;
    let currents = CurrentModel::fit(&features(), &data).unwrap();
    let cases = [
        (TemporalForm::Window, simulation()),
        (TemporalForm::Streaming, simulation()),
        (TemporalForm::Window, with_friction(false, 0.0)),
        (TemporalForm::Window, with_friction(true, 0.0)),
        (TemporalForm::Streaming, with_friction(true, 0.0)),
        (TemporalForm::Streaming, with_friction(true, 0.1)),
        (TemporalForm::Streaming, with_drive()),
    ];
    for (form, simulation) in cases {
        let servo = simulation.options().servo.as_ref();
        let form = (form, servo.map(|servo| (servo.holds, servo.load_friction.clone())));
        let mut network = Transformer::<f64>::new(&shape(form.0), 5).unwrap();
        for (k, values) in network.parameters_mut().iter_mut().enumerate() {
            let mut stream = rng(2, &format!("{k}"));
            values.iter_mut().for_each(|value| *value += stream.random_range(-0.15..0.15));
        }
        // The last in pure simulation.
        let telemetry =
            |k: usize| if k == 2 { TelemetrySource::Modelled(&currents) } else { TelemetrySource::Recorded };
        let segments: Vec<Segment<'_>> = data
            .iter()
            .enumerate()
            .map(|(k, trajectory)| Segment { trajectory, start: 3 * k, telemetry: telemetry(k) })
            .collect();
        let initial: Vec<f64> =
            segments.iter().flat_map(|one| one.trajectory.state_at(one.start)).map(|x| x + 0.02).collect();
        let weights = LossWeights::PUBLISHED;
        let tapes = TapePool::default();
        let run = |network: &Transformer<f64>, initial: &[f64]| {
            horizon_gradient(
                (&simulation, &scale),
                (network, &tapes),
                &segments,
                (initial, horizon),
                &weights,
            )
        };
        let loss = |network: &Transformer<f64>, initial: &[f64]| run(network, initial).0.loss.sum();
        let (found, gradient) = run(&network, &initial);
        for (name, part) in [
            ("position", found.loss.position),
            ("gripper", found.loss.gripper),
            ("force", found.loss.force),
            ("gate", found.loss.gate),
            ("condition", found.loss.condition),
        ] {
            assert!(part > 0.0, "{name}");
        }
        // Central differences err by h² of the third derivative and by 1e-16/h of the loss: 1e-10 and some 1e-9 at h = 1e-6.
        let (h, tol) = (1e-6, 2e-7);
        for vector in 0..gradient.len() {
            let mut stream = rng(3, &format!("{vector}"));
            let direction: Vec<f64> =
                gradient[vector].iter().map(|_| stream.random_range(-1.0..1.0)).collect();
            let at = |h: f64| {
                let mut moved = network.clone();
                moved.parameters_mut()[vector].iter_mut().zip(&direction).for_each(|(p, d)| *p += h * d);
                loss(&moved, &initial)
            };
            let expected = (at(h) - at(-h)) / (2.0 * h);
            let along: f64 = gradient[vector].iter().zip(&direction).map(|(g, d)| g * d).sum();
            let size = gradient[vector].iter().map(|g| g * g).sum::<f64>().sqrt();
            assert!((along - expected).abs() <= tol * size.max(1.0), "{form:?} {vector}: {along} {expected}");
            assert!(size > 1e-3, "{form:?} {vector}: nothing to compare");
        }
        for k in 0..initial.len() {
            let at = |h: f64| {
                let mut moved = initial.clone();
                moved[k] += h;
                loss(&network, &moved)
            };
            let expected = (at(h) - at(-h)) / (2.0 * h);
            assert!(
                (found.initial[k] - expected).abs() <= tol * expected.abs().max(1.0),
                "{form:?} state {k}: {} {expected}",
                found.initial[k]
            );
        }
    }
}

fn options() -> NeuralOptions {
    NeuralOptions {
        horizons: vec![(0, 16), (100, 32)],
        start_noise: 0.02,
        learning_rate: (3e-3, 20),
        ema: 0.05,
        epoch: 30,
        validation_horizon: 200,
        rollouts: 8,
        // The condition of this data is drawn: there is nothing to learn of it.
        loss: LossWeights { condition: 1.0, ..LossWeights::PUBLISHED },
        ..NeuralOptions::published(1500, 300)
    }
}

#[test]
fn a_servo_is_learned_without_torques_and_the_training_resumes_bit_for_bit() {
    let (training, validation) = (trajectories(0..8, 240), trajectories(8..10, 240));
    let (simulation, scale, options) = (simulation(), scale(&training), options());
    let currents = CurrentModel::fit(&features(), &training).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let network = Transformer::<f32>::new(&shape(TemporalForm::Streaming), 1).unwrap();
    let run = |file: Option<&std::path::Path>, last: usize| {
        let mut task =
            NeuralTask::new(&options, (&simulation, &scale, &currents), [&training, &validation]).unwrap();
        let mut progress = |p: &hysteron_learn::TrainingProgress| !matches!(p, hysteron_learn::TrainingProgress::Epoch(epoch) if epoch.number == last);
        let mut session = TrainingSession { file, progress: &mut progress };
        fit(&mut task, network.clone(), &json!({ "test": 1 }), &mut session).unwrap()
    };
    let before = {
        let mut task =
            NeuralTask::new(&options, (&simulation, &scale, &currents), [&training, &validation]).unwrap();
        task.validate(&network).unwrap()
    };
    let whole = run(None, usize::MAX);
    // A network that knows nothing lets the arm fall; this one follows.
    assert!(before > 10.0 && whole.validation < 0.2 * before, "{before} {}", whole.validation);
    let path = folder.path().join("state");
    assert!(!run(Some(&path), 4).is_finished);
    let resumed = run(Some(&path), usize::MAX);
    assert_eq!(resumed.curve, whole.curve);
    assert_eq!(resumed.model.parameters(), whole.model.parameters());
    let _ = Training::load::<hysteron_base::json::Value>(&path, &network).unwrap();
    let actuator = NeuralActuator {
        network: whole.model,
        features: features(),
        scale,
        simulation: SimulationOptions::PUBLISHED,
        joints: ["joint1", "joint2", "joint3", "joint4"].map(str::to_owned).to_vec(),
        currents,
        sensing: None,
        contact: CONTACT,
        details: ActuatorDetails::default(),
    };
    let file = folder.path().join("actuator.safetensors");
    actuator.write(&file).unwrap();
    let read = NeuralActuator::read(&file).unwrap();
    let recorded = roll_out(&read, &simulation, &validation[0], TelemetrySource::Recorded);
    assert_eq!(recorded, roll_out(&actuator, &simulation, &validation[0], TelemetrySource::Recorded));
    // Pure simulation sees other currents, and stays with the arm.
    let pure = roll_out(&read, &simulation, &validation[0], TelemetrySource::Modelled(&read.currents));
    assert!(pure != recorded);
    let scores = pose_scores(&features(), &validation[..1], &[pure.positions], 200);
    assert!(scores.mean_deg() < 10.0, "{scores:?}");
    let refused = read.simulation(&Model::builtin("panda").unwrap()).unwrap_err().to_string();
    assert!(refused.contains("joints joint1, joint2, joint3, joint4"), "{refused}");
    let bytes = std::fs::read(&file).unwrap();
    std::fs::write(&file, &bytes[..bytes.len() / 2]).unwrap();
    let refused = NeuralActuator::read(&file).unwrap_err().to_string();
    assert!(refused.contains("a whole safetensors file"), "{refused}");
}

/// One whose network gives no torque.
fn silent_actuator(simulation: &ArmSimulation, training: &[Trajectory]) -> NeuralActuator {
    let network = Transformer::<f32>::new(&shape(TemporalForm::Streaming), 1).unwrap();
    NeuralActuator {
        network: network.with_silent_head(Heads::TORQUE),
        features: features(),
        scale: scale(training),
        simulation: simulation.options().clone(),
        joints: ["joint1", "joint2", "joint3", "joint4"].map(str::to_owned).to_vec(),
        currents: CurrentModel::fit(&features(), training).unwrap(),
        sensing: None,
        contact: CONTACT,
        details: ActuatorDetails::default(),
    }
}

#[test]
fn a_servo_in_the_loop_is_where_training_begins_and_no_worse_is_kept() {
    let (training, validation) = (trajectories(0..6, 240), trajectories(6..8, 240));
    let (simulation, scale) = (with_servo(), scale(&training));
    let currents = CurrentModel::fit(&features(), &training).unwrap();
    let actuator = silent_actuator(&simulation, &training);
    let network = actuator.network.clone();
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("actuator.safetensors");
    actuator.write(&file).unwrap();
    let read = NeuralActuator::read(&file).unwrap();
    assert_eq!(read.simulation, actuator.simulation);
    let m = features().motors();
    let servo = read.simulation.servo.clone().unwrap();
    let segment = Segment::recorded(&validation[0], 0);
    let alone = servo.run(&arm(), (&features(), PERIOD), &[segment], 239).unwrap();
    let alone: Vec<f64> = alone.chunks_exact(2 * m).flat_map(|state| &state[..m]).copied().collect();
    for telemetry in [TelemetrySource::Recorded, TelemetrySource::Modelled(&currents)] {
        let rollout = roll_out(&read, &read.simulation(&arm()).unwrap(), &validation[0], telemetry);
        assert_eq!(rollout.positions, alone);
    }
    let train = |learning_rate: f64| {
        let options = NeuralOptions {
            warm_start: 0,
            updates: 60,
            pure: 0.5,
            learning_rate: (learning_rate, 5),
            loss: LossWeights {
                position_bend: 0.005,
                force: 0.0,
                gate: 0.0,
                condition: 0.0,
                ..options().loss
            },
            ..options()
        };
        let setting = (&simulation, &scale, &currents);
        let mut task = NeuralTask::new(&options, setting, [&training, &validation]).unwrap();
        let before = task.validate(&network).unwrap();
        let mut session = TrainingSession { file: None, progress: &mut |_| true };
        (before, fit(&mut task, network.clone(), &json!({}), &mut session).unwrap())
    };
    let (before, found) = train(3e-3);
    assert!(found.epochs > 0 && found.validation < 0.8 * before, "{before} {}", found.validation);
    // A step size that spoils every network leaves the servo.
    let (before, found) = train(30.0);
    assert_eq!((found.epochs, found.validation), (0, before));
    assert_eq!(found.model.parameters(), network.parameters());
}

#[test]
fn an_actuator_is_adapted_to_a_changed_arm_by_two_trajectories() {
    let (known, asked) = (trajectories(0..2, 240), trajectories(6..8, 240));
    let before = silent_actuator(&with_servo(), &known);
    let after = before.adapted(&arm(), &known, (60, &mut |_| true)).unwrap();
    let error = |actuator: &NeuralActuator| {
        let simulation = actuator.simulation(&arm()).unwrap();
        let roll = |one: &Trajectory| {
            roll_out(actuator, &simulation, one, TelemetrySource::Modelled(&actuator.currents)).positions
        };
        let positions: Vec<Positions> = asked.iter().map(roll).collect();
        pose_scores(&features(), &asked, &positions, 239).mean_deg()
    };
    assert!(error(&after) < 0.3 * error(&before), "{} {}", error(&before), error(&after));
    // The servo that made the trajectories, and nothing at the tip.
    let servo = after.simulation.servo.as_ref().unwrap();
    for (found, true_stiffness) in servo.stiffness.iter().zip([20.0, 25.0, 20.0, 15.0]) {
        assert!((found / true_stiffness - 1.0).abs() < 0.1, "{servo:?}");
    }
    assert!(after.simulation.payload < 0.05, "{}", after.simulation.payload);
    let short = [known[0].rows(0..100)];
    let refused = before.adapted(&arm(), &short, (60, &mut |_| true)).unwrap_err().to_string();
    assert!(refused.contains("expected 128 samples or more to adapt to"), "{refused}");
    let alone = NeuralActuator { simulation: SimulationOptions::PUBLISHED, ..before.clone() };
    let refused = alone.adapted(&arm(), &known, (60, &mut |_| true)).unwrap_err().to_string();
    assert!(refused.contains("expected one with a servo in the loop"), "{refused}");
    assert!(
        before.adapted(&arm(), &[], (60, &mut |_| true)).unwrap_err().to_string().contains("one or more")
    );
}

#[test]
fn rivals_follow_what_they_are_made_for() {
    let data = trajectories(0..4, 200);
    let (features, model) = (features(), simulation());
    let m = features.motors();
    let goal: Vec<Positions> = data.iter().map(|one| copied_goal(&features, one)).collect();
    let lag = FirstOrderServo::fit(model.model(), &features, &data).unwrap();
    let lagged: Vec<Positions> =
        data.iter().map(|one| lag.positions(model.model(), &features, one)).collect();
    let servo =
        RolloutServo::fit(&arm(), (&features, PERIOD, &Motors::default()), &data, &|_, _| true).unwrap();
    let rolled: Vec<Positions> = data
        .iter()
        .map(|trajectory| {
            let segment = Segment::recorded(trajectory, 0);
            let states = servo.run(&arm(), (&features, PERIOD), &[segment], trajectory.len() - 1).unwrap();
            states.chunks_exact(2 * m).flat_map(|state| &state[..m]).copied().collect()
        })
        .collect();
    let [goal, lagged, rolled] =
        [goal, lagged, rolled].map(|all| pose_scores(&features, &data, &all, 200).mean_deg());
    // The data is a servo of the fitted kind; what its fit leaves is its tolerance.
    assert!(lagged < 0.5 * goal && rolled < 0.1 * goal, "{goal} {lagged} {rolled}");
}

#[test]
fn torques_by_inverse_dynamics_move_the_simulated_arm_as_recorded() {
    let data = trajectories(0..1, 200);
    let simulation = simulation();
    let m = features().motors();
    let torques = torques_of(&data[0], &simulation, 8.0).unwrap();
    let mut state = data[0].state_at(0).to_vec();
    let mut next = state.clone();
    let mut worst = 0.0f64;
    for (row, torques) in torques.chunks_exact(m).enumerate().take(100) {
        for k in 0..m {
            worst = worst.max((state[k] - data[0].state_at(row)[k]).abs());
        }
        simulation.step(&state, MotorCommand { goals: &[], gains: &[], windings: &[], torques }, &mut next);
        std::mem::swap(&mut state, &mut next);
    }
    // Open loop for 1.7 s: filtering at its beginning and a torque held for 17 ms leave a few degrees.
    assert!(worst < 0.1, "{worst}");
}

#[test]
fn friction_of_a_degraded_motor_is_found_by_the_detector_that_is_made_for_it() {
    // Degraded motors need a fifth of an ampere more along their motion: far above what else the current shows of speed and place.
    let worn = |one: Trajectory| {
        let features = features();
        let mut worn = one;
        if worn.is_healthy == Some(false) {
            for row in worn.inputs.chunks_exact_mut(features.len()) {
                row[features.currents() + 2] += 0.2 * (row[17] / 0.02).tanh();
            }
        }
        worn
    };
    let [known, asked] =
        [0..8, 8..12].map(|seeds| trajectories(seeds, 300).into_iter().map(worn).collect::<Vec<_>>());
    let silent: [&[ConditionEstimate]; 2] = [&[], &[]];
    let simulation = simulation();
    let all = detectors((simulation.model(), &features()), [&known, &asked], silent).unwrap();
    assert_eq!(all.len(), 4);
    assert!(all[1].area > 0.95, "{all:?}");
    assert!(all[2].area > 0.9 && all[3].area > 0.9, "{all:?}");
    let healthy = Trajectory { is_healthy: Some(true), ..asked[0].clone() };
    let bad = detectors((simulation.model(), &features()), [&known, &[healthy]], silent).unwrap_err();
    assert!(bad.to_string().contains("test recordings: expected healthy and degraded motors"), "{bad}");
}

#[test]
fn scores_are_those_of_their_definitions() {
    let data = trajectories(0..1, 200);
    let features = features();
    let m = features.motors();
    let mut off: Vec<f64> =
        data[0].states.chunks_exact(2 * m).flat_map(|state| &state[..m]).copied().collect();
    off.chunks_exact_mut(m).for_each(|row| row[m - 1] += 0.01);
    let poses = pose_scores(&features, &data, &[off], 100);
    // A line of 22.8 mm/rad opens the jaws; joints are where they were.
    assert!((poses.gripper_mm.unwrap() - 0.228).abs() < 1e-9 && poses.mean_deg() == 0.0, "{poses:?}");
    let label = |row: usize| data[0].force[row].unwrap();
    let exact: (Vec<[f64; 3]>, Vec<f64>) =
        (0..199).map(|row| (label(row), f64::from(u8::from(label(row)[2] != 0.0)))).unzip();
    let scores = force_scores(&data, std::slice::from_ref(&exact), (199, CONTACT)).unwrap();
    assert_eq!((scores.mean_of_axes_n, scores.false_contact, scores.missed_contact), (0.0, 0.0, 0.0));
    let off = (exact.0.iter().map(|f| [f[0], f[1], f[2] + 0.3]).collect(), vec![1.0; 199]);
    let scores = force_scores(&data, &[off], (199, CONTACT)).unwrap();
    // Three tenths of a newton along one axis of three.
    assert!((scores.mean_of_axes_n - 0.1).abs() < 1e-12 && (scores.loaded_axis_n - 0.3).abs() < 1e-12);
    assert!((scores.loaded_norm_n - 0.3).abs() < 1e-12 && scores.false_contact == 1.0);
    let unknown = Trajectory { force: vec![None; 200], ..data[0].clone() };
    assert_eq!(force_scores(&[unknown], &[exact], (199, CONTACT)), None);
    let values = [(0.9, true), (0.4, true), (0.4, false), (0.1, false)];
    assert_eq!(area_under_curve(&values), Some(0.875));
    assert_eq!(area_under_curve(&values[..2]), None);
    assert!((wrap(6.0) - (6.0 - std::f64::consts::TAU)).abs() < 1e-12);
}

/// A recording with one channel left out, or times changed.
fn changed(leave_out: &str, time: impl Fn(usize) -> f64) -> Recording {
    let whole = recording(1, 100);
    let channels = whole.channels().iter().filter(|channel| channel.name != leave_out).cloned().collect();
    let times = (0..whole.n_samples()).map(time).collect();
    Recording::new(times, channels, Vec::new(), whole.meta().clone()).unwrap()
}

#[test]
fn recordings_that_are_not_whole_or_at_another_rate_are_refused() {
    let refusal = |recording: &Recording| {
        trajectory_of(recording, &features(), PERIOD, Unlabelled::Unknown).unwrap_err().to_string()
    };
    let even = |i: usize| PERIOD * i as f64;
    for (channel, expected) in [
        ("current_3_a", "current_3_a"),
        ("voltage_1_v", "voltage_1_v"),
        ("goal_aperture_m", "goal_aperture_m"),
    ] {
        let found = refusal(&changed(channel, even));
        assert!(found.contains(expected), "{found}");
    }
    let found = refusal(&changed("", |i| 0.01 * i as f64));
    assert!(
        found.contains("time_s: expected steps of 0.017 s, within 10 %, got 0.01000 s in the median"),
        "{found}"
    );
    // Every tenth sample comes three periods late.
    let found = refusal(&changed("", |i| PERIOD * (i + 2 * (i / 10)) as f64));
    assert!(found.contains("time_s: expected at most 5 % of the steps longer than 1.5 periods"), "{found}");
    let filled = |gap: &dyn Fn(usize) -> bool| {
        let whole = recording(1, 100);
        let gap = (0..100).map(gap).collect();
        Recording::new(whole.time().to_vec(), whole.channels().to_vec(), gap, whole.meta().clone()).unwrap()
    };
    let found = refusal(&filled(&|i| i % 9 == 0));
    assert!(found.contains("gap: expected at most 10 % of the samples filled in, got 12.0 %"), "{found}");
    let tenth = filled(&|i| i % 10 == 0);
    assert!(trajectory_of(&tenth, &features(), PERIOD, Unlabelled::Unknown).is_ok());
    // No step is late, every other one is 45 % of a period off.
    let found = refusal(&changed("", |i| PERIOD * (i as f64 + 0.45 * (i / 2 % 2) as f64)));
    assert!(found.contains("scatter by at most 20 % about their median, got"), "{found}");
    // Without any channel of force nothing is known of it, unless the motion is labelled free.
    let mut channels = recording(1, 100).channels().to_vec();
    channels.retain(|channel| !channel.name.starts_with("force"));
    let times = (0..100).map(even).collect();
    let silent = Recording::new(times, channels, Vec::new(), Metadata::default()).unwrap();
    let of = |unlabelled| trajectory_of(&silent, &features(), PERIOD, unlabelled).unwrap();
    assert!(of(Unlabelled::Unknown).force.iter().all(Option::is_none));
    assert!(of(Unlabelled::Free).force.iter().all(|force| *force == Some([0.0; 3])));
    let short = recording(1, 20);
    assert!(refusal(&short).contains("32 samples or more"));
}
