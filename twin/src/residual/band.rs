//! How far the tip may be off: a band calibrated on recordings that no network learned from.
//!
//! Samples of a recording resemble each other, so each recording counts as one, however long it is, and the band is made for a
//! sample drawn from another recording.
//!
//! # Reference
//! Dunn, Wasserman, Ramdas (2023), Distribution-free prediction sets for two-layer hierarchical models, section 3.1 (pooled
//! distributions), without the mass that makes a band of fewer than ten recordings infinite.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::ResidualPart;

/// Distances of the true tip from the predicted one that are exceeded in few samples.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct TipBand {
    /// Part of the samples within [-].
    pub level: f64,
    /// Radius of the band [mm].
    pub radius_mm: f64,
    /// The same of the twin alone [mm].
    pub alone_mm: f64,
    /// Recordings that were left out in turn.
    pub recordings: usize,
}

/// Distances of the tip on a recording that a network did not learn from, sample by sample, by [`ResidualPart`] [mm].
pub(super) type LeftOut = [Vec<f64>; ResidualPart::ALL.len()];

impl TipBand {
    /// Part of the samples that a band is to hold [-].
    pub const LEVEL: f64 = 0.9;

    /// The band of a twin with a part of a residual model; none without a sample.
    pub(super) fn new(part: ResidualPart, left_out: &[&LeftOut]) -> Option<Self> {
        let of = |part: ResidualPart| quantile(left_out.iter().map(|one| one[part as usize].as_slice()));
        Some(Self {
            level: Self::LEVEL,
            radius_mm: of(part)?,
            alone_mm: of(ResidualPart::Nothing)?,
            recordings: left_out.len(),
        })
    }

    /// Radius [m] where an input lies so many half-widths of its range beyond it: what was learned is not known to hold there, so
    /// that for each of them the band grows by that of the twin alone.
    pub fn radius(&self, beyond: f64) -> f64 {
        1e-3 * (self.radius_mm + beyond * self.alone_mm)
    }
}

/// The value that [`TipBand::LEVEL`] of the samples do not exceed, where all groups weigh the same.
fn quantile<'a>(groups: impl Iterator<Item = &'a [f64]>) -> Option<f64> {
    let weighted = |group: &'a [f64]| group.iter().map(|value| (*value, 1.0 / group.len() as f64));
    let mut values: Vec<(f64, f64)> = groups.flat_map(weighted).collect();
    values.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut left = TipBand::LEVEL * values.iter().map(|(_, weight)| weight).sum::<f64>();
    values.into_iter().find_map(|(value, weight)| {
        left -= weight;
        // Weights that add up to a whole number do so to rounding.
        (left <= 1e-9).then_some(value)
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)] // a test may stop where it stands
    use super::*;

    fn uniform(n: usize, scale: f64) -> Vec<f64> {
        (1..=n).map(|i| scale * i as f64 / n as f64).collect()
    }

    #[test]
    fn a_long_recording_counts_as_a_short_one() {
        // Of distances that are even from 0 to 1 and from 0 to 3, 90 % lie below x with (min(x, 1) + x / 3) / 2 = 0.9: x = 2.4.
        let left_out =
            [(100, 1.0), (10_000, 3.0)].map(|(n, scale)| [uniform(n, 10.0), Vec::new(), uniform(n, scale)]);
        let band = TipBand::new(ResidualPart::Network, &left_out.iter().collect::<Vec<_>>()).unwrap();
        assert!((band.radius_mm - 2.4).abs() < 1e-3 && (band.alone_mm - 9.0).abs() < 1e-9, "{band:?}");
        assert!((band.radius(0.0) - 2.4e-3).abs() < 1e-6 && (band.radius(0.5) - 6.9e-3).abs() < 1e-6);
    }

    #[test]
    fn without_a_sample_there_is_no_band() {
        assert_eq!(TipBand::new(ResidualPart::Network, &[]), None);
        let nothing = [const { Vec::new() }; 3];
        assert_eq!(TipBand::new(ResidualPart::Network, &[&nothing]), None);
    }
}
