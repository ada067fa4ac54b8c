//! Tests of the rig from outside: one folder or file per subject.

#![allow(clippy::unwrap_used)] // a test may stop where it stands

mod it {
    mod calibration;
    #[cfg(unix)]
    mod emulator;
    mod fuzz;
    #[cfg(unix)]
    mod registers;
    #[cfg(unix)]
    mod session;
    #[cfg(unix)]
    mod teleoperation;
    mod tracker;
}
