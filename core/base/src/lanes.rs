//! Explicit SIMD, through `pulp`: numbers of which every lane belongs to another element, or another state.
//!
//! A kernel is written once, generic over the instruction set, and dispatched at run time ([`Isa::detect`]).
//! [`Isa::portable`] runs the same code one number at a time: it is what processors without AVX2 use, and what the
//! tests compare with.

use std::ops::{Add, Mul, Neg, Sub};

use pulp::bytemuck;
pub use pulp::{Simd, WithSimd};

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

    /// AVX2 + FMA, where this processor has them.
    pub fn avx2() -> Option<Self> {
        #[cfg(target_arch = "x86_64")]
        let found = pulp::x86::V3::try_new().map(|v3| Self(pulp::Arch::V3(v3)));
        #[cfg(not(target_arch = "x86_64"))]
        let found = None;
        found
    }

    /// Every set this processor has, so that a test on AVX-512 covers AVX2 too.
    pub fn all() -> Vec<Self> {
        [Self::portable(), Self::detect()].into_iter().chain(Self::avx2()).collect()
    }

    /// Runs `op` compiled for this instruction set.
    #[inline]
    pub fn run<Op: WithSimd>(self, op: Op) -> Op::Output {
        self.0.dispatch(op)
    }
}

/// Elements per batch: the widest registers hold eight `f64`; narrower ones take several passes.
pub const LANES: usize = 8;

/// One number for each element of a batch.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C, align(64))]
pub struct Pack(pub [f64; LANES]);

struct Apart<F>(F);

impl<R, F: FnOnce() -> R> WithSimd for Apart<F> {
    type Output = R;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> R {
        (self.0)()
    }
}

/// Calls `kernel` as a function that is not inlined.
#[inline(never)]
pub fn outlined<R>(kernel: impl FnOnce() -> R) -> R {
    kernel()
}

/// A register of `f64`, with operators. `S` fixes how many lanes it has.
#[derive(Debug, Clone, Copy)]
pub struct Lanes<S: Simd> {
    simd: S,
    value: S::f64s,
}

/// Reads and writes the part of a [`Pack`] that one pass handles.
#[derive(Clone, Copy)]
pub struct Packs<S: Simd> {
    simd: S,
    pass: usize,
}

impl<S: Simd> Packs<S> {
    /// Passes needed to cover a batch.
    pub const PASSES: usize = LANES / S::F64_LANES;

    /// The part number `pass` of [`Self::PASSES`].
    #[inline(always)]
    pub fn new(simd: S, pass: usize) -> Self {
        Self { simd, pass }
    }

    /// The lanes of this pass within a batch.
    #[inline(always)]
    pub fn range(self) -> std::ops::Range<usize> {
        self.pass * S::F64_LANES..(self.pass + 1) * S::F64_LANES
    }

    /// The lanes of this pass.
    #[inline(always)]
    pub fn load(self, pack: &Pack) -> Lanes<S> {
        Lanes { simd: self.simd, value: S::as_simd_f64s(&pack.0).0[self.pass] }
    }

    /// Writes the lanes of this pass.
    #[inline(always)]
    pub fn store(self, lanes: Lanes<S>, pack: &mut Pack) {
        S::as_mut_simd_f64s(&mut pack.0).0[self.pass] = lanes.value;
    }

    /// `value` in every lane.
    #[inline(always)]
    pub fn splat(self, value: f64) -> Lanes<S> {
        Lanes { simd: self.simd, value: self.simd.splat_f64s(value) }
    }

    /// The coordinates of this pass from what [`collect`] has put together.
    #[inline(always)]
    pub fn gather(self, rows: &PaddedPoints) -> [Lanes<S>; 3] {
        let r = &S::as_simd_f64s(rows.0.as_flattened()).0[4 * self.pass..][..4];
        let [x, y, z, _] = self.simd.deinterleave_shfl_f64s([r[0], r[1], r[2], r[3]]);
        let simd = self.simd;
        [Lanes { simd, value: x }, Lanes { simd, value: y }, Lanes { simd, value: z }]
    }

    /// Writes `[x, y, z, 0]` of every lane of this pass, the inverse of [`Self::gather`]: row `slot` belongs to the
    /// element
    /// [`element`] of the batch.
    #[inline(always)]
    pub fn spread(self, point: &[Lanes<S>; 3], rows: &mut PaddedPoints) {
        let [x, y, z] = [point[0].value, point[1].value, point[2].value];
        let r = self.simd.interleave_shfl_f64s([x, y, z, self.simd.splat_f64s(0.0)]);
        S::as_mut_simd_f64s(rows.0.as_flattened_mut()).0[4 * self.pass..][..4].copy_from_slice(&r);
    }
}

/// A padded point for each element of a batch.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(64))]
pub struct PaddedPoints(pub [[f64; 4]; LANES]);

impl PaddedPoints {
    /// Zeros.
    pub const ZERO: Self = Self([[0.0; 4]; LANES]);
}

/// Puts one padded point for each element of a batch side by side, for [`Packs::gather`]. A register that is loaded
/// right after its parts were stored waits for all of them to reach the cache: best collected long before.
#[inline(always)]
pub fn collect<S: Simd>(points: &[[f64; 4]], which: &[u32; LANES], rows: &mut PaddedPoints) {
    for (slot, row) in rows.0.iter_mut().enumerate() {
        *row = points[which[element::<S>(slot)] as usize];
    }
}

/// The element of a batch that row `slot` belongs to. When eight-lane registers are interleaved, the middle of each
/// half swaps; the tests check every instruction set.
#[inline(always)]
pub fn element<S: Simd>(slot: usize) -> usize {
    if S::F64_LANES == 8 { [0, 2, 1, 3, 4, 6, 5, 7][slot] } else { slot }
}

impl<S: Simd> Lanes<S> {
    /// True where some lane is greater; one that is not a number is not.
    #[inline(always)]
    pub fn exceeds(self, limit: f64) -> bool {
        let greater = self.simd.greater_than_f64s(self.value, self.simd.splat_f64s(limit));
        self.simd.first_true_m64s(greater) < S::F64_LANES
    }

    /// `self * b + c`.
    #[inline(always)]
    pub fn mul_add(self, b: Self, c: Self) -> Self {
        Self { simd: self.simd, value: self.simd.mul_add_e_f64s(self.value, b.value, c.value) }
    }

    /// 1 / self.
    #[inline(always)]
    pub fn recip(self) -> Self {
        let one = self.simd.splat_f64s(1.0);
        Self { simd: self.simd, value: self.simd.div_f64s(one, self.value) }
    }

    /// The same value in every lane of a register like this one.
    #[inline(always)]
    pub fn same(self, value: f64) -> Self {
        Self { simd: self.simd, value: self.simd.splat_f64s(value) }
    }

    /// The first lanes of `pack` in a register like this one.
    #[inline(always)]
    pub fn load(self, pack: &Pack) -> Self {
        Self { simd: self.simd, value: S::as_simd_f64s(&pack.0).0[0] }
    }

    /// Runs `kernel` as a function of its own, compiled for the registers that this one is of; `kernel` has to be inlined always.
    #[inline(always)]
    pub fn apart<R>(self, kernel: impl FnOnce() -> R) -> R {
        if S::IS_SCALAR { outlined(kernel) } else { self.simd.vectorize(Apart(kernel)) }
    }

    /// Natural logarithm, lane by lane: there is no instruction for it.
    #[inline(always)]
    pub fn ln(self) -> Self {
        let mut lanes = Pack([0.0; LANES]);
        self.store(&mut lanes);
        for lane in &mut lanes.0[..S::F64_LANES] {
            *lane = lane.ln();
        }
        Self { simd: self.simd, value: S::as_simd_f64s(&lanes.0).0[0] }
    }

    /// Writes the lanes to the front of `pack`.
    #[inline(always)]
    pub fn store(self, pack: &mut Pack) {
        S::as_mut_simd_f64s(&mut pack.0).0[0] = self.value;
    }

    /// The lanes as an array, the first `S::F64_LANES` of which count.
    #[inline(always)]
    pub fn to_array(self) -> [f64; LANES] {
        let mut pack: Pack = Pack(bytemuck::Zeroable::zeroed());
        self.store(&mut pack);
        pack.0
    }
}

impl<S: Simd> Add for Lanes<S> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self { simd: self.simd, value: self.simd.add_f64s(self.value, other.value) }
    }
}

impl<S: Simd> Sub for Lanes<S> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self { simd: self.simd, value: self.simd.sub_f64s(self.value, other.value) }
    }
}

impl<S: Simd> Mul for Lanes<S> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Self { simd: self.simd, value: self.simd.mul_f64s(self.value, other.value) }
    }
}

impl<S: Simd> Neg for Lanes<S> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self { simd: self.simd, value: self.simd.neg_f64s(self.value) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Checks every pass over one batch.
    struct Passes;

    impl WithSimd for Passes {
        type Output = usize;

        fn with_simd<S: Simd>(self, simd: S) -> usize {
            // The fourth number is padding and must not come back.
            let points: Vec<[f64; 4]> =
                (0..20).map(|i| [0.0, 100.0, 200.0, 7.0].map(|c| c + f64::from(i))).collect();
            let which = [3, 17, 0, 9, 9, 4, 19, 12];
            let numbers = Pack([1.5, -2.0, 0.25, 8.0, 1e-3, 30.0, -7.0, 2.0]);
            let (mut collected, mut spread) = (PaddedPoints::ZERO, PaddedPoints::ZERO);
            collect::<S>(&points, &which, &mut collected);
            for pass in 0..Packs::<S>::PASSES {
                let packs = Packs::new(simd, pass);
                let gathered = packs.gather(&collected);
                let loaded = packs.load(&numbers).to_array();
                for (lane, element) in packs.range().enumerate() {
                    assert_eq!(loaded[lane], numbers.0[element]);
                    for c in 0..3 {
                        assert_eq!(gathered[c].to_array()[lane], points[which[element] as usize][c]);
                    }
                }
                packs.spread(&gathered, &mut spread);
            }
            let mut seen = [0; LANES];
            for slot in 0..LANES {
                let [x, y, z, _] = points[which[element::<S>(slot)] as usize];
                assert_eq!(spread.0[slot], [x, y, z, 0.0]);
                seen[element::<S>(slot)] += 1;
            }
            assert_eq!(seen, [1; LANES], "every element once");
            Packs::<S>::PASSES * S::F64_LANES
        }
    }

    #[test]
    fn gather_and_spread_are_inverse() {
        for isa in Isa::all() {
            assert_eq!(isa.run(Passes), LANES, "{isa:?}");
        }
    }

    struct Operators;

    impl WithSimd for Operators {
        type Output = ();

        fn with_simd<S: Simd>(self, simd: S) {
            let packs = Packs::new(simd, 0);
            let (a, b) = (packs.load(&Pack([1.0, 2.0, 4.0, 8.0, 1.0, 2.0, 4.0, 9.0])), packs.splat(3.0));
            let first = |lanes: Lanes<S>| lanes.to_array()[0];
            assert_eq!(
                [
                    first(a + b),
                    first(a - b),
                    first(a * b),
                    first(-b),
                    first(b.recip()),
                    first(b.mul_add(b, a))
                ],
                [4.0, -2.0, 3.0, -3.0, 1.0 / 3.0, 10.0]
            );
            assert_eq!(first(b.ln()), 3.0_f64.ln());
            let largest = a.to_array()[..S::F64_LANES].iter().copied().fold(0.0, f64::max);
            assert!(a.exceeds(0.99 * largest) && !a.exceeds(largest));
            assert!(!packs.splat(f64::NAN).exceeds(0.0));
        }
    }

    #[test]
    fn operators_are_those_of_numbers() {
        for isa in Isa::all() {
            isa.run(Operators);
        }
    }
}
