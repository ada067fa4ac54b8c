//! Lanes and threads give what single calls give.

use hysteron_arm_dynamics::kernels::{
    ForwardDerivatives, ForwardDynamics, InverseDynamicsKernel, MassMatrix,
};
use hysteron_arm_dynamics::*;
use hysteron_base::lanes::Isa;
use rand::RngExt;

use hysteron_arm_fixtures::robots::{assert_close, model};

/// States of every input, row by row.
fn states(n_states: usize, n: usize) -> [Vec<f64>; 3] {
    let mut stream = hysteron_base::rng(5, "test/batch");
    [1.5, 2.0, 5.0].map(|scale| (0..n_states * n).map(|_| scale * stream.random_range(-1.0..1.0)).collect())
}

fn run<K: StateKernel>(batch: &Batch, model: &Model, kernel: &K, n_states: usize) -> Vec<f64> {
    let inputs = states(n_states, model.n_joints());
    let inputs: Vec<&[f64]> = kernel.inputs(model).iter().zip(&inputs).map(|(_, rows)| &rows[..]).collect();
    let mut outputs: Vec<Vec<f64>> =
        kernel.outputs(model).iter().map(|width| vec![0.0; width * n_states]).collect();
    let mut slices: Vec<&mut [f64]> = outputs.iter_mut().map(|rows| &mut rows[..]).collect();
    batch.run(kernel, n_states, &inputs, &mut slices);
    outputs.concat()
}

/// A number of states that fills neither the last register nor the last block of a thread.
const N_STATES: usize = 1003;

#[test]
fn every_instruction_set_gives_what_single_calls_give() {
    for name in ["panda", "so101"] {
        let model = model(name);
        let n = model.n_joints();
        let [q, dq, tau] = states(N_STATES, n);
        let (mut data, mut inverse, mut forward) =
            (Data::new(&model, 0.0), vec![0.0; q.len()], vec![0.0; q.len()]);
        for ((((q, dq), x), inverse), forward) in q
            .chunks(n)
            .zip(dq.chunks(n))
            .zip(tau.chunks(n))
            .zip(inverse.chunks_mut(n))
            .zip(forward.chunks_mut(n))
        {
            inverse_dynamics(&model, &mut data, [q, dq, x], &[], inverse);
            forward_dynamics(&model, &mut data, [q, dq, x], &[], forward);
        }
        for isa in Isa::all() {
            let batch = Batch::on(&model, isa);
            assert_close(
                &format!("{name}, {isa:?}"),
                &run(&batch, &model, &InverseDynamicsKernel, N_STATES),
                &inverse,
                1e-12,
            );
            // The condition of the mass matrix takes the rest.
            assert_close(
                &format!("{name}, {isa:?}"),
                &run(&batch, &model, &ForwardDynamics, N_STATES),
                &forward,
                1e-10,
            );
        }
    }
}

#[test]
fn any_number_of_threads_gives_the_same_bytes() {
    let model = model("panda");
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let batch = Batch::new(&model);
            let mut all = run(&batch, &model, &InverseDynamicsKernel, N_STATES);
            all.extend(run(&batch, &model, &ForwardDynamics, N_STATES));
            all.extend(run(&batch, &model, &MassMatrix, N_STATES));
            all.extend(run(&batch, &model, &ForwardDerivatives, N_STATES));
            all.iter().map(|x| x.to_bits()).collect::<Vec<u64>>()
        })
    };
    let one = on(1);
    assert!(one == on(2) && one == on(4));
}

#[test]
fn single_precision_is_close_to_double() {
    let model = model("panda");
    let n = model.n_joints();
    let [q, dq, ddq] = states(1, n);
    let (mut data, mut tau) = (Data::new(&model, 0.0_f64), vec![0.0; n]);
    inverse_dynamics(&model, &mut data, [&q, &dq, &ddq], &[], &mut tau);
    let single = [&q, &dq, &ddq].map(|x| x.iter().map(|x| *x as f32).collect::<Vec<f32>>());
    let (mut data, mut out) = (Data::new(&model, 0.0_f32), vec![0.0_f32; n]);
    inverse_dynamics(&model, &mut data, [&single[0], &single[1], &single[2]], &[], &mut out);
    let out: Vec<f64> = out.iter().map(|x| f64::from(*x)).collect();
    assert_close("f32", &out, &tau, 1e-5);
}
