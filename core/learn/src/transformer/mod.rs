//! Transformers over short windows of samples: the published form, which attends to a whole window, and a streaming form, which
//! takes one sample at a time and keeps what it knows of those before; with recurrent layers in place of attention for comparison.
//! Equations: `docs/learn.md`.

mod card;
mod cell;
mod closed_loop;
#[cfg(test)]
mod closed_loop_tests;
mod graph;
mod kernels;
mod layer;
mod linear;
mod network;
mod runner;
mod shape;
mod small_batch;
mod tape;
mod tape_pool;
#[cfg(test)]
mod tests;

pub use card::{CardUpdates, DeviceCard};
pub use closed_loop::{ClosedLoop, PlantBatch, StepLoss};
pub use graph::TransformerGraph;
pub use network::Transformer;
pub use runner::TransformerRunner;
pub use shape::{BlockKind, TemporalForm, TransformerShape};
pub use tape::TransformerTape;
pub use tape_pool::TapePool;
