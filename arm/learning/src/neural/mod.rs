//! Actuators learned from telemetry, as NeuralActuator has them: torques that move a simulated arm as the recorded one
//! moved, forces on its tip, and the condition of a motor. Equations and protocol: `docs/neural-actuator.md`.

mod actuator;
mod adapt;
mod base_frame;
mod baselines;
mod closed_loop;
mod compare;
mod comparison_scores;
mod condition;
mod current;
mod data;
mod details;
mod drive_model;
mod evaluate;
mod features;
mod fit;
mod health;
mod heat;
mod live;
mod loss;
mod motors;
mod observations;
mod segment;
mod sensing;
#[cfg(test)]
mod sensing_tests;
mod sensing_training;
mod servo;
#[cfg(test)]
mod servo_tests;
mod simulation;
mod supervised;
#[cfg(test)]
mod tests;
mod training;
mod warm_start;

pub use actuator::NeuralActuator;
pub use baselines::{FirstOrderServo, Positions, copied_goal};
pub use closed_loop::{ActuatorLoop, LoopGradient};
pub use compare::BaselineComparison;
pub use comparison_scores::{
    ActuatorComparison, ByHorizon, ByMethod, ComparisonFormat, FORCES, ForceSource, ForcesBySource, HORIZONS,
    METHODS, TaskScores, TaskTrace,
};
pub use condition::{ConditionEstimate, DetectorScores, EVIDENCE, detectors};
pub use current::CurrentModel;
pub use data::{MIN_ROWS, Trajectory, Unlabelled, gripper_of, trajectory_of};
pub use details::{ActuatorDetails, Baselines};
pub use evaluate::{
    ArmRollout, ForceScores, PoseScores, area_under_curve, condition_scores, force_scores, pose_scores,
    roll_out,
};
pub use features::{FeatureLayout, GripperAxis, InputScale};
pub use fit::{
    ActuatorFit, ActuatorOptions, ActuatorSession, MotorModelKind, TrainingStage, fit_actuator, fit_sensing,
};
pub use health::HealthModel;
pub use live::{LiveEstimator, ServoTelemetry};
pub use loss::{CONTACT, Heads, LossParts, LossWeights, Totals, length, wrap};
pub use motors::Motors;
pub use observations::{IdentifiedArm, ObservedTrajectory, telemetry};
pub use segment::{Segment, TelemetrySource};
pub use sensing::{ContactEstimate, SensedTrajectory, Sensing, SensingRunner};
pub use sensing_training::{SensingOptions, SensingTask, identified_observers};
pub use servo::RolloutServo;
pub use simulation::{ArmSimulation, MotorCommand, SimulationOptions};
pub use training::{NeuralOptions, NeuralTask, horizon_gradient};
pub use warm_start::torques_of;
