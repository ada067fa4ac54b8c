//! Fixtures for the tests of the arm crates: five robots with reference values, dual and complex numbers, recordings of an arm.

#![allow(clippy::unwrap_used, reason = "a test may stop where it stands")]

pub mod numbers;
pub mod recordings;
pub mod robots;
