//! The numbers that the algorithms run on.
//!
//! Every algorithm is written once over [`Scalar`]. A constant is made from a number that is already there
//! ([`Scalar::splat`]), because a register of lanes cannot be made from nothing.

use std::fmt::Debug;
use std::ops::{Add, Mul, Neg, Sub};

use hysteron_base::lanes::{LANES, outlined};

/// A number: `f64`, `f32`, one number for each lane of a register; dual and complex numbers in tests.
pub trait Scalar:
    Copy + Debug + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Neg<Output = Self>
{
    /// Numbers in it.
    const N_LANES: usize = 1;

    /// The numbers in it, without derivatives; the first [`Self::N_LANES`] count.
    fn values(self) -> [f64; LANES];

    /// The constants `values`, as a number of the same kind.
    #[inline(always)]
    fn constants(self, values: &[f64; LANES]) -> Self {
        self.splat(values[0])
    }

    /// The constant `value`, as a number of the same kind.
    fn splat(self, value: f64) -> Self;

    /// Sine and cosine of an angle [rad].
    fn sin_cos(self) -> (Self, Self);

    /// 1 / self.
    fn recip(self) -> Self;

    /// `self * b + c`; fused where that costs nothing.
    #[inline(always)]
    fn mul_add(self, b: Self, c: Self) -> Self {
        self * b + c
    }

    /// Runs `kernel` as a function of its own, compiled for the registers of this number: once for all callers.
    ///
    /// Code that is only inlined is compiled again for each of its callers.
    #[inline(always)]
    fn apart<R>(self, kernel: impl FnOnce() -> R) -> R {
        outlined(kernel)
    }

    /// `self * factor`.
    #[inline(always)]
    fn scale(self, factor: f64) -> Self {
        self * self.splat(factor)
    }
}

impl Scalar for f64 {
    #[inline(always)]
    fn values(self) -> [f64; LANES] {
        [self; LANES]
    }

    #[inline(always)]
    fn splat(self, value: f64) -> Self {
        value
    }

    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        f64::sin_cos(self)
    }

    #[inline(always)]
    fn recip(self) -> Self {
        1.0 / self
    }
}

impl Scalar for f32 {
    #[inline(always)]
    fn values(self) -> [f64; LANES] {
        [self.into(); LANES]
    }

    #[inline(always)]
    fn splat(self, value: f64) -> Self {
        value as f32
    }

    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        f32::sin_cos(self)
    }

    #[inline(always)]
    fn recip(self) -> Self {
        1.0 / self
    }
}
