//! The program `hysteron`.
fn main() {}
