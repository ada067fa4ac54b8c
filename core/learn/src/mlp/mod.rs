//! Multi-layer perceptrons with tangents, for models whose outputs are derivatives of a network.

mod activation;
mod derivatives;
mod shape;
mod small_batch;
mod tape;
#[cfg(test)]
mod tests;

pub use activation::Activation;
pub use derivatives::ByParameters;
pub use shape::Mlp;
pub use tape::MlpTape;
