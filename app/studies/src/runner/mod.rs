//! What all studies share: cells that are computed once and read again, progress, interruption, the list of studies.

pub mod cells;
mod progress;
mod session;
pub mod side_by_side;
pub mod table;

pub use cells::{Listener, StudyProgress};
pub use session::run;
