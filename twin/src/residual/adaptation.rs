//! A correction of the residual network, linear in the operators of hysteresis, estimated recursively from
//! the measured tip.
//!
//! The network stays, and the missing displacement of the tip that it predicts gets a correction Θ φ: φ holds
//! one, the stroke of every primary tendon and its plays. Θ is a slow random process around zero
//! (Ornstein-Uhlenbeck), so that data that does not recur loses its weight, and neither Θ nor its covariance
//! P can grow beyond their prior; a Kalman filter estimates it:
//!
//! ```text
//!     Θ ← a Θ,  P ← a² P + (1 - a²) P₀          a = exp(-Δt/τ)
//!     k = P φ / (r + φᵀ P φ),  Θ ← Θ + e kᵀ,  P ← P - k φᵀ P
//! ```
//!
//! with what the measured tip has from the twin's, less Θ φ, as e. The three axes share φ, hence P and k. One more
//! term of one, with a prior and a time of its own, is the drift of the tracker: it takes its part of e and is never
//! kept.

use hysteron_base::BadInput;
use nalgebra::{DMatrix, DVector};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::FeatureSpec;

/// How fast and how far the correction goes.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct AdaptOptions {
    /// Time constant τ of the data's weight, which falls to 1/e [s].
    pub memory_s: f64,
    /// Noise of the tip, and hysteresis that no correction models [m].
    pub noise_m: f64,
    /// Correlation time of that error [s].
    pub noise_time_s: f64,
    /// Prior deviation of the constant term [m].
    pub offset_m: f64,
    /// Prior deviation of what a millimetre of stroke or play does [-].
    pub gain: f64,
    /// Largest correction, along each axis [m].
    pub largest_m: f64,
    /// Deviation of the tracker's drift, along each axis [m].
    pub drift_m: f64,
    /// Time over which that stays what it is [s].
    pub drift_time_s: f64,
    /// Prior deviation of a tendon's zero [m].
    pub zero_m: f64,
    /// Prior deviation of the play [m].
    pub play_m: f64,
    /// Prior deviation of the factor on friction [-].
    pub friction_ratio: f64,
    /// Part of the error on test blocks by which more numbers must do better than fewer to be kept [-].
    pub least_gain: f64,
}

impl AdaptOptions {
    /// Refuses numbers that are not positive.
    ///
    /// # Errors
    /// `BadInput` naming one.
    pub(super) fn check(&self) -> Result<(), BadInput> {
        let positive = [
            ("memory_s", self.memory_s),
            ("noise_m", self.noise_m),
            ("noise_time_s", self.noise_time_s),
            ("offset_m", self.offset_m),
            ("gain", self.gain),
            ("largest_m", self.largest_m),
            ("drift_m", self.drift_m),
            ("drift_time_s", self.drift_time_s),
            ("zero_m", self.zero_m),
            ("play_m", self.play_m),
            ("friction_ratio", self.friction_ratio),
            ("least_gain", self.least_gain),
        ];
        match positive.iter().find(|(_, value)| !(*value > 0.0 && value.is_finite())) {
            Some((name, value)) => Err(BadInput::new(*name, "a finite number > 0", value.to_string())),
            None => Ok(()),
        }
    }
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
            // A tracker's distortion wanders by some tenths of a millimetre within minutes.
            drift_m: 2e-4,
            drift_time_s: 120.0,
            zero_m: 5e-4,
            play_m: 3e-4,
            friction_ratio: 0.5,
            least_gain: 0.1,
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

    /// On top of a correction that was there before.
    pub(super) fn added_to(&self, before: Option<&Self>) -> Self {
        before.map_or_else(|| self.clone(), |before| before.plus(self))
    }

    /// Both corrections together, within the bound of `other`.
    fn plus(&self, other: &Self) -> Self {
        let row = |c: usize| self.rows[c].iter().zip(&other.rows[c]).map(|(a, b)| a + b).collect();
        Self { rows: std::array::from_fn(row), largest_m: other.largest_m }
    }

    /// Whether it is of a network with these features.
    pub(super) fn fits(&self, spec: &FeatureSpec) -> bool {
        self.largest_m >= 0.0 && self.rows.iter().all(|row| row.len() == n_terms(spec))
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

/// The filter. Its last term is the tracker's drift.
#[derive(Debug, Clone)]
pub(super) struct AdaptationFilter {
    options: AdaptOptions,
    theta: Adaptation,
    /// P, and the diagonal of P₀.
    covariance: DMatrix<f64>,
    prior: DVector<f64>,
    /// By term: a; and r.
    kept: DVector<f64>,
    noise: f64,
}

impl AdaptationFilter {
    /// Knows nothing yet.
    pub fn new(spec: &FeatureSpec, options: AdaptOptions) -> Self {
        let n = n_terms(spec);
        let deviation = |term: usize| match term {
            0 => options.offset_m,
            _ if term == n => options.drift_m,
            _ => options.gain,
        };
        let prior = DVector::from_fn(n + 1, |term, _| deviation(term).powi(2));
        let time = |term: usize| if term == n { options.drift_time_s } else { options.memory_s };
        let rows = [(); 3].map(|()| vec![0.0; n + 1]);
        Self {
            theta: Adaptation { rows, largest_m: options.largest_m },
            covariance: DMatrix::from_diagonal(&prior),
            prior,
            kept: DVector::from_fn(n + 1, |term, _| (-spec.step_s / time(term)).exp()),
            // An error that stays for several samples is one measurement, not several.
            noise: options.noise_m.powi(2) * f64::max(options.noise_time_s / spec.step_s, 1.0),
            options,
        }
    }

    /// The correction found, without the drift.
    pub fn correction(&self) -> Adaptation {
        let mut found = self.theta.clone();
        found.rows.iter_mut().for_each(|row| row.truncate(self.kept.len() - 1));
        found
    }

    /// One sample: from the twin's tip to the measured one [m] where the terms were φ.
    pub fn update(&mut self, terms: &[f64], missed: [f64; 3]) {
        let terms = DVector::from_iterator(self.kept.len(), terms.iter().copied().chain([1.0]));
        let known = self.theta.displacement(terms.as_slice());
        let error: [f64; 3] = std::array::from_fn(|c| missed[c] - known[c]);
        self.covariance.column_iter_mut().zip(&self.kept).for_each(|(mut column, kept)| column *= *kept);
        self.covariance.row_iter_mut().zip(&self.kept).for_each(|(mut row, kept)| row *= *kept);
        for (k, prior) in self.prior.iter().enumerate() {
            self.covariance[(k, k)] += (1.0 - self.kept[k].powi(2)) * prior;
        }
        let spread = &self.covariance * &terms;
        let gain = &spread / (self.noise + terms.dot(&spread));
        for (row, error) in self.theta.rows.iter_mut().zip(error) {
            // What the correction cannot do, or what is no small error, is no reason to turn it upside down.
            let error = error.clamp(-self.options.largest_m, self.options.largest_m);
            for ((theta, gain), kept) in row.iter_mut().zip(&gain).zip(&self.kept) {
                *theta = kept * *theta + gain * error;
            }
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
        drift_m: 1e-9,
        drift_time_s: 120.0,
        zero_m: 5e-4,
        play_m: 3e-4,
        friction_ratio: 0.5,
        least_gain: 0.1,
    };

    fn spec() -> FeatureSpec {
        FeatureSpec { n_primary: 2, plays_m: vec![1e-3], filters_s: vec![1.0], feedback: false, step_s: 0.01 }
    }

    /// Errors that a constant correction explains, for `n` samples of random strokes.
    fn follow(filter: &mut AdaptationFilter, n: usize, of: &dyn Fn(&[f64]) -> [f64; 3]) -> Vec<[f64; 3]> {
        let mut stream = rng(1, "adaptation");
        let mut left = Vec::new();
        for _ in 0..n {
            let mut terms = vec![1.0];
            terms.extend((0..4).map(|_| stream.random_range(-5e-3..5e-3)));
            let (asked, given) = (of(&terms), filter.correction().displacement(&terms));
            filter.update(&terms, asked);
            left.push(std::array::from_fn(|c| asked[c] - given[c]));
        }
        left
    }

    #[test]
    fn a_correction_that_exists_is_found_within_a_minute() {
        let mut filter = AdaptationFilter::new(&spec(), OPEN);
        let of = |terms: &[f64]| [1e-3 + 0.1 * terms[1], -5e-4, 0.2 * terms[4] - 0.1 * terms[2]];
        let left = follow(&mut filter, 6000, &of);
        let rms = |part: &[[f64; 3]]| {
            (part.iter().flatten().map(|e| e * e).sum::<f64>() / (3 * part.len()) as f64).sqrt()
        };
        let (before, after) = (rms(&left[..20]), rms(&left[5000..]));
        // The ridge of the filter: r / (N E φ²) over the prior's variance, with 5000 samples of E φ² = (5 mm)²/3, r
        // = 50 (0.3 mm)² and 0.25: below 1e-3 of what there was; forgetting adds a 600th a second of what the prior
        // pulls.
        assert!(after < 2e-2 * before, "{before} {after}");
    }

    #[test]
    fn unobserved_changes_decay() {
        let options = AdaptOptions { memory_s: 10.0, ..OPEN };
        let mut filter = AdaptationFilter::new(&spec(), options);
        follow(&mut filter, 1000, &|_| [1e-3, 0.0, 0.0]);
        let learned = filter.correction().displacement(&[1.0, 0.0, 0.0, 0.0, 0.0])[0];
        assert!((learned / 1e-3 - 1.0).abs() < 0.1, "{learned}");
        // Samples without information: no terms at all.
        for _ in 0..1000 {
            filter.update(&[0.0; 5], [0.0; 3]);
        }
        let left = filter.correction().displacement(&[1.0, 0.0, 0.0, 0.0, 0.0])[0];
        assert!((left / learned - (-1.0f64).exp()).abs() < 1e-9, "{left} of {learned}");
    }

    #[test]
    fn neither_correction_nor_uncertainty_passes_its_bound() {
        let mut filter = AdaptationFilter::new(&spec(), OPEN);
        follow(&mut filter, 20_000, &|_| [1.0, -1.0, 1.0]);
        let given = filter.correction().displacement(&[1.0, 0.0, 0.0, 0.0, 0.0]);
        assert!(given.iter().all(|c| c.abs() <= OPEN.largest_m), "{given:?}");
        let within = (0..5).all(|k| {
            let variance = filter.covariance[(k, k)];
            variance > 0.0 && variance <= filter.prior[k] * (1.0 + 1e-12)
        });
        assert!(within, "{}", filter.covariance);
    }

    #[test]
    fn a_tracker_that_stands_elsewhere_is_no_change_of_the_robot() {
        // As likely a drift as an offset: half of it is either's; a drift ten times as likely takes all but a
        // hundredth.
        for (drift_m, part) in [(2e-3, 0.5), (2e-2, 0.01)] {
            let options = AdaptOptions { drift_m, drift_time_s: 1e6, memory_s: 1e6, ..OPEN };
            let mut filter = AdaptationFilter::new(&spec(), options);
            (0..2000).for_each(|_| filter.update(&[1.0, 0.0, 0.0, 0.0, 0.0], [3e-4, 0.0, 0.0]));
            let kept = filter.correction().displacement(&[1.0, 0.0, 0.0, 0.0, 0.0])[0];
            // The noise of 2000 samples, r = 50 (0.3 mm)², is some 1e-3 of either prior.
            assert!((kept / 3e-4 - part).abs() < 0.01, "{kept}");
        }
    }
}
