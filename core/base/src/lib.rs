//! Units, random streams, scene files, recordings and the one error shape.
//!
//! Everything that other crates must agree on, and nothing that computes. What enters here from a file is
//! checked once and leaves as SI, so no other crate converts a unit or checks a bound of a scene.
//!
//! ```
//! use hysteron_base::{Channel, Metadata, Recording};
//!
//! let stroke = Channel::new("stroke_1_m", vec![0.0, 1e-3, 2e-3]);
//! let recording = Recording::new(vec![0.0, 0.01, 0.02], vec![stroke], Vec::new(), Metadata::default())?;
//! assert_eq!(recording.strokes()[0][2], 2e-3);
//! assert!((recording.rate_hz().unwrap_or(0.0) - 100.0).abs() < 1e-9);
//! # Ok::<(), hysteron_base::BadInput>(())
//! ```

// Units are in brackets in the comments, [m] and [N], which rustdoc takes for links.
#![allow(rustdoc::broken_intra_doc_links)]

pub mod checks;
mod error;
pub mod file;
pub mod import;
pub mod json;
pub mod lanes;
mod lock;
pub mod number;
mod panics;
pub mod parallel;
pub mod plausible_range;
mod recording;
mod rng;
pub mod sampling;
mod scene;
pub mod schema;
pub mod size;
pub mod statistics;
mod table;
pub mod units;

pub use error::{BadInput, Error, Result};
pub use lock::{Lock, abandon_outputs};
pub use recording::{
    Channel, Journal, JournalFile, JournalQueue, JournalWriter, MAX_CHANNELS, Metadata, Recording,
    TrajectoryShard,
};
pub use rng::{normal, rng};
pub use scene::{
    AuxiliaryLayout, Bounds, Friction, Insert, Material, MaterialLaw, PointForce, PrescribedQuantity, Region,
    Scene, Solver, Tendon, TipDefinition, TrackerFrame,
};
pub use table::{Column, RowFilter, Table, TextFormat};
pub use units::LengthUnit;
