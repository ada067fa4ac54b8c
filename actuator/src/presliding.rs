//! Friction that gives way before it slides: the friction of a guide, from -1 to 1 of its bound, as an
//! operator of slip.
//!
//! Coulomb's law is rigid until it slides. Dahl's gives way from the first micrometre, exponentially; Prandtl's elements give
//! way one after the other, piecewise linearly. Both store reversals, as contacts of asperities and of strands do.

/// How friction approaches its bound, also after a reversal.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum FrictionLaw {
    /// At once: nothing slips below the bound.
    #[default]
    Coulomb,
    /// dz/du = (1 - z sgn u̇)/δ, with the slip δ over which it gives way [m].
    ///
    /// # Reference
    /// Dahl (1968), A solid friction model, with the exponent 1.
    Dahl(f64),
    /// Elastoplastic elements side by side, of equal strength, that yield after δ/n, 2δ/n, ..., δ [m].
    ///
    /// # Reference
    /// Prandtl (1928), Ein Gedankenmodell zur kinetischen Theorie der festen Körper; Iwan (1966).
    Prandtl(f64),
}

/// Elements of [`FrictionLaw::Prandtl`].
const ELEMENTS: usize = 4;

/// Strains of a guide's elements, each -1 to 1 [-]; the first one alone for Dahl's law.
pub(crate) type GuideStrains = [f64; ELEMENTS];

impl FrictionLaw {
    /// The share z of the friction bound after slip `by` from where the elements were `from`, and dz/du
    /// [1/m]: where the two sides differ, that towards `ahead`.
    pub(crate) fn engaged(self, from: &GuideStrains, by: f64, ahead: f64) -> [f64; 2] {
        match self {
            Self::Coulomb => [0.0; 2],
            Self::Dahl(length) => {
                let sign = if by == 0.0 { ahead.signum() } else { by.signum() };
                let left = (1.0 - sign * from[0]) * (-by.abs() / length).exp();
                [sign * (1.0 - left), left / length]
            }
            Self::Prandtl(length) => {
                let (mut held, mut slope) = (0.0, 0.0);
                for (i, strain) in from.iter().enumerate() {
                    let yields = yields_after(length, i);
                    let trial = strain + by / yields;
                    held += trial.clamp(-1.0, 1.0) / ELEMENTS as f64;
                    let is_elastic =
                        if ahead > 0.0 { (-1.0..1.0).contains(&trial) } else { -1.0 < trial && trial <= 1.0 };
                    slope += if is_elastic { 1.0 / (ELEMENTS as f64 * yields) } else { 0.0 };
                }
                [held, slope]
            }
        }
    }

    /// Moves the elements by a slip.
    pub(crate) fn strain(self, elements: &mut GuideStrains, by: f64) {
        match self {
            Self::Coulomb => {}
            Self::Dahl(_) => elements[0] = self.engaged(elements, by, by)[0],
            Self::Prandtl(length) => {
                for (i, strain) in elements.iter_mut().enumerate() {
                    *strain = (*strain + by / yields_after(length, i)).clamp(-1.0, 1.0);
                }
            }
        }
    }

    /// Slip over which it gives way [m]; zero for Coulomb's.
    pub fn presliding(self) -> f64 {
        match self {
            Self::Coulomb => 0.0,
            Self::Dahl(length) | Self::Prandtl(length) => length,
        }
    }
}

/// Slip from rest after which element `i` yields [m].
fn yields_after(length: f64, i: usize) -> f64 {
    length * (i + 1) as f64 / ELEMENTS as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    const LENGTH: f64 = 1e-4;

    /// z along a path of slips [m] in steps of `step` [m], from no strain.
    fn along(law: FrictionLaw, turns: &[f64], step: f64) -> Vec<(f64, f64)> {
        let (mut elements, mut at, mut path) = (GuideStrains::default(), 0.0, Vec::new());
        for turn in turns {
            let n = ((turn - at) / step).abs().round();
            let by = (turn - at) / n;
            for _ in 0..n as usize {
                law.strain(&mut elements, by);
                at += by;
                path.push((at, law.engaged(&elements, 0.0, 1.0)[0]));
            }
        }
        path
    }

    #[test]
    fn dahl_gives_way_exponentially_and_turns_back_from_where_it_is() {
        let law = FrictionLaw::Dahl(LENGTH);
        let path = along(law, &[1.3 * LENGTH, 0.2 * LENGTH], 0.01 * LENGTH);
        let top = 1.0 - f64::exp(-1.3);
        for (i, (at, z)) in path.iter().enumerate() {
            // u = 1.3 δ is the 130th.
            let exact = match i < 130 {
                true => 1.0 - (-at / LENGTH).exp(),
                false => -1.0 + (1.0 + top) * ((at - 1.3 * LENGTH) / LENGTH).exp(),
            };
            assert!((z - exact).abs() < 1e-12, "{at}: {z} {exact}");
        }
        let [_, slope] = law.engaged(&GuideStrains::default(), 0.0, 1.0);
        assert!((slope * LENGTH - 1.0).abs() < 1e-12);
        // Far along it is at its bound, and stays there.
        assert!((along(law, &[50.0 * LENGTH], LENGTH).pop().map_or(0.0, |(_, z)| z) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn steady_loop_of_dahl_has_the_closed_area() {
        // Between ±A it goes from -tanh(A/δ) to tanh(A/δ), and the loop encloses 4 (A - δ tanh(A/δ)).
        let amplitude = 1.7 * LENGTH;
        let law = FrictionLaw::Dahl(LENGTH);
        let turns: Vec<f64> = (0..21).map(|k| if k % 2 == 0 { amplitude } else { -amplitude }).collect();
        let path = along(law, &turns, 1e-4 * LENGTH);
        let top = path.last().map_or(0.0, |(_, z)| *z);
        assert!((top - (amplitude / LENGTH).tanh()).abs() < 1e-9, "{top}");
        let n = (4.0 * amplitude / (1e-4 * LENGTH)).round() as usize;
        let pairs = path[path.len() - n - 1..].windows(2);
        let area: f64 = pairs.map(|pair| 0.5 * (pair[0].1 + pair[1].1) * (pair[1].0 - pair[0].0)).sum();
        let exact = 4.0 * (amplitude - LENGTH * (amplitude / LENGTH).tanh());
        // Trapezoids over ten thousand parts of δ.
        assert!((area / exact - 1.0).abs() < 1e-6, "{area} {exact}");
    }

    #[test]
    fn prandtl_is_piecewise_linear_and_its_branches_are_the_first_one_twice() {
        // Element i of n holds u/(i δ/n) until it yields: after k of them, z = k/n + u/δ Σ_{i > k} 1/i.
        let virgin = |u: f64| -> f64 {
            (1..=ELEMENTS)
                .map(|i| (u * ELEMENTS as f64 / (i as f64 * LENGTH)).min(1.0) / ELEMENTS as f64)
                .sum()
        };
        let law = FrictionLaw::Prandtl(LENGTH);
        let path = along(law, &[0.8 * LENGTH, -0.8 * LENGTH], 0.01 * LENGTH);
        for (i, (at, z)) in path.iter().enumerate() {
            // Masing's rule: a branch after a reversal is the first one at twice its size.
            let exact = match i < 80 {
                true => virgin(*at),
                false => virgin(0.8 * LENGTH) - 2.0 * virgin(0.5 * (0.8 * LENGTH - at)),
            };
            assert!((z - exact).abs() < 1e-12, "{at}: {z} {exact}");
        }
    }

    #[test]
    fn slopes_are_those_of_differences_on_either_side() {
        let mut elements = GuideStrains::default();
        for law in [FrictionLaw::Dahl(LENGTH), FrictionLaw::Prandtl(LENGTH)] {
            law.strain(&mut elements, 0.6 * LENGTH);
            for by in [-0.9, -0.13, 0.0, 0.13, 0.9] {
                for ahead in [-1.0, 1.0] {
                    let at = |by: f64| law.engaged(&elements, by * LENGTH, ahead)[0];
                    let step = 1e-6 * ahead;
                    let difference = (at(by + step) - at(by)) / (step * LENGTH);
                    let [_, slope] = law.engaged(&elements, by * LENGTH, ahead);
                    assert!((slope - difference).abs() * LENGTH < 1e-5, "{law:?} {by} {slope} {difference}");
                }
            }
        }
    }
}
