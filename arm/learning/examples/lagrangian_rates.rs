//! Times of a structured Lagrangian (DeLaN) of seven joints and 2 × 128 units, as one JSON object: the torque of one sample, and
//! a step of training on 512 samples (loss, gradient, Adam).
//!
//!     cargo run --release -p hysteron-arm-learning --example lagrangian_rates
//!
//! Processor time, the best of several rounds; with RAYON_NUM_THREADS=1 that of one core. Of a step of training also the time by the
//! clock, which is shorter where there are more cores. `bench/peers/delan_peer.py` runs it next to JAX.

#![allow(clippy::print_stdout, clippy::unwrap_used)] // prints its result; may stop where it stands

use std::hint::black_box;
use std::time::Instant;

use hysteron_arm_learning::lagrangian::{
    ArmSamples, InputForm, JointWeights, LearnedDynamics, NetworkShape, Scales, TorqueObjective, Variant,
};
use hysteron_learn::{
    Activation, Adam, Decay, Objective, Schedule, TrainingProgress, TrainingSession, minimise,
};
use rustix::time::{ClockId, clock_gettime};

const JOINTS: usize = 7;
const BATCH: usize = 512;
const STEPS: usize = 20;
/// Rounds, one of them to warm up: as many as JAX has in the comparison.
const EPOCHS: usize = 21;

/// Processor time of this program [s].
fn now() -> f64 {
    let time = clock_gettime(ClockId::ProcessCPUTime);
    time.tv_sec as f64 + 1e-9 * time.tv_nsec as f64
}

fn samples() -> ArmSamples {
    let numbers =
        |seed: f64| (0..BATCH * STEPS * JOINTS).map(|i| (1.1 * i as f64 + seed).sin()).collect::<Vec<_>>();
    let mut samples = ArmSamples::new(JOINTS);
    let [q, dq, ddq, tau] = [0.0, 0.4, 0.9, 1.7].map(numbers);
    samples.push([&q, &dq, &ddq, &tau], [&[], &[]]).unwrap();
    samples
}

/// Shortest time of a torque [µs].
fn torque(shape: &NetworkShape) -> f64 {
    let parameters = shape.initial_parameters(1);
    let model = LearnedDynamics { shape: shape.clone(), parameters };
    let mut stream = model.stream();
    let (motion, mut tau) = ([[0.3; JOINTS], [0.7; JOINTS], [-0.2; JOINTS]], [0.0; JOINTS]);
    let calls = 2000;
    let mut best = f64::INFINITY;
    for _ in 0..15 {
        let start = now();
        for _ in 0..calls {
            stream.torque([&motion[0], &motion[1], &motion[2]], &mut tau);
            black_box(&tau);
        }
        best = best.min((now() - start) / f64::from(calls));
    }
    1e6 * best
}

/// Shortest mean time of a step in an epoch of training: of the processor, and by the clock [ms].
fn step(shape: &NetworkShape, samples: &ArmSamples) -> [f64; 2] {
    let adam = Adam { learning_rate: 1e-4, ..Adam::default() };
    let decay = Decay::Step { epochs: 1000, factor: 1.0 };
    let schedule = Schedule { epochs: EPOCHS, patience: EPOCHS, adam, decay, ema: None };
    let begin = shape.initial_parameters(1).into_iter().map(|p| p as f32).collect();
    let mut objective =
        NotEvaluated(TorqueObjective::<f32>::new(shape, [samples, samples], JointWeights::Equal, 0.0));
    let mut best = [f64::INFINITY; 2];
    let (mut start, mut start_by_clock) = (now(), Instant::now());
    let mut progress = |p: &TrainingProgress| {
        if let TrainingProgress::Epoch(_) = p {
            best = [best[0].min(now() - start), best[1].min(start_by_clock.elapsed().as_secs_f64())];
            (start, start_by_clock) = (now(), Instant::now());
        }
        true
    };
    let mut session = TrainingSession { file: None, progress: &mut progress };
    minimise(&mut objective, begin, (1, BATCH), &schedule, &(), &mut session).unwrap();
    best.map(|best| 1e3 * best / STEPS as f64)
}

/// The objective without its validation.
struct NotEvaluated<'a>(TorqueObjective<'a, f32>);

impl Objective<f32> for NotEvaluated<'_> {
    fn n_samples(&self) -> usize {
        self.0.n_samples()
    }

    fn gradient(&mut self, parameters: &[f32], samples: &[usize], gradient: &mut [f32]) -> f64 {
        self.0.gradient(parameters, samples, gradient)
    }

    fn validate(&mut self, _: &[f32]) -> f64 {
        0.0
    }
}

fn main() {
    let samples = samples();
    let shape = |activation| NetworkShape {
        variant: Variant::StructuredLagrangian,
        hidden: vec![128, 128],
        activation,
        epsilon: 1e-4,
        scales: Scales::ones(JOINTS),
        lengths: vec![None; JOINTS],
        inputs: InputForm::SinesAndCosines,
        squares: 0,
    };
    let report = [Activation::Relu, Activation::Softplus].map(|activation| {
        let shape = shape(activation);
        (activation, torque(&shape), step(&shape, &samples))
    });
    let of = |k: usize| {
        let (activation, torque, [step, by_clock]) = report[k];
        hysteron_base::json!({
            "activation": activation, "torque_us": torque,
            "training_step_ms": step, "training_step_by_clock_ms": by_clock,
        })
    };
    println!("{}", hysteron_base::json!({ "joints": JOINTS, "batch": BATCH, "models": [of(0), of(1)] }));
}
