//! LSTM networks: shapes and weights, passes over batches, one sample at a time.

mod architecture;
mod backprop;
mod batch;
mod ensemble;
mod gates;
mod graph;
#[cfg(test)]
mod graph_tests;
mod layer;
mod network;
#[cfg(test)]
mod on_device_tests;
mod runner;
mod tensors;
mod trainer;

pub use architecture::{Architecture, HeadActivation};
pub use backprop::{Backprop, PlacedNetwork, Updates};
pub use batch::{HeadOutputs, Memory, SequenceBatch};
pub use ensemble::Member;
pub use network::Network;
pub use runner::NetworkRunner;
pub use trainer::Trainer;
