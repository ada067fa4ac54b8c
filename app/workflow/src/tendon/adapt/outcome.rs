//! The outcome of `adapt`.

use hysteron_base::checks::Warning;
use hysteron_report::verdict::{Criterion, Verdict};
use hysteron_twin::residual::{AdaptOptions, Adapted, AdaptedParts, MotionErrors};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::shared::outcome::MetricsFormat;
use crate::shared::recording_checks::Findings;
use crate::shared::verdict;
use crate::{COMMIT, Context};

/// The outcome of `adapt`.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct Outcome {
    /// Format of the file.
    pub format: MetricsFormat,
    /// Its version.
    pub version: u32,
    /// Whether the adapted twin can be used.
    pub verdict: Verdict,
    /// Parts of the adaptation that are kept.
    pub kept: AdaptedParts,
    /// By what would be kept: the root mean square distance of the tip on all blocks while each was held out.
    pub held_out: Vec<HeldOutError>,
    /// Error of the twin on the robot as it was [m]: along the recordings of `--reference`, or else of the networks in validation.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub known_error_m: Option<f64>,
    /// Blocks of the recordings that were held out in turn.
    pub blocks: Vec<AdaptationBlock>,
    /// Beyond what the checkpoint had; in the checkpoint only if listed in `kept`.
    pub found: FoundChange,
    /// Errors along the recordings.
    pub recordings: Vec<MotionErrors>,
    /// Options of the adaptation.
    pub options: AdaptOptions,
    /// Warnings about the recordings.
    #[serde(default)]
    pub recording_warnings: Vec<Warning>,
    /// The command that made this.
    pub command: String,
    /// Commit of the program.
    pub commit: String,
}

/// Error on blocks that were held out.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct HeldOutError {
    /// Parts that would be kept.
    pub kept: AdaptedParts,
    /// Root mean square distance of the tip [m].
    pub rms_m: f64,
}

/// A block of a recording.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct AdaptationBlock {
    /// Name of the recording.
    pub recording: String,
    /// First and last time [s].
    pub time_s: [f64; 2],
}

/// A change of the robot that was found.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct FoundChange {
    /// Zeros of the tendons [m].
    pub zeros_m: Vec<f64>,
    /// Backlash that was added [m].
    pub play_m: f64,
    /// Friction over that before [-].
    pub friction_ratio: f64,
    /// Weight of the prior, chosen on the blocks that were held out [-].
    pub prior_weight: f64,
}

impl crate::shared::outcome::Outcome for Outcome {
    fn verdict(&self) -> Option<&Verdict> {
        Some(&self.verdict)
    }
}

impl Outcome {
    pub(super) fn new(
        adapted: &Adapted,
        options: &AdaptOptions,
        findings: &Findings,
        context: &Context,
    ) -> Self {
        let held_out = adapted.held_out_m.iter().map(|&(kept, rms_m)| HeldOutError { kept, rms_m });
        let blocks = adapted.blocks.iter();
        let blocks = blocks.map(|(name, time)| AdaptationBlock { recording: name.clone(), time_s: *time });
        Self {
            format: MetricsFormat,
            version: 1,
            verdict: assess(adapted, options),
            kept: adapted.kept,
            held_out: held_out.collect(),
            known_error_m: adapted.known_error_m,
            blocks: blocks.collect(),
            found: FoundChange {
                zeros_m: adapted.found.zeros_m.clone(),
                play_m: adapted.found.play_m,
                friction_ratio: adapted.found.friction_ratio,
                prior_weight: adapted.prior_weight,
            },
            recordings: adapted.motions.clone(),
            options: *options,
            recording_warnings: findings.warnings().to_vec(),
            command: context.command.clone(),
            commit: COMMIT.to_owned(),
        }
    }
}

/// Whether what was kept does better, on blocks that were held out, than the twin as it was.
fn assess(adapted: &Adapted, options: &AdaptOptions) -> Verdict {
    let held_out = |parts: AdaptedParts| {
        adapted.held_out_m.iter().find(|(kept, _)| *kept == parts).map_or(f64::NAN, |(_, rms)| *rms)
    };
    let (before, after) = (held_out(AdaptedParts::Nothing), held_out(adapted.kept));
    let mm = |m: f64| format!("{:.3} mm", 1e3 * m);
    let statement = match adapted.kept {
        AdaptedParts::Nothing
            if adapted.known_error_m.is_some_and(|known| before <= (1.0 + options.least_gain) * known) =>
        {
            format!(
                "the present twin is off by {}, no more than on the robot as it was: no change is to be seen, and it is kept",
                mm(before)
            )
        }
        AdaptedParts::Nothing => {
            format!(
                "no change explains the recordings better than the present twin ({}), which is kept",
                mm(before)
            )
        }
        kept => format!(
            "on blocks that were held out, the tip is off by {} with {}, {} as it was",
            mm(after),
            words(kept),
            mm(before)
        ),
    };
    let outside = adapted.motions.iter().map(|motion| motion.extrapolating).fold(0.0, f64::max);
    let assessment = Verdict::on(format!("the twin of the changed robot is off by {}", mm(after)))
        .because(Criterion::ErrorOverBaseline, verdict::ratio(after, before), statement)
        .because(
            Criterion::OutsideTraining,
            outside,
            format!("up to {:.0} % of a recording is outside the network's training", 100.0 * outside),
        );
    // Pieces of one motion confirm a change on the motion that it was found on.
    let recordings: std::collections::BTreeSet<&str> =
        adapted.blocks.iter().map(|(name, _)| name.as_str()).collect();
    verdict::repeated(assessment, recordings.len(), "recording that was held out").verdict()
}

/// Description of the parts that would be kept.
pub(super) fn words(kept: AdaptedParts) -> &'static str {
    match kept {
        AdaptedParts::Nothing => "nothing new",
        AdaptedParts::Change => "zeros, play and friction",
        AdaptedParts::Correction => "a linear correction",
        AdaptedParts::Both => "zeros, play, friction and a linear correction",
    }
}
