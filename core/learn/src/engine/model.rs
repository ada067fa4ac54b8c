//! Models of any family that the engine trains, as named arrays of parameters.

use hysteron_base::json;
use serde::Serialize;

use crate::Float;

/// A named array within a vector of parameters.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TensorShape {
    /// Its name in files.
    pub name: String,
    /// Its dimensions.
    pub shape: Vec<usize>,
}

impl TensorShape {
    /// An array of this name and these dimensions.
    pub fn new(name: impl Into<String>, shape: &[usize]) -> Self {
        Self { name: name.into(), shape: shape.to_vec() }
    }

    /// Numbers in it.
    pub fn len(&self) -> usize {
        self.shape.iter().product()
    }

    /// Whether it holds no number.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// A model of some family: the engine updates, averages, keeps and saves its parameters and asks no more of it. What a
/// batch is and how the gradient comes about is the [`crate::TrainingTask`]'s.
pub trait TrainableModel: Clone {
    /// Number type of the parameters.
    type Value: Float;

    /// The family, as files name it.
    const FAMILY: &'static str;

    /// Everything that is not a parameter and must be equal to read the parameters of another one.
    fn shape(&self) -> impl Serialize;

    /// The vectors of parameters.
    fn parameters(&self) -> &[Vec<Self::Value>];

    /// The same, to be changed.
    fn parameters_mut(&mut self) -> &mut [Vec<Self::Value>];

    /// For each vector of parameters, the arrays it consists of, in order.
    fn tensors(&self) -> Vec<Vec<TensorShape>>;
}

/// One vector of parameters of a model whose shape its user knows, as that of several perceptrons.
#[derive(Debug, Clone, PartialEq)]
pub struct ParameterVector<T>([Vec<T>; 1]);

impl<T> ParameterVector<T> {
    /// A model with these parameters.
    pub fn new(values: Vec<T>) -> Self {
        Self([values])
    }

    /// The parameters.
    pub fn values(&self) -> &[T] {
        &self.0[0]
    }

    /// The parameters.
    pub fn into_values(self) -> Vec<T> {
        let [values] = self.0;
        values
    }
}

impl<T: Float> TrainableModel for ParameterVector<T> {
    type Value = T;

    const FAMILY: &'static str = "vector";

    fn shape(&self) -> impl Serialize {
        json!({ "parameters": self.values().len() })
    }

    fn parameters(&self) -> &[Vec<T>] {
        &self.0
    }

    fn parameters_mut(&mut self) -> &mut [Vec<T>] {
        &mut self.0
    }

    fn tensors(&self) -> Vec<Vec<TensorShape>> {
        vec![vec![TensorShape::new("parameters", &[self.values().len()])]]
    }
}
