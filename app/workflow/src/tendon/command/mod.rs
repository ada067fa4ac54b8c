//! `hysteron command`: strokes for a path of the tip, by a trained inverse controller or through the robot's twin.

mod answer;
mod approach;
mod finder;
mod options;
mod outcome;
mod page;
mod run;
mod strokes;
mod twin_strokes;

pub use answer::{LimitOverrides, Target};
pub use options::{Options, Way};
pub use outcome::Outcome;
pub use run::run;
