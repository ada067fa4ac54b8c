//! Calls per second of the arm's algorithms on a URDF, as one JSON object: single calls, and states in batches of lanes.
//!
//!     cargo run --release -p hysteron-arm-dynamics --example dynamics_rates -- arm/dynamics/robots/panda.urdf [LOCKED_JOINT…]
//!
//! Processor time of one core, the best of seven rounds. `bench/peers/arm_dynamics_peer.py` runs it next to
//! other programs.
//! `speed_up_on_two_threads` is of wall-clock times, the best of two hundred short runs each.

use std::hint::black_box;
use std::time::{Duration, Instant};

use hysteron_arm_dynamics::kernels::{
    ForwardDerivatives, ForwardDynamics, InverseDynamicsKernel, MassMatrix,
};
use hysteron_arm_dynamics::*;
use hysteron_base::lanes::Isa;
use rand::RngExt;
use rustix::time::{ClockId, clock_gettime};

const STATES: usize = 256;

/// Processor time of this program [s].
fn now() -> f64 {
    let time = clock_gettime(ClockId::ProcessCPUTime);
    time.tv_sec as f64 + 1e-9 * time.tv_nsec as f64
}

/// States per second of `run`, which handles all of them.
fn rate(mut run: impl FnMut()) -> f64 {
    let mut best = 0.0_f64;
    for _ in 0..7 {
        let (start, mut calls, mut end) = (now(), 0, now());
        while end - start < 0.1 {
            run();
            calls += STATES;
            end = now();
        }
        best = best.max(calls as f64 / (end - start));
    }
    best.round()
}

struct States {
    n: usize,
    inputs: [Vec<f64>; 3],
}

impl States {
    fn at(&self, i: usize) -> [&[f64]; 3] {
        [0, 1, 2].map(|k| &self.inputs[k][self.n * i..self.n * (i + 1)])
    }
}

fn single(model: &Model, states: &States) -> serde_json::Value {
    let n = model.n_joints();
    let mut data = Data::new(model, 0.0);
    let (mut x, mut mass, [mut a, mut b, mut c]) =
        (vec![0.0; n], vec![0.0; n * n], [0; 3].map(|_| vec![0.0; n * n]));
    let inverse = rate(|| {
        for i in 0..STATES {
            inverse_dynamics(model, &mut data, states.at(i), &[], &mut x);
            black_box(&x);
        }
    });
    let forward = rate(|| {
        for i in 0..STATES {
            forward_dynamics(model, &mut data, states.at(i), &[], &mut x);
            black_box(&x);
        }
    });
    let composite = rate(|| {
        for i in 0..STATES {
            mass_matrix(model, &mut data, states.at(i)[0], &mut mass);
            black_box(&mass);
        }
    });
    let inverse_derivatives = rate(|| {
        for i in 0..STATES {
            inverse_dynamics_derivatives(model, &mut data, states.at(i), &[], [&mut a, &mut b, &mut c]);
            black_box(&a);
        }
    });
    let forward_derivatives = rate(|| {
        for i in 0..STATES {
            let by = [&mut a[..], &mut b, &mut c];
            forward_dynamics_derivatives(model, &mut data, states.at(i), &[], &mut x, by);
            black_box(&a);
        }
    });
    let (weights, mut gradient) = (vec![1.0; n], Cotangent::new(model, 0, 0.0));
    let adjoint = rate(|| {
        for i in 0..STATES {
            forward_dynamics(model, &mut data, states.at(i), &[], &mut x);
            forward_dynamics_adjoint(model, &mut data, &[], &weights, &mut gradient);
            black_box(&gradient);
        }
    });
    hysteron_base::json!({
        "inverse_dynamics": inverse, "forward_dynamics": forward, "mass_matrix": composite,
        "inverse_derivatives": inverse_derivatives, "forward_derivatives": forward_derivatives,
        "forward_and_adjoint": adjoint,
    })
}

fn batches(model: &Model, states: &States, isa: Isa) -> serde_json::Value {
    let n = model.n_joints();
    let batch = Batch::on(model, isa);
    let [q, dq, x] = &states.inputs;
    let (mut out, [mut a, mut b, mut c]) = (vec![0.0; STATES * n], [0; 3].map(|_| vec![0.0; STATES * n * n]));
    let inverse = rate(|| batch.run(&InverseDynamicsKernel, STATES, &[q, dq, x], &mut [&mut out]));
    let forward = rate(|| batch.run(&ForwardDynamics, STATES, &[q, dq, x], &mut [&mut out]));
    let composite = rate(|| batch.run(&MassMatrix, STATES, &[q], &mut [&mut a]));
    let derivatives = rate(|| {
        batch.run(&ForwardDerivatives, STATES, &[q, dq, x], &mut [&mut out, &mut a, &mut b, &mut c]);
    });
    hysteron_base::json!({
        "inverse_dynamics": inverse, "forward_dynamics": forward, "mass_matrix": composite,
        "forward_derivatives": derivatives,
    })
}

/// Steps of rollouts, in four parts each.
const STEPS: usize = 25;

/// Data steps per second of rollouts, there, and there and back.
fn rollouts(model: &Model, states: &States, isa: Isa, integrator: Integrator) -> serde_json::Value {
    let n = model.n_joints();
    let rollouts =
        ArmRollouts { model, integrator, period: (0.01, 4), n_steps: STEPS, frames: Vec::new(), isa };
    let initial: Vec<f64> = (0..STATES).flat_map(|i| states.at(i)[..2].concat()).collect();
    let tau: Vec<f64> = (0..STATES).flat_map(|i| states.at(i)[2].repeat(STEPS)).collect();
    let inputs = RolloutInputs { initial: &initial, tau: &tau, forces: &[], friction: &[] };
    let mut found = vec![0.0; STATES * STEPS * 2 * n];
    let weights = vec![1.0; found.len()];
    let forwards = rate(|| rollouts.run(&inputs, &mut found));
    let both = rate(|| {
        rollouts.run(&inputs, &mut found);
        black_box(rollouts.pull_back(&inputs, &found, &weights));
    });
    let steps = STEPS as f64;
    hysteron_base::json!({ "rollout": steps * forwards, "rollout_and_adjoint": steps * both })
}

/// Least wall-clock time that `run` takes on `threads` threads, of many short runs with pauses: other programs leave some of them alone [s].
fn fastest(threads: usize, mut run: impl FnMut() + Send) -> f64 {
    let Ok(pool) = rayon::ThreadPoolBuilder::new().num_threads(threads).build() else { return f64::NAN };
    let mut once = || {
        std::thread::sleep(Duration::from_millis(20));
        // Both threads are awake when the clock starts.
        pool.broadcast(|_| ());
        let start = Instant::now();
        pool.install(&mut run);
        start.elapsed().as_secs_f64()
    };
    (0..200).map(|_| once()).fold(f64::INFINITY, f64::min)
}

/// How much sooner two threads are done than one, for a batch and for rollouts with their gradients.
fn speed_up(model: &Model) -> serde_json::Value {
    let n = model.n_joints();
    let mut stream = hysteron_base::rng(2, "bench/arm");
    let mut draw = |length: usize| (0..length).map(|_| stream.random_range(-1.0..1.0)).collect::<Vec<f64>>();
    let n_states = 64 * STATES;
    let ([q, dq, x], mut out) = ([(); 3].map(|()| draw(n_states * n)), vec![0.0; n_states * n]);
    let batch = Batch::new(model);
    let mut forward = || batch.run(&ForwardDynamics, n_states, &[&q, &dq, &x], &mut [&mut out]);
    let (integrator, isa) = (Integrator::SemiImplicitEuler, Isa::detect());
    let rollouts =
        ArmRollouts { model, integrator, period: (0.01, 4), n_steps: STEPS, frames: Vec::new(), isa };
    let (initial, tau) = (draw(STATES * 2 * n), draw(STATES * STEPS * n));
    let inputs = RolloutInputs { initial: &initial, tau: &tau, forces: &[], friction: &[] };
    let mut found = vec![0.0; STATES * STEPS * 2 * n];
    let mut there_and_back = || {
        rollouts.run(&inputs, &mut found);
        black_box(rollouts.pull_back(&inputs, &found, &found));
    };
    hysteron_base::json!({
        "forward_dynamics": fastest(1, &mut forward) / fastest(2, &mut forward),
        "rollout_and_adjoint": fastest(1, &mut there_and_back) / fastest(2, &mut there_and_back),
    })
}

#[allow(clippy::print_stdout)] // what it is for
fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let (file, locked) = arguments.split_first().ok_or("a robot file is missing")?;
    let locked: Vec<(&str, f64)> = locked.iter().map(|name| (name.as_str(), 0.0)).collect();
    let model = Model::read(file.as_ref())?.with_locked(&locked)?;
    let n = model.n_joints();
    let mut stream = hysteron_base::rng(1, "bench/arm");
    let inputs = [0; 3].map(|_| (0..STATES * n).map(|_| stream.random_range(-1.0..1.0)).collect());
    let states = States { n, inputs };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    let mut report = hysteron_base::json!({ "joints": n, "single": single(&model, &states) });
    pool.install(|| {
        let instruction_sets = [
            ("lanes", Some(Isa::detect())),
            ("lanes_avx2", Isa::avx2()),
            ("lanes_portable", Some(Isa::portable())),
        ];
        for (way, isa) in instruction_sets.into_iter().filter_map(|(way, isa)| Some((way, isa?))) {
            report[way] = batches(&model, &states, isa);
            report[format!("{way}_rollouts")] = rollouts(&model, &states, isa, Integrator::SemiImplicitEuler);
            let with_friction = Integrator::WithFriction(EndStops::Rigid);
            report[format!("{way}_rollouts_with_friction")] = rollouts(&model, &states, isa, with_friction);
        }
    });
    report["speed_up_on_two_threads"] = speed_up(&model);
    println!("{report}");
    Ok(())
}
