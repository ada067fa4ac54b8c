//! Files: arrays and JSON with a checksum, and what the engine and its families keep in them.

mod checkpoint;
mod parameters_file;
mod provenance;
mod tensor_file;

pub use checkpoint::Checkpoint;
pub use parameters_file::{read_parameters, read_parameters_details, read_parameters_kind, write_parameters};
pub use provenance::{Provenance, options_of_this_version};
pub(crate) use tensor_file::TensorFile;
