//! Rigid-body dynamics of the Panda, single calls and batches in lanes, and rollouts of OpenManipulator-X with their gradients, on one
//! thread and on two.
#![allow(missing_docs)] // criterion's macros make undocumented functions
#![allow(clippy::unwrap_used, clippy::print_stdout)] // a benchmark may stop where it stands, and prints its proof

use std::hint::black_box;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use hysteron_arm_dynamics::kernels::{
    ForwardDerivatives, ForwardDynamics, InverseDynamicsKernel, MassMatrix,
};
use hysteron_arm_dynamics::*;
use hysteron_arm_learning::lagrangian::{InputForm, LearnedDynamics, NetworkShape, Scales, Variant};
use hysteron_learn::Activation;
use rand::RngExt;

/// States of a batch.
const N_STATES: usize = 4096;

/// Coordinates, speeds and torques, row by row.
fn states(n: usize) -> [Vec<f64>; 3] {
    let mut stream = hysteron_base::rng(7, "bench/arm");
    [1.0, 1.0, 10.0].map(|most| (0..N_STATES * n).map(|_| stream.random_range(-most..most)).collect())
}

fn single_calls(criterion: &mut Criterion) {
    let model = Model::builtin("panda").unwrap();
    let n = model.n_joints();
    let states = states(n);
    let (mut data, mut x) = (Data::new(&model, 0.0), vec![0.0; n]);
    let [mut a, mut b, mut c] = [0; 3].map(|_| vec![0.0; n * n]);
    let mut cotangent = Cotangent::new(&model, 0, 0.0);
    let mut k = 0;
    let mut next = || {
        k = (k + 1) % N_STATES;
        [0, 1, 2].map(|i| &states[i][n * k..n * (k + 1)])
    };
    let mut bench = |name: &str, call: &mut dyn FnMut([&[f64]; 3])| {
        criterion.bench_function(&format!("{name}/panda/single"), |bencher| bencher.iter(|| call(next())));
    };
    bench("rnea", &mut |state| inverse_dynamics(&model, &mut data, state, &[], black_box(&mut x)));
    bench("aba", &mut |state| forward_dynamics(&model, &mut data, state, &[], black_box(&mut x)));
    bench("crba", &mut |state| mass_matrix(&model, &mut data, state[0], black_box(&mut a)));
    bench("aba_derivatives", &mut |state| {
        let by = [&mut a[..], &mut b, &mut c];
        forward_dynamics_derivatives(&model, &mut data, state, &[], black_box(&mut x), by);
    });
    bench("aba_adjoint", &mut |state| {
        forward_dynamics(&model, &mut data, state, &[], &mut x);
        forward_dynamics_adjoint(&model, &mut data, &[], &x, black_box(&mut cotangent));
    });
}

/// Handles all states on `threads` threads.
fn batch<K: StateKernel>(criterion: &mut Criterion, name: &str, kernel: &K, threads: usize) {
    let model = Model::builtin("panda").unwrap();
    let states = states(model.n_joints());
    let inputs: Vec<&[f64]> = kernel.inputs(&model).iter().zip(&states).map(|(_, rows)| &rows[..]).collect();
    let mut outputs: Vec<Vec<f64>> =
        kernel.outputs(&model).iter().map(|width| vec![0.0; width * N_STATES]).collect();
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    let batch = Batch::new(&model);
    let mut group = criterion.benchmark_group(format!("{name}/panda/lanes"));
    group.throughput(Throughput::Elements(N_STATES as u64));
    group.bench_function(format!("threads={threads}"), |bencher| {
        bencher.iter(|| {
            let mut slices: Vec<&mut [f64]> = outputs.iter_mut().map(|rows| &mut rows[..]).collect();
            pool.install(|| batch.run(kernel, N_STATES, &inputs, &mut slices));
        });
    });
    group.finish();
    let sum: f64 = outputs.iter().flatten().sum();
    println!("    sum of all results {sum:.6e}");
}

fn batches(criterion: &mut Criterion) {
    for threads in [1, 2] {
        batch(criterion, "rnea", &InverseDynamicsKernel, threads);
        batch(criterion, "aba", &ForwardDynamics, threads);
        batch(criterion, "crba", &MassMatrix, threads);
        batch(criterion, "aba_derivatives", &ForwardDerivatives, threads);
    }
}

/// Steps of a rollout, in four parts each.
const STEPS: usize = 25;

/// OpenManipulator-X, its gripper locked unless friction moves its fingers together: rollouts, and there and back.
fn rollouts(criterion: &mut Criterion) {
    let whole = Model::builtin("open-manipulator-x").unwrap();
    let fingers = [("gripper_left_joint", 0.01), ("gripper_right_joint", 0.01)];
    let locked = whole.with_locked(&fingers).unwrap();
    let cases = [
        ("smooth", &locked, Integrator::SemiImplicitEuler),
        ("friction", &whole, Integrator::WithFriction(EndStops::Rigid)),
    ];
    for threads in [1, 2] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        for (name, model, integrator) in cases {
            rollout(criterion, (name, &pool), model, integrator);
        }
    }
}

fn rollout(
    criterion: &mut Criterion,
    (name, pool): (&str, &rayon::ThreadPool),
    model: &Model,
    integrator: Integrator,
) {
    const ARMS: usize = 256;
    let (n, isa) = (model.n_joints(), hysteron_base::lanes::Isa::detect());
    let mut stream = hysteron_base::rng(8, "bench/arm");
    let mut draw = |length: usize, most: f64| -> Vec<f64> {
        (0..length).map(|_| stream.random_range(-most..most)).collect()
    };
    let (initial, tau) = (draw(ARMS * 2 * n, 0.5), draw(ARMS * STEPS * n, 0.3));
    let rollouts =
        ArmRollouts { model, integrator, period: (0.01, 4), n_steps: STEPS, frames: Vec::new(), isa };
    let inputs = RolloutInputs { initial: &initial, tau: &tau, forces: &[], friction: &[] };
    let mut states = vec![0.0; ARMS * STEPS * 2 * n];
    let threads = pool.current_num_threads();
    let mut group = criterion.benchmark_group(format!("rollout/open-manipulator-x/{name}"));
    group.throughput(Throughput::Elements((ARMS * STEPS) as u64));
    group.bench_function(format!("threads={threads}"), |bencher| {
        bencher.iter(|| pool.install(|| rollouts.run(&inputs, &mut states)));
    });
    group.bench_function(format!("adjoint/threads={threads}"), |bencher| {
        bencher.iter(|| {
            pool.install(|| rollouts.run(&inputs, &mut states));
            black_box(pool.install(|| rollouts.pull_back(&inputs, &states, &states)));
        });
    });
    group.finish();
    println!("    sum of all states {:.6e}", states.iter().sum::<f64>());
}

/// The torque of a structured Lagrangian (DeLaN) of seven joints and 2 × 128 units, one sample at a time;
/// next to it the time of two passes over its weights, forward and backward, which it cannot do without, and
/// the torque of rigid bodies (`rnea/panda/single`).
fn learned_torque(criterion: &mut Criterion) {
    let n = 7;
    for activation in [Activation::Relu, Activation::Softplus, Activation::Tanh] {
        let shape = NetworkShape {
            variant: Variant::StructuredLagrangian,
            hidden: vec![128, 128],
            activation,
            epsilon: 1e-4,
            scales: Scales::ones(n),
            lengths: vec![None; n],
            inputs: InputForm::SinesAndCosines,
            squares: 0,
        };
        let parameters = shape.initial_parameters(1);
        let weights: Vec<f32> = parameters.iter().map(|p| *p as f32).collect();
        let mut stream = LearnedDynamics { shape, parameters }.stream();
        let [q, dq, ddq] = states(n);
        let (mut tau, mut k) = (vec![0.0; n], 0);
        let name = format!("delan/7 joints/2x128/{activation:?}").to_lowercase();
        criterion.bench_function(&name, |bencher| {
            bencher.iter(|| {
                k = (k + 1) % N_STATES;
                let row = n * k..n * (k + 1);
                stream.torque([&q[row.clone()], &dq[row.clone()], &ddq[row]], black_box(&mut tau));
            });
        });
        if activation == Activation::Relu {
            criterion.bench_function("delan/7 joints/2x128/weights read twice", |bencher| {
                bencher.iter(|| {
                    let pass = |at: f32| {
                        let mut sums = [at; 32];
                        for block in weights.as_chunks::<32>().0 {
                            sums.iter_mut().zip(block).for_each(|(sum, w)| *sum += w);
                        }
                        sums.iter().sum::<f32>()
                    };
                    black_box((0..2).fold(0.0, |sum, _| sum + pass(black_box(sum))))
                });
            });
        }
    }
}

criterion_group!(benches, single_calls, batches, rollouts, learned_torque);
criterion_main!(benches);
