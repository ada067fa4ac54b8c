//! Bodies that can exist: the pseudo-inertia is positive definite.
//!
//! # Reference
//! Wensing, Kim, Slotine (2018), Linear matrix inequalities for physically consistent inertial parameter identification, eq. 14; Lee,
//! Wensing, Park (2020), Geometric robot dynamic identification, for the divergence.

use nalgebra::{Matrix4, SMatrix, SVector};

/// The ten parameters of a body, as in [`Inertia::parameters`](crate::spatial::Inertia::parameters).
pub type Body = SVector<f64, 10>;

/// P = [Σ h; hᵀ m] with Σ = ½ tr(J) 1 - J, linear in the parameters: positive definite exactly where some distribution of mass
/// has them.
pub fn pseudo_inertia(p: &[f64; 10]) -> [[f64; 4]; 4] {
    let [m, hx, hy, hz, xx, xy, yy, xz, yz, zz] = *p;
    let half = 0.5 * (xx + yy + zz);
    [[half - xx, -xy, -xz, hx], [-xy, half - yy, -yz, hy], [-xz, -yz, half - zz, hz], [hx, hy, hz, m]]
}

pub fn matrix(p: &Body) -> Matrix4<f64> {
    let rows = pseudo_inertia(&p.data.0[0]);
    Matrix4::from_fn(|r, c| rows[r][c])
}

/// -ln det P + tr(P₀⁻¹ P), least at P = P₀, with gradient and Hessian; `None` where P is not positive definite.
pub fn divergence(p: &Body, nominal_inverse: &Matrix4<f64>) -> Option<(f64, Body, SMatrix<f64, 10, 10>)> {
    let matrix_p = matrix(p);
    let cholesky = matrix_p.cholesky()?;
    let log_det = 2.0 * (0..4).map(|k| cholesky.l()[(k, k)].ln()).sum::<f64>();
    let inverse = cholesky.inverse();
    let mut by_inverse = [Matrix4::zeros(); 10];
    let mut gradient = Body::zeros();
    for (i, product) in by_inverse.iter_mut().enumerate() {
        let mut unit = Body::zeros();
        unit[i] = 1.0;
        let direction = matrix(&unit);
        *product = inverse * direction;
        gradient[i] = (nominal_inverse * direction).trace() - product.trace();
    }
    let hessian = SMatrix::from_fn(|i, j| (by_inverse[i] * by_inverse[j]).trace());
    let value = (nominal_inverse * matrix_p).trace() - log_det;
    value.is_finite().then_some((value, gradient, hessian))
}
