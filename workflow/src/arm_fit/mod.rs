//! `hysteron arm fit` and `hysteron arm evaluate`: models that learn from recordings of arms.

pub mod delan;
pub mod evaluate;
pub mod neural;
mod neural_evaluate;
pub(crate) mod recordings;
#[cfg(test)]
mod tests;
