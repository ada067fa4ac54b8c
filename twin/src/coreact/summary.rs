//! Summary of an identification.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::problem::Bound;
use hysteron_fit::qp::QpStatus;

/// Distribution of a distance.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
pub struct DistanceSummary {
    /// Root of the mean square [m].
    pub rms_m: f64,
    /// Median [m].
    pub median_m: f64,
    /// 99th percentile [m].
    pub p99_m: f64,
    /// Largest [m].
    pub max_m: f64,
}

impl DistanceSummary {
    /// Of these distances [m]; zeros where there is none.
    pub fn of(mut distances: Vec<f64>) -> Self {
        if distances.is_empty() {
            return Self::default();
        }
        distances.sort_by(f64::total_cmp);
        let n = distances.len();
        let at = |part: f64| distances[((n - 1) as f64 * part).round() as usize];
        Self {
            rms_m: (distances.iter().map(|d| d * d).sum::<f64>() / n as f64).sqrt(),
            median_m: at(0.5),
            p99_m: at(0.99),
            max_m: at(1.0),
        }
    }
}

/// Counts of an identification.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
pub struct IdentificationSummary {
    /// Samples in all.
    pub samples: usize,
    /// Samples whose tip had been filled in: strokes were held there.
    pub gaps: usize,
    /// QPs solved, almost solved, infeasible and failed; only those solved were used.
    pub qps: [usize; 4],
    /// Distance of the tip from the measured one without auxiliary tendons.
    pub before: DistanceSummary,
    /// And with them.
    pub after: DistanceSummary,
    /// Samples in which at least one stroke was at this bound: lower, upper, rate.
    pub samples_at_bound: [usize; 3],
    /// The same for strokes, of all strokes in all samples [-].
    pub share_at_bound: [f64; 3],
    /// Samples in which a chain was bent further than it was validated.
    #[serde(default)]
    pub samples_outside_validation: usize,
}

impl IdentificationSummary {
    pub(super) fn count_status(&mut self, status: QpStatus) {
        self.qps[match status {
            QpStatus::Solved => 0,
            QpStatus::AlmostSolved => 1,
            QpStatus::Infeasible => 2,
            QpStatus::Failed => 3,
        }] += 1;
    }

    pub(super) fn count_bounds(&mut self, bounds: &[Option<Bound>]) {
        for (k, kind) in [Bound::Lower, Bound::Upper, Bound::Rate].into_iter().enumerate() {
            let n = bounds.iter().filter(|bound| **bound == Some(kind)).count();
            self.samples_at_bound[k] += usize::from(n > 0);
            self.share_at_bound[k] += n as f64;
        }
    }
}
