//! A servo that pulls a tendon, from a recording of its rig: load scale, friction, backlash.
//!
//! A load is the drive that a servo gives its motor, not its pull. In steady motion (`steady.rs`)
//!
//! ```text
//! s (l - o) = τ_f(ω) + r (T + δ Ṫ) + J ω̇
//! ```
//!
//! with the load l, its offset o, the tension T on the radius r, friction τ_f with the motor's back EMF in it, and two terms that
//! account for inertia and for the delay of the load. Where tensions were measured, the load scale s is found
//! with the friction; where they were not, only samples of a slack tendon count (`slack.rs`) and s comes from
//! a data sheet. Backlash shows in tensions at reversals (`backlash.rs`).

mod backlash;
mod fit;
mod slack;
mod slack_friction;
mod steady;

pub use backlash::{Backlash, Reversal, identify_backlash};
pub use fit::{PulleyFit, PulleyServo, identify_pulley};
pub use slack::find_slack;
pub use slack_friction::{SlackFriction, slack_friction};
pub use steady::{PulleyRecord, SteadySamples, finest_speed};
