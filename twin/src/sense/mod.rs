//! Force estimation without force sensors: tensions at the pulleys and the force on the tip, from strokes,
//! loads, tip and twin.
//!
//! The twin gives the tip without contact, the tensions, and the response of both to a force; the loads of
//! the servos correct the tensions, the tracked tip gives the force. The difference of twin and robot, which
//! none of them measures, is fitted to motion without contact, so every estimate comes with its standard
//! error.

mod fit;
mod observer;
mod scores;
mod sensor;
mod tension;
mod tip_force;

pub use fit::{KnownForce, RecordingObservations, fit_sensor};
pub use observer::{Observation, SenseSample, Steady, TwinObserver};
pub use scores::{ContactScore, ForceScore, SensingScores, SensingTruth, TensionScore, score};
pub use sensor::{ForceSensor, SensedSample, ServoLoad, TendonSensing};
pub use tension::{TensionErrors, TensionFilter};
pub use tip_force::{TipForceErrors, TipForceEstimate, TipForceFilter, TipSample};
