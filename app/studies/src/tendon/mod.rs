//! Studies of tendon robots: comparisons with other programs and recorded robots, and the whole chain on virtual ones.

pub mod ablation;
pub mod adaptation;
pub mod columns;
pub mod commands;
pub mod convergence;
pub mod coreact;
pub mod edic;
pub mod ftdcr;
pub mod inverse;
pub mod layouts;
mod numbers;
mod options;
pub mod outcome;
pub mod path_following;
pub mod population;
pub mod robots;
pub mod scenes;
pub mod sensing;
mod session;
pub mod sofa;
pub mod sorosim;
pub mod tentacle;
#[cfg(test)]
mod tests;

pub use options::{DataOptions, Options, PopulationOptions};
pub use outcome::Outcome;
