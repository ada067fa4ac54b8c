//! The five robots, their reference states, and how numbers are compared.

use hysteron_base::json;
use std::path::{Path, PathBuf};

use hysteron_arm::Model;

pub const NAMES: [&str; 5] = ["double_pendulum", "open_manipulator_x", "panda", "so101", "ur5"];

pub fn file(name: &str) -> PathBuf {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    [root.join("robots"), root.join("tests/data")]
        .map(|folder| folder.join(format!("{name}.urdf")))
        .into_iter()
        .find(|path| path.exists())
        .unwrap()
}

pub fn model(name: &str) -> Model {
    Model::read(&file(name)).unwrap()
}

/// A state of a reference file.
#[derive(serde::Deserialize)]
pub struct State {
    pub q: Vec<f64>,
    pub v: Vec<f64>,
    pub a: Vec<f64>,
    pub tau: Vec<f64>,
    pub mass_matrix: Vec<Vec<f64>>,
    pub coriolis_times_v: Vec<f64>,
    pub gravity: Vec<f64>,
    pub inverse_dynamics: Vec<f64>,
    pub forward_dynamics: Vec<f64>,
    pub d_id_dq: Vec<Vec<f64>>,
    pub d_id_dv: Vec<Vec<f64>>,
    pub d_id_da: Vec<Vec<f64>>,
    pub d_fd_dq: Vec<Vec<f64>>,
    pub d_fd_dv: Vec<Vec<f64>>,
    pub d_fd_dtau: Vec<Vec<f64>>,
    pub tip_jacobian_world_aligned: Vec<Vec<f64>>,
    pub tip_in_world: Vec<Vec<f64>>,
    pub kinetic_energy: f64,
    pub potential_energy: f64,
}

#[derive(serde::Deserialize)]
pub struct Reference {
    pub joints: Vec<String>,
    pub tip_frame: String,
    pub states: Vec<State>,
}

pub fn reference(name: &str) -> Reference {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(format!("{name}.json"));
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

pub fn assert_close(what: &str, got: &[f64], expected: &[f64], tolerance: f64) {
    let difference = difference(got, expected);
    assert!(difference <= tolerance, "{what}: {difference:e}\n{got:?}\n{expected:?}");
}
