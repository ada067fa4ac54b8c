//! Tetrahedral finite elements: mesh in, stiffness factor out.

mod error;
mod gmsh;
mod mesh;
mod quality;
mod tube;
mod vtk;

pub use error::{Error, Result};
pub use gmsh::{Encoding, read_mesh, write_mesh};
pub use mesh::{Cells, Mesh};
pub use quality::{Distribution, MeshQuality, check_mesh};
pub use tube::{Channel, Layers, Order, Tube};
pub use vtk::{Array, Polylines, Pvd, Values, write_polylines, write_vtu};
