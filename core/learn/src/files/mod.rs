//! Files: arrays and JSON with a checksum, and what the engine and its families keep in them.

mod checkpoint;
mod parameters_file;
mod tensor_file;

pub use checkpoint::Checkpoint;
pub use parameters_file::{read_parameters, read_parameters_header, write_parameters};
pub(crate) use tensor_file::TensorFile;
