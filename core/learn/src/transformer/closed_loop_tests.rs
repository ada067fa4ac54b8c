//! Gradients of rollouts in a linear plant: against their closed form where the network gives a constant, and against differences.
#![allow(clippy::unwrap_used)] // a test may stop where it stands

use hysteron_base::rng;
use rand::RngExt;

use super::*;
use crate::TrainableModel;

const ROWS: usize = 3;
const HORIZON: usize = 7;
const A: [[f64; 2]; 2] = [[0.9, 0.2], [-0.3, 0.8]];
const B: [f64; 2] = [0.5, 1.5];

/// x⁺ = A x + B y; the network's inputs are x and, from a recording, the number of the step.
struct Linear;

impl PlantBatch<f64> for Linear {
    fn rows(&self) -> usize {
        ROWS
    }

    fn state_len(&self) -> usize {
        2
    }

    fn observe(&self, row: usize, step: isize, state: Option<&[f64]>, token: &mut [f64]) {
        token[..2].copy_from_slice(state.unwrap_or(&[0.1, -0.2]));
        token[2] = 0.1 * step as f64 + row as f64;
    }

    fn observe_back(&self, _: usize, _: usize, _: &[f64], by_token: &[f64], by_state: &mut [f64]) {
        by_state.iter_mut().zip(by_token).for_each(|(sum, part)| *sum += part);
    }

    fn step(&mut self, _: usize, states: &[f64], outputs: &[f64], next: &mut [f64]) {
        for ((x, y), next) in states.chunks_exact(2).zip(outputs).zip(next.chunks_exact_mut(2)) {
            (0..2).for_each(|i| next[i] = A[i][0] * x[0] + A[i][1] * x[1] + B[i] * y);
        }
    }

    fn step_back(
        &mut self,
        _: usize,
        _: (&[f64], &[f64]),
        by_next: &[f64],
        by_states: &mut [f64],
        by_outputs: &mut [f64],
    ) {
        let rows = by_states.chunks_exact_mut(2).zip(by_outputs);
        for ((by_state, by_output), by_next) in rows.zip(by_next.chunks_exact(2)) {
            (0..2).for_each(|j| by_state[j] += A[0][j] * by_next[0] + A[1][j] * by_next[1]);
            *by_output += B[0] * by_next[0] + B[1] * by_next[1];
        }
    }
}

fn uniform(name: &str, n: usize) -> Vec<f64> {
    let mut stream = rng(1, name);
    (0..n).map(|_| stream.random_range(-1.0..1.0)).collect()
}

fn network(form: TemporalForm) -> Transformer<f64> {
    with_block(BlockKind::GatedPreNorm, form)
}

fn with_block(block: BlockKind, form: TemporalForm) -> Transformer<f64> {
    let shape = TransformerShape {
        inputs: 3,
        heads: vec![1],
        width: 8,
        layers: 1,
        attention_heads: 2,
        feed_forward: 12,
        latent: 5,
        tokens: 4,
        block,
        form,
    };
    let mut network = Transformer::new(&shape, 3).unwrap();
    for (k, values) in network.parameters_mut().iter_mut().enumerate() {
        let noise = uniform(&format!("parameters {k}"), values.len());
        values.iter_mut().zip(noise).for_each(|(value, noise)| *value += 0.3 * noise);
    }
    network
}

#[test]
fn a_constant_input_to_a_linear_plant_has_the_gradient_in_closed_form() {
    for form in [TemporalForm::Window, TemporalForm::Streaming] {
        let mut network = network(form);
        let [weight, bias] = network.layout.heads[0].clone();
        let head = network.parameters_mut().last_mut().unwrap();
        head[weight].fill(0.0);
        head[bias.clone()].fill(0.7);
        let initial = uniform("initial", 2 * ROWS);
        let mut rollouts = ClosedLoop::new(Linear, (&network, None), HORIZON);
        rollouts.run(&initial);
        // Half the square of the last state, whose gradient is that state.
        let mut loss = |(step, _): (usize, usize), x: &[f64], _: &[f64], [by_state, _]: [&mut [f64]; 2]| {
            if step + 1 == HORIZON {
                by_state.copy_from_slice(x);
            }
        };
        let mut gradient = network.zeros();
        let by_initial = rollouts.pull_back(&mut loss, &mut gradient);
        // By the state, (Aᵀ)ᴴ x; by the input, Σ Bᵀ (Aᵀ)ᵏ x over k < H.
        let mut by_bias = 0.0;
        for (row, by_initial) in by_initial.chunks_exact(2).enumerate() {
            let mut pulled: [f64; 2] =
                rollouts.states()[(HORIZON * ROWS + row) * 2..][..2].try_into().unwrap();
            for _ in 0..HORIZON {
                by_bias += B[0] * pulled[0] + B[1] * pulled[1];
                pulled = [0, 1].map(|j| A[0][j] * pulled[0] + A[1][j] * pulled[1]);
            }
            assert_near(by_initial[0], pulled[0]);
            assert_near(by_initial[1], pulled[1]);
        }
        let head = gradient.pop().unwrap();
        assert_near(head[bias][0], by_bias);
        assert!(gradient.iter().flatten().all(|by| *by == 0.0), "{form:?}: a constant has no other source");
    }
}

/// Sums of some dozens of products of numbers up to about 3, in another order.
fn assert_near(found: f64, expected: f64) {
    assert!((found - expected).abs() < 256.0 * f64::EPSILON, "{found} {expected}");
}

/// Σ w·(x, y) over all steps and rows, and its gradient by parameters and initial states.
fn weighted(network: &Transformer<f64>, initial: &[f64]) -> (f64, Vec<Vec<f64>>, Vec<f64>) {
    let tapes = TapePool::default();
    let mut rollouts = ClosedLoop::new(Linear, (network, Some(&tapes)), HORIZON);
    rollouts.run(initial);
    let weights = uniform("weights", HORIZON * ROWS * 3);
    let mut value = 0.0;
    let mut loss = |(step, row): (usize, usize), x: &[f64], y: &[f64], [by_x, by_y]: [&mut [f64]; 2]| {
        let w = &weights[(step * ROWS + row) * 3..][..3];
        value += w[0] * x[0] + w[1] * x[1] + w[2] * y[0];
        by_x.copy_from_slice(&w[..2]);
        by_y.copy_from_slice(&w[2..]);
    };
    let mut gradient = network.zeros();
    let by_initial = rollouts.pull_back(&mut loss, &mut gradient);
    (value, gradient, by_initial)
}

#[test]
fn gradients_through_network_and_plant_are_derivatives() {
    /// Error of the central difference: about STEP² and 1e-16/STEP, relative to the largest derivative.
    const STEP: f64 = 1e-5;
    const ACC: f64 = 1e-8;
    let published =
        [TemporalForm::Window, TemporalForm::Streaming].map(|form| (BlockKind::GatedPreNorm, form));
    let recurrent = [BlockKind::Gru, BlockKind::Lstm].map(|block| (block, TemporalForm::Streaming));
    for (block, form) in published.into_iter().chain(recurrent) {
        let (network, initial) = (with_block(block, form), uniform("initial", 2 * ROWS));
        let (_, gradient, by_initial) = weighted(&network, &initial);
        let check = |what: &str, along: f64, above: f64, below: f64| {
            let difference = (above - below) / (2.0 * STEP);
            assert!(along.abs() > 1e-3, "{block:?} {form:?}, {what}: nothing to compare, {along}");
            let scale = along.abs().max(1.0);
            assert!(
                (along - difference).abs() < ACC * scale,
                "{block:?} {form:?}, {what}: {along} {difference}"
            );
        };
        for part in 0..gradient.len() {
            let direction = uniform(&format!("direction {part}"), gradient[part].len());
            let length = direction.iter().map(|d| d * d).sum::<f64>().sqrt();
            let direction: Vec<f64> = direction.iter().map(|d| d / length).collect();
            let along = gradient[part].iter().zip(&direction).map(|(g, d)| g * d).sum();
            let [above, below] = [STEP, -STEP].map(|step| {
                let mut moved = network.clone();
                moved.parameters_mut()[part].iter_mut().zip(&direction).for_each(|(p, d)| *p += step * d);
                weighted(&moved, &initial).0
            });
            check(&format!("parameters {part}"), along, above, below);
        }
        for k in 0..initial.len() {
            let [above, below] = [STEP, -STEP].map(|step| {
                let mut moved = initial.clone();
                moved[k] += step;
                weighted(&network, &moved).0
            });
            check(&format!("initial {k}"), by_initial[k], above, below);
        }
    }
}
