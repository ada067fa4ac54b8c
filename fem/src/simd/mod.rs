//! Explicit SIMD, through `pulp`: the only module of the workspace that names it.
//!
//! Every kernel is written once, generic over the instruction set, and dispatched at run time
//! ([`Isa::detect`]). [`Isa::portable`] runs the same code one number at a time: it is what processors
//! without AVX2 use, and what the tests compare with.

mod blocks;
mod lanes;
mod vectors;

pub(crate) use blocks::{BLOCK, Envelope, Panel};
pub(crate) use lanes::{LANES, Lanes, Pack, Packs};
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

    /// Runs `op` compiled for this instruction set.
    #[inline]
    pub(crate) fn run<Op: pulp::WithSimd>(self, op: Op) -> Op::Output {
        self.0.dispatch(op)
    }
}
