//! Linear least squares of the missing displacement, before the training of a network.
//!
//! Plays and first-order filters are what hysteresis and creep are made of, and much of both is linear in them (Prandtl-Ishlinskii,
//! Maxwell). Along the axis a body that bends to one side moves as one that bends to the other: there it is also
//! features times the stroke of their tendon. Beyond the range of training every term keeps the value that it had at
//! its end: gone on, a straight line did worse there than nothing. Least squares find the weights of these terms at
//! once and without chance; the network then learns what is left, in a smaller range.

use hysteron_base::BadInput;
use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Deserializer, Serialize};

/// Weights of the terms.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LinearPart {
    /// Features of one tendon, the first of which is its stroke.
    per_tendon: usize,
    /// Θ: by axis, then by term [m].
    rows: [Vec<f64>; 3],
    /// For each feature the scale and shift from the network's ranges to those that the part was fitted in; none
    /// where these are the same.
    #[serde(default)]
    ranges: Vec<[f64; 2]>,
}

/// One sample of the fit: the tip's error is `error` + `gain` z for a displacement z.
pub(super) struct Equation<'a> {
    /// Normalised features of the strokes.
    pub features: &'a [f32],
    /// 3 × 3 [-].
    pub gain: [[f64; 3]; 3],
    /// [m].
    pub error: [f64; 3],
}

/// Ridge over the sum of the squared gains: neighbouring samples have correlated errors, so that a thousand weigh like
/// ten.
const RIDGE: f64 = 1e-4;

impl LinearPart {
    /// The weights with the least squared errors over `equations`, for features of so many tendons.
    ///
    /// # Errors
    /// Equations that are not finite.
    pub(super) fn fit<'a>(
        n_tendons: usize,
        n_features: usize,
        equations: impl Iterator<Item = Equation<'a>>,
    ) -> Result<Self, BadInput> {
        let per_tendon = n_features / n_tendons.max(1);
        let n = 1 + 2 * n_features;
        let mut part = Self { per_tendon, rows: [(); 3].map(|()| vec![0.0; n]), ranges: Vec::new() };
        let mut blocks = [(); 9].map(|()| DMatrix::<f64>::zeros(n, n));
        let mut right = DVector::zeros(3 * n);
        let (mut terms, mut scale) = (Vec::with_capacity(n), 0.0);
        for Equation { features, gain, error } in equations {
            part.terms_into(features, &mut terms);
            let by = |a: usize, b: usize| (0..3).map(|c| gain[c][a] * gain[c][b]).sum::<f64>();
            for a in 0..3 {
                let pull: f64 = (0..3).map(|c| gain[c][a] * error[c]).sum();
                terms.iter().enumerate().for_each(|(k, term)| right[a * n + k] -= pull * term);
                for b in 0..=a {
                    add_product(&mut blocks[3 * a + b], by(a, b), &terms);
                }
                scale += by(a, a) / 3.0;
            }
        }
        let mut normal = DMatrix::zeros(3 * n, 3 * n);
        for (a, b) in (0..3).flat_map(|a| (0..=a).map(move |b| (a, b))) {
            let mut block = blocks[3 * a + b].clone();
            block.fill_upper_triangle_with_lower_triangle();
            normal.view_mut((a * n, b * n), (n, n)).copy_from(&block);
            normal.view_mut((b * n, a * n), (n, n)).copy_from(&block);
        }
        normal += DMatrix::identity(3 * n, 3 * n) * (RIDGE * scale).max(f64::MIN_POSITIVE);
        // Across the robot a body that is bent the other way moves the other way: products of two features do not.
        for unused in (0..2).flat_map(|a| a * n + 1 + n_features..(a + 1) * n) {
            normal.row_mut(unused).fill(0.0);
            normal.column_mut(unused).fill(0.0);
            normal[(unused, unused)] = 1.0;
            right[unused] = 0.0;
        }
        let found = normal.cholesky().map(|factor| factor.solve(&right));
        let found = found.filter(|found| found.iter().all(|value| value.is_finite()));
        let found =
            found.ok_or_else(|| BadInput::new("identified recordings", "finite numbers", "others"))?;
        for (row, found) in part.rows.iter_mut().zip(found.as_slice().chunks_exact(n)) {
            row.copy_from_slice(found);
        }
        Ok(part)
    }

    /// The same part for features that are normalised by ranges from which `ranges` lead to those of the fit.
    pub(super) fn for_ranges(self, ranges: &[[f64; 2]]) -> Self {
        Self { ranges: ranges.to_vec(), ..self }
    }

    /// The same with all weights zero.
    pub(super) fn silent(self) -> Self {
        Self { rows: self.rows.map(|row| vec![0.0; row.len()]), ..self }
    }

    /// Whether it is for features of so many tendons.
    pub fn fits(&self, n_tendons: usize, n_features: usize) -> bool {
        self.per_tendon * n_tendons == n_features
            && (self.ranges.is_empty() || self.ranges.len() == n_features)
            && self.rows.iter().all(|row| row.len() == 1 + 2 * n_features)
    }

    /// One, all features within their range, and all these times the stroke of their tendon.
    fn terms_into(&self, features: &[f32], terms: &mut Vec<f64>) {
        terms.clear();
        terms.push(1.0);
        let in_fit = |k: usize, feature: f64| self.ranges.get(k).map_or(feature, |[a, b]| a * feature + b);
        terms.extend(features.iter().enumerate().map(|(k, &x)| in_fit(k, f64::from(x)).clamp(-1.0, 1.0)));
        for first in (1..=features.len()).step_by(self.per_tendon) {
            let stroke = terms[first];
            (first..first + self.per_tendon).for_each(|k| terms.push(stroke * terms[k]));
        }
    }

    /// The displacement for normalised features of the strokes [m]; `terms` is scratch.
    pub(super) fn displacement(&self, features: &[f32], terms: &mut Vec<f64>) -> [f64; 3] {
        self.terms_into(features, terms);
        self.rows.each_ref().map(|row| row.iter().zip(&*terms).map(|(weight, term)| weight * term).sum())
    }
}

/// Mean displacement of several linear parts [m]; `terms` is scratch.
pub(super) fn mean_displacement(parts: &[LinearPart], features: &[f32], terms: &mut Vec<f64>) -> [f64; 3] {
    let sum = parts.iter().fold([0.0; 3], |sum, part| {
        let displacement = part.displacement(features, terms);
        std::array::from_fn(|c| sum[c] + displacement[c])
    });
    sum.map(|value| value / parts.len().max(1) as f64)
}

/// Reads one part, as files of older programs have it, or several.
pub(super) fn one_or_more<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<LinearPart>, D::Error> {
    #[derive(Deserialize)]
    #[serde(untagged)]
    enum LinearParts {
        One(LinearPart),
        More(Vec<LinearPart>),
    }
    Ok(match LinearParts::deserialize(deserializer)? {
        LinearParts::One(part) => vec![part],
        LinearParts::More(parts) => parts,
    })
}

/// block += factor t tᵀ, the lower triangle.
pub(super) fn add_product(block: &mut DMatrix<f64>, factor: f64, terms: &[f64]) {
    let n = terms.len();
    for (k, column) in block.as_mut_slice().chunks_exact_mut(n).enumerate() {
        let weight = factor * terms[k];
        for (value, term) in column[k..].iter_mut().zip(&terms[k..]) {
            *value += weight * term;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_that_made_the_errors_are_found() -> Result<(), BadInput> {
        // Two tendons of three features.
        let (n_tendons, n_features) = (2, 6);
        let row = |seed: usize, used: usize| -> Vec<f64> {
            (0..13).map(|k| if k < used { 1e-3 * ((seed + 3 * k) as f64).sin() } else { 0.0 }).collect()
        };
        // Products act along the axis alone.
        let rows = [row(1, 7), row(2, 7), row(5, 13)];
        let truth = LinearPart { per_tendon: 3, rows, ranges: Vec::new() };
        assert!(truth.fits(n_tendons, n_features) && !truth.fits(3, n_features));
        let features: Vec<[f32; 6]> =
            (0..500).map(|i| std::array::from_fn(|k| ((i * (k + 2)) as f32 * 0.37).sin())).collect();
        let gain = |i: usize| -> [[f64; 3]; 3] {
            std::array::from_fn(|a| {
                std::array::from_fn(|c| if a == c { 1.0 } else { 0.1 * ((i + a + 2 * c) as f64).cos() })
            })
        };
        let mut terms = Vec::new();
        let errors: Vec<[f64; 3]> = (0..500)
            .map(|i| {
                let z = truth.displacement(&features[i], &mut terms);
                gain(i).map(|row| -row.iter().zip(z).map(|(g, z)| g * z).sum::<f64>())
            })
            .collect();
        let equations =
            (0..500).map(|i| Equation { features: &features[i], gain: gain(i), error: errors[i] });
        let found = LinearPart::fit(n_tendons, n_features, equations)?;
        for (found, truth) in found.rows.iter().flatten().zip(truth.rows.iter().flatten()) {
            // The ridge takes 1e-4 of a weight whose term is one, and more where terms are small: squares of sines
            // have means of 1/4.
            assert!((found - truth).abs() < 4.0 * 10.0 * RIDGE * 1e-3, "{found} {truth}");
        }
        // In ranges of twice the width, about another middle, it is the same.
        let wide = truth.clone().for_ranges(&[[2.0, 0.5]; 6]);
        let halved = features[7].map(|x| (x - 0.5) / 2.0);
        let [same, expected] =
            [wide.displacement(&halved, &mut terms), truth.displacement(&features[7], &mut terms)];
        assert!(same.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-8), "{same:?} {expected:?}");
        let far = features[7].map(|feature| 3.0 * feature.signum());
        let end = features[7].map(f32::signum);
        assert_eq!(truth.displacement(&far, &mut terms), truth.displacement(&end, &mut terms));
        Ok(())
    }
}
