//! The outcome of `fit-residual`.

use hysteron_base::checks::Warning;
use hysteron_base::number::digits;
use hysteron_learn::{FitReport, mean};
use hysteron_report::verdict::{Criterion, Verdict};
use hysteron_twin::residual::{ResidualPart, ResidualTraining, TrainedMember};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::shared::outcome::MetricsFormat;
use crate::shared::recording_checks::Findings;
use crate::shared::training;
use crate::{COMMIT, Context};

/// The outcome of `fit-residual`.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct Outcome {
    /// Format of the file.
    pub format: MetricsFormat,
    /// Its version.
    pub version: u32,
    /// Whether the networks can be used.
    pub verdict: Verdict,
    /// Learning curve, and errors in validation next to those of the baselines: one entry per network.
    pub networks: Vec<FitReport>,
    /// Where a network does no better than a baseline.
    pub warnings: Vec<String>,
    /// Warnings about the recordings.
    #[serde(default)]
    pub recording_warnings: Vec<Warning>,
    /// Data and options, as the checkpoint holds them.
    pub training: ResidualTraining,
    /// The command that made this.
    pub command: String,
    /// Commit of the program.
    pub commit: String,
}

impl crate::shared::outcome::Outcome for Outcome {
    fn verdict(&self) -> Option<&Verdict> {
        Some(&self.verdict)
    }
}

impl Outcome {
    pub(super) fn new(
        networks: Vec<FitReport>,
        described: ResidualTraining,
        findings: &Findings,
        context: &Context,
    ) -> Self {
        let mut kept = kept(&networks, &described);
        // Networks of folds are of one method; others are members of a mean.
        if described.networks_of_all.is_some() && !kept.is_empty() {
            kept = vec![FitReport::pooled(&kept)];
        }
        Self {
            format: MetricsFormat,
            version: 1,
            verdict: verdict(&networks, &kept),
            warnings: [left_out(&described), training::losses(&kept)].concat(),
            networks,
            recording_warnings: findings.warnings().to_vec(),
            training: described,
            command: context.command.clone(),
            commit: COMMIT.to_owned(),
        }
    }
}

/// The reports of the networks in the mean, up to the part that is in the model.
fn kept(networks: &[FitReport], described: &ResidualTraining) -> Vec<FitReport> {
    let Some(part) = described.part else { return networks.to_vec() };
    let members = networks.iter().zip(&described.members).filter(|(_, member)| member.is_kept);
    members.map(|(report, _)| report.up_to(part.name())).collect()
}

fn verdict(networks: &[FitReport], kept: &[FitReport]) -> Verdict {
    if !kept.is_empty() {
        return training::verdict(kept);
    }
    let twin = networks.iter().map(|report| report.together()[0]).collect::<Vec<_>>();
    let claim = format!(
        "the twin alone is off by {} mm, and nothing that was learned does better on recordings that it did not learn from",
        digits(mean(&twin))
    );
    Verdict::on(claim)
        .because(Criterion::ErrorOverBaseline, 1.0, "the checkpoint changes nothing of the twin".to_owned())
        .verdict()
}

/// Sentences that name what is left out of the model.
fn left_out(described: &ResidualTraining) -> Vec<String> {
    let part = match described.part {
        Some(ResidualPart::Linear) => {
            Some("the networks gain nothing in validation: the linear part is kept")
        }
        Some(ResidualPart::Nothing) => {
            Some("nothing that was learned gains in validation: the twin is kept as it is")
        }
        Some(ResidualPart::Network) | None => None,
    };
    let is_out = |member: &TrainedMember| !member.is_kept && described.part != Some(ResidualPart::Nothing);
    let out = described.members.iter().enumerate().filter(|(_, member)| is_out(member));
    let sentence = |(k, _): (usize, &TrainedMember)| {
        format!(
            "network {} is left out of the mean: in validation it is no better than the twin alone",
            k + 1
        )
    };
    part.into_iter().map(str::to_owned).chain(out.map(sentence)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use hysteron_learn::ChannelErrors;
    use hysteron_report::verdict::Usability;

    #[test]
    fn what_gains_nothing_is_named_and_decides_nothing() {
        let report = |errors: [f64; 3]| FitReport {
            unit: "mm".into(),
            methods: ["twin alone", "linear part alone", "network"].map(str::to_owned).to_vec(),
            channels: vec![ChannelErrors { name: "tip x".to_owned(), errors: errors.to_vec() }],
            ..FitReport::default()
        };
        let member =
            |is_kept| TrainedMember { held_out: Vec::new(), held_out_rmse_mm: 1.0, epochs: 1, is_kept };
        let of = |part, is_kept: [bool; 2]| ResidualTraining {
            part: Some(part),
            members: is_kept.map(member).to_vec(),
            ..ResidualTraining::default()
        };
        let networks = [report([1.0, 0.9, 0.4]), report([1.0, 0.9, 1.3])];
        let one = of(ResidualPart::Network, [true, false]);
        assert!(left_out(&one)[0].contains("network 2 is left out"));
        let kept_one = kept(&networks, &one);
        let found = verdict(&networks, &kept_one);
        assert!(found.sentence.contains("the network is off by 0.400 mm"), "{}", found.sentence);
        let linear = of(ResidualPart::Linear, [true, true]);
        let found = verdict(&networks, &kept(&networks, &linear));
        assert!(found.sentence.contains("the linear part alone is off by 0.900 mm"), "{}", found.sentence);
        let nothing = of(ResidualPart::Nothing, [false, false]);
        let found = verdict(&networks, &kept(&networks, &nothing));
        assert!(
            found.usability != Usability::Usable
                && found.sentence.contains("the twin alone is off by 1.00 mm")
        );
        assert_eq!(left_out(&nothing).len(), 1);
    }
}
