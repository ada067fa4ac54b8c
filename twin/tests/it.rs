//! Integration tests of `hysteron-twin`: robots on small meshes, made in code.

// A failed expectation is how a test fails; printed lines are the residuals asked for by TOL_SCALE=0.
#![allow(clippy::unwrap_used, clippy::print_stdout, clippy::print_stderr)]

mod twin;
