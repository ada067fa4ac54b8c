//! `study adaptation`: a robot that changes, or does not, and a minute of data after which its twin has followed. Friction half as
//! much again, play grown by 0.3 mm, a tendon that has gone slack by 0.6 mm, a load added.
//!
//! Targets are followed on each robot with the network of the robot as it was, and with what `adapt` kept after a
//! minute of it.
//! The error of the twin on the unchanged robot is the least that exact knowledge of the change would leave,
//! and is the baseline. The plan of that minute (`quick`) has other motion than the training of the network.

mod outcome;
mod page;
mod run;

pub use outcome::{AdaptationMetrics, Row, Tip};
pub use run::run;
