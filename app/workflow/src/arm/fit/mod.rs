//! `hysteron arm fit`: models that learn from recordings of arms.

pub mod delan;
#[cfg(test)]
mod delan_tests;
pub mod neural;
#[cfg(test)]
mod sensing_tests;
#[cfg(test)]
mod tests;
