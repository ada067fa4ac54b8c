//! The fused layers against candle's cells, and against an independent plain network in double precision.
#![allow(clippy::unwrap_used)] // a test may stop where it stands

use hysteron_base::rng;
use rand::RngExt;

use super::graph::Graph;
use crate::on_device::DeviceWeights;
use crate::{Architecture, HeadActivation, HeadOutputs, Memory, Network, SequenceBatch, TrainableModel};

/// Two chunks of rows, and three groups of 9, 9 and 1.
const STEPS: usize = 30;
const ROWS: usize = 19;
/// Sums of up to STEPS ROWS = 570 products in `f32` that went through up to 30 steps: √(570 · 30) ≈ 130 rounding
/// errors of 2⁻²⁴, and four times that.
const ACC: f64 = 520.0 * 0.5 * f32::EPSILON as f64;

fn architecture(head: HeadActivation) -> Architecture {
    Architecture { inputs: 3, hidden: 5, layers: 2, outputs: 2, head, dropout: 0.0 }
}

fn uniform(name: &str, n: usize) -> Vec<f32> {
    let mut stream = rng(1, name);
    (0..n).map(|_| stream.random_range(-1.0..1.0)).collect()
}

/// A case with random inputs, memory, dropout mask and weights w of the loss Σ w y.
struct Case {
    network: Network,
    inputs: Vec<f32>,
    memory: Memory,
    masks: Vec<Vec<f32>>,
    loss: Vec<f32>,
    outputs: HeadOutputs,
}

impl Case {
    fn new(head: HeadActivation, outputs: HeadOutputs) -> Self {
        let architecture = architecture(head);
        let mut memory = Memory::zeros(&architecture, ROWS);
        for (k, state) in memory.h.iter_mut().chain(&mut memory.c).enumerate() {
            *state = uniform(&format!("state {k}"), state.len());
        }
        let mask = uniform("mask", STEPS * ROWS * architecture.hidden);
        let n = if outputs == HeadOutputs::All { STEPS * ROWS } else { ROWS };
        Self {
            network: Network::new(&architecture, 5).unwrap(),
            inputs: uniform("inputs", STEPS * ROWS * architecture.inputs),
            memory,
            masks: vec![mask.iter().map(|v| if *v < 0.0 { 0.0 } else { 2.0 }).collect()],
            loss: uniform("loss", n * architecture.outputs),
            outputs,
        }
    }

    /// Outputs, gradients and the memory at the end.
    fn run(&self, graph: &Graph) -> (Vec<f32>, Vec<Vec<f32>>, Memory) {
        let batch = SequenceBatch { inputs: &self.inputs, steps: STEPS, rows: ROWS, outputs: self.outputs };
        let mut memory = self.memory.clone();
        let weights = DeviceWeights::new(graph.device(), self.network.parameters()).unwrap();
        let of = (self.network.architecture(), &weights);
        let pass = graph.forward(of, &batch, &mut memory, &self.masks).unwrap();
        let outputs = pass.outputs().unwrap();
        let gradients = pass.gradients(&weights, &self.loss).unwrap();
        (outputs, gradients.to_vecs().unwrap(), memory)
    }

    /// Σ w y by the textbook, number by number.
    fn reference(&self, parameters: &[Vec<f64>]) -> f64 {
        let architecture = self.network.architecture();
        let n = architecture.hidden;
        let sigmoid = |x: f64| 1.0 / (1.0 + (-x).exp());
        let mut value = 0.0;
        for row in 0..ROWS {
            let state = |all: &Vec<f32>| all[row * n..][..n].iter().map(|v| f64::from(*v)).collect();
            let mut h: Vec<Vec<f64>> = self.memory.h.iter().map(state).collect();
            let mut c: Vec<Vec<f64>> = self.memory.c.iter().map(state).collect();
            for step in 0..STEPS {
                let sample = step * ROWS + row;
                let x = &self.inputs[sample * architecture.inputs..][..architecture.inputs];
                let mut x: Vec<f64> = x.iter().map(|v| f64::from(*v)).collect();
                for layer in 0..architecture.layers {
                    if layer > 0 {
                        let mask = &self.masks[layer - 1][sample * n..][..n];
                        x.iter_mut().zip(mask).for_each(|(x, m)| *x *= f64::from(*m));
                    }
                    let p = &parameters[layer];
                    let z = |gate: usize, unit: usize| {
                        let k = gate * n + unit;
                        let from_x: f64 = (0..x.len()).map(|j| p[k * x.len() + j] * x[j]).sum();
                        let hh = 4 * n * x.len();
                        let from_h: f64 = (0..n).map(|j| p[hh + k * n + j] * h[layer][j]).sum();
                        from_x + from_h + p[hh + 4 * n * n + k]
                    };
                    let next: Vec<(f64, f64)> = (0..n)
                        .map(|k| {
                            let c = sigmoid(z(1, k)) * c[layer][k] + sigmoid(z(0, k)) * z(2, k).tanh();
                            (sigmoid(z(3, k)) * c.tanh(), c)
                        })
                        .collect();
                    (h[layer], c[layer]) = next.into_iter().unzip();
                    x.clone_from(&h[layer]);
                }
                let at = match self.outputs {
                    HeadOutputs::All => sample,
                    HeadOutputs::Last if step + 1 == STEPS => row,
                    HeadOutputs::Last => continue,
                };
                let p = &parameters[architecture.layers];
                for k in 0..architecture.outputs {
                    let y: f64 = (0..n).map(|j| p[k * n + j] * x[j]).sum::<f64>();
                    let y = y + p[architecture.outputs * n + k];
                    let y = if architecture.head == HeadActivation::Tanh { y.tanh() } else { y };
                    value += f64::from(self.loss[at * architecture.outputs + k]) * y;
                }
            }
        }
        value
    }
}

#[track_caller]
fn assert_near(what: &str, found: &[f32], expected: &[f64]) {
    let pairs = || found.iter().zip(expected);
    let off = pairs().map(|(a, b)| (f64::from(*a) - b).abs()).fold(0.0, f64::max);
    let scale = expected.iter().fold(0.0f64, |a, b| a.max(b.abs()));
    assert!(found.len() == expected.len() && scale > 0.0, "{what}: nothing to compare");
    assert!(off <= ACC * scale, "{what}: {off:.3e} > {ACC:.1e} · {scale:.3e}");
}

fn wide(values: &[f32]) -> Vec<f64> {
    values.iter().map(|v| f64::from(*v)).collect()
}

#[test]
fn gradients_are_derivatives_of_the_textbook_network() {
    /// Error of the central difference: about STEP² and 1e-16/STEP, far below ACC.
    const STEP: f64 = 1e-5;
    for (head, outputs) in
        [(HeadActivation::Linear, HeadOutputs::All), (HeadActivation::Tanh, HeadOutputs::Last)]
    {
        let case = Case::new(head, outputs);
        let (values, gradients, _) = case.run(&Graph::new(case.network.architecture()).unwrap());
        let mut parameters: Vec<Vec<f64>> = case.network.parameters.iter().map(|p| wide(p)).collect();
        let value: f64 = values.iter().zip(&case.loss).map(|(y, w)| f64::from(y * w)).sum();
        assert_near("loss", &[value as f32], &[case.reference(&parameters)]);
        for (part, gradient) in gradients.iter().enumerate() {
            let derivative = |k: usize| {
                let middle = parameters[part][k];
                let [above, below] = [middle + STEP, middle - STEP].map(|moved| {
                    parameters[part][k] = moved;
                    case.reference(&parameters)
                });
                parameters[part][k] = middle;
                (above - below) / (2.0 * STEP)
            };
            let expected: Vec<f64> = (0..gradient.len()).map(derivative).collect();
            assert_near(&format!("{head:?} {outputs:?}, gradient of part {part}"), gradient, &expected);
        }
    }
}

#[test]
fn layers_agree_with_the_cells_of_candle() {
    for (head, outputs) in
        [(HeadActivation::Tanh, HeadOutputs::All), (HeadActivation::Linear, HeadOutputs::Last)]
    {
        let case = Case::new(head, outputs);
        let architecture = case.network.architecture();
        let unrolled = case.run(&Graph::unrolled(architecture));
        for graph in [Graph::new(architecture).unwrap(), Graph::as_on_card(architecture)] {
            let own = case.run(&graph);
            assert_near("outputs", &own.0, &wide(&unrolled.0));
            for (own, unrolled) in own.1.iter().zip(&unrolled.1) {
                assert_near("gradient", own, &wide(unrolled));
            }
            let states = own.2.h.iter().zip(&unrolled.2.h).chain(own.2.c.iter().zip(&unrolled.2.c));
            for (own, unrolled) in states {
                assert_near("memory", own, &wide(unrolled));
            }
        }
    }
}
