//! `Transformer`: shape and weights as plain arrays, and how they begin.

use hysteron_base::{BadInput, rng};
use rand::RngExt;
use serde::Serialize;

use super::linear::Packed;
use super::shape::{ParameterLayout, TransformerShape};
use crate::{Float, TensorShape, TrainableModel};

/// A Transformer encoder with its heads.
#[derive(Debug, Clone)]
pub struct Transformer<T> {
    shape: TransformerShape,
    pub(super) layout: ParameterLayout,
    /// Embedding, every layer, heads.
    parameters: Vec<Vec<T>>,
    /// Of these parameters: every change of them empties it.
    packed: Vec<Vec<Packed<T>>>,
}

impl<T: Float> Transformer<T> {
    /// Weights uniform with variance 1/inputs of their matrix (LeCun et al. 1998), positions with 0.02; biases zero,
    /// normalisations and scalars one, lags zero. The last layer of every head begins a hundred times smaller: outputs begin near zero.
    ///
    /// # Errors
    /// As [`TransformerShape::check`].
    pub fn new(shape: &TransformerShape, seed: u64) -> Result<Self, BadInput> {
        shape.check()?;
        let begin = |tensor: &TensorShape| {
            let mut stream = rng(seed, &format!("transformer/{}", tensor.name));
            let is_norm = tensor.name.contains("norm") && tensor.name.ends_with("weight");
            let spread = match tensor.name.as_str() {
                "position" => 0.02,
                name if name.ends_with("weight") && !is_norm => {
                    let last = if name.starts_with("head.") { 0.01 } else { 1.0 };
                    last / (tensor.shape[0] as f64).sqrt()
                }
                _ => 0.0,
            };
            let fixed = if is_norm || tensor.name.ends_with("scales") { 1.0 } else { 0.0 };
            // A uniform distribution of variance 1 reaches to √3.
            let reach = 3f64.sqrt() * spread;
            (0..tensor.len())
                .map(|_| T::of(if reach > 0.0 { stream.random_range(-reach..reach) } else { fixed }))
                .collect::<Vec<T>>()
        };
        let parameters =
            shape.tensors().iter().map(|vector| vector.iter().flat_map(begin).collect()).collect();
        Ok(Self::from_parts(shape, ParameterLayout::new(shape), parameters))
    }

    fn from_parts(shape: &TransformerShape, layout: ParameterLayout, parameters: Vec<Vec<T>>) -> Self {
        Self { shape: shape.clone(), layout, parameters, packed: unpacked(shape) }
    }

    /// Sizes and kind.
    pub fn shape(&self) -> &TransformerShape {
        &self.shape
    }

    /// The same with a head whose output is zero, until it is trained.
    ///
    /// # Panics
    /// If there is no such head.
    pub fn with_silent_head(mut self, head: usize) -> Self {
        let own = self.layout.heads[head].clone();
        if let Some(values) = self.parameters_mut().last_mut() {
            own.into_iter().for_each(|range| values[range].fill(T::default()));
        }
        self
    }

    /// The matrices of every vector of parameters for products with a few rows.
    pub(super) fn packed(&self) -> &[Vec<Packed<T>>] {
        &self.packed
    }

    /// The same weights in other numbers.
    pub fn converted<U: Float>(&self) -> Transformer<U> {
        let convert = |values: &Vec<T>| values.iter().map(|v| U::of(v.to_f64())).collect();
        let parameters = self.parameters.iter().map(convert).collect();
        Transformer::from_parts(&self.shape, self.layout.clone(), parameters)
    }

    /// Zeros of the shape of the parameters.
    pub fn zeros(&self) -> Vec<Vec<T>> {
        self.parameters.iter().map(|values| vec![T::default(); values.len()]).collect()
    }
}

/// Nothing yet of every matrix.
fn unpacked<T>(shape: &TransformerShape) -> Vec<Vec<Packed<T>>> {
    let of_vector = |tensors: &Vec<TensorShape>| {
        let mut start = 0;
        let mut begin = |tensor: &TensorShape| {
            start += tensor.len();
            (tensor.shape.len() == 2).then(|| Packed::new(start - tensor.len()))
        };
        tensors.iter().filter_map(&mut begin).collect()
    };
    shape.tensors().iter().map(of_vector).collect()
}

impl<T: Float> TrainableModel for Transformer<T> {
    type Value = T;

    const FAMILY: &'static str = "transformer";

    fn shape(&self) -> impl Serialize {
        &self.shape
    }

    fn parameters(&self) -> &[Vec<T>] {
        &self.parameters
    }

    fn parameters_mut(&mut self) -> &mut [Vec<T>] {
        self.packed.iter_mut().flatten().for_each(Packed::invalidate);
        &mut self.parameters
    }

    fn tensors(&self) -> Vec<Vec<TensorShape>> {
        self.shape.tensors()
    }
}
