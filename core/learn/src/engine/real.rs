//! Real numbers that networks are computed in.

use std::fmt::Debug;
use std::iter::Sum;
use std::ops::{Add, AddAssign, Div, Mul, MulAssign, Neg, Sub, SubAssign};

use pulp::Simd;

use crate::product::Field;

/// Numbers side by side in registers.
pub trait Registers: Copy {
    /// A register of an instruction set.
    type Of<S: Simd>: Copy;

    /// `values`, a multiple of a register's numbers, register by register.
    fn split<S: Simd>(values: &[Self]) -> &[Self::Of<S>];
    /// The same, to be written.
    fn split_mut<S: Simd>(values: &mut [Self]) -> &mut [Self::Of<S>];
    /// The same number in all places.
    fn splat<S: Simd>(simd: S, value: Self) -> Self::Of<S>;
    /// a b + c, rounded once.
    fn mul_add<S: Simd>(simd: S, a: Self::Of<S>, b: Self::Of<S>, c: Self::Of<S>) -> Self::Of<S>;
}

macro_rules! registers {
    ($t:ty, $of:ident, $split:ident, $split_mut:ident, $splat:ident, $mul_add:ident) => {
        impl Registers for $t {
            type Of<S: Simd> = S::$of;

            #[inline(always)]
            fn split<S: Simd>(values: &[Self]) -> &[S::$of] {
                S::$split(values).0
            }

            #[inline(always)]
            fn split_mut<S: Simd>(values: &mut [Self]) -> &mut [S::$of] {
                S::$split_mut(values).0
            }

            #[inline(always)]
            fn splat<S: Simd>(simd: S, value: Self) -> S::$of {
                simd.$splat(value)
            }

            #[inline(always)]
            fn mul_add<S: Simd>(simd: S, a: S::$of, b: S::$of, c: S::$of) -> S::$of {
                simd.$mul_add(a, b, c)
            }
        }
    };
}

registers!(f32, f32s, as_simd_f32s, as_mut_simd_f32s, splat_f32s, mul_add_f32s);
registers!(f64, f64s, as_simd_f64s, as_mut_simd_f64s, splat_f64s, mul_add_f64s);

/// `f32`, for training, or `f64`, for checks and for the last digits.
///
/// The elementary functions are written without branches and tables, so that a loop over them becomes vector code; they
/// are the same operations on every instruction set.
pub trait Float:
    Field
    + Registers
    + Copy
    + Default
    + Debug
    + PartialOrd
    + Send
    + Sync
    + 'static
    + Sum
    + Neg<Output = Self>
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + AddAssign
    + SubAssign
    + MulAssign
{
    /// The number nearest to `value`.
    fn of(value: f64) -> Self;
    /// As `f64`, exactly.
    fn to_f64(self) -> f64;
    /// The larger one.
    fn larger(self, other: Self) -> Self;
    /// Its size.
    fn size(self) -> Self;
    /// `size` with the sign of `self`.
    fn sign_on(self, size: Self) -> Self;
    /// Square root.
    fn root(self) -> Self;
    /// exp(self), within two units in the last place; the argument is limited to where it is a normal number.
    fn exponential(self) -> Self;
    /// ln(1 + self) for 0 <= self <= 1, to rounding: 2 artanh(y/(2 + y)) as a series.
    fn log_one_plus(self) -> Self;
}

/// Horner's rule, highest power first.
#[inline(always)]
fn polynomial<T: Float, const N: usize>(coefficients: &[f64; N], x: T) -> T {
    let mut sum = T::of(coefficients[0]);
    for c in &coefficients[1..] {
        sum = sum * x + T::of(*c);
    }
    sum
}

/// 1/k! from k = N − 1 down to 0.
const fn inverse_factorials<const N: usize>() -> [f64; N] {
    let mut values = [1.0; N];
    let mut k = 1;
    while k < N {
        values[N - 1 - k] = values[N - k] / k as f64;
        k += 1;
    }
    values
}

/// 1/(2k + 1) from k = N − 1 down to 0.
const fn odd_inverses<const N: usize>() -> [f64; N] {
    let mut values = [1.0; N];
    let mut k = 0;
    while k < N {
        values[N - 1 - k] = 1.0 / (2 * k + 1) as f64;
        k += 1;
    }
    values
}

macro_rules! real {
    ($t:ty, $bits:ty, $magic:expr, $mantissa:expr, $limit:expr, $high:expr, $low:expr, $exp:expr, $log:expr) => {
        impl Float for $t {
            #[inline(always)]
            fn of(value: f64) -> Self {
                value as Self
            }

            #[inline(always)]
            fn to_f64(self) -> f64 {
                f64::from(self)
            }

            #[inline(always)]
            fn larger(self, other: Self) -> Self {
                if self > other { self } else { other }
            }

            #[inline(always)]
            fn size(self) -> Self {
                self.abs()
            }

            #[inline(always)]
            fn sign_on(self, size: Self) -> Self {
                size.copysign(self)
            }

            #[inline(always)]
            fn root(self) -> Self {
                self.sqrt()
            }

            #[inline(always)]
            fn exponential(self) -> Self {
                // x = k ln 2 + r with |r| <= ln 2 / 2; adding the magic number rounds to whole k, which then stand in the low
                // bits and are added to the exponent.
                let x = if self > $limit { $limit } else { self };
                let x = if x < -$limit { -$limit } else { x };
                let shifted = x * (std::f64::consts::LOG2_E as $t) + $magic;
                let k = shifted - $magic;
                let r = (x - k * $high) - k * $low;
                const POWERS: [f64; $exp] = inverse_factorials();
                let value: $t = polynomial(&POWERS, r);
                <$t>::from_bits(value.to_bits().wrapping_add((shifted.to_bits() as $bits) << $mantissa))
            }

            #[inline(always)]
            fn log_one_plus(self) -> Self {
                let s = self / (2.0 + self);
                const ODD: [f64; $log] = odd_inverses();
                let series: $t = polynomial(&ODD, s * s);
                2.0 * s * series
            }
        }
    };
}

// Terms: |r|^n/n! < 2^-24 for n = 8 and < 2^-53 for n = 14; (1/9)^k/(2k + 1) < 2^-24 for k = 7 and < 2^-53 for k = 16.
// ln 2 is split so that k times its high part is exact.
real!(f32, u32, 12_582_912.0, 23, 87.0, 0.693_359_4, -2.121_944_4e-4, 8, 8);
real!(
    f64,
    u64,
    6_755_399_441_055_744.0,
    52,
    708.0,
    0.693_147_180_369_123_8,
    1.908_214_929_270_587_7e-10,
    14,
    17
);

#[cfg(test)]
mod tests {
    use super::*;

    /// Largest relative error of `found` against `exact`, in units in the last place of `T`.
    fn worst<T: Float>(unit: f64, range: [f64; 2], found: fn(T) -> T, exact: fn(f64) -> f64) -> f64 {
        let n = 20_001;
        (0..n)
            .map(|i| {
                let x = T::of(range[0] + (range[1] - range[0]) * f64::from(i) / f64::from(n - 1));
                let truth = exact(x.to_f64());
                (found(x).to_f64() - truth).abs() / (truth.abs() * unit).max(f64::MIN_POSITIVE)
            })
            .fold(0.0, f64::max)
    }

    #[test]
    fn exponentials_and_logarithms_are_those_of_the_standard_library() {
        assert!(worst::<f32>(f32::EPSILON.into(), [-86.0, 86.0], Float::exponential, f64::exp) < 2.0);
        assert!(worst::<f64>(f64::EPSILON, [-700.0, 700.0], Float::exponential, f64::exp) < 3.0);
        assert!(worst::<f32>(f32::EPSILON.into(), [0.0, 1.0], Float::log_one_plus, f64::ln_1p) < 4.0);
        assert!(worst::<f64>(f64::EPSILON, [0.0, 1.0], Float::log_one_plus, f64::ln_1p) < 4.0);
    }
}
