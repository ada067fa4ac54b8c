//! Units, random streams, scene files, recordings and the one error shape.

mod error;

pub use error::{BadInput, Error, Result};
