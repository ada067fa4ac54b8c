//! Registers of lanes as [`Scalar`]: every lane belongs to another state of the arm.

use hysteron_base::lanes::{LANES, Lanes, Pack, Simd};

use crate::Scalar;

/// π in three parts, the first two of 30 bits: their products with whole numbers below 2²³ are exact.
const PI_PARTS: [f64; 3] = [3.141592651605606, 1.9841871583270443e-9, 1.034036596358821e-18];

/// Added and taken away again, it rounds to a whole number.
const ROUNDS: f64 = 6755399441055744.0;

/// 1/3!, 1/5!, … with signs: on [−π/2, π/2] the term that is left out is below 2e-18.
const SIN: [f64; 10] = [
    -1.0 / 6.0,
    1.0 / 120.0,
    -1.0 / 5040.0,
    1.0 / 362_880.0,
    -1.0 / 39_916_800.0,
    1.0 / 6_227_020_800.0,
    -1.0 / 1_307_674_368_000.0,
    1.0 / 355_687_428_096_000.0,
    -1.0 / 121_645_100_408_832_000.0,
    1.0 / 51_090_942_171_709_440_000.0,
];

/// 1/2!, 1/4!, … with signs.
const COS: [f64; 11] = [
    -1.0 / 2.0,
    1.0 / 24.0,
    -1.0 / 720.0,
    1.0 / 40_320.0,
    -1.0 / 3_628_800.0,
    1.0 / 479_001_600.0,
    -1.0 / 87_178_291_200.0,
    1.0 / 20_922_789_888_000.0,
    -1.0 / 6_402_373_705_728_000.0,
    1.0 / 2_432_902_008_176_640_000.0,
    -1.0 / 1_124_000_727_777_607_680_000.0,
];

/// The nearest whole number.
#[inline(always)]
fn rounded<S: Simd>(x: Lanes<S>) -> Lanes<S> {
    (x + x.same(ROUNDS)) - x.same(ROUNDS)
}

/// Σ terms_k x^k.
#[inline(always)]
fn series<S: Simd, const N: usize>(x: Lanes<S>, terms: &[f64; N]) -> Lanes<S> {
    let mut sum = x.same(terms[N - 1]);
    for k in (0..N - 1).rev() {
        sum = Lanes::mul_add(sum, x, x.same(terms[k]));
    }
    sum
}

impl<S: Simd> Scalar for Lanes<S> {
    const N_LANES: usize = S::F64_LANES;

    #[inline(always)]
    fn values(self) -> [f64; LANES] {
        self.to_array()
    }

    #[inline(always)]
    fn constants(self, values: &[f64; LANES]) -> Self {
        self.load(&Pack(*values))
    }

    #[inline(always)]
    fn splat(self, value: f64) -> Self {
        self.same(value)
    }

    /// Within 4e-16 of the true values for angles up to 1e6 rad.
    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        let turns = rounded(self.scale(std::f64::consts::FRAC_1_PI));
        let mut r = self;
        for part in PI_PARTS {
            r = Lanes::mul_add(turns, self.same(-part), r);
        }
        // −1 where the number of half turns is odd.
        let odd = turns - rounded(turns.scale(0.5)).scale(2.0);
        let sign = Lanes::mul_add(odd.scale(-2.0), odd, self.same(1.0));
        let square = r * r;
        let sin = Lanes::mul_add(series(square, &SIN) * square, r, r);
        let cos = Lanes::mul_add(series(square, &COS), square, self.same(1.0));
        (sin * sign, cos * sign)
    }

    #[inline(always)]
    fn recip(self) -> Self {
        Lanes::recip(self)
    }

    #[inline(always)]
    fn apart<R>(self, kernel: impl FnOnce() -> R) -> R {
        Lanes::apart(self, kernel)
    }

    #[inline(always)]
    fn mul_add(self, b: Self, c: Self) -> Self {
        Lanes::mul_add(self, b, c)
    }
}

#[cfg(test)]
mod tests {
    use hysteron_base::lanes::{Isa, Packs, WithSimd};

    use super::*;

    struct Angles(Pack);

    impl WithSimd for Angles {
        type Output = ();

        fn with_simd<S: Simd>(self, simd: S) {
            for pass in 0..Packs::<S>::PASSES {
                let packs = Packs::new(simd, pass);
                let (sin, cos) = Scalar::sin_cos(packs.load(&self.0));
                for (lane, element) in packs.range().enumerate() {
                    let (expected, x) = (self.0.0[element].sin_cos(), self.0.0[element]);
                    let got = (sin.to_array()[lane], cos.to_array()[lane]);
                    // Rounding of the reduced angle, of the series, of the result.
                    let tolerance = if x.abs() < 100.0 { 4e-16 } else { 1e-15 };
                    assert!((got.0 - expected.0).abs() <= tolerance, "sin {x}: {got:?} {expected:?}");
                    assert!((got.1 - expected.1).abs() <= tolerance, "cos {x}: {got:?} {expected:?}");
                }
            }
        }
    }

    #[test]
    fn sine_and_cosine_are_those_of_the_library() {
        for isa in Isa::all() {
            for step in 0..2000 {
                let at = |lane: usize| (step * LANES + lane) as f64 * 3.3e-3 - 25.0;
                isa.run(Angles(Pack(std::array::from_fn(at))));
                isa.run(Angles(Pack(std::array::from_fn(|lane| 4e4 * at(lane)))));
            }
        }
    }
}
