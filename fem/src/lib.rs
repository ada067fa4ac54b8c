//! Tetrahedral finite elements: mesh in, stiffness factor out.

mod error;
mod mesh;

pub use error::{Error, Result};
pub use mesh::{Cells, Mesh};
