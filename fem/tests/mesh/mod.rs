mod gmsh;
mod gmsh_errors;
mod meshes;
mod msh_writer;
mod quality;
mod tube;
mod versions;
mod vtk;

use std::path::PathBuf;

use hysteron_base::BadInput;
use hysteron_fem::{Error, Mesh, Result};

pub const MM: f64 = 1e-3;

/// A sample written by Gmsh.
pub fn sample(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(name)
}

pub fn read_sample(name: &str) -> Mesh {
    hysteron_fem::read_mesh(&sample(name), MM).expect("a good sample")
}

/// The bad input that a call must have found.
pub fn bad_input<T: std::fmt::Debug>(result: Result<T>) -> BadInput {
    match result {
        Err(Error::BadInput(bad)) => bad,
        other => panic!("expected bad input, got {other:?}"),
    }
}

/// Volume from the corners [m³].
pub fn volume(mesh: &Mesh) -> f64 {
    (0..mesh.cells.len())
        .map(|e| {
            let [o, a, b, c] = mesh.cells.corners(e).map(|n| nalgebra::Vector3::from(mesh.nodes[n as usize]));
            (a - o).dot(&(b - o).cross(&(c - o))) / 6.0
        })
        .sum()
}
