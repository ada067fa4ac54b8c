//! LSTM networks: training on a processor as fast as it multiplies, rollouts without tensors, checkpoints.
//!
//! A [`Network`] is plain named arrays. A [`Trainer`] turns them into a candle graph for each batch, whose only
//! own operation is an LSTM layer over a whole sequence; a [`Runner`] steps one sample at a time. Arrays are `f32`
//! and time-major: [step][row of the batch][channel]. Equations and file formats: `docs/learn.md`.
//!
//! A network that was just drawn, one sample at a time:
//!
//! ```
//! use hysteron_learn::{Architecture, Head, Network, Runner};
//!
//! let architecture = Architecture { inputs: 2, hidden: 8, layers: 1, outputs: 1, head: Head::Linear, dropout: 0.0 };
//! let mut runner = Runner::new(&Network::new(&architecture, 1)?);
//! let first = runner.step(&[0.5, -0.5])[0];
//! runner.reset();
//! assert_eq!(runner.step(&[0.5, -0.5])[0], first);
//! # Ok::<(), hysteron_learn::Error>(())
//! ```

mod activation;
mod adam;
mod architecture;
mod batch;
mod checkpoint;
mod error;
mod fit_report;
mod gates;
mod graph;
#[cfg(test)]
mod graph_tests;
mod lbfgs;
mod lesson;
mod loss;
mod minibatch;
mod mlp;
mod mlp_tape;
#[cfg(test)]
mod mlp_tests;
mod network;
mod normaliser;
mod parameters_file;
mod passes;
mod product;
mod real;
mod runner;
mod schedule;
mod sequence;
mod sequence_options;
mod tensor_file;
mod trainer;
mod training;
mod windowed;

pub use activation::Activation;
pub use adam::Adam;
pub use architecture::{Architecture, Head};
pub use batch::{Batch, Memory, Outputs};
pub use checkpoint::Checkpoint;
pub use error::{Error, Result};
pub use fit_report::{ChannelErrors, FitReport};
pub use lbfgs::{Ending, Lbfgs};
pub use lesson::{Epoch, Learned, Lesson, Progress, Session, teach};
pub use loss::{mean, mean_squared_error};
pub use minibatch::{Minimum, Objective, minimise};
pub use mlp::Mlp;
pub use mlp_tape::MlpTape;
pub use network::Network;
pub use normaliser::{ChannelRange, Normaliser};
pub use parameters_file::{read_parameters, write_parameters};
pub use passes::{Sequences, Sum};
pub use real::Real;
pub use runner::{Runner, WeightFormat};
pub use schedule::{Fall, MOST_EPOCHS, MOST_HIDDEN, MOST_ROWS, Schedule};
pub use sequence_options::SequenceOptions;
pub use trainer::Trainer;
pub use training::Training;
pub use windowed::{WindowedLesson, WindowedOptions, WindowedPath, windows};
