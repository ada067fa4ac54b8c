//! The engine: what training is for every family of models. It knows neither networks nor what a batch is.

mod adam;
mod fit;
mod fit_report;
mod lbfgs;
mod levenberg_marquardt;
mod loss;
mod minibatch;
mod model;
mod real;
mod schedule;
mod training;

pub use adam::{Adam, Penalty};
pub(crate) use adam::{AdamFactors, Moments};
pub use fit::{Epoch, FitResult, TrainingProgress, TrainingSession, TrainingTask, fit};
pub use fit_report::{ChannelErrors, FitReport, simplest_within};
pub use lbfgs::{Ending, Lbfgs};
pub use levenberg_marquardt::{LeastSquares, LevenbergMarquardt};
pub use loss::{mean, mean_squared_error};
pub use minibatch::{Objective, minimise};
pub use model::{ParameterVector, TensorShape, TrainableModel};
pub use real::Float;
pub use schedule::{Decay, MAX_EPOCHS, MAX_HIDDEN, MAX_ROWS, Schedule, warm_up_cosine};
pub(crate) use schedule::{MAX_LAYERS, check_counts};
pub use training::Training;
pub(crate) use training::Updated;
