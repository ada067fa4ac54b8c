//! Models of a motor, a gearbox and a tendon. Knows no robot: arms and tendon-driven bodies share it.

mod backlash;
mod catalogue;
mod drive;
pub mod filter;
mod friction;
pub mod health;
pub mod identify;
pub mod law;
mod load;
mod motor;
pub mod number;
mod operators;
mod policies;
mod policy;
mod position_loop;
mod presliding;
mod prony;
mod servo;
mod sliding;
mod tendon;

pub use backlash::Play;
pub use catalogue::CatalogueDrive;
pub use drive::{Drive, DriveLoad, DriveState, Gear};
pub use friction::{Stribeck, capstan_bound, capstan_factor};
pub use load::{LoadModel, SteadyLoad, SteadyMotion};
pub use motor::{Bridge, Motor, Supply, Winding};
pub use operators::OperatorBank;
pub use position_loop::{Gains, LoopSpec, PositionLoop, ServoCommand};
pub use presliding::FrictionLaw;
pub use prony::{Prony, PronyStep};
pub use servo::{NOMINAL_VOLTAGE, ServoSimulation, ServoSpec, TICKS_PER_TURN, stroke_per_tick};
pub use tendon::{Guide, TendonModel, TendonSpec, TendonTrial};
