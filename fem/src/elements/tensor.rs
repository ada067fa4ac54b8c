//! 3-vectors and 3×3 tensors of lanes: only what the element laws need.
//!
//! Loops instead of `array::map` throughout the kernels: a closure passed through the standard library
//! is compiled without the instruction set that the dispatch chose, and every operation becomes a call.

use crate::simd::{Lanes, Simd};

pub(crate) type Vec3<S> = [Lanes<S>; 3];
/// Rows of a 3×3 tensor.
pub(crate) type Mat3<S> = [[Lanes<S>; 3]; 3];

#[inline(always)]
pub(crate) fn dot<S: Simd>(a: Vec3<S>, b: Vec3<S>) -> Lanes<S> {
    a[0].mul_add(b[0], a[1].mul_add(b[1], a[2] * b[2]))
}

#[inline(always)]
pub(crate) fn cross<S: Simd>(a: Vec3<S>, b: Vec3<S>) -> Vec3<S> {
    [
        a[1].mul_add(b[2], -(a[2] * b[1])),
        a[2].mul_add(b[0], -(a[0] * b[2])),
        a[0].mul_add(b[1], -(a[1] * b[0])),
    ]
}

#[inline(always)]
pub(crate) fn scale<S: Simd>(s: Lanes<S>, a: Vec3<S>) -> Vec3<S> {
    [s * a[0], s * a[1], s * a[2]]
}

#[inline(always)]
pub(crate) fn sub<S: Simd>(a: Vec3<S>, b: Vec3<S>) -> Vec3<S> {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// s A.
#[inline(always)]
pub(crate) fn scale_rows<S: Simd>(s: Lanes<S>, a: &Mat3<S>) -> Mat3<S> {
    [scale(s, a[0]), scale(s, a[1]), scale(s, a[2])]
}

/// A x.
#[inline(always)]
pub(crate) fn apply<S: Simd>(a: &Mat3<S>, x: Vec3<S>) -> Vec3<S> {
    [dot(a[0], x), dot(a[1], x), dot(a[2], x)]
}

/// Aᵀ.
#[inline(always)]
pub(crate) fn transpose<S: Simd>(a: &Mat3<S>) -> Mat3<S> {
    [[a[0][0], a[1][0], a[2][0]], [a[0][1], a[1][1], a[2][1]], [a[0][2], a[1][2], a[2][2]]]
}

/// A B.
#[inline(always)]
pub(crate) fn multiply<S: Simd>(a: &Mat3<S>, b: &Mat3<S>) -> Mat3<S> {
    let bt = transpose(b);
    [apply(&bt, a[0]), apply(&bt, a[1]), apply(&bt, a[2])]
}

/// A Bᵀ.
#[inline(always)]
pub(crate) fn multiply_transposed<S: Simd>(a: &Mat3<S>, b: &Mat3<S>) -> Mat3<S> {
    [apply(b, a[0]), apply(b, a[1]), apply(b, a[2])]
}

#[inline(always)]
pub(crate) fn trace<S: Simd>(a: &Mat3<S>) -> Lanes<S> {
    a[0][0] + a[1][1] + a[2][2]
}

/// The cofactor matrix: det(A) A⁻ᵀ. Its rows are cross products of the rows of A.
#[inline(always)]
pub(crate) fn cofactor<S: Simd>(a: &Mat3<S>) -> Mat3<S> {
    [cross(a[1], a[2]), cross(a[2], a[0]), cross(a[0], a[1])]
}

/// s on the diagonal.
#[inline(always)]
pub(crate) fn spherical<S: Simd>(s: Lanes<S>) -> Mat3<S> {
    let zero = s.same(0.0);
    [[s, zero, zero], [zero, s, zero], [zero, zero, s]]
}

/// (1 + e)^(-1/2) for |e| <= 0.12 to within 2.3e-8, lowest power first: the polynomial through its values at the
/// roots of the sixth Chebyshev polynomial. Up to |e| = 0.9 it is between 0.73 and 1.01 times that, and so positive.
const INVERSE_ROOT: [f64; 6] =
    [1.000_000_02, -0.500_000_02, 0.374_973_204, -0.312_475_111, 0.278_379_79, -0.250_684_134];

/// Rotation R of the polar decomposition F = R S.
///
/// While strains are small, F p(FᵀF) with p(C) close to C^(-1/2) is R but for 1e-8: it is R times a function of S,
/// which is positive definite, so nothing is lost where p is less close. Newton's iteration X ← ½ (X + X⁻ᵀ) leads on
/// from there, and from F itself where strains are large; a step X ← X (3 - XᵀX)/2, which divides by nothing, ends
/// it. Newton's iteration converges quadratically to the nearest orthogonal matrix for every invertible F; for det F
/// < 0 that is a reflection, and the element is inverted.
///
/// # Reference
/// Higham (2008), Functions of matrices, eqs. 8.17 and 8.20, without scaling: strains are below one.
#[inline(always)]
pub(crate) fn polar_rotation<S: Simd>(f: &Mat3<S>) -> Mat3<S> {
    // |XᵀX - 1|² from which the last step leaves 3/8 of it: below round-off.
    const CLOSE: f64 = 2e-15;
    // |FᵀF - 1|² up to which p is positive.
    const NEAR: f64 = 0.8;
    const MAX_ITERATIONS: usize = 60;
    let half = f[0][0].same(0.5);
    let mut x = *f;
    let mut e = excess(&x);
    let mut size = norm_squared(&e);
    if !size.exceeds(NEAR) {
        x = apply_symmetric(&x, &inverse_root(&e));
        e = excess(&x);
        size = norm_squared(&e);
    }
    for _ in 0..MAX_ITERATIONS {
        if !size.exceeds(CLOSE) {
            break;
        }
        let cof = cofactor(&x);
        let factor = half * dot(x[0], cof[0]).recip();
        for i in 0..3 {
            for j in 0..3 {
                x[i][j] = cof[i][j].mul_add(factor, half * x[i][j]);
            }
        }
        e = excess(&x);
        size = norm_squared(&e);
    }
    let change = apply_symmetric(&x, &e);
    for i in 0..3 {
        for j in 0..3 {
            x[i][j] = change[i][j].mul_add(-half, x[i][j]);
        }
    }
    x
}

/// Entries (0,0), (1,1), (2,2), (0,1), (0,2), (1,2) of a symmetric tensor.
type Symmetric<S> = [Lanes<S>; 6];

/// XᵀX - 1.
#[inline(always)]
fn excess<S: Simd>(x: &Mat3<S>) -> Symmetric<S> {
    let columns = transpose(x);
    let one = x[0][0].same(1.0);
    let mut e = symmetric(&columns, &columns);
    for i in 0..3 {
        e[i] = e[i] - one;
    }
    e
}

/// The entries of A Bᵀ, where that is symmetric.
#[inline(always)]
fn symmetric<S: Simd>(a: &Mat3<S>, b: &Mat3<S>) -> Symmetric<S> {
    [dot(a[0], b[0]), dot(a[1], b[1]), dot(a[2], b[2]), dot(a[0], b[1]), dot(a[0], b[2]), dot(a[1], b[2])]
}

#[inline(always)]
fn rows<S: Simd>(e: &Symmetric<S>) -> Mat3<S> {
    [[e[0], e[3], e[4]], [e[3], e[1], e[5]], [e[4], e[5], e[2]]]
}

/// X E.
#[inline(always)]
fn apply_symmetric<S: Simd>(x: &Mat3<S>, e: &Symmetric<S>) -> Mat3<S> {
    let e = rows(e);
    [apply(&e, x[0]), apply(&e, x[1]), apply(&e, x[2])]
}

/// Σ E_ij².
#[inline(always)]
fn norm_squared<S: Simd>(e: &Symmetric<S>) -> Lanes<S> {
    let diagonal = dot([e[0], e[1], e[2]], [e[0], e[1], e[2]]);
    let other = dot([e[3], e[4], e[5]], [e[3], e[4], e[5]]);
    other + other + diagonal
}

/// p(1 + E), in three products: powers of E commute and are symmetric.
#[inline(always)]
fn inverse_root<S: Simd>(e: &Symmetric<S>) -> Symmetric<S> {
    let c = INVERSE_ROOT;
    let square = symmetric(&rows(e), &rows(e));
    let cube = symmetric(&rows(&square), &rows(e));
    let mut high = square;
    let mut low = square;
    for k in 0..6 {
        high[k] = square[k].mul_add(e[k].same(c[5]), e[k] * e[k].same(c[4]));
        low[k] = square[k].mul_add(e[k].same(c[2]), e[k] * e[k].same(c[1]));
    }
    for k in 0..3 {
        high[k] = high[k] + e[k].same(c[3]);
        low[k] = low[k] + e[k].same(c[0]);
    }
    let high = symmetric(&rows(&cube), &rows(&high));
    for k in 0..6 {
        low[k] = low[k] + high[k];
    }
    low
}

#[cfg(test)]
mod tests {
    use hysteron_base::rng;
    use nalgebra::{Matrix3, Rotation3, Unit, Vector3};
    use rand::RngExt;

    use super::*;
    use crate::simd::{Isa, LANES, Pack, Packs, WithSimd};

    /// Polar rotations of eight matrices, another in every lane.
    struct Polar<'a>(&'a [Matrix3<f64>]);

    impl WithSimd for Polar<'_> {
        type Output = Vec<Matrix3<f64>>;

        fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
            let mut rotations = Vec::new();
            for pass in 0..Packs::<S>::PASSES {
                let packs = Packs::new(simd, pass);
                let entry = |i: usize, j: usize| {
                    packs.load(&Pack(std::array::from_fn::<f64, LANES, _>(|lane| self.0[lane][(i, j)])))
                };
                let f: Mat3<S> = [0, 1, 2].map(|i| [entry(i, 0), entry(i, 1), entry(i, 2)]);
                let r = polar_rotation(&f).map(|row| row.map(|lanes| lanes.to_array()));
                rotations.extend((0..S::F64_LANES).map(|lane| Matrix3::from_fn(|i, j| r[i][j][lane])));
            }
            rotations
        }
    }

    fn svd_rotation(f: &Matrix3<f64>) -> Matrix3<f64> {
        let svd = f.svd(true, true);
        svd.u.expect("asked for") * svd.v_t.expect("asked for")
    }

    #[test]
    fn polar_rotation_is_that_of_the_svd() {
        // Both are exact up to round-off for strains up to one half: small ones end after the polynomial, others by
        // Newton.
        const TOL: f64 = 1e-14;
        let mut stream = rng(31, "test/polar");
        for strain in [1e-9, 1e-3, 0.05, 0.2, 0.5].repeat(40) {
            let f: Vec<Matrix3<f64>> = (0..LANES)
                .map(|_| {
                    let mut turn = |angle: f64| {
                        let axis = Vector3::from_fn(|_, _| stream.random_range(-1.0..1.0));
                        Rotation3::from_axis_angle(&Unit::new_normalize(axis), angle).into_inner()
                    };
                    let (r, v) = (turn(3.0), turn(1.0));
                    let r = r * turn(2.5);
                    let stretch = Vector3::from_fn(|_, _| 1.0 + stream.random_range(-strain..strain));
                    r * v * Matrix3::from_diagonal(&stretch) * v.transpose()
                })
                .collect();
            for isa in Isa::all() {
                for (r, f) in isa.run(Polar(&f)).iter().zip(&f) {
                    assert!((r.transpose() * r - Matrix3::identity()).norm() < TOL, "{isa:?} {f}");
                    assert!((r - svd_rotation(f)).norm() < TOL, "{isa:?} {f}");
                    assert!(r.determinant() > 0.0);
                }
            }
        }
    }

    #[test]
    fn inverse_root_is_as_accurate_as_documented() {
        let ratio = |e: f64| INVERSE_ROOT.iter().rev().fold(0.0, |sum, c| sum * e + c) * (1.0 + e).sqrt();
        let over = |largest: f64| (-1000..=1000).map(move |k| f64::from(k) * 1e-3 * largest);
        let worst = over(0.12).map(|e| (ratio(e) - 1.0).abs()).fold(0.0, f64::max);
        // The coefficients have nine digits.
        assert!((2e-8..2.5e-8).contains(&worst), "{worst}");
        assert!(over(0.9).all(|e| (0.73..1.01).contains(&ratio(e))));
    }

    #[test]
    fn polar_rotation_ignores_scale() {
        // Edges of a millimetre, or gradients of a thousand per metre: edge frames need both.
        const TOL: f64 = 1e-14;
        let shear = Matrix3::new(1.0, 0.4, 0.1, -0.2, 0.9, 0.3, 0.0, 0.2, 1.1);
        for scale in [1e-4, 1e-3, 1e3, 1e4] {
            for isa in Isa::all() {
                let r = isa.run(Polar(&[scale * shear; LANES]))[0];
                assert!((r - svd_rotation(&shear)).norm() < TOL, "{isa:?} {scale}");
            }
        }
    }
}
