//! Explicit SIMD, through `pulp`: the only module of this crate that names it; the kernels
//! of the elements see its traits through here.
//!
//! Every kernel is written once, generic over the instruction set, and dispatched at run time
//! ([`Isa::detect`]). [`Isa::portable`] runs the same code one number at a time: it is what processors
//! without AVX2 use, and what the tests compare with.

mod blocks;
mod lanes;
#[cfg(test)]
mod tests;
mod vectors;

pub(crate) use blocks::{BLOCK, Envelope, Panel};
pub(crate) use lanes::{LANES, Lanes, Pack, Packs, Rows, collect, element};
pub(crate) use pulp::{Simd, WithSimd};
pub use vectors::{axpy, combine_into, dot};

/// The instruction set kernels run on.
#[derive(Debug, Clone, Copy)]
pub struct Isa(pulp::Arch);

impl Isa {
    /// The widest set this processor has: AVX-512, AVX2 + FMA, NEON, or the portable path.
    pub fn detect() -> Self {
        Self(pulp::Arch::new())
    }

    /// One number at a time, on any processor.
    pub fn portable() -> Self {
        Self(pulp::Arch::Scalar)
    }

    /// Every set this processor has, so that a test on AVX-512 covers AVX2 too.
    #[cfg(test)]
    pub(crate) fn all() -> Vec<Self> {
        let mut all = vec![Self::portable(), Self::detect()];
        #[cfg(target_arch = "x86_64")]
        all.extend(pulp::x86::V3::try_new().map(|v3| Self(pulp::Arch::V3(v3))));
        all
    }

    /// Runs `op` compiled for this instruction set.
    #[inline]
    pub(crate) fn run<Op: pulp::WithSimd>(self, op: Op) -> Op::Output {
        self.0.dispatch(op)
    }
}
