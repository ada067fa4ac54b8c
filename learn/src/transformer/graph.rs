//! The network by candle's own operations, which finds its derivatives itself: what the fused passes are checked against and measured
//! beside.

use candle_core::{D, DType, Device, Result, Tensor, Var, WithDType};

use super::{Block, Form, Transformer, TransformerShape};
use crate::{Error, Model, Real};

/// A [`Transformer`] as a graph of candle.
pub struct TransformerGraph {
    shape: TransformerShape,
    rows: usize,
    kind: DType,
    /// Parameters, as the network has them.
    vars: Vec<Var>,
    /// Inputs and outputs of the last pass, time-major.
    pass: Option<(Var, Tensor)>,
}

impl TransformerGraph {
    /// The same network for sequences of `rows` side by side.
    ///
    /// # Errors
    /// candle refuses.
    pub fn new<T: Real + WithDType>(network: &Transformer<T>, rows: usize) -> crate::Result<Self> {
        let vars = network.parameters().iter().map(|v| Var::from_slice(v, v.len(), &Device::Cpu));
        let vars = vars.collect::<Result<_>>()?;
        Ok(Self { shape: network.shape().clone(), rows, kind: T::DTYPE, vars, pass: None })
    }

    /// Outputs ([result][row][output]) for `inputs` ([step][row][input]).
    ///
    /// # Errors
    /// candle refuses.
    pub fn forward<T: WithDType>(&mut self, inputs: &[T]) -> crate::Result<Vec<T>> {
        let n = inputs.len() / (self.rows * self.shape.inputs);
        let given = Var::from_slice(inputs, (n, self.rows, self.shape.inputs), &Device::Cpu)?;
        let outputs = self.run(&given.transpose(0, 1)?.contiguous()?)?.transpose(0, 1)?.contiguous()?;
        let values = outputs.flatten_all()?.to_vec1()?;
        self.pass = Some((given, outputs));
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
        let gradients = (outputs * weights)?.sum_all()?.backward()?;
        let of = |var: &Var| match gradients.get(var) {
            Some(gradient) => gradient.flatten_all()?.to_vec1(),
            None => var.zeros_like()?.flatten_all()?.to_vec1(),
        };
        Ok(self.vars.iter().chain([given]).map(of).collect::<Result<_>>()?)
    }

    fn find(&self, vector: usize, name: &str) -> Result<Option<Tensor>> {
        let mut start = 0;
        for tensor in &self.shape.tensors()[vector] {
            if tensor.name.ends_with(name) {
                let flat = self.vars[vector].narrow(0, start, tensor.len())?;
                return flat.reshape(tensor.shape.clone()).map(Some);
            }
            start += tensor.len();
        }
        Ok(None)
    }

    fn tensor(&self, vector: usize, name: &str) -> Result<Tensor> {
        self.find(vector, name)?.ok_or_else(|| candle_core::Error::Msg(format!("no tensor {name}")))
    }

    fn linear(&self, vector: usize, name: &str, x: &Tensor) -> Result<Tensor> {
        let weight = self.tensor(vector, &format!("{name}.weight"))?;
        let mut sizes = x.dims().to_vec();
        let inputs = sizes.pop().unwrap_or_default();
        sizes.push(weight.dim(1)?);
        // One product: to broadcast the weights would copy them for every row.
        let y = x.reshape(((), inputs))?.matmul(&weight)?.reshape(sizes)?;
        y.broadcast_add(&self.tensor(vector, &format!("{name}.bias"))?)
    }

    fn norm(&self, vector: usize, name: &str, x: &Tensor) -> Result<Tensor> {
        let x = x.broadcast_sub(&x.mean_keepdim(D::Minus1)?)?;
        let spread = (x.sqr()?.mean_keepdim(D::Minus1)? + 1e-5)?.sqrt()?;
        let weight = self.tensor(vector, &format!("{name}.weight"))?;
        let bias = self.tensor(vector, &format!("{name}.bias"))?;
        x.broadcast_div(&spread)?.broadcast_mul(&weight)?.broadcast_add(&bias)
    }

    /// By definition, number by number of lags: added to the scores (heads × n × n), with what may not be seen far below. Nothing in
    /// the published form.
    fn mask(&self, layer: usize, n: usize) -> Result<Option<Tensor>> {
        let heads = self.shape.attention_heads;
        let Some(lags) = self.find(1 + layer, "attention.lags")? else { return Ok(None) };
        // Row by row the lags in the order of the keys; unseen ones get a zero lag and a large negative number.
        let sees = |q: usize, k: usize| k <= q && q - k < self.shape.tokens;
        let index: Vec<u32> =
            (0..n * n).map(|i| if sees(i / n, i % n) { (i / n - i % n) as u32 } else { 0 }).collect();
        let hidden: Vec<f64> = (0..n * n).map(|i| if sees(i / n, i % n) { 0.0 } else { -1e30 }).collect();
        let index = Tensor::from_vec(index, n * n, &Device::Cpu)?;
        let hidden = Tensor::from_vec(hidden, (n, n), &Device::Cpu)?.to_dtype(self.kind)?;
        lags.index_select(&index, 1)?.reshape((heads, n, n))?.broadcast_add(&hidden).map(Some)
    }

    fn attention(&self, layer: usize, x: &Tensor) -> Result<Tensor> {
        let (d, heads) = (self.shape.width, self.shape.attention_heads);
        let (rows, n, _) = x.dims3()?;
        let all = self.linear(1 + layer, "attention", x)?;
        let is_gated = self.shape.block == Block::GatedPreNorm;
        let first = if is_gated { 2 * d } else { d };
        let part = |at: usize| {
            let part = all.narrow(2, at, d)?.reshape((rows, n, heads, d / heads))?;
            part.transpose(1, 2)?.contiguous()
        };
        let (q, k, v) = (part(0)?, part(first)?, part(first + d)?);
        let mut scores = (q.matmul(&k.t()?.contiguous()?)? * (1.0 / ((d / heads) as f64).sqrt()))?;
        if let Some(mask) = self.mask(layer, n)? {
            scores = scores.broadcast_add(&mask)?;
        }
        let weights = scores.broadcast_sub(&scores.max_keepdim(D::Minus1)?.detach())?.exp()?;
        let weights = weights.broadcast_div(&weights.sum_keepdim(D::Minus1)?)?;
        let mut seen = weights.matmul(&v)?.transpose(1, 2)?.reshape((rows, n, d))?;
        if is_gated {
            seen = (seen * sigmoid(&all.narrow(2, d, d)?)?)?;
        }
        self.linear(1 + layer, "attention.out", &seen)
    }

    fn layer(&self, layer: usize, x: &Tensor) -> Result<Tensor> {
        let at = 1 + layer;
        match self.shape.block {
            Block::GatedPreNorm => {
                let x = (x + self.attention(layer, &self.norm(at, "norm1", x)?)?)?;
                let hidden = gelu(&self.linear(at, "feed_forward", &self.norm(at, "norm2", &x)?)?)?;
                &x + self.linear(at, "feed_forward.out", &hidden)?
            }
            Block::ScaledPostNorm => {
                let scale = |k: usize| self.tensor(at, "scales")?.narrow(0, k, 1);
                let seen = self.attention(layer, x)?.broadcast_mul(&scale(0)?)?;
                let x = self.norm(at, "norm1", &(x + seen)?)?;
                let hidden = self.linear(at, "feed_forward", &x)?.silu()?;
                let added = self.linear(at, "feed_forward.out", &hidden)?.broadcast_mul(&scale(1)?)?;
                self.norm(at, "norm2", &(x + added)?)
            }
            Block::Gru | Block::Lstm => self.remembered(at, x),
        }
    }

    /// Hidden states of a recurrent layer, step by step.
    fn remembered(&self, at: usize, x: &Tensor) -> Result<Tensor> {
        let (rows, n, d) = x.dims3()?;
        let zero = Tensor::zeros((rows, d), self.kind, &Device::Cpu)?;
        let (mut h, mut c) = (zero.clone(), zero);
        let mut all = Vec::new();
        for s in 0..n {
            let token = self.linear(at, "cell", &x.narrow(1, s, 1)?.squeeze(1)?)?;
            let state = self.linear(at, "cell.state", &h)?;
            let of = |from: &Tensor, k: usize| from.narrow(1, k * d, d);
            let sum = |k: usize| of(&token, k)? + of(&state, k)?;
            if self.shape.block == Block::Gru {
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

    /// From inputs (rows × steps × inputs) to outputs (rows × results × outputs).
    fn run(&self, inputs: &Tensor) -> Result<Tensor> {
        let shape = &self.shape;
        let last = shape.layers + 1;
        let mut x = self.linear(0, "input", inputs)?;
        if let Some(position) = self.find(0, "position")? {
            x = x.broadcast_add(&position)?;
        }
        for layer in 0..shape.layers {
            x = self.layer(layer, &x)?;
        }
        if shape.block == Block::GatedPreNorm {
            x = self.norm(last, "norm", &x)?;
        }
        let n = x.dim(1)?;
        let mean = |from: usize, to: usize| x.narrow(1, from, to - from)?.mean_keepdim(1);
        // A recurrent layer's last token knows of the others.
        let pooled = if matches!(shape.block, Block::Gru | Block::Lstm) { 1 } else { shape.tokens };
        let pooled = match shape.form {
            Form::Window => mean(0, n)?,
            Form::Streaming => {
                let all = (0..n).map(|s| mean((s + 1).saturating_sub(pooled), s + 1));
                Tensor::cat(&all.collect::<Result<Vec<_>>>()?, 1)?
            }
        };
        let latent = self.linear(last, "latent", &pooled)?.silu()?;
        let head = |k: usize| {
            let own = latent.narrow(2, k * shape.latent, shape.latent)?;
            self.linear(last, &format!("head.{k}"), &own)
        };
        Tensor::cat(&(0..shape.heads.len()).map(head).collect::<Result<Vec<_>>>()?, 2)
    }
}

fn sigmoid(x: &Tensor) -> Result<Tensor> {
    (x.neg()?.exp()? + 1.0)?.recip()
}

/// Of its parts: the derivative of candle's own has constants of six digits.
fn gelu(x: &Tensor) -> Result<Tensor> {
    let inner = (x + ((x.sqr()? * x)? * 0.044_715)?)?;
    let scaled = (inner * (2.0 * (2.0 / std::f64::consts::PI).sqrt()))?;
    x * sigmoid(&scaled)?
}
