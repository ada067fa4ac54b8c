//! Bodies that can exist: the pseudo-inertia is positive definite.
//!
//! # Reference
//! Wensing, Kim, Slotine (2018), Linear matrix inequalities for physically consistent inertial parameter identification, eq. 14; Lee,
//! Wensing, Park (2020), Geometric robot dynamic identification, for the divergence.

use hysteron_arm_dynamics::spatial::Inertia;
use nalgebra::{Matrix3, Matrix4, SMatrix, SVector};

/// The ten parameters of a body, as in [`Inertia::parameters`](hysteron_arm_dynamics::spatial::Inertia::parameters).
pub type InertialParameters = SVector<f64, 10>;

/// P = [Σ h; hᵀ m] with Σ = ½ tr(J) 1 - J, linear in the parameters: positive definite exactly where some distribution of mass
/// has them.
pub fn pseudo_inertia(p: &[f64; 10]) -> [[f64; 4]; 4] {
    let [m, hx, hy, hz, xx, xy, yy, xz, yz, zz] = *p;
    let half = 0.5 * (xx + yy + zz);
    [[half - xx, -xy, -xz, hx], [-xy, half - yy, -yz, hy], [-xz, -yz, half - zz, hz], [hx, hy, hz, m]]
}

pub fn matrix(p: &InertialParameters) -> Matrix4<f64> {
    let rows = pseudo_inertia(&p.data.0[0]);
    Matrix4::from_fn(|r, c| rows[r][c])
}

/// Least mass [kg] and radius of gyration [m] of the prior of a body: rods without width and frames without mass are in
/// robots' files, and no divergence from them is finite.
const MIN_MASS: f64 = 1e-3;
const MIN_RADIUS: f64 = 0.01;

/// The nearest body that can exist and has some width in every direction: its own centre, no less mass, no less width.
pub fn nearest_consistent(inertia: &Inertia<f64>) -> Inertia<f64> {
    let mass = inertia.mass.max(MIN_MASS);
    let [xx, xy, yy, xz, yz, zz] = inertia.second_about_centre();
    let second = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
    let mut widths = (Matrix3::identity() * (0.5 * second.trace()) - second).symmetric_eigen();
    widths.eigenvalues.apply(|width| *width = width.max(mass * MIN_RADIUS * MIN_RADIUS));
    let widths = widths.recompose();
    let s = Matrix3::identity() * widths.trace() - widths;
    let second = [s[(0, 0)], s[(0, 1)], s[(1, 1)], s[(0, 2)], s[(1, 2)], s[(2, 2)]];
    Inertia::about_centre(mass, inertia.centre(), second)
}

/// -ln det P + tr(P₀⁻¹ P), least at P = P₀, with gradient and Hessian; `None` where P is not positive definite.
pub fn divergence(
    p: &InertialParameters,
    nominal_inverse: &Matrix4<f64>,
) -> Option<(f64, InertialParameters, SMatrix<f64, 10, 10>)> {
    let matrix_p = matrix(p);
    let cholesky = matrix_p.cholesky()?;
    let log_det = 2.0 * (0..4).map(|k| cholesky.l()[(k, k)].ln()).sum::<f64>();
    let inverse = cholesky.inverse();
    let mut by_inverse = [Matrix4::zeros(); 10];
    let mut gradient = InertialParameters::zeros();
    for (i, product) in by_inverse.iter_mut().enumerate() {
        let mut unit = InertialParameters::zeros();
        unit[i] = 1.0;
        let direction = matrix(&unit);
        *product = inverse * direction;
        gradient[i] = (nominal_inverse * direction).trace() - product.trace();
    }
    let hessian = SMatrix::from_fn(|i, j| (by_inverse[i] * by_inverse[j]).trace());
    let value = (nominal_inverse * matrix_p).trace() - log_det;
    value.is_finite().then_some((value, gradient, hessian))
}
