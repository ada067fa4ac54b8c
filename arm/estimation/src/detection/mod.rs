//! Contacts in estimated external torques: when the arm was touched, and which joint felt it last.
//!
//! A [`Test`] turns external torques into one number a sample, which exceeds 1 where a contact is detected; what counts as
//! contact-free is learned from motion without any ([`FreeMotion`]). [`Alarm`] adds hysteresis. [`assess`] and [`roc`] measure how good
//! that is where contacts are known.

mod assess;
mod statistics;
mod thresholds;

pub use assess::{Assessment, Truth, assess, logarithmic, roc};
pub use statistics::{Band, Cusum, Test};
pub use thresholds::{Alarm, FreeMotion};
