//! Facts that hold for any plan, any target and any pair of curves; and the inverse controller.

#![allow(clippy::unwrap_used)] // a test may stop where it stands

mod it {
    mod inverse;
    mod plan;
    mod target;
    mod tracking;
}
