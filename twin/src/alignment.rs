//! The rigid motion that brings points nearest to others.
//!
//! # Reference
//! Kabsch (1976), A solution for the best rotation to relate two sets of vectors.

use nalgebra::{Matrix3, Vector3};

/// The rotation R nearest to the moment M = Σ q pᵀ of arms p and what they became, q: tr(Rᵀ M) is largest. Arms in a
/// plane are enough.
pub fn nearest_rotation(moment: &Matrix3<f64>) -> Matrix3<f64> {
    let svd = moment.svd(true, true);
    let (Some(u), Some(v_t)) = (svd.u, svd.v_t) else { return Matrix3::identity() };
    // A turn, not a reflection: the weakest direction gives way.
    let mut signs = Vector3::repeat(1.0);
    signs[svd.singular_values.imin()] = (u.determinant() * v_t.determinant()).signum();
    u * Matrix3::from_diagonal(&signs) * v_t
}

/// Turn and shift that bring the points `from` nearest to `to`, one by one [m].
pub fn alignment(from: &[Vector3<f64>], to: &[Vector3<f64>]) -> (Matrix3<f64>, Vector3<f64>) {
    let mean = |points: &[Vector3<f64>]| points.iter().sum::<Vector3<f64>>() / points.len() as f64;
    let (a, b) = (mean(from), mean(to));
    let turn = nearest_rotation(&from.iter().zip(to).map(|(p, q)| (q - b) * (p - a).transpose()).sum());
    (turn, b - turn * a)
}
