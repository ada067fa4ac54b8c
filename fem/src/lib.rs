//! Tetrahedral finite elements: mesh in, stiffness factor out.

mod elements;
mod embed;
mod error;
mod factor;
mod gmsh;
mod mesh;
mod model;
mod ordering;
mod quality;
mod simd;
mod stiffness;
mod tube;
mod vtk;

pub use elements::Tangent;
pub use embed::Embedding;
pub use error::{Error, Result};
pub use factor::{FactorKind, StiffnessFactor};
pub use gmsh::{Encoding, read_mesh, write_mesh};
pub use mesh::{Cells, Mesh};
pub use model::FemModel;
pub use quality::{Distribution, MeshQuality, check_mesh};
pub use simd::{Isa, axpy, combine_into, dot};
pub use stiffness::{Stiffness, StiffnessPattern};
pub use tube::{Channel, Layers, Order, Tube};
pub use vtk::{Array, Polylines, Pvd, Values, write_polylines, write_vtu};
