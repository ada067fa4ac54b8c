//! Sequence regression: from sequences of inputs to sequences of outputs, with features and loss of the caller.
//!
//! Two ways to train an LSTM, whole sequences with truncated back-propagation ([`SequenceTask`]) and sliding windows
//! ([`WindowTask`]), and one way to use it sample by sample ([`Predictor`]).

mod options;
mod predictor;
mod sequences;
mod windows;

pub use options::SequenceOptions;
pub use predictor::{Predictor, RANGE_MARGIN, restore_bounded};
pub use sequences::{Evaluation, SequenceTask, Sequences};
pub use windows::{WindowOptions, WindowTask, WindowedSequence, windows};
