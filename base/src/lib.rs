//! Units, random streams, scene files, recordings and the one error shape.
//!
//! Everything that other crates must agree on, and nothing that computes. What enters here from a file is
//! checked once and leaves as SI, so no other crate converts a unit or checks a bound of a scene.

// Units stand in brackets in the comments, [m] and [N], which rustdoc takes for links.
#![allow(rustdoc::broken_intra_doc_links)]

mod error;
pub mod file;
pub mod lanes;
mod lock;
mod recording;
mod rng;
mod scene;
pub mod schema;
pub mod size;
mod table;
pub mod units;

pub use error::{BadInput, Error, Result};
pub use lock::Lock;
pub use recording::{Channel, Journal, JournalFile, JournalQueue, JournalWriter, Metadata, Recording};
pub use rng::rng;
pub use scene::{
    AuxiliaryLayout, Bounds, Drive, Friction, Law, Material, PointForce, Region, Scene, Solver, Tendon, Tip,
    TrackerFrame,
};
pub use table::{Column, Filter, Table};
pub use units::LengthUnit;
