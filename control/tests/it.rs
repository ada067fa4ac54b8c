//! Facts that hold for any plan, any target and any pair of curves.

#![allow(clippy::unwrap_used)] // a test may stop where it stands

mod it {
    mod plan;
    mod target;
    mod tracking;
}
