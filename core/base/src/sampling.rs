//! How evenly a recording was sampled.

/// Metadata: scatter of the steps of a file that was resampled [-].
pub const STEP_SCATTER: &str = "step_scatter_ratio";
/// A step longer than this many medians is late: a sample is missing [-].
const LATE: f64 = 1.5;

/// Steps between the samples of a recording, one or more.
#[derive(Debug, Clone)]
pub struct SampleSteps {
    /// In ascending order [s].
    ascending: Vec<f64>,
}

impl SampleSteps {
    /// Those between these times; `None` for fewer than two.
    pub fn of(times: &[f64]) -> Option<Self> {
        let mut ascending: Vec<f64> = times.windows(2).map(|pair| pair[1] - pair[0]).collect();
        ascending.sort_by(f64::total_cmp);
        (!ascending.is_empty()).then_some(Self { ascending })
    }

    /// The median [s].
    pub fn median(&self) -> f64 {
        self.ascending[self.ascending.len() / 2]
    }

    /// Part of them that is longer than `limit` [s].
    pub fn longer_than(&self, limit: f64) -> f64 {
        let n = self.ascending.len();
        (n - self.ascending.partition_point(|step| *step <= limit)) as f64 / n as f64
    }

    /// Mean distance from the median, over it, of those that are not late [-].
    pub fn scatter(&self) -> f64 {
        let median = self.median();
        let own = &self.ascending[..self.ascending.partition_point(|step| *step <= LATE * median)];
        own.iter().map(|step| (step / median - 1.0).abs()).sum::<f64>() / own.len() as f64
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)] // a test may stop where it stands
    use super::*;

    #[test]
    fn a_late_step_counts_as_late_and_not_as_scatter() {
        let steps = SampleSteps::of(&[0.0, 1.0, 1.8, 2.8, 4.0, 9.0, 10.0]).unwrap();
        assert_eq!(steps.median(), 1.0);
        assert!((steps.longer_than(1.5) - 1.0 / 6.0).abs() < 1e-12);
        assert!((steps.scatter() - 0.4 / 5.0).abs() < 1e-12);
        assert!(SampleSteps::of(&[1.0]).is_none());
    }
}
