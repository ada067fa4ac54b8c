//! Models of inverse dynamics that learn energies: the family of deep Lagrangian networks.
//!
//! A model is a sum of terms, each a small network with a meaning: a structured Lagrangian or Hamiltonian (mass matrix by
//! its Cholesky factor, and potential), one network for either, friction, and a network for what is left. Torques come from
//! one tangent and one reverse pass, the gradient of a loss from the value and two tangents and ordinary reverse mode; no
//! Jacobian is carried. Equations, sources and misprints: `docs/lagrangian.md`.

mod along;
mod black_box;
mod block;
mod body;
mod decomposition;
mod factor;
mod friction;
mod learned;
mod network;
mod objective;
mod recordings;
mod samples;
mod scores;
mod side;
mod simulated;
mod structured;
#[cfg(test)]
mod tests;
mod training;

pub use along::external_torques_along;
pub use body::LearnedBody;
pub use decomposition::{Decomposition, decompose};
pub use learned::{LearnedDynamics, TorqueStream};
pub use network::{InputForm, NetworkShape, Scales, Variant};
pub use objective::{JointWeights, TorqueObjective};
pub use recordings::samples_of;
pub use samples::ArmSamples;
pub use scores::TorqueScores;
pub use simulated::{Sinusoids, sinusoids};
pub use training::{Polish, StepDecay, TrainedLagrangian, TrainingOptions, train};

/// Most joints of a model.
pub(crate) const MAX_JOINTS: usize = 16;
/// Columns of a mass matrix's factor at most: six for each joint of an arm of seven, and as many as it has joints.
pub(crate) const MAX_COLUMNS: usize = 49;
