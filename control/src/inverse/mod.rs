//! The inverse controller h (EDIC, CoReAct paper, section IV-C): from where the tip shall be to the strokes
//! that bring it there, fitted to recordings of a rig and of a twin alike.
//!
//! Two designs. The input of the paper's ([`fit_windowed`]) is a window of positions. Ours
//! ([`fit_recurrent`]) takes features of the path, ahead included, through whole trajectories with one cell
//! update a sample, and corrects a static regression.

mod axes;
mod base;
mod candidate;
mod controller;
mod dataset;
mod delay;
mod features;
mod fit;
mod folds;
mod loss;
mod model;
mod path_point;
mod recurrent;
mod recurrent_options;
mod regression;
mod smooth;
mod training;
mod windowed;
mod workspace;

use hysteron_base::BadInput;

pub use axes::{Axes, TipPosition};
pub use candidate::Candidate;
pub use controller::{Commands, InverseController, SampleFlags};
pub use dataset::{DataOrigin, Dataset, Demonstration};
pub use delay::ahead;
pub use features::{FeatureSpec, Features};
pub use fit::FittedController;
pub use folds::Folds;
pub use loss::LossWeights;
pub use model::{InverseDesign, InverseModel};
pub use path_point::{PathPoint, PathSmoothing};
pub use recurrent::{fit_base, fit_recurrent};
pub use recurrent_options::{BaseMap, RecurrentOptions};
pub use regression::StaticRegression;
pub use training::{InverseOptions, InverseTraining, LeadingTwin, TrainedDesign, TrainedOn, WeightErrors};
pub use windowed::{PUBLISHED, fit_windowed};
pub use workspace::TipWorkspace;

/// Result of a check that has no file to fail on.
type Check<T> = std::result::Result<T, BadInput>;
