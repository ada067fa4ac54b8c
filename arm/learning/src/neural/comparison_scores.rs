//! The numbers of a comparison of an actuator with its baselines: by method, horizon and source of the force.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::evaluate::{ForceScores, PoseScores};

/// Horizons of the paper's tables [steps].
pub const HORIZONS: [usize; 4] = [100, 300, 500, 600];

/// Methods compared, in the order of the table.
pub const METHODS: [&str; 5] = [
    "network, recorded currents (as published)",
    "network, pure simulation (currents of the drive model)",
    "copy the goal",
    "copy the goal, lag and droop fitted",
    "servo identified by rollout",
];

/// Sources of force estimates, in the order of the table: key and name.
pub const FORCES: [(&str, &str); 4] = [
    ("force", "network, recorded telemetry"),
    ("force_gmo_linear", "GMO-linear"),
    ("force_gmo_drive", "GMO-drive"),
    ("force_pure", "network, pure simulation"),
];

/// A number or several of each method of [`METHODS`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ByMethod<T> {
    /// Network in the loop with recorded currents.
    #[serde(rename = "network, recorded currents (as published)")]
    pub network: T,
    /// Network in the loop with currents by the model of the drives.
    #[serde(rename = "network, pure simulation (currents of the drive model)")]
    pub pure_network: T,
    /// Motors whose positions are their goals.
    #[serde(rename = "copy the goal")]
    pub copied_goal: T,
    /// The goal later, smoother and lower.
    #[serde(rename = "copy the goal, lag and droop fitted")]
    pub fitted_goal: T,
    /// Position servo identified by rollout.
    #[serde(rename = "servo identified by rollout")]
    pub servo: T,
}

impl<T> ByMethod<T> {
    /// Of what `of` gives for each index into [`METHODS`].
    pub fn from_fn(mut of: impl FnMut(usize) -> T) -> Self {
        Self { network: of(0), pure_network: of(1), copied_goal: of(2), fitted_goal: of(3), servo: of(4) }
    }

    /// In the order of [`METHODS`].
    pub fn values(&self) -> [&T; METHODS.len()] {
        [&self.network, &self.pure_network, &self.copied_goal, &self.fitted_goal, &self.servo]
    }
}

/// A number or several of each horizon of [`HORIZONS`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ByHorizon<T> {
    /// Over the first 100 steps.
    #[serde(rename = "100")]
    pub steps_100: T,
    /// Over the first 300 steps.
    #[serde(rename = "300")]
    pub steps_300: T,
    /// Over the first 500 steps.
    #[serde(rename = "500")]
    pub steps_500: T,
    /// Over the first 600 steps.
    #[serde(rename = "600")]
    pub steps_600: T,
}

impl<T> ByHorizon<T> {
    /// Of what `of` gives for each horizon [steps].
    pub fn from_fn(of: impl FnMut(usize) -> T) -> Self {
        let [steps_100, steps_300, steps_500, steps_600] = HORIZONS.map(of);
        Self { steps_100, steps_300, steps_500, steps_600 }
    }

    /// In the order of [`HORIZONS`].
    pub fn values(&self) -> [&T; HORIZONS.len()] {
        [&self.steps_100, &self.steps_300, &self.steps_500, &self.steps_600]
    }

    /// Over that many first steps; none where that is no horizon of [`HORIZONS`].
    pub fn over(&self, steps: usize) -> Option<&T> {
        HORIZONS.iter().position(|horizon| *horizon == steps).map(|k| self.values()[k])
    }
}

/// Errors of the forces of each source of [`FORCES`]; none where a source gives no force, or without any label.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ForcesBySource {
    /// Network with recorded telemetry.
    pub force: Option<ForceScores>,
    /// Momentum observer with a linear model of the torque.
    pub force_gmo_linear: Option<ForceScores>,
    /// Momentum observer with a model of the drive.
    pub force_gmo_drive: Option<ForceScores>,
    /// Network in pure simulation.
    pub force_pure: Option<ForceScores>,
}

impl ForcesBySource {
    /// Of what `of` gives for each index into [`FORCES`].
    pub fn from_fn(mut of: impl FnMut(usize) -> Option<ForceScores>) -> Self {
        Self { force: of(0), force_gmo_linear: of(1), force_gmo_drive: of(2), force_pure: of(3) }
    }

    /// In the order of [`FORCES`].
    pub fn values(&self) -> [Option<&ForceScores>; FORCES.len()] {
        [&self.force, &self.force_gmo_linear, &self.force_gmo_drive, &self.force_pure].map(Option::as_ref)
    }
}

/// The value of `format` of a comparison.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[schemars(inline)]
pub enum ComparisonFormat {
    /// Comparison of a neural actuator with its baselines.
    #[serde(rename = "hysteron-neural-evaluation")]
    Evaluation,
}

/// Network that gives force, contact and condition.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ForceSource {
    /// The network in the loop, as published.
    Loop,
    /// A network of its own next to a momentum observer.
    Observer,
}

/// Comparison of an actuator with its baselines.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ActuatorComparison {
    /// Format of these numbers.
    pub format: ComparisonFormat,
    /// Its version.
    pub version: u32,
    /// Mean absolute error of the joints over the first steps, mean of the tasks [deg].
    pub mean_deg: ByMethod<ByHorizon<Option<f64>>>,
    /// The same of the aperture [mm]; none without a gripper.
    pub mean_gripper_mm: ByMethod<ByHorizon<Option<f64>>>,
    /// Errors of the forces, all tasks together.
    pub forces: ForcesBySource,
    /// Network that gives the force.
    pub force_from: ForceSource,
    /// Accuracy and area under the curve of the condition, sample by sample; none unless both conditions are there.
    pub condition_accuracy_auc: Option<[f64; 2]>,
    /// One entry per task.
    pub tasks: Vec<TaskScores>,
    /// Criterion by which recordings were excluded from the training; none where that is not known.
    pub left_out: Option<Vec<String>>,
    /// Number of recordings that it was trained on.
    pub trained_on: usize,
}

/// The scores of a task.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct TaskScores {
    /// Its name.
    pub task: String,
    /// Number of its trajectories.
    pub trajectories: usize,
    /// Errors of the poses.
    pub poses: ByMethod<ByHorizon<PoseScores>>,
    /// Errors of the forces.
    pub forces: ForcesBySource,
}

/// The first trajectory of a task over time.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct TaskTrace {
    /// Name of the task.
    pub task: String,
    /// Times (n_rows) [s].
    pub time_s: Vec<f64>,
    /// Measured angles (n_joints × n_rows) [rad].
    pub measured_rad: Vec<Vec<f64>>,
    /// Angles by each method of [`METHODS`] (n_joints × n_rows) [rad].
    pub methods_rad: Vec<Vec<Vec<f64>>>,
    /// Label of the force along z, 0 where there is none (n_rows) [N].
    pub label_n: Vec<f64>,
    /// Force along z by each source of [`FORCES`] (n_rows) [N]; none where a source gives none.
    pub forces_n: Vec<Option<Vec<f64>>>,
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)] // a test may stop where it stands

    use std::collections::BTreeMap;

    use hysteron_base::json;

    use super::*;

    /// Keys as written, with their numbers.
    fn written(content: impl Serialize) -> BTreeMap<String, usize> {
        json::from_text(json::to_text(content).unwrap()).unwrap()
    }

    #[test]
    fn every_number_stands_under_the_name_of_its_method_and_horizon() {
        let methods = written(ByMethod::from_fn(|k| k));
        assert_eq!(methods.len(), METHODS.len());
        for (k, name) in METHODS.iter().enumerate() {
            assert_eq!(methods[*name], k, "{name}");
        }
        assert_eq!(ByMethod::from_fn(|k| k).values(), [&0, &1, &2, &3, &4]);
        let horizons = written(ByHorizon::from_fn(|steps| steps));
        assert_eq!(horizons, HORIZONS.iter().map(|steps| (steps.to_string(), *steps)).collect());
        assert_eq!(ByHorizon::from_fn(|steps| steps).values(), HORIZONS.each_ref());
        assert_eq!(
            HORIZONS.map(|steps| ByHorizon::from_fn(|own| own).over(steps).copied()),
            HORIZONS.map(Some)
        );
        assert_eq!(ByHorizon::from_fn(|steps| steps).over(200), None);
    }

    #[test]
    fn every_force_stands_under_the_key_of_its_source() {
        let score = |k: usize| ForceScores {
            mean_of_axes_n: k as f64,
            loaded_mean_of_axes_n: f64::NAN,
            loaded_axis_n: 0.0,
            loaded_norm_n: 0.0,
            false_contact: 0.0,
            missed_contact: 0.0,
            samples: [k, 0],
        };
        let text = json::to_text(ForcesBySource::from_fn(|k| (k != 1).then(|| score(k)))).unwrap();
        let all: BTreeMap<String, Option<ForceScores>> = json::from_text(&text).unwrap();
        for (k, (key, _)) in FORCES.iter().enumerate() {
            assert_eq!(all[*key].as_ref().map(|found| found.samples[0]), (k != 1).then_some(k), "{key}");
        }
        let read: ForcesBySource = json::from_text(&text).unwrap();
        assert!(read.force_gmo_linear.is_none() && read.force.unwrap().loaded_mean_of_axes_n.is_nan());
    }
}
