//! Integration tests of `hysteron-fem`.

mod mesh;
mod physics;
mod readme;
