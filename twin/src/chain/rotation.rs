//! Rotations as rotation vectors: exponential, logarithm, and the coefficients of half a relative rotation.

use nalgebra::{Matrix3, Vector3};

/// exp [θ]×: the rotation by the rotation vector θ [rad].
pub(crate) fn exp(theta: &Vector3<f64>) -> Matrix3<f64> {
    let angle = theta.norm();
    let (a, b) = if angle < 1e-4 {
        let square = angle * angle;
        (1.0 - square / 6.0, 0.5 - square / 24.0)
    } else {
        (angle.sin() / angle, (1.0 - angle.cos()) / (angle * angle))
    };
    let cross = theta.cross_matrix();
    Matrix3::identity() + a * cross + b * (cross * cross)
}

/// The rotation vector of a rotation by less than π [rad].
pub(crate) fn log(rotation: &Matrix3<f64>) -> Vector3<f64> {
    let r = rotation;
    let sine = 0.5 * Vector3::new(r[(2, 1)] - r[(1, 2)], r[(0, 2)] - r[(2, 0)], r[(1, 0)] - r[(0, 1)]);
    let size = sine.norm();
    let angle = size.atan2(0.5 * (r.trace() - 1.0));
    if angle < 1e-4 { sine * (1.0 + angle * angle / 6.0) } else { sine * (angle / size) }
}

/// The rotation closest to one that is off by round-off: one Newton step of the polar decomposition.
pub(crate) fn orthonormal(rotation: &Matrix3<f64>) -> Matrix3<f64> {
    rotation * (1.5 * Matrix3::identity() - 0.5 * (rotation.transpose() * rotation))
}

/// Functions of h², the square of half the angle between two frames, in the variations of a geometrically exact rod.
#[derive(Debug, Clone, Copy)]
pub(crate) struct HalfAngle {
    /// g = (h - sin h) / h³.
    pub g: f64,
    /// dg/dh / h.
    pub g_slope: f64,
    /// κ = (1 - cos h) / h².
    pub kappa: f64,
    /// dκ/dh / h.
    pub kappa_slope: f64,
}

impl HalfAngle {
    /// Power series for half angles below one, closed forms beyond.
    pub fn new(square: f64) -> Self {
        if square > 1.0 {
            let h = square.sqrt();
            let (sin, cos) = h.sin_cos();
            return Self {
                g: (h - sin) / (h * square),
                g_slope: (h * (1.0 - cos) - 3.0 * (h - sin)) / (h * square * square),
                kappa: (1.0 - cos) / square,
                kappa_slope: (h * sin - 2.0 * (1.0 - cos)) / (square * square),
            };
        }
        // g = Σ (-h²)^n / (2n + 3)!, κ = Σ (-h²)^n / (2n + 2)!.
        let (mut g, mut g_slope, mut kappa, mut kappa_slope) = (0.0, 0.0, 0.0, 0.0);
        let (mut power, mut previous, mut factorial) = (1.0, 0.0, 2.0);
        for n in 0..9_u32 {
            let order = f64::from(n);
            let next = factorial * (2.0 * order + 3.0);
            kappa += power / factorial;
            g += power / next;
            kappa_slope -= 2.0 * order * previous / factorial;
            g_slope -= 2.0 * order * previous / next;
            previous = power;
            power *= -square;
            factorial = next * (2.0 * order + 4.0);
        }
        Self { g, g_slope, kappa, kappa_slope }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn logarithm_is_inverse_of_exponential() {
        for size in [0.0, 1e-9, 1e-5, 0.03, 1.0, 3.0] {
            let theta = size * Vector3::new(0.6, -0.64, 0.48);
            let rotation = exp(&theta);
            assert!((log(&rotation) - theta).norm() < 1e-14 * (1.0 + 100.0 * size), "{size}");
            assert!((orthonormal(&rotation) - rotation).norm() < 1e-15);
            assert!((rotation.transpose() * rotation - Matrix3::identity()).norm() < 1e-15);
        }
    }

    #[test]
    fn series_continue_closed_forms_and_slopes_are_derivatives() {
        let of = |h: f64| HalfAngle::new(h * h);
        let (below, above) = (of(1.0 - 1e-9), of(1.0 + 1e-9));
        assert!((below.g - above.g).abs() < 1e-9 && (below.kappa - above.kappa).abs() < 1e-9);
        assert!((below.g_slope - above.g_slope).abs() < 1e-9);
        for h in [0.02, 0.5, 0.95, 1.4] {
            let step = 1e-5;
            let (ahead, behind, here) = (of(h + step), of(h - step), of(h));
            let slope = |ahead: f64, behind: f64| (ahead - behind) / (2.0 * step) / h;
            assert!((slope(ahead.g, behind.g) - here.g_slope).abs() < 1e-8, "{h}");
            assert!((slope(ahead.kappa, behind.kappa) - here.kappa_slope).abs() < 1e-8, "{h}");
        }
    }
}
