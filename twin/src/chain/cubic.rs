//! The cubic part of a section's energy, ⅙ A[ε, ε, ε] with a fully symmetric A.
//!
//! Kept as the polynomial Σ c_ijk ε_i ε_j ε_k over i <= j <= k, in which c is A times its number of permutations over six.
//! Row by row of (j, i), with k in registers: each number is read once and multiplied twice.

use hysteron_base::lanes::{Isa, LANES, Lanes, Pack, Packs, Simd, WithSimd};

use super::{PADDED, STRAIN, Strain};

/// Registers of a strain.
const PACKS: usize = PADDED / LANES;

/// Numbers of one register in single precision. The tensor is known to five digits, and streaming it is what a residual
/// mostly costs; energy, stress and tangent are those of the same rounded polynomial.
type Row = [f32; LANES];

/// Coefficients of the cubic polynomial.
#[derive(Debug, Clone)]
pub(crate) struct Cubic(Vec<Row>);

impl Cubic {
    /// Numbers of the polynomial.
    pub const COEFFICIENTS: usize = STRAIN * (STRAIN + 1) * (STRAIN + 2) / 6;

    /// The coefficients c_ijk, i <= j <= k, by j, then i, then k.
    pub fn coefficients(&self) -> Vec<f32> {
        let mut rows = self.0.iter();
        let mut coefficients = Vec::with_capacity(Self::COEFFICIENTS);
        for j in 0..STRAIN {
            for _ in 0..=j {
                let padded: Vec<f32> = rows.by_ref().take(PACKS - j / LANES).flatten().copied().collect();
                coefficients.extend_from_slice(&padded[j % LANES..][..STRAIN - j]);
            }
        }
        coefficients
    }

    /// Multiplies the polynomial by a factor.
    pub fn scale_by(&mut self, factor: f64) {
        let entries = self.0.as_flattened_mut();
        entries.iter_mut().for_each(|entry| *entry = (factor * f64::from(*entry)) as f32);
    }

    /// From what [`Self::coefficients`] gave; their number is [`Self::COEFFICIENTS`].
    pub fn from_coefficients(coefficients: &[f32]) -> Self {
        let mut rows = Vec::new();
        let mut rest = coefficients;
        for j in 0..STRAIN {
            for _ in 0..=j {
                let (here, after) = rest.split_at(STRAIN - j);
                rest = after;
                let mut padded = [0.0; PADDED];
                padded[j..STRAIN].copy_from_slice(here);
                rows.extend_from_slice(&padded.as_chunks::<LANES>().0[j / LANES..]);
            }
        }
        Self(rows)
    }

    /// From A, which `of` gives for i <= j <= k.
    pub fn new(of: impl Fn(usize, usize, usize) -> f64) -> Self {
        let mut packs = Vec::new();
        for j in 0..STRAIN {
            for i in 0..=j {
                for pack in j / LANES..PACKS {
                    packs.push(std::array::from_fn(|lane| {
                        let k = LANES * pack + lane;
                        if k < j || k >= STRAIN {
                            return 0.0_f32;
                        }
                        let share = match (i == j, j == k) {
                            (true, true) => 1.0 / 6.0,
                            (false, false) => 1.0,
                            _ => 0.5,
                        };
                        (share * of(i, j, k)) as f32
                    }));
                }
            }
        }
        Self(packs)
    }

    /// Adds ½ A[ε, ε] to `stress`; a third of its product with ε is the energy.
    pub fn add_stress(&self, isa: Isa, strain: &Strain, stress: &mut Strain) {
        isa.run(Stress { cubic: &self.0, strain, stress });
    }

    /// Adds A ε to a matrix by rows.
    pub fn add_tangent(&self, isa: Isa, strain: &Strain, tangent: &mut [Strain; STRAIN]) {
        let mut half = [[0.0; PADDED]; STRAIN];
        isa.run(HalfTangent { cubic: &self.0, strain, half: &mut half });
        for i in 0..STRAIN {
            for k in 0..STRAIN {
                tangent[i][k] += half[i][k] + half[k][i];
            }
        }
    }
}

/// A row in registers.
#[inline(always)]
fn load<S: Simd>(packs: Packs<S>, row: &Row) -> Lanes<S> {
    packs.load(&Pack(row.map(f64::from)))
}

/// The strain in registers.
#[inline(always)]
fn load_strain<S: Simd>(packs: Packs<S>, strain: &Strain) -> [Lanes<S>; PACKS] {
    std::array::from_fn(|pack| packs.load(&Pack(std::array::from_fn(|lane| strain[LANES * pack + lane]))))
}

/// Adds a matrix to `half` that with its transpose is A ε.
struct HalfTangent<'a> {
    cubic: &'a [Row],
    strain: &'a Strain,
    half: &'a mut [Strain; STRAIN],
}

impl WithSimd for HalfTangent<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        for pass in 0..Packs::<S>::PASSES {
            let packs = Packs::new(simd, pass);
            let mut sums = HalfSums {
                strain: load_strain(packs, self.strain),
                rows: [[packs.splat(0.0); PACKS]; STRAIN],
            };
            let mut rest = self.cubic;
            for j in 0..STRAIN {
                rest = match j / LANES {
                    0 => sums.add::<0>(packs, self.strain, j, rest, self.half),
                    1 => sums.add::<1>(packs, self.strain, j, rest, self.half),
                    2 => sums.add::<2>(packs, self.strain, j, rest, self.half),
                    _ => sums.add::<3>(packs, self.strain, j, rest, self.half),
                };
            }
            let lanes = S::F64_LANES;
            for (half, row) in self.half.iter_mut().zip(&sums.rows) {
                for (pack, sum) in row.iter().enumerate() {
                    let first = LANES * pack + packs.range().start;
                    for (half, sum) in half[first..first + lanes].iter_mut().zip(sum.to_array()) {
                        *half += sum;
                    }
                }
            }
        }
    }
}

/// Rows of half the tangent, and the strain in registers.
struct HalfSums<S: Simd> {
    strain: [Lanes<S>; PACKS],
    rows: [[Lanes<S>; PACKS]; STRAIN],
}

impl<S: Simd> HalfSums<S> {
    /// All coefficients with the middle index `j`, whose register is `FIRST`; returns those that follow.
    #[inline(always)]
    fn add<'a, const FIRST: usize>(
        &mut self,
        packs: Packs<S>,
        strain: &Strain,
        j: usize,
        cubic: &'a [Row],
        half: &mut [Strain; STRAIN],
    ) -> &'a [Row] {
        let n = PACKS - FIRST;
        let (here, rest) = cubic.split_at((j + 1) * n);
        let middle = packs.splat(strain[j]);
        let mut of_middle = [packs.splat(0.0); PACKS];
        for (i, coefficients) in here.chunks_exact(n).enumerate() {
            let first = packs.splat(strain[i]);
            let mut product = packs.splat(0.0);
            for pack in FIRST..PACKS {
                let c = load(packs, &coefficients[pack - FIRST]);
                self.rows[i][pack] = c.mul_add(middle, self.rows[i][pack]);
                of_middle[pack] = c.mul_add(first, of_middle[pack]);
                product = c.mul_add(self.strain[pack], product);
            }
            half[i][j] += product.to_array()[..S::F64_LANES].iter().sum::<f64>();
        }
        for pack in FIRST..PACKS {
            self.rows[j][pack] = self.rows[j][pack] + of_middle[pack];
        }
        rest
    }
}

struct Stress<'a> {
    cubic: &'a [Row],
    strain: &'a Strain,
    stress: &'a mut Strain,
}

impl WithSimd for Stress<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        for pass in 0..Packs::<S>::PASSES {
            let packs = Packs::new(simd, pass);
            let mut sums = CubicSums {
                strain: load_strain(packs, self.strain),
                of_first: [packs.splat(0.0); STRAIN],
                of_last: [packs.splat(0.0); PACKS],
            };
            let mut rest = self.cubic;
            for j in 0..STRAIN {
                rest = match j / LANES {
                    0 => sums.add::<0>(packs, self.strain, j, rest),
                    1 => sums.add::<1>(packs, self.strain, j, rest),
                    2 => sums.add::<2>(packs, self.strain, j, rest),
                    _ => sums.add::<3>(packs, self.strain, j, rest),
                };
            }
            let lanes = S::F64_LANES;
            for (stress, sum) in self.stress.iter_mut().zip(&sums.of_first) {
                *stress += sum.to_array()[..lanes].iter().sum::<f64>();
            }
            for (pack, sum) in sums.of_last.iter().enumerate() {
                let first = LANES * pack + packs.range().start;
                for (stress, sum) in self.stress[first..first + lanes].iter_mut().zip(sum.to_array()) {
                    *stress += sum;
                }
            }
        }
    }
}

/// Partial sums of the gradient, and the strain in registers.
struct CubicSums<S: Simd> {
    strain: [Lanes<S>; PACKS],
    /// By the first or second index, lanes still apart.
    of_first: [Lanes<S>; STRAIN],
    /// By the last index.
    of_last: [Lanes<S>; PACKS],
}

impl<S: Simd> CubicSums<S> {
    /// All coefficients with the middle index `j`, whose register is `FIRST`; returns those that follow.
    #[inline(always)]
    fn add<'a, const FIRST: usize>(
        &mut self,
        packs: Packs<S>,
        strain: &Strain,
        j: usize,
        cubic: &'a [Row],
    ) -> &'a [Row] {
        let n = PACKS - FIRST;
        let (here, rest) = cubic.split_at((j + 1) * n);
        let middle = packs.splat(strain[j]);
        let mut products = self.strain;
        for pack in FIRST..PACKS {
            products[pack] = products[pack] * middle;
        }
        let mut over_first = [packs.splat(0.0); PACKS];
        for (i, row) in here.chunks_exact(n).enumerate() {
            let first = packs.splat(strain[i]);
            let mut sum = self.of_first[i];
            for pack in FIRST..PACKS {
                let c = load(packs, &row[pack - FIRST]);
                over_first[pack] = c.mul_add(first, over_first[pack]);
                sum = c.mul_add(products[pack], sum);
            }
            self.of_first[i] = sum;
        }
        for pack in FIRST..PACKS {
            self.of_last[pack] = over_first[pack].mul_add(middle, self.of_last[pack]);
            self.of_first[j] = over_first[pack].mul_add(self.strain[pack], self.of_first[j]);
        }
        rest
    }
}

#[cfg(test)]
mod tests {
    use rand::RngExt;

    use super::*;

    #[test]
    fn stress_and_tangent_are_those_of_the_dense_tensor() {
        let tensor = |i: usize, j: usize, k: usize| {
            let mut sorted = [i, j, k];
            sorted.sort_unstable();
            // A multiple of 1/4, whose shares are single-precision numbers; of sixths there is only the last digit left.
            let number = (1.0 + (sorted[0] + 31 * sorted[1] + 577 * sorted[2]) as f64).sin();
            if i == j && j == k { 6.0 * (8.0 * number).round() } else { (8.0 * number).round() / 4.0 }
        };
        let cubic = Cubic::new(tensor);
        assert_eq!(Cubic::from_coefficients(&cubic.coefficients()).0, cubic.0);
        assert_eq!(cubic.coefficients().len(), Cubic::COEFFICIENTS);
        let mut rng = hysteron_base::rng(1, "cubic");
        let mut strain = [0.0; PADDED];
        strain[..STRAIN].fill_with(|| rng.random_range(-1.0..1.0));
        let mut tangent = [[0.0; PADDED]; STRAIN];
        cubic.add_tangent(Isa::detect(), &strain, &mut tangent);
        for isa in Isa::all() {
            let mut stress = [0.0; PADDED];
            cubic.add_stress(isa, &strain, &mut stress);
            for i in 0..STRAIN {
                let mut expected = 0.0;
                for j in 0..STRAIN {
                    let entry: f64 = (0..STRAIN).map(|k| tensor(i, j, k) * strain[k]).sum();
                    assert!((tangent[i][j] - entry).abs() < 1e-12, "{i} {j}");
                    expected += 0.5 * entry * strain[j];
                }
                assert!((stress[i] - expected).abs() < 1e-11, "{i}: {} and {expected}", stress[i]);
            }
        }
    }
}
