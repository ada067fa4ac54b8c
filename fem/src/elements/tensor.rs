//! 3-vectors and 3×3 tensors of lanes: only what the element laws need.
//!
//! Loops instead of `array::map` throughout the kernels: a closure passed through the standard library
//! is compiled without the instruction set that the dispatch chose, and every operation becomes a call.

use pulp::Simd;

use crate::simd::Lanes;

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
        // Written so that NaN ends the loop too.
        if !(change.max() > CHANGE_SQUARED) {
            break;
        }
    }
    x
}
