//! Which parts of a residual model are kept: those that gain on recordings which no network learned from.

use hysteron_learn::{FitReport, simplest_within};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Parts of a residual model, from the fewest numbers to the most.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ResidualPart {
    /// The twin alone.
    Nothing,
    /// The linear part.
    Linear,
    /// The linear part, and the network on what it leaves.
    Network,
}

/// Part by which errors of two parts differ by chance [-]: below it the one with fewer numbers is kept.
const SAME: f64 = 0.02;

impl ResidualPart {
    pub(super) const ALL: [Self; 3] = [Self::Nothing, Self::Linear, Self::Network];

    /// Its name, as a method of a [`FitReport`].
    pub fn name(self) -> &'static str {
        match self {
            Self::Nothing => "twin alone",
            Self::Linear => "linear part alone",
            Self::Network => "network",
        }
    }

    /// The simplest whose error, root mean square over the validation of all members, is within [`SAME`] of the least.
    pub(super) fn best(reports: &[FitReport]) -> Self {
        simplest_within(SAME, &FitReport::pooled(reports).together()).map_or(Self::Nothing, |k| Self::ALL[k])
    }

    /// Whether this part of a member does better than the twin alone on what the member did not learn from.
    pub(super) fn gains(self, report: &FitReport) -> bool {
        report.together()[self as usize] < report.together()[0]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use hysteron_learn::ChannelErrors;

    #[test]
    fn a_part_is_kept_where_it_gains_on_what_no_network_saw() {
        let report = |errors: [f64; 3]| FitReport {
            methods: ResidualPart::ALL.map(|part| part.name().to_owned()).to_vec(),
            channels: vec![ChannelErrors { name: "tip x".to_owned(), errors: errors.to_vec() }],
            ..FitReport::default()
        };
        let best = |errors: [[f64; 3]; 2]| ResidualPart::best(&errors.map(report));
        assert_eq!(best([[1.0, 0.8, 0.5], [1.0, 0.8, 0.6]]), ResidualPart::Network);
        // A network that is better by less than chance makes.
        assert_eq!(best([[1.0, 0.6, 0.595], [1.0, 0.6, 0.595]]), ResidualPart::Linear);
        // One that is much worse outweighs one that is a little better.
        assert_eq!(best([[1.0, 1.1, 0.9], [1.0, 1.1, 2.0]]), ResidualPart::Nothing);
        assert!(ResidualPart::Network.gains(&report([1.0, 1.1, 0.9])));
        assert!(!ResidualPart::Network.gains(&report([1.0, 0.5, 1.01])));
        assert!(!ResidualPart::Nothing.gains(&report([1.0, 0.5, 0.4])));
    }
}
