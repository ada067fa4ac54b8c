//! How the energy of a section goes on where its cubic term would soften it away.
//!
//! Along a ray of strains t ε the energy Q t² + C t³ has the stiffness 2 Q + 6 C t: with C < 0 none is left at t = -Q / 3C, and
//! beyond the energy has no floor. From where C / Q has come to c₀ the stiffness along the ray stays what it is there,
//! 2 Q (1 + 3 c₀): W = Q g(C / Q), g(c) = (1 + 3 c₀) - 3 c₀² / c + c₀³ / c², which meets 1 + c at c₀ with two derivatives. The
//! energy is then never below (1 + 3 c₀) Q, so every load has an equilibrium; before c₀ nothing changes.

/// C / Q from which the energy goes on with constant stiffness along its ray: a quarter of that at rest.
pub(super) const SOFTEST: f64 = -0.25;

/// Derivatives of W = Q g(C / Q).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Continuation {
    /// C / Q [-].
    pub ratio: f64,
    /// g.
    pub energy: f64,
    /// ∂W/∂Q and ∂W/∂C [-].
    pub of_quadratic: f64,
    pub of_cubic: f64,
    /// g''.
    pub curvature: f64,
}

impl Continuation {
    /// For a quadratic and a cubic part of the energy [J]; `None` where W is their sum.
    pub fn of(quadratic: f64, cubic: f64) -> Option<Self> {
        if cubic >= SOFTEST * quadratic || quadratic <= 0.0 {
            return None;
        }
        let c = cubic / quadratic;
        let (first, second) = (-3.0 * SOFTEST.powi(2) / c, SOFTEST.powi(3) / (c * c));
        let (energy, slope) = (1.0 + 3.0 * SOFTEST + first + second, -(first + 2.0 * second) / c);
        Some(Self {
            ratio: c,
            energy,
            of_quadratic: energy - c * slope,
            of_cubic: slope,
            curvature: (2.0 * first + 6.0 * second) / (c * c),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::section::SectionLaw;
    use super::super::tests::moved_chain;
    use super::super::{PADDED, STRAIN, Strain};
    use super::*;

    /// A strain along which the cubic term softens, as long as makes C / Q the given number.
    fn softening(law: &SectionLaw, ratio: f64) -> Strain {
        let mut rng = hysteron_base::rng(5, "chain/softening");
        let mut strain: Strain = [0.0; PADDED];
        strain[..STRAIN].fill_with(|| 1e-4 * rand::RngExt::random_range(&mut rng, -1.0..1.0));
        let (quadratic, cubic) = law.energies(&strain);
        strain.map(|e| e * ratio * quadratic / cubic)
    }

    #[test]
    fn stress_is_the_gradient_of_the_energy_and_tangent_that_of_the_stress_on_both_sides() {
        let (_, moved) = moved_chain();
        let law = &moved.chain.laws[3];
        let isa = moved.chain.isa;
        for ratio in [-0.1, 1.001 * SOFTEST, -0.4, -1.0, -30.0] {
            let strain = softening(law, ratio);
            let soft = Continuation::of(law.energies(&strain).0, law.energies(&strain).1);
            assert_eq!(soft.is_some(), ratio < SOFTEST);
            let (at, tangent) = (law.stress(isa, &strain), law.tangent(isa, &strain));
            let largest = strain.iter().fold(0.0f64, |max, e| max.max(e.abs()));
            let stiffest = tangent.iter().flatten().fold(0.0f64, |max, k| max.max(k.abs()));
            let strongest = at.stress.iter().fold(0.0f64, |max, s| max.max(s.abs()));
            let step = 1e-5 * largest;
            for k in 0..STRAIN {
                let moved = |way: f64| {
                    let mut moved = strain;
                    moved[k] += way * step;
                    law.stress(isa, &moved)
                };
                let (ahead, behind) = (moved(1.0), moved(-1.0));
                let slope = (ahead.energy - behind.energy) / (2.0 * step);
                // Differences of second order: a part of 1e-10, times how fast the ratio turns.
                assert!(
                    (slope - at.stress[k]).abs() < 1e-6 * strongest,
                    "{ratio} {k}: {slope} {}",
                    at.stress[k]
                );
                for i in 0..STRAIN {
                    let slope = (ahead.stress[i] - behind.stress[i]) / (2.0 * step);
                    assert!((slope - tangent[i][k]).abs() < 1e-6 * stiffest, "{ratio} {i} {k}");
                }
            }
        }
    }

    #[test]
    fn stiffness_along_a_ray_stays_where_it_has_come_to_a_quarter() {
        let (_, moved) = moved_chain();
        let (law, isa) = (&moved.chain.laws[3], moved.chain.isa);
        let strain = softening(law, SOFTEST);
        let (quadratic, _) = law.energies(&strain);
        let along = |t: f64| {
            let strain = strain.map(|e| t * e);
            let tangent = law.tangent(isa, &strain);
            let of = |i: usize| (0..STRAIN).map(|k| tangent[i][k] * strain[k]).sum::<f64>();
            (0..STRAIN).map(|i| of(i) * strain[i]).sum::<f64>() / (2.0 * quadratic * t * t)
        };
        for (t, expected) in
            [(1e-3, 0.99925), (0.5, 0.625), (1.0, 0.25), (2.0, 0.25), (1e3, 0.25), (-1.0, 1.75)]
        {
            // The tensor is kept in single precision, which the sum of many terms of both signs shows.
            assert!((along(t) - expected).abs() < 1e-4, "{t}: {}", along(t));
        }
        let energy = |t: f64| law.stress(isa, &strain.map(|e| t * e)).energy;
        assert!(energy(1e6) > 0.25 * 1e12 * quadratic);
    }
}
