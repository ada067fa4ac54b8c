//! Tests of the rig from outside: one folder per subject.

#![allow(clippy::unwrap_used)] // a test may stop where it stands

mod it {
    mod tracker;
}
