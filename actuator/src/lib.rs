//! What a motor, a gearbox and a tendon do. Knows no robot: arms and tendon-driven bodies share it.

mod backlash;
mod friction;
pub mod law;
pub mod number;
mod policies;
mod presliding;
mod prony;
mod servo;
mod sliding;
mod tendon;

pub use backlash::Play;
pub use friction::{Stribeck, capstan_bound, capstan_factor};
pub use presliding::FrictionLaw;
pub use prony::{Prony, PronyStep};
pub use servo::{
    Gains, NOMINAL_VOLTAGE, PWM_FULL_SCALE, Servo, ServoCommand, ServoSpec, ServoState, TICKS_PER_TURN,
};
pub use tendon::{Guide, Tendon, TendonSpec, TendonTrial};
