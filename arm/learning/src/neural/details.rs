//! Training metadata in the file of an actuator, and the baselines that were fitted with it.

use hysteron_arm_estimation::servo_force::BaselineObservers;
use hysteron_learn::{Provenance, options_of_this_version};
use serde::{Deserialize, Serialize};

use super::baselines::FirstOrderServo;
use super::sensing_training::SensingOptions;
use super::servo::RolloutServo;
use super::training::NeuralOptions;

/// Baselines of an actuator, fitted to the same trajectories.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Baselines {
    /// The goal later, smoother and lower.
    #[serde(rename = "lag_and_droop")]
    pub lag: FirstOrderServo,
    /// A servo identified by rollout.
    pub servo: RolloutServo,
    /// Momentum observers, where PWM and contact-free trajectories are asked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub observers: Option<BaselineObservers>,
}

/// Training and baselines of an actuator; what is not known is left out of its file.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct ActuatorDetails {
    /// Baselines, fitted to the same trajectories.
    #[serde(rename = "rivals", skip_serializing_if = "Option::is_none")]
    pub baselines: Option<Baselines>,
    /// How the network in the loop was trained.
    #[serde(skip_serializing_if = "Option::is_none", deserialize_with = "options_of_this_version")]
    pub options: Option<NeuralOptions>,
    /// How the network of force and condition was trained.
    #[serde(skip_serializing_if = "Option::is_none", deserialize_with = "options_of_this_version")]
    pub sensing_options: Option<SensingOptions>,
    /// Root mean square error of the joints in rollouts of the validation trajectories [deg].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub validation_deg: Option<f64>,
    /// Epochs done when the weights in the loop were found.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub epochs: Option<usize>,
    /// Names of the recordings.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub recordings: Vec<String>,
    /// Of every epoch in the loop, the error in training and in validation.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub curve: Vec<[f64; 2]>,
    /// Criterion by which recordings were excluded.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub left_out: Option<Vec<String>>,
    /// Recordings that it was adapted to.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub adapted_to: Vec<String>,
    /// The command and the program that made the file.
    #[serde(flatten)]
    pub provenance: Option<Provenance>,
}
