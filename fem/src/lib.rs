//! Tetrahedral finite elements: mesh in, stiffness factor out.

mod elements;
mod embed;
mod error;
mod factor;
mod mesh;
mod model;
mod ordering;
mod simd;
mod stiffness;

pub use elements::Tangent;
pub use embed::Embedding;
pub use error::{Error, Result};
pub use factor::{FactorKind, StiffnessFactor};
pub use mesh::{Cells, Mesh};
pub use model::FemModel;
pub use simd::{Isa, axpy, combine_into, dot};
pub use stiffness::{Stiffness, StiffnessPattern};
