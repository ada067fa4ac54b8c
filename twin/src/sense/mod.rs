//! Feeling without force sensors: tensions at the pulleys and the force on the tip, from strokes, loads, tip and twin.
//!
//! The twin says where the tip would be without contact, what the tensions are, and how both answer a force; the loads of the
//! servos correct the tensions, the tracked tip tells the force. What none of them can know, how far twin and robot differ, is learned from
//! motion without contact, so every estimate comes with its standard error.

mod fit;
mod observer;
mod sensor;
mod tension;
mod tip_force;

pub use fit::{KnownForce, Observed, fit_sensor};
pub use observer::{Observation, Observer, SenseSample, Steady};
pub use sensor::{ForceSensor, Sensed, Sensing, ServoLoad};
pub use tension::{TensionErrors, TensionFilter};
pub use tip_force::{TipErrors, TipForceEstimate, TipForceFilter, TipSample};
