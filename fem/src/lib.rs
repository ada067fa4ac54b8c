//! Tetrahedral finite elements: mesh in, stiffness factor out.
//!
//! ```
//! use hysteron_fem::{Layers, Order, Tube, check_mesh};
//!
//! // A solid cylinder of 10 mm by 1 mm.
//! let tube = Tube {
//!     profile: vec![[0.0, 1e-3], [10e-3, 1e-3]],
//!     bore_radius: 0.0,
//!     channels: Vec::new(),
//!     outer_divisions: 12,
//!     bore_divisions: 8,
//!     channel_divisions: 8,
//!     layers: Layers::Count(10),
//!     order: Order::Linear,
//! };
//! let mesh = tube.mesh()?;
//! let quality = check_mesh(&mesh, "a cylinder")?;
//! println!("{} nodes, {:.2e} m³", quality.n_nodes, quality.volume.sum);
//! # Ok::<(), hysteron_fem::Error>(())
//! ```

mod anchor;
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
pub mod vectors;
mod vtk;

pub use anchor::{Anchor, AnchorCarriers, axes_across};
pub use elements::Tangent;
pub use embed::Embedding;
pub use error::{Error, Result};
pub use factor::{FactorKind, StiffnessFactor};
pub use gmsh::{MshEncoding, read_mesh, write_mesh};
pub use mesh::{Cells, Mesh};
pub use model::FemModel;
pub use quality::{Distribution, MeshQuality, check_mesh};
pub use stiffness::{Stiffness, StiffnessPattern};
pub use tube::{Layers, Order, TendonChannel, Tube};
pub use vtk::{ArrayValues, Polylines, Pvd, VtkArray, write_polylines, write_vtu};
