//! The five robots, their reference states, and how numbers are compared.

use hysteron_base::json;
use std::path::{Path, PathBuf};

use hysteron_arm_dynamics::Model;

/// Names of the robots.
pub const NAMES: [&str; 5] = ["double_pendulum", "open_manipulator_x", "panda", "so101", "ur5"];

/// Folder of the crate that has the robots and their reference values.
fn dynamics() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../arm/dynamics")
}

/// File of the robot `name`.
pub fn file(name: &str) -> PathBuf {
    [dynamics().join("robots"), dynamics().join("tests/data")]
        .map(|folder| folder.join(format!("{name}.urdf")))
        .into_iter()
        .find(|path| path.exists())
        .unwrap()
}

/// Text of a file in the folder `robot_files`: robot files as people have them, and `urdf.json`, their values by Pinocchio.
pub fn robot_file(name: &str) -> String {
    std::fs::read_to_string(dynamics().join("tests/data/robot_files").join(name)).unwrap()
}

/// The robot `name`.
pub fn model(name: &str) -> Model {
    Model::read(&file(name)).unwrap()
}

/// A state of a reference file.
#[derive(serde::Deserialize)]
pub struct State {
    /// Positions [rad, m].
    pub q: Vec<f64>,
    /// Speeds.
    pub v: Vec<f64>,
    /// Accelerations.
    pub a: Vec<f64>,
    /// Torques that forward dynamics are given.
    pub tau: Vec<f64>,
    /// Mass matrix, row by row.
    pub mass_matrix: Vec<Vec<f64>>,
    /// Coriolis matrix times speeds.
    pub coriolis_times_v: Vec<f64>,
    /// Gravity torques.
    pub gravity: Vec<f64>,
    /// Torques for the accelerations.
    pub inverse_dynamics: Vec<f64>,
    /// Accelerations under the torques.
    pub forward_dynamics: Vec<f64>,
    /// Derivative of inverse dynamics by positions.
    pub d_id_dq: Vec<Vec<f64>>,
    /// Derivative of inverse dynamics by speeds.
    pub d_id_dv: Vec<Vec<f64>>,
    /// Derivative of inverse dynamics by accelerations.
    pub d_id_da: Vec<Vec<f64>>,
    /// Derivative of forward dynamics by positions.
    pub d_fd_dq: Vec<Vec<f64>>,
    /// Derivative of forward dynamics by speeds.
    pub d_fd_dv: Vec<Vec<f64>>,
    /// Derivative of forward dynamics by torques.
    pub d_fd_dtau: Vec<Vec<f64>>,
    /// Jacobian of the tip along the axes of the world, row by row.
    pub tip_jacobian_world_aligned: Vec<Vec<f64>>,
    /// Pose of the tip, row by row.
    pub tip_in_world: Vec<Vec<f64>>,
    /// Kinetic energy [J].
    pub kinetic_energy: f64,
    /// Potential energy [J].
    pub potential_energy: f64,
}

/// A reference file: states of one robot, computed by Pinocchio.
#[derive(serde::Deserialize)]
pub struct Reference {
    /// Names of the joints in order.
    pub joints: Vec<String>,
    /// Name of the frame of the tip.
    pub tip_frame: String,
    /// The states.
    pub states: Vec<State>,
}

/// Reference values of the robot `name`.
pub fn reference(name: &str) -> Reference {
    let path = dynamics().join("tests/data").join(format!("{name}.json"));
    json::from_text(std::fs::read_to_string(path).unwrap()).unwrap()
}

/// Every state of every robot.
pub fn each(mut check: impl FnMut(&str, &Model, &Reference, &State)) {
    for name in NAMES {
        let (model, reference) = (model(name), reference(name));
        let joints: Vec<&str> = model.joints().iter().map(|joint| joint.name.as_str()).collect();
        assert_eq!(joints, reference.joints, "{name}");
        reference.states.iter().for_each(|state| check(name, &model, &reference, state));
    }
}

/// Greatest difference, relative to the greatest number of the expected ones.
pub fn difference(got: &[f64], expected: &[f64]) -> f64 {
    assert_eq!(got.len(), expected.len());
    let scale = expected.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    let worst = got
        .iter()
        .zip(expected)
        .fold(0.0_f64, |m, (a, b)| if (a - b).is_nan() { f64::NAN } else { m.max((a - b).abs()) });
    if worst == 0.0 { 0.0 } else { worst / scale }
}

/// Fails where `got` is further from `expected` than `tolerance`, relative to the greatest number.
pub fn assert_close(what: &str, got: &[f64], expected: &[f64], tolerance: f64) {
    let difference = difference(got, expected);
    assert!(difference <= tolerance, "{what}: {difference:e}\n{got:?}\n{expected:?}");
}
