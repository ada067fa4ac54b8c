//! Detection thresholds for external torques, from torque noise and from contact-free motion.

/// External torques of an arm without contact, joint by joint.
#[derive(Debug, Clone, PartialEq)]
pub struct FreeMotion {
    /// Mean [N m]: what the model errs by.
    pub mean: Vec<f64>,
    /// Standard deviation [N m].
    pub deviation: Vec<f64>,
    /// Largest distance from the mean [N m].
    pub largest: Vec<f64>,
}

impl FreeMotion {
    /// From rows of external torques (n_samples × n), at least one.
    pub fn learn(rows: &[f64], n: usize) -> Self {
        assert!(
            n > 0 && rows.len() >= n && rows.len().is_multiple_of(n),
            "{} numbers of {n} joints",
            rows.len()
        );
        let n_samples = (rows.len() / n) as f64;
        let column = |j: usize| rows.iter().skip(j).step_by(n);
        let mean: Vec<f64> = (0..n).map(|j| column(j).sum::<f64>() / n_samples).collect();
        let deviation =
            (0..n).map(|j| (column(j).map(|x| (x - mean[j]).powi(2)).sum::<f64>() / n_samples).sqrt());
        let largest = (0..n).map(|j| column(j).fold(0.0, |m: f64, x| m.max((x - mean[j]).abs())));
        Self { deviation: deviation.collect(), largest: largest.collect(), mean: mean.clone() }
    }
}

/// An alarm with hysteresis: on above 1, off again below `release`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Alarm {
    release: f64,
    is_on: bool,
}

impl Alarm {
    /// Off, `release` from 0 to 1.
    pub fn new(release: f64) -> Self {
        assert!((0.0..=1.0).contains(&release), "release {release}");
        Self { release, is_on: false }
    }

    /// Takes the next value of a test; true while the alarm is on.
    pub fn update(&mut self, value: f64) -> bool {
        self.is_on = value > if self.is_on { self.release } else { 1.0 };
        self.is_on
    }
}
