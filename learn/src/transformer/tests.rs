//! The fused passes against candle's derivatives of the same network, and the forms against each other.
#![allow(clippy::unwrap_used)] // a test may stop where it stands

use candle_core::{D, Device, Tensor, Var};
use hysteron_base::rng;
use rand::RngExt;

use super::*;
use crate::{Model, WeightFormat};

const ROWS: usize = 3;

fn shape(block: Block, form: Form) -> TransformerShape {
    let heads = vec![5, 3, 1];
    TransformerShape {
        inputs: 7,
        heads,
        width: 24,
        layers: 2,
        attention_heads: 3,
        feed_forward: 40,
        latent: 10,
        tokens: 5,
        block,
        form,
    }
}

fn steps(form: Form) -> usize {
    if form == Form::Window { 5 } else { 13 }
}

fn uniform(name: &str, n: usize) -> Vec<f64> {
    let mut stream = rng(1, name);
    (0..n).map(|_| stream.random_range(-1.0..1.0)).collect()
}

/// A network of which no parameter is at its beginning.
fn network(shape: &TransformerShape) -> Transformer<f64> {
    let mut network = Transformer::new(shape, 3).unwrap();
    for (k, values) in network.parameters_mut().iter_mut().enumerate() {
        let noise = uniform(&format!("parameters {k}"), values.len());
        values.iter_mut().zip(noise).for_each(|(value, noise)| *value += 0.2 * noise);
    }
    network
}

/// Outputs and the gradients of Σ w y by parameters and inputs.
struct Found {
    outputs: Vec<f64>,
    gradient: Vec<Vec<f64>>,
    by_inputs: Vec<f64>,
}

fn fused(network: &Transformer<f64>, inputs: &[f64], weights: &[f64]) -> Found {
    let shape = network.shape();
    let n = steps(shape.form);
    let mut tape = TransformerTape::new(shape, n, ROWS);
    let outputs = tape.forward(network, 0..n, inputs).to_vec();
    let mut gradient = network.zeros();
    tape.clear_gradients();
    let by_inputs = tape.backward(network, 0..n, weights, &mut gradient).to_vec();
    tape.weight_gradients(network, n, &mut gradient);
    Found { outputs, gradient, by_inputs }
}

/// The network as a candle graph.
struct Graph {
    shape: TransformerShape,
    vars: Vec<Var>,
}

impl Graph {
    fn tensor(&self, vector: usize, name: &str) -> Option<Tensor> {
        let mut start = 0;
        for tensor in &self.shape.tensors()[vector] {
            if tensor.name.ends_with(name) {
                let flat = self.vars[vector].narrow(0, start, tensor.len()).unwrap();
                return Some(flat.reshape(tensor.shape.clone()).unwrap());
            }
            start += tensor.len();
        }
        None
    }

    fn linear(&self, vector: usize, name: &str, x: &Tensor) -> Tensor {
        let weight = self.tensor(vector, &format!("{name}.weight")).unwrap();
        let bias = self.tensor(vector, &format!("{name}.bias")).unwrap();
        x.broadcast_matmul(&weight).unwrap().broadcast_add(&bias).unwrap()
    }

    fn norm(&self, vector: usize, name: &str, x: &Tensor) -> Tensor {
        let mean = x.mean_keepdim(D::Minus1).unwrap();
        let x = x.broadcast_sub(&mean).unwrap();
        let spread = (x.sqr().unwrap().mean_keepdim(D::Minus1).unwrap() + 1e-5).unwrap().sqrt().unwrap();
        let weight = self.tensor(vector, &format!("{name}.weight")).unwrap();
        let bias = self.tensor(vector, &format!("{name}.bias")).unwrap();
        x.broadcast_div(&spread).unwrap().broadcast_mul(&weight).unwrap().broadcast_add(&bias).unwrap()
    }

    /// By definition, number by number of lags: added to the scores (heads × n × n), with what may not be seen far below.
    fn mask(&self, layer: usize, n: usize) -> Tensor {
        let heads = self.shape.attention_heads;
        let Some(lags) = self.tensor(1 + layer, "attention.lags") else {
            return Tensor::zeros((heads, n, n), candle_core::DType::F64, &Device::Cpu).unwrap();
        };
        // Row by row the lags in the order of the keys; unseen ones get a zero lag and a large negative number.
        let sees = |q: usize, k: usize| k <= q && q - k < self.shape.tokens;
        let index: Vec<u32> =
            (0..n * n).map(|i| if sees(i / n, i % n) { (i / n - i % n) as u32 } else { 0 }).collect();
        let hidden: Vec<f64> = (0..n * n).map(|i| if sees(i / n, i % n) { 0.0 } else { -1e30 }).collect();
        let index = Tensor::from_vec(index, n * n, &Device::Cpu).unwrap();
        let hidden = Tensor::from_vec(hidden, (n, n), &Device::Cpu).unwrap();
        lags.index_select(&index, 1).unwrap().reshape((heads, n, n)).unwrap().broadcast_add(&hidden).unwrap()
    }

    fn attention(&self, layer: usize, x: &Tensor) -> Tensor {
        let (d, heads) = (self.shape.width, self.shape.attention_heads);
        let (rows, n, _) = x.dims3().unwrap();
        let all = self.linear(1 + layer, "attention", x);
        let is_gated = self.shape.block == Block::GatedPreNorm;
        let first = if is_gated { 2 * d } else { d };
        let part = |at: usize| {
            let part = all.narrow(2, at, d).unwrap().reshape((rows, n, heads, d / heads)).unwrap();
            part.transpose(1, 2).unwrap().contiguous().unwrap()
        };
        let (q, k, v) = (part(0), part(first), part(first + d));
        let scale = 1.0 / ((d / heads) as f64).sqrt();
        let scores = (q.matmul(&k.t().unwrap().contiguous().unwrap()).unwrap() * scale).unwrap();
        let scores = scores.broadcast_add(&self.mask(layer, n)).unwrap();
        let most = scores.max_keepdim(D::Minus1).unwrap().detach();
        let weights = scores.broadcast_sub(&most).unwrap().exp().unwrap();
        let weights = weights.broadcast_div(&weights.sum_keepdim(D::Minus1).unwrap()).unwrap();
        let seen = weights.matmul(&v).unwrap().transpose(1, 2).unwrap().reshape((rows, n, d)).unwrap();
        let seen = if is_gated { (seen * sigmoid(&all.narrow(2, d, d).unwrap())).unwrap() } else { seen };
        self.linear(1 + layer, "attention.out", &seen)
    }

    fn layer(&self, layer: usize, x: &Tensor) -> Tensor {
        let at = 1 + layer;
        match self.shape.block {
            Block::GatedPreNorm => {
                let x = (x + self.attention(layer, &self.norm(at, "norm1", x))).unwrap();
                let hidden = gelu(&self.linear(at, "feed_forward", &self.norm(at, "norm2", &x)));
                (x + self.linear(at, "feed_forward.out", &hidden)).unwrap()
            }
            Block::ScaledPostNorm => {
                let scale = |k: usize| self.tensor(at, "scales").unwrap().narrow(0, k, 1).unwrap();
                let seen = self.attention(layer, x).broadcast_mul(&scale(0)).unwrap();
                let x = self.norm(at, "norm1", &(x + seen).unwrap());
                let hidden = self.linear(at, "feed_forward", &x).silu().unwrap();
                let added = self.linear(at, "feed_forward.out", &hidden).broadcast_mul(&scale(1)).unwrap();
                self.norm(at, "norm2", &(x + added).unwrap())
            }
            Block::Gru | Block::Lstm => self.remembered(at, x),
        }
    }

    /// Hidden states of a recurrent layer, step by step.
    fn remembered(&self, at: usize, x: &Tensor) -> Tensor {
        let (rows, n, d) = x.dims3().unwrap();
        let zero = Tensor::zeros((rows, d), candle_core::DType::F64, &Device::Cpu).unwrap();
        let (mut h, mut c) = (zero.clone(), zero);
        let mut all = Vec::new();
        for s in 0..n {
            let token = self.linear(at, "cell", &x.narrow(1, s, 1).unwrap().squeeze(1).unwrap());
            let state = self.linear(at, "cell.state", &h);
            let of = |from: &Tensor, k: usize| from.narrow(1, k * d, d).unwrap();
            let sum = |k: usize| (of(&token, k) + of(&state, k)).unwrap();
            if self.shape.block == Block::Gru {
                let (z, r) = (sigmoid(&sum(0)), sigmoid(&sum(1)));
                let n = (of(&token, 2) + (r * of(&state, 2)).unwrap()).unwrap().tanh().unwrap();
                h = (((1.0 - &z).unwrap() * n).unwrap() + (z * h).unwrap()).unwrap();
            } else {
                let [i, f, o] = [0, 1, 2].map(|k| sigmoid(&sum(k)));
                c = ((f * c).unwrap() + (i * sum(3).tanh().unwrap()).unwrap()).unwrap();
                h = (o * c.tanh().unwrap()).unwrap();
            }
            all.push(h.unsqueeze(1).unwrap());
        }
        Tensor::cat(&all, 1).unwrap()
    }

    /// From inputs (rows × steps × inputs) to outputs (rows × results × outputs).
    fn run(&self, inputs: &Tensor) -> Tensor {
        let shape = &self.shape;
        let last = shape.layers + 1;
        let mut x = self.linear(0, "input", inputs);
        if let Some(position) = self.tensor(0, "position") {
            x = x.broadcast_add(&position).unwrap();
        }
        for layer in 0..shape.layers {
            x = self.layer(layer, &x);
        }
        if shape.block == Block::GatedPreNorm {
            x = self.norm(last, "norm", &x);
        }
        let n = x.dim(1).unwrap();
        let mean = |from: usize, to: usize| x.narrow(1, from, to - from).unwrap().mean_keepdim(1).unwrap();
        // A recurrent layer's last token knows of the others.
        let pooled = if matches!(shape.block, Block::Gru | Block::Lstm) { 1 } else { shape.tokens };
        let pooled = match shape.form {
            Form::Window => mean(0, n),
            Form::Streaming => {
                let all: Vec<Tensor> = (0..n).map(|s| mean((s + 1).saturating_sub(pooled), s + 1)).collect();
                Tensor::cat(&all, 1).unwrap()
            }
        };
        let latent = self.linear(last, "latent", &pooled).silu().unwrap();
        let head = |k: usize| {
            let own = latent.narrow(2, k * shape.latent, shape.latent).unwrap();
            self.linear(last, &format!("head.{k}"), &own)
        };
        Tensor::cat(&(0..shape.heads.len()).map(head).collect::<Vec<_>>(), 2).unwrap()
    }
}

fn sigmoid(x: &Tensor) -> Tensor {
    ((x.neg().unwrap().exp().unwrap() + 1.0).unwrap()).recip().unwrap()
}

/// Of its parts: candle's own derivative has constants of six digits.
fn gelu(x: &Tensor) -> Tensor {
    let inner = (x + (x.powf(3.0).unwrap() * 0.044_715).unwrap()).unwrap();
    let scaled = (inner * (2.0 * (2.0 / std::f64::consts::PI).sqrt())).unwrap();
    (x * sigmoid(&scaled)).unwrap()
}

fn by_candle(network: &Transformer<f64>, inputs: &[f64], weights: &[f64]) -> Found {
    let shape = network.shape().clone();
    let vars = network.parameters().iter().map(|v| Var::from_slice(v, v.len(), &Device::Cpu).unwrap());
    let graph = Graph { shape: shape.clone(), vars: vars.collect() };
    let n = steps(shape.form);
    let given = Var::from_slice(inputs, (n, ROWS, shape.inputs), &Device::Cpu).unwrap();
    let outputs = graph.run(&given.transpose(0, 1).unwrap().contiguous().unwrap());
    let outputs = outputs.transpose(0, 1).unwrap().contiguous().unwrap();
    let weights = Tensor::from_slice(weights, outputs.shape(), &Device::Cpu).unwrap();
    let gradients = (&outputs * weights).unwrap().sum_all().unwrap().backward().unwrap();
    let of = |var: &Var| gradients.get(var).unwrap().flatten_all().unwrap().to_vec1().unwrap();
    Found {
        outputs: outputs.flatten_all().unwrap().to_vec1().unwrap(),
        gradient: graph.vars.iter().map(of).collect(),
        by_inputs: of(&given),
    }
}

/// Rounding of double precision in sums of some thousand products of numbers of about 1.
const TOL: f64 = 1e-11;

fn assert_close(what: &str, found: &[f64], expected: &[f64]) {
    assert_eq!(found.len(), expected.len(), "{what}");
    let scale = expected.iter().fold(1.0f64, |max, v| max.max(v.abs()));
    for (k, (found, expected)) in found.iter().zip(expected).enumerate() {
        assert!((found - expected).abs() <= TOL * scale, "{what} {k}: {found} {expected}");
    }
    assert!(expected.iter().any(|v| v.abs() > 1e-3), "{what}: nothing to compare");
}

const FORMS: [Form; 2] = [Form::Window, Form::Streaming];
const BLOCKS: [Block; 4] = [Block::GatedPreNorm, Block::ScaledPostNorm, Block::Gru, Block::Lstm];

/// Recurrent layers stream.
fn is_there(block: Block, form: Form) -> bool {
    form == Form::Streaming || matches!(block, Block::GatedPreNorm | Block::ScaledPostNorm)
}

/// Inputs, and weights of the loss, for a shape.
fn case(shape: &TransformerShape) -> (Vec<f64>, Vec<f64>) {
    let n = steps(shape.form);
    let results = if shape.form == Form::Window { 1 } else { n };
    (uniform("inputs", n * ROWS * shape.inputs), uniform("loss", results * ROWS * shape.outputs()))
}

#[test]
fn values_and_gradients_are_candles() {
    for form in FORMS {
        for block in BLOCKS.into_iter().filter(|block| is_there(*block, form)) {
            let shape = shape(block, form);
            let network = network(&shape);
            let (inputs, weights) = case(&shape);
            let found = fused(&network, &inputs, &weights);
            let expected = by_candle(&network, &inputs, &weights);
            let what = format!("{form:?} {block:?}");
            assert_close(&format!("{what} outputs"), &found.outputs, &expected.outputs);
            assert_close(&format!("{what} inputs"), &found.by_inputs, &expected.by_inputs);
            for (k, (found, expected)) in found.gradient.iter().zip(&expected.gradient).enumerate() {
                assert_close(&format!("{what} parameters {k}"), found, expected);
            }
        }
    }
}

#[test]
fn token_by_token_is_as_the_whole_sequence_and_so_is_its_gradient() {
    for block in BLOCKS {
        let shape = shape(block, Form::Streaming);
        let network = network(&shape);
        let (inputs, weights) = case(&shape);
        let whole = fused(&network, &inputs, &weights);
        let n = steps(Form::Streaming);
        let mut tape = TransformerTape::new(&shape, n, ROWS);
        let of_step = |values: &[f64], s: usize| {
            let width = values.len() / n;
            values[s * width..][..width].to_vec()
        };
        let mut outputs = Vec::new();
        for s in 0..n {
            outputs.extend_from_slice(tape.forward(&network, s..s + 1, &of_step(&inputs, s)));
        }
        assert_close("outputs", &outputs, &whole.outputs);
        let mut gradient = network.zeros();
        tape.clear_gradients();
        for s in (0..n).rev() {
            let by_inputs = tape.backward(&network, s..s + 1, &of_step(&weights, s), &mut gradient);
            assert_close(&format!("inputs of step {s}"), by_inputs, &of_step(&whole.by_inputs, s));
        }
        tape.weight_gradients(&network, n, &mut gradient);
        for (k, (found, expected)) in gradient.iter().zip(&whole.gradient).enumerate() {
            assert_close(&format!("parameters {k}"), found, expected);
        }
    }
}

#[test]
fn a_runner_steps_as_the_network_that_was_trained() {
    for form in FORMS {
        for block in BLOCKS.into_iter().filter(|block| is_there(*block, form)) {
            let shape = shape(block, form);
            let network = network(&shape).converted::<f32>();
            // Longer than what the streaming form keeps before it moves it.
            let n = 150;
            let inputs: Vec<f32> =
                uniform("inputs", n * shape.inputs).into_iter().map(|v| v as f32).collect();
            let mut runner = TransformerRunner::new(&network, WeightFormat::Float32);
            let stepped: Vec<Vec<f32>> =
                inputs.chunks(shape.inputs).map(|x| runner.step(x).to_vec()).collect();
            let mut whole =
                TransformerTape::new(&shape, if form == Form::Window { shape.tokens } else { n }, 1);
            for s in 0..n {
                let expected = match form {
                    Form::Streaming => {
                        whole.forward(&network, s..s + 1, &inputs[s * shape.inputs..][..shape.inputs])
                    }
                    Form::Window => {
                        let sample = |k: usize| (s + 1 + k).saturating_sub(shape.tokens);
                        let window: Vec<f32> = (0..shape.tokens)
                            .flat_map(|k| &inputs[sample(k) * shape.inputs..][..shape.inputs])
                            .copied()
                            .collect();
                        whole.forward(&network, 0..shape.tokens, &window)
                    }
                };
                for (found, expected) in stepped[s].iter().zip(expected) {
                    // Sums of up to 40 products in single precision, through some 20 of them, of numbers below about 4.
                    assert!(
                        (found - expected).abs() <= 4.0 * 20.0 * 40f32.sqrt() * f32::EPSILON,
                        "{form:?} {s}: {found} {expected}"
                    );
                }
            }
            runner.reset();
            assert_eq!(runner.step(&inputs[..shape.inputs]), stepped[0]);
        }
    }
}

#[test]
fn a_step_allocates_nothing_and_short_weights_are_near() {
    for form in FORMS {
        let shape = TransformerShape::published(36, &[5, 3, 1, 5], form);
        let network = Transformer::<f32>::new(&shape, 1).unwrap();
        let mut runner = TransformerRunner::new(&network, WeightFormat::Float32);
        let mut short = TransformerRunner::new(&network, WeightFormat::Int16);
        let x = vec![0.3; 36];
        let first = runner.step(&x).to_vec();
        let found = allocation_counter::measure(|| {
            for _ in 0..100 {
                runner.step(&x);
            }
        });
        assert_eq!(found.count_total, 0, "{form:?}");
        let largest = first.iter().fold(0.0f32, |max, v| max.max(v.abs()));
        for (short, long) in short.step(&x).iter().zip(&first) {
            assert!((short - long).abs() < 1e-3 * largest, "{short} {long}");
        }
    }
}

#[test]
fn sizes_that_cannot_be_are_refused() {
    let shape = TransformerShape::published(36, &[5, 3, 1, 5], Form::Window);
    let refused = |change: fn(&mut TransformerShape)| {
        let mut shape = shape.clone();
        change(&mut shape);
        Transformer::<f32>::new(&shape, 1).unwrap_err().to_string()
    };
    assert!(
        refused(|s| s.attention_heads = 5).contains("width: expected a multiple of the 5 attention heads")
    );
    assert!(refused(|s| s.block = Block::Gru).contains("form: expected streaming"));
    assert!(refused(|s| s.tokens = 0).contains("tokens"));
    assert!(refused(|s| s.heads.clear()).contains("heads"));
}

#[test]
fn the_published_sizes_have_the_published_number_of_parameters_but_for_what_the_text_leaves_open() {
    let of = |heads: &[usize]| TransformerShape::published(36, heads, Form::Window).n_parameters();
    // A head for the condition of five motors is the difference between the two printed counts, exactly.
    assert_eq!(of(&[5, 3, 1, 5]) - of(&[5, 3, 1]), 1_441_838 - 1_422_825);
    // The release has 1.4 % more, in parts that neither paper nor design notes place.
    assert_eq!(1_441_838 - of(&[5, 3, 1, 5]), 20_832);
}
