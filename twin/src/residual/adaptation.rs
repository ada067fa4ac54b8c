//! A residual network that goes on learning: a few parameters, found recursively from the tip as it is measured.
//!
//! A robot changes: a tendon is tensioned anew, friction grows, a tool is put on. The network stays, and the displacement of
//! the tip that it says is missing gets a correction Θ φ, linear in what hysteresis is made of: φ holds one, the stroke of
//! every primary tendon and its plays. Θ is a slow random process around zero (Ornstein-Uhlenbeck), so that what is not seen
//! again is forgotten, and neither Θ nor its covariance P can grow beyond their prior; a Kalman filter follows it:
//!
//! ```text
//!     Θ ← a Θ,  P ← a² P + (1 - a²) P₀          a = exp(-Δt/τ)
//!     k = P φ / (r + φᵀ P φ),  Θ ← Θ + e kᵀ,  P ← P - k φᵀ P
//! ```
//!
//! with what the measured tip has from the twin's, less Θ φ, as e. The three axes share φ, hence P and k. The twin goes on
//! with the correction that it had: with friction, a correction that is still being found would move its tip by less than it
//! says, or later, and be driven on.

use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};

use super::FeatureSpec;

/// How fast and how far the correction goes.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct AdaptOptions {
    /// Time τ after which what was seen counts 1/e [s].
    pub memory_s: f64,
    /// Error of the tip that says nothing, noise and hysteresis that no correction has [m].
    pub noise_m: f64,
    /// Time over which that error stays what it is [s].
    pub noise_time_s: f64,
    /// Prior deviation of the constant term [m].
    pub offset_m: f64,
    /// Prior deviation of what a millimetre of stroke or play does [-].
    pub gain: f64,
    /// Largest correction, along each axis [m].
    pub largest_m: f64,
}

impl Default for AdaptOptions {
    fn default() -> Self {
        Self {
            memory_s: 600.0,
            noise_m: 5e-4,
            noise_time_s: 2.0,
            offset_m: 1e-3,
            gain: 0.05,
            largest_m: 8e-3,
        }
    }
}

/// The correction Θ of a network's displacements.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Adaptation {
    /// Θ: by axis, then by term [m for the first, - for the others].
    rows: [Vec<f64>; 3],
    /// Largest correction, along each axis [m].
    largest_m: f64,
}

impl Adaptation {
    /// The correction for terms φ [m].
    pub(super) fn displacement(&self, terms: &[f64]) -> [f64; 3] {
        self.rows.each_ref().map(|row| {
            let sum: f64 = row.iter().zip(terms).map(|(theta, term)| theta * term).sum();
            sum.clamp(-self.largest_m, self.largest_m)
        })
    }

    fn zero(spec: &FeatureSpec, largest_m: f64) -> Self {
        Self { rows: [(); 3].map(|()| vec![0.0; n_terms(spec)]), largest_m }
    }

    /// Both corrections together, within the bound of `other`.
    fn plus(&self, other: &Self) -> Self {
        let row = |c: usize| self.rows[c].iter().zip(&other.rows[c]).map(|(a, b)| a + b).collect();
        Self { rows: std::array::from_fn(row), largest_m: other.largest_m }
    }

    /// Whether it is of a network with these features.
    pub(super) fn fits(&self, spec: &FeatureSpec) -> bool {
        self.rows.iter().all(|row| row.len() == n_terms(spec))
    }
}

/// Number of terms φ.
fn n_terms(spec: &FeatureSpec) -> usize {
    1 + spec.n_primary * (1 + spec.plays_m.len())
}

/// Picks φ out of the features of the strokes.
pub(super) fn terms_into(spec: &FeatureSpec, features: &[f64], terms: &mut Vec<f64>) {
    terms.clear();
    terms.push(1.0);
    let (n_plays, per_tendon) = (spec.plays_m.len(), spec.n_of_strokes() / spec.n_primary);
    for of_tendon in features.chunks_exact(per_tendon).take(spec.n_primary) {
        terms.push(of_tendon[0]);
        terms.extend_from_slice(&of_tendon[2..2 + n_plays]);
    }
}

/// The filter.
#[derive(Debug, Clone)]
pub(super) struct Filter {
    options: AdaptOptions,
    theta: Adaptation,
    /// P, and the diagonal of P₀.
    covariance: DMatrix<f64>,
    prior: DVector<f64>,
    /// a² and r.
    kept: f64,
    noise: f64,
}

impl Filter {
    /// Knows nothing yet.
    pub fn new(spec: &FeatureSpec, options: AdaptOptions) -> Self {
        let n = n_terms(spec);
        let deviation = |term: usize| if term == 0 { options.offset_m } else { options.gain };
        let prior = DVector::from_fn(n, |term, _| deviation(term).powi(2));
        Self {
            theta: Adaptation::zero(spec, options.largest_m),
            covariance: DMatrix::from_diagonal(&prior),
            prior,
            kept: (-2.0 * spec.step_s / options.memory_s).exp(),
            // An error that stays for several samples is one measurement, not several.
            noise: options.noise_m.powi(2) * f64::max(options.noise_time_s / spec.step_s, 1.0),
            options,
        }
    }

    /// What was found, on top of the correction that the twin had.
    pub fn added_to(&self, before: Option<&Adaptation>) -> Adaptation {
        before.map_or_else(|| self.theta.clone(), |before| before.plus(&self.theta))
    }

    /// One sample: from the twin's tip to the measured one [m] where the terms were φ.
    pub fn update(&mut self, terms: &[f64], missed: [f64; 3]) {
        let known = self.theta.displacement(terms);
        let error: [f64; 3] = std::array::from_fn(|c| missed[c] - known[c]);
        self.covariance *= self.kept;
        for (k, prior) in self.prior.iter().enumerate() {
            self.covariance[(k, k)] += (1.0 - self.kept) * prior;
        }
        let forgets = self.kept.sqrt();
        let terms = DVector::from_column_slice(terms);
        let spread = &self.covariance * &terms;
        let gain = &spread / (self.noise + terms.dot(&spread));
        for (row, error) in self.theta.rows.iter_mut().zip(error) {
            // What the correction cannot do, or what is no small error, is no reason to turn it upside down.
            let error = error.clamp(-self.options.largest_m, self.options.largest_m);
            row.iter_mut().zip(&gain).for_each(|(theta, gain)| *theta = forgets * *theta + gain * error);
        }
        self.covariance -= gain * spread.transpose();
        // Rounding must not make it lose its symmetry.
        self.covariance = 0.5 * (&self.covariance + self.covariance.transpose());
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use hysteron_base::rng;
    use rand::RngExt;

    /// Sure of what is measured, and open to much.
    const OPEN: AdaptOptions = AdaptOptions {
        memory_s: 600.0,
        noise_m: 3e-4,
        noise_time_s: 0.5,
        offset_m: 2e-3,
        gain: 0.5,
        largest_m: 8e-3,
    };

    fn spec() -> FeatureSpec {
        FeatureSpec { n_primary: 2, plays_m: vec![1e-3], lags_s: vec![1.0], feedback: false, step_s: 0.01 }
    }

    /// Errors that a constant correction explains, for `n` samples of random strokes.
    fn follow(filter: &mut Filter, n: usize, of: &dyn Fn(&[f64]) -> [f64; 3]) -> Vec<[f64; 3]> {
        let mut stream = rng(1, "adaptation");
        let mut left = Vec::new();
        for _ in 0..n {
            let mut terms = vec![1.0];
            terms.extend((0..4).map(|_| stream.random_range(-5e-3..5e-3)));
            let (asked, given) = (of(&terms), filter.theta.displacement(&terms));
            filter.update(&terms, asked);
            left.push(std::array::from_fn(|c| asked[c] - given[c]));
        }
        left
    }

    #[test]
    fn a_correction_that_exists_is_found_within_a_minute() {
        let mut filter = Filter::new(&spec(), OPEN);
        let of = |terms: &[f64]| [1e-3 + 0.1 * terms[1], -5e-4, 0.2 * terms[4] - 0.1 * terms[2]];
        let left = follow(&mut filter, 6000, &of);
        let rms = |part: &[[f64; 3]]| {
            (part.iter().flatten().map(|e| e * e).sum::<f64>() / (3 * part.len()) as f64).sqrt()
        };
        let (before, after) = (rms(&left[..20]), rms(&left[5000..]));
        // The ridge of the filter: r / (N E φ²) over the prior's variance, with 5000 samples of E φ² = (5 mm)²/3, r = 50
        // (0.3 mm)² and 0.25: below 1e-3 of what there was; forgetting adds a 600th a second of what the prior pulls.
        assert!(after < 2e-2 * before, "{before} {after}");
    }

    #[test]
    fn what_is_not_seen_again_is_forgotten() {
        let options = AdaptOptions { memory_s: 10.0, ..OPEN };
        let mut filter = Filter::new(&spec(), options);
        follow(&mut filter, 1000, &|_| [1e-3, 0.0, 0.0]);
        let learned = filter.theta.displacement(&[1.0, 0.0, 0.0, 0.0, 0.0])[0];
        assert!((learned / 1e-3 - 1.0).abs() < 0.1, "{learned}");
        // Samples that tell nothing: no terms at all.
        for _ in 0..1000 {
            filter.update(&[0.0; 5], [0.0; 3]);
        }
        let left = filter.theta.displacement(&[1.0, 0.0, 0.0, 0.0, 0.0])[0];
        assert!((left / learned - (-1.0f64).exp()).abs() < 1e-9, "{left} of {learned}");
    }

    #[test]
    fn neither_correction_nor_uncertainty_passes_its_bound() {
        let mut filter = Filter::new(&spec(), OPEN);
        follow(&mut filter, 20_000, &|_| [1.0, -1.0, 1.0]);
        let given = filter.theta.displacement(&[1.0, 0.0, 0.0, 0.0, 0.0]);
        assert!(given.iter().all(|c| c.abs() <= OPEN.largest_m), "{given:?}");
        let within = (0..5).all(|k| {
            let variance = filter.covariance[(k, k)];
            variance > 0.0 && variance <= filter.prior[k] * (1.0 + 1e-12)
        });
        assert!(within, "{}", filter.covariance);
    }
}
