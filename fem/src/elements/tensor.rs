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

/// Rotation R of the polar decomposition F = R S, by Newton's iteration X ← ½ (X + X⁻ᵀ).
///
/// Converges quadratically to the nearest orthogonal matrix for every invertible F; for det F < 0 that
/// is a reflection, and the element is inverted.
///
/// # Reference
/// Higham (1986), Computing the polar decomposition, eq. 3.1, without scaling: strains are below one.
#[inline(always)]
pub(crate) fn polar_rotation<S: Simd>(f: &Mat3<S>) -> Mat3<S> {
    // One more step squares the error: a change of 3e-8 leaves one below round-off.
    const CHANGE_SQUARED: f64 = 1e-15;
    const MAX_ITERATIONS: usize = 60;
    let half = f[0][0].same(0.5);
    let mut x = *f;
    for _ in 0..MAX_ITERATIONS {
        let cof = cofactor(&x);
        let factor = half * dot(x[0], cof[0]).recip();
        let mut change = half.same(0.0);
        for i in 0..3 {
            for j in 0..3 {
                let next = cof[i][j].mul_add(factor, half * x[i][j]);
                let d = next - x[i][j];
                change = d.mul_add(d, change);
                x[i][j] = next;
            }
        }
        let change = change.max();
        if change <= CHANGE_SQUARED || change.is_nan() {
            break;
        }
    }
    x
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
        // Both are exact up to round-off for strains up to one half.
        const TOL: f64 = 1e-14;
        let mut stream = rng(31, "test/polar");
        for _ in 0..200 {
            let f: Vec<Matrix3<f64>> = (0..LANES)
                .map(|_| {
                    let mut turn = |angle: f64| {
                        let axis = Vector3::from_fn(|_, _| stream.random_range(-1.0..1.0));
                        Rotation3::from_axis_angle(&Unit::new_normalize(axis), angle).into_inner()
                    };
                    let (r, v) = (turn(3.0), turn(1.0));
                    let r = r * turn(2.5);
                    let stretch = Vector3::from_fn(|_, _| stream.random_range(0.5..1.5));
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
