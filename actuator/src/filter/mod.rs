//! Filters of measured signals: Butterworth low pass by specification, median, Savitzky-Golay.
//!
//! A [`LowPass`] is a design; [`LowPassState`] runs it sample by sample without allocation, and [`LowPass::zero_phase`] over a
//! whole recording forwards and backwards, which no control loop can.

mod butterworth;
mod median;
mod savitzky_golay;

pub use butterworth::{LowPass, LowPassState, Specification};
pub use median::{Median, median_of};
pub use savitzky_golay::SavitzkyGolay;

#[cfg(test)]
mod tests;
