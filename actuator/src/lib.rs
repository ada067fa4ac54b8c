//! What a motor, a gearbox and a tendon do. Knows no robot: arms and tendon-driven bodies share it.

mod servo;

pub use servo::{Gains, ServoCommand, ServoState};
