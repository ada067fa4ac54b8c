//! Files: arrays and JSON with a checksum, and what the engine and its families keep in them.

mod checkpoint;
mod parameters_file;
mod tensor_file;

pub use checkpoint::Checkpoint;
pub use parameters_file::{parameters_kind, read_parameters, write_parameters};
pub(crate) use tensor_file::TensorFile;
