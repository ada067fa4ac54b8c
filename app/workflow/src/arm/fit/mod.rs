//! `hysteron arm fit`, `hysteron arm evaluate`, `hysteron arm estimate` and `hysteron arm adapt`: models that learn from recordings of arms.

pub mod adapt;
pub mod delan;
#[cfg(test)]
mod delan_tests;
pub mod estimate;
pub mod evaluate;
pub mod neural;
mod neural_evaluate;
pub(crate) mod recordings;
#[cfg(test)]
mod sensing_tests;
#[cfg(test)]
mod tests;
