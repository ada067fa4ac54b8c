//! `study coreact`: CoReAct end to end, as a user runs it. Record, identify, train, roll out; on trajectories that nothing was
//! trained on.
//!
//! Every stage is a command of the program, and what it wrote is kept, so that the study resumes where it was stopped. Each
//! table row is one twin: uncorrected, with friction, with the residual network, with both, and with the paper's
//! network. `robots` runs the same ablation on others.

mod outcome;
mod page;
mod random_plan;
mod run;
mod twins;

pub use outcome::{CoreactMetrics, PathErrors, Stability, TwinErrors, TwinTable};
pub(super) use page::twin_tiles;
pub use run::run;
pub(super) use twins::{TwinAblation, TwinModels};
