//! Cells, progress and interruption of all studies: cells that are computed once and read again.

pub mod cells;
mod progress;
mod session;
pub mod side_by_side;
pub mod table;

pub use cells::{Listener, StudyProgress};
pub use session::run;
