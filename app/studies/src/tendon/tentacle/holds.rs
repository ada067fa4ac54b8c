//! Recorded holds, and the markers on the body.

use std::path::Path;

use anyhow::Result;
use hysteron_fem::{Embedding, FemModel};
use hysteron_twin::{TwinState, nearest_rotation};
use nalgebra::{Matrix3, Rotation3, Vector3};

use crate::tendon::columns::read_columns;

/// Markers.
pub(super) const N_MARKERS: usize = 4;
/// Arc length of the markers' sections and their offset along the rod frame's Z [m].
const ARMS: [(f64, f64); 3] = [(0.1291, 0.025), (0.2195, -0.021), (0.2800, 0.020)];
/// Length of the body, and distance of the last marker beyond it [m].
const TIP: (f64, f64) = (0.360, 0.008);
/// Centre of the base from the base marker, mocap axes [m].
const BASE: [f64; 3] = [-0.030, -0.013, 0.0];
/// A static hold.
#[derive(Clone)]
pub(super) struct Hold {
    /// Tensions of the tendons [N].
    pub tensions: [f64; 2],
    /// The base marker [m].
    pub base: Vector3<f64>,
    /// The markers [m].
    pub markers: [Vector3<f64>; N_MARKERS],
}

impl Hold {
    /// The two sessions differ in the pose of the base.
    pub fn is_session_b(&self) -> bool {
        (self.base.x - 0.2175).abs() < 0.005
    }
}

/// Reads all holds.
///
/// # Errors
/// The file cannot be read or has other columns.
pub(super) fn read_holds(path: &Path) -> Result<Vec<Hold>> {
    let mut names = vec!["tension1_N".to_owned(), "tension2_N".to_owned()];
    for marker in ["pb", "p1", "p2", "p3", "p4"] {
        names.extend(["x", "y", "z"].map(|axis| format!("{marker}_{axis}")));
    }
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let columns = read_columns(path, &names)?;
    let hold = |k: usize| {
        let point = |m: usize| Vector3::from_fn(|c, _| columns[2 + 3 * m + c][k]);
        Hold {
            tensions: [columns[0][k], columns[1][k]],
            base: point(0),
            markers: std::array::from_fn(|m| point(m + 1)),
        }
    };
    Ok((0..columns[0].len()).map(hold).collect())
}

/// A section: its centre and a ring of points, carried by the body.
struct Section {
    rest: Vec<Vector3<f64>>,
    points: Vec<Embedding>,
}

impl Section {
    fn new(body: &FemModel, s: f64, radius: f64) -> Self {
        let ring = (0..8).map(|k| {
            let (sin, cos) = (std::f64::consts::FRAC_PI_4 * f64::from(k)).sin_cos();
            Vector3::new(radius * cos, radius * sin, s)
        });
        let rest: Vec<_> = std::iter::once(Vector3::new(0.0, 0.0, s)).chain(ring).collect();
        let points = rest.iter().map(|point| Embedding::new(body, (*point).into())).collect();
        Self { rest, points }
    }

    /// Centre and best-fit rotation.
    fn pose(&self, state: &TwinState) -> (Vector3<f64>, Matrix3<f64>) {
        let moved: Vec<_> =
            self.points.iter().map(|point| Vector3::from(point.at(&state.positions))).collect();
        let mean = |points: &[Vector3<f64>]| points.iter().sum::<Vector3<f64>>() / points.len() as f64;
        let (from, to) = (mean(&self.rest), mean(&moved));
        let mut moment = Matrix3::zeros();
        for (rest, moved) in self.rest.iter().zip(&moved) {
            moment += (moved - to) * (rest - from).transpose();
        }
        (moved[0], nearest_rotation(&moment))
    }
}

/// The markers on the body.
pub(super) struct Markers {
    arms: Vec<(Section, Vector3<f64>)>,
}

impl Markers {
    pub fn new(body: &FemModel) -> Self {
        let mut arms: Vec<_> = ARMS
            .into_iter()
            .map(|(s, offset)| (Section::new(body, s, 0.004), Vector3::new(0.0, offset, 0.0)))
            .collect();
        arms.push((Section::new(body, TIP.0, 0.004), Vector3::new(0.0, 0.0, TIP.1)));
        Self { arms }
    }

    /// Markers in the mesh's axes, their arms turned by `twist` about the axis [rad].
    pub fn in_body(&self, state: &TwinState, twist: f64) -> [Vector3<f64>; N_MARKERS] {
        let twist = Rotation3::from_axis_angle(&Vector3::z_axis(), twist);
        std::array::from_fn(|m| {
            let (section, arm) = &self.arms[m];
            let (center, rotation) = section.pose(state);
            center + rotation * (twist * arm)
        })
    }

    /// Markers in the mocap frame.
    pub fn at(&self, state: &TwinState, base: Vector3<f64>) -> [Vector3<f64>; N_MARKERS] {
        self.in_body(state, 0.0).map(|point| in_mocap(point, base))
    }
}

/// A point in the mesh's axes, in the mocap frame.
pub(super) fn in_mocap(point: Vector3<f64>, base: Vector3<f64>) -> Vector3<f64> {
    base + Vector3::from(BASE) + Vector3::new(point.y, point.z, point.x)
}
