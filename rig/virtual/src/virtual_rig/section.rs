//! One section of the rod: constant curvature, torsion and stretch, exactly.
//!
//! With rotation θ (bending, bending, torsion over the whole section) and stretch ε, the end is in the frame of the
//! beginning at R = exp(θ×) and d = (1 + ε) L V(θ) e₃, V the left Jacobian of the exponential map. No shear.

use super::linear::{IDENTITY, M3, V3, add, cross, scale};

/// Pose of the end of a section in the frame of its beginning, and its derivatives by θ and ε.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SectionPose {
    /// Orientation of the end.
    pub(crate) r: M3,
    /// Position of the end [m].
    pub(crate) d: V3,
    /// ∂d/∂θ_j, and ∂d/∂ε last [m].
    pub(crate) d_by: [V3; 4],
    /// ω_j: ∂R/∂θ_j = ω_j × R.
    pub(crate) omega: [V3; 3],
    /// θ of which all this is.
    theta: V3,
    /// (1 - cos|θ|)/|θ|² differentiated by |θ|²; and (|θ| - sin|θ|)/|θ|³.
    a_x: f64,
    b: f64,
    /// (1 + ε) L, and L [m].
    length: f64,
    rest_length: f64,
}

impl Default for SectionPose {
    fn default() -> Self {
        Self::new(&[0.0; 4], 1.0)
    }
}

impl SectionPose {
    /// The section with strains θ [rad] and ε [-] whose length at rest is `length` [m].
    pub(crate) fn new(strain: &[f64; 4], length: f64) -> Self {
        let theta = [strain[0], strain[1], strain[2]];
        let x = super::linear::dot(theta, theta);
        let [c, a, b, a_x, b_x] = coefficients(x);
        let stretched = (1.0 + strain[3]) * length;
        // θ × e3 and θ × (θ × e3).
        let t1 = [theta[1], -theta[0], 0.0];
        let t2 = [theta[0] * theta[2], theta[1] * theta[2], theta[2] * theta[2] - x];
        let w = add([0.0, 0.0, 1.0], add(scale(a, t1), scale(b, t2)));
        let radial = add(scale(2.0 * a_x, t1), scale(2.0 * b_x, t2));
        let mut d_by = [[0.0; 3]; 4];
        let mut omega = [[0.0; 3]; 3];
        let mut r = [[0.0; 3]; 3];
        for j in 0..3 {
            let e = IDENTITY[j];
            let e1 = [e[1], -e[0], 0.0];
            let e2 = add(cross(e, t1), cross(theta, e1));
            let by = add(add(scale(a, e1), scale(b, e2)), scale(theta[j], radial));
            d_by[j] = scale(stretched, by);
            let first = cross(theta, e);
            let second = cross(theta, first);
            omega[j] = add(e, add(scale(a, first), scale(b, second)));
            for i in 0..3 {
                r[i][j] = e[i] + c * first[i] + a * second[i];
            }
        }
        d_by[3] = scale(length, w);
        Self { r, d: scale(stretched, w), d_by, omega, theta, a_x, b, length: stretched, rest_length: length }
    }

    /// `force`·∂²d/∂θ_j∂θ_k and, in the last row and column, ∂²d/∂θ_j∂ε: leading terms in θ, for a tangent.
    pub(crate) fn bend(&self, force: V3) -> [[f64; 4]; 4] {
        let mut h = [[0.0; 4]; 4];
        for j in 0..3 {
            for k in 0..=j {
                // e_j × (e_k × e3) + e_k × (e_j × e3) = (e_j·e3) e_k + (e_k·e3) e_j - 2 (e_j·e_k) e3
                let mut second = 0.0;
                if j == 2 {
                    second += force[k];
                }
                if k == 2 {
                    second += force[j];
                }
                if j == k {
                    second -= 2.0 * force[2];
                }
                // f·(e_j × e3)
                let turned = |j: usize| [-force[1], force[0], 0.0][j];
                let radial = 2.0 * self.a_x * (self.theta[k] * turned(j) + self.theta[j] * turned(k));
                h[j][k] = self.length * (self.b * second + radial);
                h[k][j] = h[j][k];
            }
            h[j][3] = super::linear::dot(force, self.d_by[j]) * self.rest_length / self.length;
            h[3][j] = h[j][3];
        }
        h
    }
}

/// sin t/t, (1 - cos t)/t², (t - sin t)/t³ and the derivatives of the last two by x = t², at x.
fn coefficients(x: f64) -> [f64; 5] {
    if x < 1.0 {
        // Series 1/p! - x/(p+2)! + …, to the last bit.
        let series = |p: f64, first: f64| {
            let (mut sum, mut term) = (first, first);
            for k in 1..8 {
                let n = p + 2.0 * f64::from(k);
                term *= -x / (n * (n - 1.0));
                sum += term;
            }
            sum
        };
        let slope = |p: f64, first: f64| {
            let (mut sum, mut term) = (0.0, first);
            for k in 1..8 {
                let n = p + 2.0 * f64::from(k);
                term *= -1.0 / (n * (n - 1.0));
                sum += f64::from(k) * term;
                term *= x;
            }
            sum
        };
        [series(1.0, 1.0), series(2.0, 0.5), series(3.0, 1.0 / 6.0), slope(2.0, 0.5), slope(3.0, 1.0 / 6.0)]
    } else {
        let t = x.sqrt();
        let (sin, cos) = t.sin_cos();
        let (c, a, b) = (sin / t, (1.0 - cos) / x, (t - sin) / (x * t));
        [c, a, b, (0.5 * c - a) / x, (0.5 * a - 1.5 * b) / x]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coefficients_meet_where_series_and_closed_form_change() {
        let (below, above) = (coefficients(1.0 - 1e-13), coefficients(1.0));
        for (a, b) in below.iter().zip(&above) {
            assert!((a - b).abs() < 2e-12, "{a} {b}");
        }
    }

    #[test]
    fn derivatives_are_those_of_position_and_orientation() {
        for strain in [[0.1, -0.2, 0.05, 0.02], [0.9, 0.8, -0.5, -0.1], [0.0; 4]] {
            let section = SectionPose::new(&strain, 0.01);
            let h = 1e-6;
            for j in 0..4 {
                let shifted = |sign: f64| {
                    let mut strain = strain;
                    strain[j] += sign * h;
                    SectionPose::new(&strain, 0.01)
                };
                let (high, low) = (shifted(1.0), shifted(-1.0));
                for i in 0..3 {
                    let difference = (high.d[i] - low.d[i]) / (2.0 * h);
                    assert!((difference - section.d_by[j][i]).abs() < 1e-11, "d[{i}] by {j}");
                    if j < 3 {
                        let columns = |r: &M3| [r[0][i], r[1][i], r[2][i]];
                        let turned = cross(section.omega[j], columns(&section.r));
                        for k in 0..3 {
                            let difference = (high.r[k][i] - low.r[k][i]) / (2.0 * h);
                            assert!((difference - turned[k]).abs() < 1e-9, "R[{k}][{i}] by {j}");
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn second_derivatives_are_right_to_leading_order() {
        let (strain, force, h) = ([0.02, -0.03, 0.01, 0.01], [0.3, -0.7, 0.5], 1e-5);
        let bend = SectionPose::new(&strain, 0.01).bend(force);
        for j in 0..4 {
            for k in 0..4 {
                let shifted = |sign: f64| {
                    let mut strain = strain;
                    strain[k] += sign * h;
                    super::super::linear::dot(force, SectionPose::new(&strain, 0.01).d_by[j])
                };
                let difference = (shifted(1.0) - shifted(-1.0)) / (2.0 * h);
                assert!(
                    (difference - bend[j][k]).abs() < 0.02 * 0.01,
                    "{j} {k}: {difference} {}",
                    bend[j][k]
                );
            }
        }
    }
}
