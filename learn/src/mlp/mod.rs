//! Multi-layer perceptrons with tangents, for models whose outputs are derivatives of a network.

mod activation;
mod shape;
mod tape;
#[cfg(test)]
mod tests;

pub use activation::Activation;
pub use shape::Mlp;
pub use tape::MlpTape;
