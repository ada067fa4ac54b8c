//! Material laws: what a deformation gradient F costs, and the stress and stiffness that follow.
//!
//! Every law gives the first Piola-Kirchhoff stress P = ∂ψ/∂F and its derivative in one four-term form,
//! so that one kernel assembles all of them. With p_a = Q ∇N_a the block of nodes a, b is
//!
//! K_ab = w ( α (∇N_a·∇N_b) 1 + λ p_a p_bᵀ + κ p_b p_aᵀ + c \[p_a\]× M \[p_b\]× ).
//!
//! The derivation is in `docs/fem.md`.

use hysteron_base::Material;

use super::tensor::{
    Mat3, cofactor, dot, multiply, multiply_transposed, polar_rotation, scale_rows, spherical, trace,
    transpose,
};
use crate::simd::{Lanes, Simd};

/// Which derivative of the stress to assemble.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Tangent {
    /// The derivative of the nodal forces: Newton converges quadratically, but the matrix may be
    /// indefinite in compression.
    Exact,
    /// The rest stiffness turned at each quadrature point, R Ke Rᵀ: always positive definite. Equal to
    /// `Exact` at small strain, and used in its place for edge frames, whose exact derivative is not
    /// symmetric.
    Warped,
}

/// Lamé's parameters (λ, μ) \[Pa\].
pub(crate) fn lame_parameters(material: &Material) -> (f64, f64) {
    let (e, nu) = (material.youngs_modulus, material.poisson_ratio);
    (e * nu / ((1.0 + nu) * (1.0 - 2.0 * nu)), e / (2.0 * (1.0 + nu)))
}

/// Lamé's parameters in every lane.
#[derive(Clone, Copy)]
pub(crate) struct Lame<S: Simd> {
    pub lambda: Lanes<S>,
    pub mu: Lanes<S>,
}

/// Arguments of a law in one quadrature point.
pub(crate) struct QuadraturePoint<'a, S: Simd> {
    /// Deformation gradient.
    pub f: &'a Mat3<S>,
    /// Deformed edges x_1 - x_0, x_2 - x_0, x_3 - x_0 (rows).
    pub edges: &'a Mat3<S>,
    /// Rest gradients of the shape functions of nodes 1, 2, 3 (rows).
    pub gradients: &'a Mat3<S>,
}

/// The four-term stiffness of one quadrature point; see the module's documentation.
pub(crate) struct PointTangent<S: Simd> {
    pub alpha: Lanes<S>,
    pub lambda: Lanes<S>,
    pub kappa: Lanes<S>,
    /// Q: rest gradient to p.
    pub map: Mat3<S>,
    /// (c, M), M symmetric.
    pub couple: Option<(Lanes<S>, Mat3<S>)>,
}

/// A law in the form of the kernels.
pub(crate) trait PointLaw: Copy {
    /// Energy density ψ \[J/m³\].
    fn energy<S: Simd>(self, lame: Lame<S>, at: &QuadraturePoint<'_, S>) -> Lanes<S>;
    /// First Piola-Kirchhoff stress P \[Pa\].
    fn stress<S: Simd>(self, lame: Lame<S>, at: &QuadraturePoint<'_, S>) -> Mat3<S>;
    /// Derivative of P.
    fn tangent<S: Simd>(self, lame: Lame<S>, at: &QuadraturePoint<'_, S>, kind: Tangent) -> PointTangent<S>;
}

/// μ |A|² + λ/2 tr²(A) for the symmetric part of a strain A.
#[inline(always)]
fn linear_energy<S: Simd>(lame: Lame<S>, strain: &Mat3<S>) -> Lanes<S> {
    let half = lame.mu.same(0.5);
    let mut norm = lame.mu.same(0.0);
    for i in 0..3 {
        for j in 0..3 {
            let e = half * (strain[i][j] + strain[j][i]);
            norm = e.mul_add(e, norm);
        }
    }
    let tr = trace(strain);
    lame.mu * norm + half * lame.lambda * tr * tr
}

/// The rest stiffness, turned by `map`.
#[inline(always)]
fn warped<S: Simd>(lame: Lame<S>, map: Mat3<S>) -> PointTangent<S> {
    PointTangent { alpha: lame.mu, lambda: lame.lambda, kappa: lame.mu, map, couple: None }
}

#[inline(always)]
fn minus_identity<S: Simd>(a: &Mat3<S>) -> Mat3<S> {
    let one = a[0][0].same(1.0);
    let mut b = *a;
    for i in 0..3 {
        b[i][i] = b[i][i] - one;
    }
    b
}

#[derive(Clone, Copy)]
pub(crate) struct SmallStrain;

impl PointLaw for SmallStrain {
    #[inline(always)]
    fn energy<S: Simd>(self, lame: Lame<S>, at: &QuadraturePoint<'_, S>) -> Lanes<S> {
        linear_energy(lame, &minus_identity(at.f))
    }

    #[inline(always)]
    fn stress<S: Simd>(self, lame: Lame<S>, at: &QuadraturePoint<'_, S>) -> Mat3<S> {
        let strain = minus_identity(at.f);
        let mut stress = spherical(lame.lambda * trace(&strain));
        for i in 0..3 {
            for j in 0..3 {
                stress[i][j] = stress[i][j] + lame.mu * (strain[i][j] + strain[j][i]);
            }
        }
        stress
    }

    #[inline(always)]
    fn tangent<S: Simd>(
        self,
        lame: Lame<S>,
        _at: &QuadraturePoint<'_, S>,
        _kind: Tangent,
    ) -> PointTangent<S> {
        warped(lame, spherical(lame.mu.same(1.0)))
    }
}

#[derive(Clone, Copy)]
pub(crate) struct Corotational;

impl PointLaw for Corotational {
    #[inline(always)]
    fn energy<S: Simd>(self, lame: Lame<S>, at: &QuadraturePoint<'_, S>) -> Lanes<S> {
        let r = polar_rotation(at.f);
        linear_energy(lame, &minus_identity(&multiply(&transpose(&r), at.f)))
    }

    /// P = 2μ (F - R) + λ (tr S - 3) R, with F = R S.
    #[inline(always)]
    fn stress<S: Simd>(self, lame: Lame<S>, at: &QuadraturePoint<'_, S>) -> Mat3<S> {
        let f = at.f;
        let r = polar_rotation(f);
        let two_mu = lame.mu + lame.mu;
        let volume_strain = dot(r[0], f[0]) + dot(r[1], f[1]) + dot(r[2], f[2]) - lame.mu.same(3.0);
        let along_r = lame.lambda.mul_add(volume_strain, -two_mu);
        let mut stress = *f;
        for i in 0..3 {
            for j in 0..3 {
                stress[i][j] = two_mu.mul_add(f[i][j], along_r * r[i][j]);
            }
        }
        stress
    }

    /// The rotation turns by ω = M axial(dF Rᵀ - R dFᵀ) with M = (tr(V) 1 - V)⁻¹ and V = F Rᵀ, which
    /// adds the couple term with c = 2μ - λ (tr S - 3).
    #[inline(always)]
    fn tangent<S: Simd>(self, lame: Lame<S>, at: &QuadraturePoint<'_, S>, kind: Tangent) -> PointTangent<S> {
        let r = polar_rotation(at.f);
        if kind == Tangent::Warped {
            return warped(lame, r);
        }
        let v = multiply_transposed(at.f, &r);
        let tr = trace(&v);
        let mut resistance = spherical(tr);
        for i in 0..3 {
            for j in 0..3 {
                resistance[i][j] = resistance[i][j] - v[i][j];
            }
        }
        let cof = cofactor(&resistance);
        let per_det = dot(resistance[0], cof[0]).recip();
        let two_mu = lame.mu + lame.mu;
        PointTangent {
            alpha: two_mu,
            lambda: lame.lambda,
            kappa: lame.mu.same(0.0),
            map: r,
            couple: Some((two_mu - lame.lambda * (tr - tr.same(3.0)), scale_rows(per_det, &cof))),
        }
    }
}

#[derive(Clone, Copy)]
pub(crate) struct CorotationalEdges;

impl CorotationalEdges {
    /// R = polar(D) polar(D0)ᵀ, D the edges as columns. polar(D0) = polar(D0⁻ᵀ), whose columns are the
    /// rest gradients.
    #[inline(always)]
    fn rotation<S: Simd>(at: &QuadraturePoint<'_, S>) -> Mat3<S> {
        let now = polar_rotation(&transpose(at.edges));
        let rest = polar_rotation(&transpose(at.gradients));
        multiply_transposed(&now, &rest)
    }
}

impl PointLaw for CorotationalEdges {
    /// The energy of the strain sym(RᵀF) - 1; its derivative is not exactly the stress.
    #[inline(always)]
    fn energy<S: Simd>(self, lame: Lame<S>, at: &QuadraturePoint<'_, S>) -> Lanes<S> {
        let r = Self::rotation(at);
        linear_energy(lame, &minus_identity(&multiply(&transpose(&r), at.f)))
    }

    #[inline(always)]
    fn stress<S: Simd>(self, lame: Lame<S>, at: &QuadraturePoint<'_, S>) -> Mat3<S> {
        let r = Self::rotation(at);
        let local = multiply(&transpose(&r), at.f);
        multiply(&r, &SmallStrain.stress(lame, &QuadraturePoint { f: &local, ..*at }))
    }

    /// Always the turned rest stiffness: the exact derivative is not symmetric.
    #[inline(always)]
    fn tangent<S: Simd>(self, lame: Lame<S>, at: &QuadraturePoint<'_, S>, _kind: Tangent) -> PointTangent<S> {
        warped(lame, Self::rotation(at))
    }
}

#[derive(Clone, Copy)]
pub(crate) struct NeoHookean;

impl NeoHookean {
    /// (J, F⁻ᵀ).
    #[inline(always)]
    fn inverse_transpose<S: Simd>(f: &Mat3<S>) -> (Lanes<S>, Mat3<S>) {
        let cof = cofactor(f);
        let j = dot(f[0], cof[0]);
        let per_j = j.recip();
        (j, scale_rows(per_j, &cof))
    }
}

impl PointLaw for NeoHookean {
    #[inline(always)]
    fn energy<S: Simd>(self, lame: Lame<S>, at: &QuadraturePoint<'_, S>) -> Lanes<S> {
        let f = at.f;
        let norm = dot(f[0], f[0]) + dot(f[1], f[1]) + dot(f[2], f[2]);
        let ln_j = dot(f[0], cofactor(f)[0]).ln();
        let half = norm.same(0.5);
        half * lame.mu * (norm - norm.same(3.0)) - lame.mu * ln_j + half * lame.lambda * ln_j * ln_j
    }

    /// P = μ F + (λ ln J - μ) F⁻ᵀ.
    #[inline(always)]
    fn stress<S: Simd>(self, lame: Lame<S>, at: &QuadraturePoint<'_, S>) -> Mat3<S> {
        let (j, inverse) = Self::inverse_transpose(at.f);
        let pressure = lame.lambda * j.ln() - lame.mu;
        let mut stress = *at.f;
        for i in 0..3 {
            for k in 0..3 {
                stress[i][k] = lame.mu.mul_add(stress[i][k], pressure * inverse[i][k]);
            }
        }
        stress
    }

    /// dP = μ dF + (μ - λ ln J) F⁻ᵀ dFᵀ F⁻ᵀ + λ tr(F⁻¹ dF) F⁻ᵀ.
    #[inline(always)]
    fn tangent<S: Simd>(self, lame: Lame<S>, at: &QuadraturePoint<'_, S>, kind: Tangent) -> PointTangent<S> {
        if kind == Tangent::Warped {
            return warped(lame, polar_rotation(at.f));
        }
        let (j, inverse) = Self::inverse_transpose(at.f);
        PointTangent {
            alpha: lame.mu,
            lambda: lame.lambda,
            kappa: lame.mu - lame.lambda * j.ln(),
            map: inverse,
            couple: None,
        }
    }
}

#[cfg(test)]
mod tests {
    use hysteron_base::{MaterialLaw, rng};
    use nalgebra::{Matrix3, Vector3};
    use rand::RngExt;

    use super::*;
    use crate::simd::{Isa, Packs, WithSimd};

    /// ψ, P and the block K_ab per volume at F, the same in every lane.
    struct At<L> {
        law: L,
        f: Matrix3<f64>,
        a: Vector3<f64>,
        b: Vector3<f64>,
        kind: Tangent,
    }

    impl<L: PointLaw> WithSimd for At<L> {
        type Output = (f64, Matrix3<f64>, Matrix3<f64>);

        fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
            let packs = Packs::new(simd, 0);
            let rows = |m: &Matrix3<f64>| -> Mat3<S> {
                [0, 1, 2].map(|i| [0, 1, 2].map(|j| packs.splat(m[(i, j)])))
            };
            let number = |lanes: Lanes<S>| lanes.to_array()[0];
            let matrix = |m: &Mat3<S>| Matrix3::from_fn(|i, j| number(m[i][j]));
            let lame = Lame { lambda: packs.splat(LAMBDA), mu: packs.splat(MU) };
            let f = rows(&self.f);
            let at = QuadraturePoint { f: &f, edges: &f, gradients: &f };
            let t = self.law.tangent(lame, &at, self.kind);
            let q = matrix(&t.map);
            let (pa, pb) = (q * self.a, q * self.b);
            let mut k = number(t.alpha) * self.a.dot(&self.b) * Matrix3::identity()
                + number(t.lambda) * pa * pb.transpose()
                + number(t.kappa) * pb * pa.transpose();
            if let Some((c, m)) = &t.couple {
                k += number(*c) * pa.cross_matrix() * matrix(m) * pb.cross_matrix();
            }
            (number(self.law.energy(lame, &at)), matrix(&self.law.stress(lame, &at)), k)
        }
    }

    const LAMBDA: f64 = 3.0;
    const MU: f64 = 0.7;

    fn at(
        law: MaterialLaw,
        f: Matrix3<f64>,
        a: Vector3<f64>,
        b: Vector3<f64>,
    ) -> (f64, Matrix3<f64>, Matrix3<f64>) {
        let (isa, kind) = (Isa::detect(), Tangent::Exact);
        match law {
            MaterialLaw::SmallStrain => isa.run(At { law: SmallStrain, f, a, b, kind }),
            MaterialLaw::Corotational => isa.run(At { law: Corotational, f, a, b, kind }),
            MaterialLaw::NeoHookean => isa.run(At { law: NeoHookean, f, a, b, kind }),
            MaterialLaw::CorotationalEdges => isa.run(At { law: CorotationalEdges, f, a, b, kind }),
        }
    }

    #[test]
    fn stress_and_block_are_derivatives_of_the_energy() {
        // Central differences with this step: truncation 1e-12, round-off 1e-10, numbers of size ten.
        const STEP: f64 = 1e-6;
        const TOL: f64 = 1e-8;
        let mut stream = rng(37, "test/law");
        let mut vector = || Vector3::from_fn(|_, _| stream.random_range(-1.0..1.0));
        let (a, b, delta) = (vector(), vector(), vector());
        let turn = nalgebra::Rotation3::new(Vector3::new(0.4, 1.5, -0.6)).into_inner();
        let f: Matrix3<f64> =
            turn * (Matrix3::identity() + 0.4 * Matrix3::from_columns(&[vector(), vector(), vector()]));
        assert!(f.determinant() > 0.0);
        for law in [MaterialLaw::SmallStrain, MaterialLaw::Corotational, MaterialLaw::NeoHookean] {
            let (_, stress, block) = at(law, f, a, b);
            let change = STEP * delta * b.transpose();
            let (energy_ahead, ahead, _) = at(law, f + change, a, b);
            let (energy_behind, behind, _) = at(law, f - change, a, b);
            let slope = stress.dot(&(delta * b.transpose()));
            let difference = (energy_ahead - energy_behind) / (2.0 * STEP);
            assert!(slope.abs() > 1e-2 && difference != slope);
            assert!((difference - slope).abs() < TOL, "{law:?}: {difference} {slope}");
            let (slope, difference) = (block * delta, (ahead - behind) / (2.0 * STEP) * a);
            assert!(slope.norm() > 1e-2 && difference != slope);
            assert!((difference - slope).norm() < TOL, "{law:?}: {difference} {slope}");
        }
    }

    #[test]
    fn all_laws_share_the_small_strain_stiffness_at_rest() {
        const ROUND_OFF: f64 = 1e-14;
        let (a, b) = (Vector3::new(0.3, -0.5, 1.0), Vector3::new(0.8, 0.2, -0.4));
        let one = Matrix3::identity();
        let expected = MU * a.dot(&b) * one + LAMBDA * a * b.transpose() + MU * b * a.transpose();
        for law in [
            MaterialLaw::SmallStrain,
            MaterialLaw::Corotational,
            MaterialLaw::CorotationalEdges,
            MaterialLaw::NeoHookean,
        ] {
            let (energy, stress, block) = at(law, one, a, b);
            assert!(energy.abs() + stress.norm() < ROUND_OFF, "{law:?}: {energy} {stress}");
            assert!((block - expected).norm() < ROUND_OFF, "{law:?}: {block}");
        }
    }

    #[test]
    fn lame_parameters_are_those_of_the_textbook() {
        let material = |nu| Material {
            law: MaterialLaw::SmallStrain,
            youngs_modulus: 2.0,
            poisson_ratio: nu,
            density: 0.0,
        };
        assert_eq!(lame_parameters(&material(0.25)), (0.8, 0.8));
        assert_eq!(lame_parameters(&material(0.0)), (0.0, 1.0));
    }
}
