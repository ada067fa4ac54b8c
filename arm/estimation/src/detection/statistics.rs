//! Tests for contacts: a band, and cumulated sums.

use super::FreeMotion;

/// A number for each sample that exceeds 1 where a contact is detected.
pub trait Test {
    /// Takes external torques (n) [N m]; the larger the result, the surer the contact. Allocates nothing.
    fn update(&mut self, external: &[f64]) -> f64;

    /// The outermost joint whose own torque shows the contact: the link that it moves, or one farther out, was hit, for a contact
    /// loads no joint beyond its link.
    fn joint(&self) -> Option<usize>;

    /// Forgets all samples.
    fn reset(&mut self);
}

/// |τ_ext − mean| over a threshold, the largest of all joints.
#[derive(Debug, Clone, PartialEq)]
pub struct Band {
    mean: Vec<f64>,
    thresholds: Vec<f64>,
    ratios: Vec<f64>,
}

impl Band {
    /// Thresholds joint by joint, above 0 [N m].
    pub fn new(mean: &[f64], thresholds: &[f64]) -> Self {
        assert_eq!(mean.len(), thresholds.len());
        assert!(thresholds.iter().all(|t| *t > 0.0), "thresholds {thresholds:?}");
        let ratios = vec![0.0; mean.len()];
        Self { mean: mean.to_vec(), thresholds: thresholds.to_vec(), ratios }
    }

    /// `factor` times the largest that was seen without contact.
    pub fn learned(free: &FreeMotion, factor: f64) -> Self {
        let thresholds: Vec<f64> = free.largest.iter().map(|x| factor * x.max(f64::MIN_POSITIVE)).collect();
        Self::new(&free.mean, &thresholds)
    }
}

impl Test for Band {
    fn update(&mut self, external: &[f64]) -> f64 {
        for (j, ratio) in self.ratios.iter_mut().enumerate() {
            *ratio = (external[j] - self.mean[j]).abs() / self.thresholds[j];
        }
        largest(&self.ratios)
    }

    fn joint(&self) -> Option<usize> {
        outermost(&self.ratios)
    }

    fn reset(&mut self) {
        self.ratios.fill(0.0);
    }
}

/// Cumulated sums to both sides: S ← max(0, S ± (τ_ext − mean)/σ − slack), over a limit.
///
/// # Reference
/// Page (1954), Continuous inspection schemes.
#[derive(Debug, Clone, PartialEq)]
pub struct Cusum {
    free: FreeMotion,
    slack: f64,
    limits: Vec<f64>,
    sums: Vec<[f64; 2]>,
    ratios: Vec<f64>,
}

/// Sums stop here, so that they come down again after a contact.
const MAX_SUM: f64 = 2.0;

impl Cusum {
    /// `slack` in standard deviations: half of the smallest shift that matters. `limits` of the sums, joint by joint.
    pub fn new(free: FreeMotion, slack: f64, limits: &[f64]) -> Self {
        assert_eq!(free.mean.len(), limits.len());
        assert!(limits.iter().all(|h| *h > 0.0) && free.deviation.iter().all(|s| *s > 0.0), "{free:?}");
        let n = limits.len();
        Self { free, slack, limits: limits.to_vec(), sums: vec![[0.0; 2]; n], ratios: vec![0.0; n] }
    }

    /// Limits `factor` times the largest sums in rows (n_samples × n) without contact.
    pub fn learned(free: FreeMotion, slack: f64, rows: &[f64], factor: f64) -> Self {
        let n = free.mean.len();
        let mut unlimited = Self::new(free.clone(), slack, &vec![f64::MAX; n]);
        let mut limits = vec![f64::MIN_POSITIVE; n];
        for row in rows.chunks(n) {
            unlimited.update(row);
            for (limit, sums) in limits.iter_mut().zip(&unlimited.sums) {
                *limit = limit.max(sums[0]).max(sums[1]);
            }
        }
        limits.iter_mut().for_each(|limit| *limit *= factor);
        Self::new(free, slack, &limits)
    }
}

impl Test for Cusum {
    fn update(&mut self, external: &[f64]) -> f64 {
        for j in 0..self.limits.len() {
            let z = (external[j] - self.free.mean[j]) / self.free.deviation[j];
            let limit = self.limits[j];
            for (sum, z) in self.sums[j].iter_mut().zip([z, -z]) {
                *sum = (*sum + z - self.slack).clamp(0.0, MAX_SUM * limit);
            }
            self.ratios[j] = self.sums[j][0].max(self.sums[j][1]) / limit;
        }
        largest(&self.ratios)
    }

    fn joint(&self) -> Option<usize> {
        outermost(&self.ratios)
    }

    fn reset(&mut self) {
        self.sums.fill([0.0; 2]);
        self.ratios.fill(0.0);
    }
}

fn largest(ratios: &[f64]) -> f64 {
    ratios.iter().fold(0.0, |m, x| m.max(*x))
}

fn outermost(ratios: &[f64]) -> Option<usize> {
    ratios.iter().rposition(|ratio| *ratio > 1.0)
}
