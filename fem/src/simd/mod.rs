//! The single-precision block envelope on registers of lanes (`hysteron_base::lanes`).

mod blocks;
#[cfg(test)]
mod tests;

pub(crate) use blocks::{BLOCK, BlockEnvelope, SolutionPanel};
pub use hysteron_base::lanes::Isa;
pub(crate) use hysteron_base::lanes::{
    LANES, Lanes, Pack, Packs, PaddedPoints, Simd, WithSimd, collect, element,
};
