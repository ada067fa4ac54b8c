//! A servo that pulls a tendon, from a recording of its rig: load scale, friction, backlash.
//!
//! A load is what a servo gives its motor, not what it pulls with. In steady motion (`steady.rs`)
//!
//! ```text
//! s (l - o) = τ_f(ω) + r (T + δ Ṫ) + J ω̇
//! ```
//!
//! with the load l, its offset o, the tension T on the radius r, friction τ_f with the motor's back EMF in it, and two terms that
//! stand for inertia and for what the load lags by. Where tensions were measured, the load scale s is found with the friction; where
//! they were not, only samples of a slack tendon count (`slack.rs`) and s is what a data sheet says. Backlash shows in tensions at
//! reversals (`backlash.rs`).

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
