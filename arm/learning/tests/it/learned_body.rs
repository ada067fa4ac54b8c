//! Learned models in place of dynamics from a file: their balance of momentum, an observer, a controller.

use hysteron_arm_dynamics::{Data, EndStops, Model, Simulator, forward_dynamics};
use hysteron_arm_estimation::ComputedTorque;
use hysteron_arm_estimation::observer::{
    ArmSample, Dynamics, FrictionModel, MomentumObserver, Observer, RigidBody,
};
use hysteron_arm_learning::lagrangian::{ArmSamples, Scales};
use hysteron_arm_learning::lagrangian::{
    InputForm, LearnedDynamics, NetworkShape, Polish, Sinusoids, TrainingOptions, Variant, sinusoids, train,
};
use hysteron_learn::{Activation, TrainingSession};

const N: usize = 3;

/// Torques at (q, q̇) for a motion that is desired.
type Control<'a> = &'a mut dyn FnMut([&[f64]; 2], [&[f64]; 3], &mut [f64]);

const INPUTS: InputForm = InputForm::Products(3);

fn shape(variant: Variant, scales: Scales) -> NetworkShape {
    let lengths = vec![None; N];
    NetworkShape {
        variant,
        hidden: vec![4; 2],
        activation: Activation::Tanh,
        epsilon: 1e-4,
        scales,
        lengths,
        inputs: INPUTS,
        squares: 6,
    }
}

/// A three-link arm learned from fifty motions.
fn learned() -> LearnedDynamics {
    let model = Model::builtin("three-link").unwrap();
    let (all, _) =
        sinusoids(&model, &Sinusoids { duration: 2.0, ..Sinusoids::published(60) }, 1, "learned body");
    let [training, validation]: [ArmSamples; 2] = [all.select(0..50), all.select(50..60)];
    let variant = Variant::StructuredLagrangian;
    let scales = Scales::of(&training, variant, INPUTS);
    let shape = shape(variant, scales);
    let options = TrainingOptions {
        polish: 60,
        polish_samples: 1500,
        polish_by: Polish::LevenbergMarquardt { batch: 1500 },
        learning_rate: 5e-3,
        ..TrainingOptions::normalised(3)
    };
    let mut session = TrainingSession { file: None, progress: &mut |_| true };
    let found = train(&shape, [&training, &validation], &options, 1, &mut session).unwrap();
    LearnedDynamics { shape, parameters: found.parameters }
}

/// A motion of all joints and its derivatives at a time.
fn motion(t: f64) -> [[f64; N]; 3] {
    let wave = |j: usize| (0.6 + 0.2 * j as f64, 1.1 + 0.4 * j as f64);
    let of = |f: &dyn Fn(f64, f64) -> f64| {
        std::array::from_fn(|j| {
            let (amplitude, rate) = wave(j);
            f(amplitude, rate)
        })
    };
    [of(&|a, w| a * (w * t).sin()), of(&|a, w| a * w * (w * t).cos()), of(&|a, w| -a * w * w * (w * t).sin())]
}

#[test]
fn momentum_changes_by_the_torque_and_by_what_position_and_speed_ask_for() {
    // ṗ = τ + Cᵀq̇ − g − τ_f along any motion, ṗ by central differences of step h: errors of h² and 1e-16/h.
    let (h, tol) = (1e-5, 1e-8);
    for variant in [Variant::StructuredLagrangian, Variant::Friction] {
        let shape = shape(variant, Scales::ones(N));
        let begin = shape.initial_parameters(3);
        let parameters = begin.iter().enumerate().map(|(i, p)| p + 0.2 * (1.3 * i as f64).sin()).collect();
        let mut body = LearnedDynamics { shape, parameters }.body().unwrap();
        for t in [0.2, 1.3, 2.9] {
            let mut at = |t: f64| {
                let [q, dq, _] = motion(t);
                let [mut momentum, mut rate] = [[0.0; N]; 2];
                body.momentum(&q, &dq, &mut momentum, &mut rate);
                [momentum, rate]
            };
            let ([after, _], [before, _], [momentum, rate]) = (at(t + h), at(t - h), at(t));
            let [q, dq, ddq] = motion(t);
            let (mut torque, mut mass) = ([0.0; N], [0.0; N * N]);
            body.inverse(&q, &dq, &ddq, &mut torque);
            body.mass(&q, &mut mass);
            for j in 0..N {
                let change = (after[j] - before[j]) / (2.0 * h);
                assert!((change - torque[j] - rate[j]).abs() < tol, "{variant:?} {t} {j}");
                let product: f64 = (0..N).map(|k| mass[N * j + k] * dq[k]).sum();
                assert!((product - momentum[j]).abs() < 1e-12, "{variant:?} {t} {j}");
            }
        }
    }
}

#[test]
fn an_observer_with_a_learned_arm_finds_the_push_that_one_with_the_true_arm_finds() {
    let model = Model::builtin("three-link").unwrap();
    let learned = learned();
    let gains = [30.0; N];
    let mut own = MomentumObserver::new(learned.body().unwrap(), FrictionModel::none(N), &gains);
    let mut truth = MomentumObserver::new(RigidBody::new(&model), FrictionModel::none(N), &gains);
    let mut exact = RigidBody::new(&model);
    // Held on its motion by exact torques while the last joints are pushed for half of the time.
    let period = 2e-3;
    let push = |t: f64| if t > 0.5 { [0.0, 0.3, -0.15] } else { [0.0; N] };
    let [mut found, mut expected] = [[0.0; N]; 2];
    let [mut largest, mut of_model] = [[0.0f64; N]; 2];
    let mut body = learned.body().unwrap();
    for step in 0..500 {
        let t = f64::from(step) * period;
        let [q, dq, _] = motion(t);
        let mut torque = [0.0; N];
        let [middle, speed, acceleration] = motion(t - 0.5 * period);
        exact.inverse(&middle, &speed, &acceleration, &mut torque);
        let mut modelled = [0.0; N];
        body.inverse(&middle, &speed, &acceleration, &mut modelled);
        (0..N).for_each(|j| of_model[j] = of_model[j].max((modelled[j] - torque[j]).abs()));
        torque.iter_mut().zip(push(t)).for_each(|(tau, push)| *tau -= push);
        let sample = ArmSample { period, position: &q, velocity: &dq, torque: &torque };
        own.update(&sample, &mut found);
        truth.update(&sample, &mut expected);
        for j in 0..N {
            largest[j] = largest[j].max((found[j] - expected[j]).abs());
        }
    }
    // A first-order low pass of the model's error is never larger than that error; a tenth for the trapezoidal rule.
    for j in 0..N {
        assert!(largest[j] < 1.1 * of_model[j], "joint {j}: {largest:?} {of_model:?}");
    }
    assert!(of_model[1] < 0.3 / 2.0 && (found[1] - 0.3).abs() < 0.3 / 2.0, "{found:?} {of_model:?}");
}

#[test]
fn computed_torques_of_a_learned_arm_hold_the_true_arm_on_its_way() {
    let model = Model::builtin("three-link").unwrap();
    let period = 2e-3;
    // Largest error over the last two seconds of three, in every joint, with these dynamics in the controller.
    let follow = |control: Control<'_>| {
        let mut simulator = Simulator::new(&model, period, 4, EndStops::None);
        let [mut q, mut dq, _] = motion(0.0);
        let mut largest: f64 = 0.0;
        for step in 0..1500 {
            let t = f64::from(step) * period;
            let [desired, speed, acceleration] = motion(t + 0.5 * period);
            let mut torque = [0.0; N];
            control([&q, &dq], [&desired, &speed, &acceleration], &mut torque);
            simulator.step([&mut q, &mut dq], &torque, &[]);
            let [there, ..] = motion(t + period);
            if t > 1.0 {
                (0..N).for_each(|j| largest = largest.max((q[j] - there[j]).abs()));
            }
        }
        largest
    };
    let mut own = ComputedTorque::new(learned().body().unwrap(), &[20.0; N]);
    let mut exact = ComputedTorque::new(RigidBody::new(&model), &[20.0; N]);
    let with_learned = follow(&mut |state, desired, torque| own.torque(state, desired, torque));
    let with_exact = follow(&mut |state, desired, torque| exact.torque(state, desired, torque));
    // The same feedback about a constant mass matrix knows neither gravity nor coupling.
    let without = follow(&mut |[q, dq], desired, torque| {
        for j in 0..N {
            let error = 400.0 * (desired[0][j] - q[j]) + 40.0 * (desired[1][j] - dq[j]);
            torque[j] = [0.3, 0.1, 0.01][j] * (desired[2][j] + error);
        }
    });
    // The error obeys ë + 2ω ė + ω² e = M⁻¹ δτ, whose gain is 1/ω² at most; half as much again because the arm is not exactly on its way.
    let (mut body, mut data, mut off) = (learned().body().unwrap(), Data::new(&model, 0.0), 0.0f64);
    for step in 0..300 {
        let [q, dq, ddq] = motion(0.01 * f64::from(step));
        let (mut torque, mut found) = ([0.0; N], [0.0; N]);
        body.inverse(&q, &dq, &ddq, &mut torque);
        forward_dynamics(&model, &mut data, [&q, &dq, &torque], &[], &mut found);
        (0..N).for_each(|j| off = off.max((found[j] - ddq[j]).abs()));
    }
    assert!(with_learned < with_exact + 1.5 * off / 400.0, "{with_exact} {with_learned} {off}");
    assert!(with_learned < 0.5 * without, "{with_learned} {without}");
}

#[test]
fn models_without_a_mass_matrix_are_refused() {
    for variant in [Variant::FeedForward, Variant::BlackBoxLagrangian, Variant::StructuredHamiltonian] {
        let shape = shape(variant, Scales::ones(N));
        let parameters = shape.initial_parameters(1);
        let bad = LearnedDynamics { shape, parameters }.body().err().unwrap().to_string();
        assert!(bad.contains("expected a model with a mass matrix of velocities"), "{bad}");
    }
}
