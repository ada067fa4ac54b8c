//! Networks: an engine that trains models of any family, LSTM networks, Transformers and multi-layer perceptrons as its families, sequence
//! regression on top, and checkpoints.
//!
//! A [`TrainableModel`] is named arrays of parameters; a [`TrainingTask`] goes through its data and gives gradients; [`fit`] is the one training
//! loop, with schedule, moving average, early stopping and a file to resume from. [`RadialBasis`] is the regression in closed form that a
//! network has to beat. A [`Network`] is trained by a candle graph
//! whose only own operation is an LSTM layer over a whole sequence ([`Backprop`]); a [`NetworkRunner`] steps it one sample at a time
//! and needs none of that. Arrays of sequences are `f32` and time-major: [step][row of the batch][channel]. Equations and file
//! formats: `docs/learn.md`.
//!
//! A network that was just drawn, one sample at a time:
//!
//! ```
//! use hysteron_learn::{Architecture, HeadActivation, Network, NetworkRunner};
//!
//! let head = HeadActivation::Linear;
//! let architecture = Architecture { inputs: 2, hidden: 8, layers: 1, outputs: 1, head, dropout: 0.0 };
//! let mut runner = NetworkRunner::new(&Network::new(&architecture, 1)?);
//! let first = runner.step(&[0.5, -0.5])[0];
//! runner.reset();
//! assert_eq!(runner.step(&[0.5, -0.5])[0], first);
//! # Ok::<(), hysteron_learn::Error>(())
//! ```

mod engine;
mod error;
mod files;
mod lstm;
mod mlp;
mod normaliser;
mod on_device;
mod panels;
mod product;
mod radial_basis;
mod regression;
pub mod ridge;
mod transformer;

pub use engine::{
    Adam, ChannelErrors, Decay, Ending, Epoch, FitReport, FitResult, Float, Lbfgs, LeastSquares,
    LevenbergMarquardt, MAX_EPOCHS, MAX_HIDDEN, MAX_ROWS, Objective, ParameterVector, Penalty, Schedule,
    TensorShape, TrainableModel, Training, TrainingProgress, TrainingSession, TrainingTask, fit, mean,
    mean_squared_error, minimise, simplest_within, warm_up_cosine,
};
pub use error::{Error, Result};
pub use files::{
    Checkpoint, Provenance, options_of_this_version, read_parameters, read_parameters_details,
    read_parameters_kind, write_parameters,
};
pub use lstm::{
    Architecture, Backprop, HeadActivation, HeadOutputs, Member, Memory, Network, NetworkRunner,
    PlacedNetwork, SequenceBatch, Trainer, Updates,
};
pub use mlp::{Activation, ByParameters, Mlp, MlpTape};
pub use normaliser::{ChannelRange, Normaliser};
pub use panels::WeightFormat;
pub use radial_basis::{RadialBasis, RadialSamples, RadialSetting};
pub use regression::{
    Evaluation, Predictor, RANGE_MARGIN, SequenceOptions, SequenceTask, Sequences, WindowOptions, WindowTask,
    WindowedSequence, restore_bounded, windows,
};
pub use transformer::{
    BlockKind, CardUpdates, ClosedLoop, DeviceCard, PlantBatch, StepLoss, TapePool, TemporalForm,
    Transformer, TransformerGraph, TransformerRunner, TransformerShape, TransformerTape,
};
