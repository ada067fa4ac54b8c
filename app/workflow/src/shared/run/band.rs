//! The band about the tip of a run with a residual network.

use hysteron_base::Recording;
use hysteron_base::statistics::nearest_quantile;
use hysteron_twin::residual::TipBand;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Channel of the radius [m].
pub const TIP_BAND: &str = "tip_band_m";

/// Where the robot's own tip is expected: the band about the tip of the twin, as wide as the error on recordings that were left out
/// in learning, and wider where an input of the network lies outside its training range.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct TipBandSummary {
    /// Part of the samples that the band is to hold [-].
    pub level: f64,
    /// Recordings that it is calibrated on.
    pub recordings: usize,
    /// Radius about the tip, median [m].
    pub radius_median_m: f64,
    /// Largest radius [m].
    pub radius_max_m: f64,
    /// Part of the measured samples that it holds, where the tip was measured [-].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub held: Option<f64>,
}

impl TipBandSummary {
    /// Of a recording with `measured` tips [m], x, y and z, but for those of a `gap`; none where it has no band.
    pub(super) fn new(
        band: &TipBand,
        recording: &Recording,
        measured: Option<[&[f64]; 3]>,
        gap: &[bool],
    ) -> Option<Self> {
        let radii = recording.channel(TIP_BAND)?;
        let is_held = |(tip, measured): ([&[f64]; 3], [&[f64]; 3])| -> Option<f64> {
            let distance =
                |i: usize| (0..3).map(|c| (tip[c][i] - measured[c][i]).powi(2)).sum::<f64>().sqrt();
            let samples: Vec<usize> = (0..radii.len()).filter(|&i| !gap[i]).collect();
            let held = samples.iter().filter(|&&i| distance(i) <= radii[i]).count();
            (!samples.is_empty()).then(|| held as f64 / samples.len() as f64)
        };
        Some(Self {
            level: band.level,
            recordings: band.recordings,
            radius_median_m: nearest_quantile(&mut radii.to_vec(), 0.5)?,
            radius_max_m: radii.iter().copied().fold(0.0, f64::max),
            held: recording.tip().zip(measured).and_then(is_held),
        })
    }

    /// In a sentence.
    pub(super) fn sentence(&self) -> String {
        let expected = expected_within(self.level, self.radius_median_m);
        let most = 1e3 * self.radius_max_m;
        let held = self
            .held
            .map_or(String::new(), |part| format!("; that holds {:.1} % of the measured tip", 100.0 * part));
        format!(
            "{expected} (at most {most:.2} mm), by {} recordings left out in learning{held}",
            self.recordings
        )
    }
}

/// How near the robot's tip is expected.
pub fn expected_within(level: f64, radius_m: f64) -> String {
    format!(
        "The robot's tip is expected within {:.2} mm of the twin's in {:.0} % of the samples",
        1e3 * radius_m,
        100.0 * level
    )
}
