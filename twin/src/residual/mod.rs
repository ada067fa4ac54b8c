//! The residual network g (CoReAct paper, eqs. 9-11): it learns the auxiliary strokes of CoReAct from what was
//! commanded, so that the twin shows the robot's hysteresis by itself.
//!
//! Two designs. [`ResidualDesign::Windowed`] is the paper's: a sliding window of strokes and tips in, all auxiliary strokes out,
//! fitted to s*. [`ResidualDesign::Recurrent`] goes through whole trajectories with one cell update a sample. It sees the strokes
//! through the operators that hysteresis is made of, play and relaxation, gives the tip displacement that is missing
//! (three numbers: across the robot spread over the tendons, along it added to the tip), and is fitted to the measured
//! tip through the linearised twin, ∂y/∂s of the identification.

mod adapt;
mod adaptation;
mod adapted_parts;
mod band;
mod change;
mod decoder;
mod features;
mod follower;
mod kept_parts;
mod linear;
mod model;
mod prepared;
mod recurrent;
mod recurrent_options;
mod rollout;
mod sequence;
mod training;
mod windowed;

use std::path::PathBuf;

use hysteron_learn::{FitReport, FitResult, Network, TrainingProgress, TrainingSession, TrainingTask, fit};
use serde::Serialize;

pub use adapt::{AdaptMotions, Adapted, MotionErrors, adapt, n_samples};
pub use adaptation::{AdaptOptions, Adaptation};
pub use adapted_parts::AdaptedParts;
pub use band::TipBand;
pub use change::RobotChange;
pub use decoder::StrokeDecoder;
pub use features::{FeatureSpec, Features};
pub use follower::{Coordinates, FollowLimits, FollowStep, PathController, PathFollower};
pub use kept_parts::ResidualPart;
pub use linear::LinearPart;
pub use model::{ResidualDesign, ResidualModel};
pub use recurrent::fit_recurrent;
pub use recurrent_options::RecurrentOptions;
pub use rollout::CorrectedRollout;
pub use sequence::{DECODER, Sequence, fit_decoder};
pub use training::{ResidualOptions, ResidualTraining, TrainedMember};
pub use windowed::{PUBLISHED, fit_windowed};

/// Files of the trainings of several networks between runs, and the receiver of their reports.
pub struct Sessions<'a> {
    /// File of each network to go on from, written after every epoch; empty for no files.
    pub files: Vec<PathBuf>,
    /// Gets the progress of a network, by number from 0; ends its training where it returns false.
    pub progress: &'a (dyn Fn(usize, &TrainingProgress) -> bool + Sync),
}

/// A trained residual network.
#[derive(Debug, Clone, PartialEq)]
pub struct FittedResidual {
    /// With the best weights.
    pub model: ResidualModel,
    /// How the training of each network went.
    pub reports: Vec<FitReport>,
    /// False where a training was stopped early and can resume from its file.
    pub is_finished: bool,
}

impl Sessions<'_> {
    /// Trains the network `number`, or goes on with it; see [`fit`].
    fn fit<T: TrainingTask<Network>>(
        &self,
        number: usize,
        task: &mut T,
        network: Network,
        identity: &impl Serialize,
    ) -> Result<FitResult<Network>, T::Error> {
        let mut progress = |progress: &TrainingProgress| (self.progress)(number, progress);
        let file = self.files.get(number).map(PathBuf::as_path);
        fit(task, network, identity, &mut TrainingSession { file, progress: &mut progress })
    }
}
