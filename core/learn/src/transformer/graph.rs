//! The network by candle's own operations, which compute its derivatives: the reference that the fused passes
//! are checked and measured against.

use candle_core::backprop::GradStore;
use candle_core::{D, Device, Result, Tensor, Var, WithDType};
use candle_nn::ops::sigmoid;

use super::{BlockKind, TemporalForm, Transformer, TransformerShape};
use crate::on_device::{DeviceGradients, DeviceWeights, derivative};
use crate::{Error, Float, TensorShape, TrainableModel};

/// A [`Transformer`] as a graph of candle, on the processor.
pub struct TransformerGraph {
    shape: TransformerShape,
    rows: usize,
    leaves: Leaves,
    times: Option<SharedTensors>,
    /// Inputs of the last pass, and its outputs, time-major.
    pass: Option<(Var, Tensor)>,
}

impl TransformerGraph {
    /// The same network for sequences of `rows` side by side.
    ///
    /// # Errors
    /// candle refuses.
    pub fn new<T: Float + WithDType>(network: &Transformer<T>, rows: usize) -> crate::Result<Self> {
        let shape = network.shape().clone();
        let leaves = Leaves::new(&shape, &DeviceWeights::new(&Device::Cpu, network.parameters())?)?;
        Ok(Self { shape, rows, leaves, times: None, pass: None })
    }

    /// Outputs ([result][row][output]) for `inputs` ([step][row][input]).
    ///
    /// # Errors
    /// candle refuses.
    pub fn forward<T: WithDType>(&mut self, inputs: &[T]) -> crate::Result<Vec<T>> {
        let n = inputs.len() / (self.rows * self.shape.inputs);
        let given = Var::from_slice(inputs, (n, self.rows, self.shape.inputs), &Device::Cpu)?;
        let times = SharedTensors::again(self.times.take(), &self.shape, n, &given)?;
        let outputs = Operations { shape: &self.shape, leaves: &self.leaves, times: &times }.run(&given)?;
        let values = outputs.flatten_all()?.to_vec1()?;
        (self.times, self.pass) = (Some(times), Some((given, outputs)));
        Ok(values)
    }

    /// The derivatives of Σ `weights` · outputs of the last pass by each vector of parameters, then by the inputs.
    ///
    /// # Errors
    /// There was no pass, or candle refuses.
    pub fn backward<T: WithDType>(&self, weights: &[T]) -> crate::Result<Vec<Vec<T>>> {
        let Some((given, outputs)) = &self.pass else {
            return Err(Error::Tensors("no pass to go back through".to_owned()));
        };
        let weights = Tensor::from_slice(weights, outputs.shape(), &Device::Cpu)?;
        let found = (outputs * weights)?.sum_all()?.backward()?;
        let mut all = self.leaves.gradients(&found)?.to_vecs()?;
        all.push(derivative(&found, given)?.flatten_all()?.to_vec1()?);
        Ok(all)
    }
}

/// The named arrays of a network as variables of their own, for one pass: the backward pass through a slice
/// of a vector would fill a whole one with zeros for each of its arrays.
pub(super) struct Leaves(Vec<Vec<(String, Var)>>);

impl Leaves {
    /// Of weights as they are now.
    ///
    /// # Errors
    /// candle refuses.
    pub fn new(shape: &TransformerShape, weights: &DeviceWeights) -> Result<Self> {
        let of_vector = |(tensors, values): (&Vec<TensorShape>, &Var)| {
            let values = values.as_detached_tensor();
            let mut start = 0;
            let own = tensors.iter().map(|tensor| {
                let part = values.narrow(0, start, tensor.len())?.reshape(tensor.shape.clone())?;
                start += tensor.len();
                Ok((tensor.name.clone(), Var::from_tensor(&part)?))
            });
            own.collect::<Result<Vec<_>>>()
        };
        let vectors = shape.tensors();
        Ok(Self(vectors.iter().zip(weights.vectors()).map(of_vector).collect::<Result<_>>()?))
    }

    /// The derivatives by every vector; zeros where there are none.
    ///
    /// # Errors
    /// candle refuses.
    pub fn gradients(&self, found: &GradStore) -> Result<DeviceGradients> {
        let of_array = |(_, own): &(String, Var)| derivative(found, own)?.flatten_all();
        let of_vector =
            |own: &Vec<(String, Var)>| Tensor::cat(&own.iter().map(of_array).collect::<Result<Vec<_>>>()?, 0);
        Ok(DeviceGradients::new(self.0.iter().map(of_vector).collect::<Result<_>>()?))
    }

    fn find(&self, vector: usize, name: &str) -> Option<&Tensor> {
        self.0[vector].iter().find(|(own, _)| own.ends_with(name)).map(|(_, var)| var.as_tensor())
    }
}

/// Tensors that sequences of so many steps share, on the device.
#[derive(Debug)]
pub(super) struct SharedTensors {
    /// Lag of every step before every step (n · n), and the mask added to scores (n × n): a large negative
    /// number where attention is masked out. By definition, number by number.
    lags: Tensor,
    hidden: Tensor,
    /// Weights of every token in every result (results × n): the mean of those that count.
    pooling: Tensor,
}

impl SharedTensors {
    /// Those `before` for sequences of `n` steps, or new ones, where the inputs are.
    ///
    /// # Errors
    /// candle refuses.
    pub fn again(before: Option<Self>, shape: &TransformerShape, n: usize, inputs: &Tensor) -> Result<Self> {
        before.filter(|own| own.steps() == n).map_or_else(|| Self::new(shape, n, inputs), Ok)
    }

    fn new(shape: &TransformerShape, n: usize, inputs: &Tensor) -> Result<Self> {
        let (kind, device) = (inputs.dtype(), inputs.device());
        let sees = |q: usize, k: usize| k <= q && q - k < shape.tokens;
        let table = |of: &dyn Fn(usize, usize) -> f64, rows: usize| {
            let values: Vec<f64> = (0..rows * n).map(|i| of(i / n, i % n)).collect();
            Tensor::from_vec(values, (rows, n), device)?.to_dtype(kind)
        };
        let lags: Vec<u32> =
            (0..n * n).map(|i| if sees(i / n, i % n) { (i / n - i % n) as u32 } else { 0 }).collect();
        let pooling = match shape.form {
            TemporalForm::Window => table(&|_, _| 1.0 / n as f64, 1)?,
            // A recurrent layer's last token knows of the others.
            TemporalForm::Streaming if matches!(shape.block, BlockKind::Gru | BlockKind::Lstm) => {
                table(&|q, k| f64::from(u8::from(q == k)), n)?
            }
            TemporalForm::Streaming => {
                let n_attended = |q: usize| (q + 1).min(shape.tokens) as f64;
                table(&|q, k| if sees(q, k) { 1.0 / n_attended(q) } else { 0.0 }, n)?
            }
        };
        Ok(Self {
            lags: Tensor::from_vec(lags, n * n, device)?,
            hidden: table(&|q, k| if sees(q, k) { 0.0 } else { -1e30 }, n)?,
            pooling,
        })
    }

    /// Steps of the sequences.
    fn steps(&self) -> usize {
        self.pooling.dims()[1]
    }
}

/// The operations of a network over sequences of as many steps, where its weights are.
pub(super) struct Operations<'a> {
    pub shape: &'a TransformerShape,
    pub leaves: &'a Leaves,
    pub times: &'a SharedTensors,
}

impl Operations<'_> {
    /// From inputs (steps × rows × inputs) to outputs (results × rows × outputs).
    ///
    /// # Errors
    /// candle refuses.
    pub fn run(&self, inputs: &Tensor) -> Result<Tensor> {
        let shape = self.shape;
        let last = shape.layers + 1;
        let mut x = self.linear(0, "input", &inputs.transpose(0, 1)?.contiguous()?)?;
        if let Some(position) = self.leaves.find(0, "position") {
            x = x.broadcast_add(position)?;
        }
        for layer in 0..shape.layers {
            x = self.layer(layer, &x)?;
        }
        if shape.block == BlockKind::GatedPreNorm {
            x = self.norm(last, "norm", &x)?;
        }
        // (width × rows · steps) times the transposed pooling: one product for all rows.
        let (rows, n, d) = x.dims3()?;
        let tokens = x.transpose(1, 2)?.reshape((rows * d, n))?;
        let pooled = tokens.matmul(&self.times.pooling.t()?.contiguous()?)?.reshape((rows, d, ()))?;
        let latent = self.linear(last, "latent", &pooled.transpose(1, 2)?.contiguous()?)?.silu()?;
        let head = |k: usize| {
            let own = latent.narrow(2, k * shape.latent, shape.latent)?.contiguous()?;
            self.linear(last, &format!("head.{k}"), &own)
        };
        let heads = (0..shape.heads.len()).map(head).collect::<Result<Vec<_>>>()?;
        Tensor::cat(&heads, 2)?.transpose(0, 1)?.contiguous()
    }

    fn tensor(&self, vector: usize, name: &str) -> Result<&Tensor> {
        self.leaves.find(vector, name).ok_or_else(|| candle_core::Error::Msg(format!("no tensor {name}")))
    }

    fn linear(&self, vector: usize, name: &str, x: &Tensor) -> Result<Tensor> {
        let weight = self.tensor(vector, &format!("{name}.weight"))?;
        let mut sizes = x.dims().to_vec();
        let inputs = sizes.pop().unwrap_or_default();
        sizes.push(weight.dim(1)?);
        // One product: to broadcast the weights would copy them for every row.
        let y = x.reshape(((), inputs))?.matmul(weight)?.reshape(sizes)?;
        y.broadcast_add(self.tensor(vector, &format!("{name}.bias"))?)
    }

    fn norm(&self, vector: usize, name: &str, x: &Tensor) -> Result<Tensor> {
        let x = x.broadcast_sub(&x.mean_keepdim(D::Minus1)?)?;
        let spread = (x.sqr()?.mean_keepdim(D::Minus1)? + 1e-5)?.sqrt()?;
        let weight = self.tensor(vector, &format!("{name}.weight"))?;
        let bias = self.tensor(vector, &format!("{name}.bias"))?;
        x.broadcast_div(&spread)?.broadcast_mul(weight)?.broadcast_add(bias)
    }

    /// Added to the scores (heads × n × n); nothing in the published form.
    fn mask(&self, layer: usize) -> Result<Option<Tensor>> {
        let Some(lags) = self.leaves.find(1 + layer, "attention.lags") else { return Ok(None) };
        let n = self.times.steps();
        let of_pairs = lags.index_select(&self.times.lags, 1)?.reshape((self.shape.attention_heads, n, n))?;
        of_pairs.broadcast_add(&self.times.hidden).map(Some)
    }

    fn attention(&self, layer: usize, x: &Tensor) -> Result<Tensor> {
        let (d, heads) = (self.shape.width, self.shape.attention_heads);
        let (rows, n, _) = x.dims3()?;
        let all = self.linear(1 + layer, "attention", x)?;
        let is_gated = self.shape.block == BlockKind::GatedPreNorm;
        let first = if is_gated { 2 * d } else { d };
        let part = |at: usize| {
            let part = all.narrow(2, at, d)?.reshape((rows, n, heads, d / heads))?;
            part.transpose(1, 2)?.contiguous()
        };
        let (q, k, v) = (part(0)?, part(first)?, part(first + d)?);
        let mut scores = (q.matmul(&k.t()?.contiguous()?)? * (1.0 / ((d / heads) as f64).sqrt()))?;
        if let Some(mask) = self.mask(layer)? {
            scores = scores.broadcast_add(&mask)?;
        }
        let weights = scores.broadcast_sub(&scores.max_keepdim(D::Minus1)?.detach())?.exp()?;
        let weights = weights.broadcast_div(&weights.sum_keepdim(D::Minus1)?)?;
        let mut context = weights.matmul(&v)?.transpose(1, 2)?.reshape((rows, n, d))?;
        if is_gated {
            context = (context * sigmoid(&all.narrow(2, d, d)?)?)?;
        }
        self.linear(1 + layer, "attention.out", &context)
    }

    fn layer(&self, layer: usize, x: &Tensor) -> Result<Tensor> {
        let at = 1 + layer;
        match self.shape.block {
            BlockKind::GatedPreNorm => {
                let x = (x + self.attention(layer, &self.norm(at, "norm1", x)?)?)?;
                let hidden = gelu(&self.linear(at, "feed_forward", &self.norm(at, "norm2", &x)?)?)?;
                &x + self.linear(at, "feed_forward.out", &hidden)?
            }
            BlockKind::ScaledPostNorm => {
                let scale = |k: usize| self.tensor(at, "scales")?.narrow(0, k, 1);
                let context = self.attention(layer, x)?.broadcast_mul(&scale(0)?)?;
                let x = self.norm(at, "norm1", &(x + context)?)?;
                let hidden = self.linear(at, "feed_forward", &x)?.silu()?;
                let added = self.linear(at, "feed_forward.out", &hidden)?.broadcast_mul(&scale(1)?)?;
                self.norm(at, "norm2", &(x + added)?)
            }
            BlockKind::Gru | BlockKind::Lstm => self.recurrent(at, x),
        }
    }

    /// Hidden states of a recurrent layer, step by step.
    fn recurrent(&self, at: usize, x: &Tensor) -> Result<Tensor> {
        let (rows, n, d) = x.dims3()?;
        let zero = Tensor::zeros((rows, d), x.dtype(), x.device())?;
        let (mut h, mut c) = (zero.clone(), zero);
        let mut all = Vec::new();
        for s in 0..n {
            let token = self.linear(at, "cell", &x.narrow(1, s, 1)?.squeeze(1)?)?;
            let state = self.linear(at, "cell.state", &h)?;
            let of = |from: &Tensor, k: usize| from.narrow(1, k * d, d);
            let sum = |k: usize| of(&token, k)? + of(&state, k)?;
            if self.shape.block == BlockKind::Gru {
                let (z, r) = (sigmoid(&sum(0)?)?, sigmoid(&sum(1)?)?);
                let new = (of(&token, 2)? + (r * of(&state, 2)?)?)?.tanh()?;
                h = (((1.0 - &z)? * new)? + (z * h)?)?;
            } else {
                let (i, f, o) = (sigmoid(&sum(0)?)?, sigmoid(&sum(1)?)?, sigmoid(&sum(2)?)?);
                c = ((f * c)? + (i * sum(3)?.tanh()?)?)?;
                h = (o * c.tanh()?)?;
            }
            all.push(h.unsqueeze(1)?);
        }
        Tensor::cat(&all, 1)
    }
}

/// Of its parts: the derivative of candle's own has constants of six digits.
fn gelu(x: &Tensor) -> Result<Tensor> {
    let inner = (x + ((x.sqr()? * x)? * 0.044_715)?)?;
    let scaled = (inner * (2.0 * (2.0 / std::f64::consts::PI).sqrt()))?;
    x * sigmoid(&scaled)?
}
