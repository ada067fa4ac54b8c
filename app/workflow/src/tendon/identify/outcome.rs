//! The outcome of `identify`.

use std::path::Path;

use hysteron_base::checks::Warning;
use hysteron_base::{BadInput, Recording, json};
use hysteron_report::verdict::{Criterion, Verdict};
use hysteron_twin::coreact::IdentificationSummary;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::shared::outcome::MetricsFormat;
use crate::shared::recording_checks::Findings;
use crate::shared::verdict::ratio;
use crate::{COMMIT, Context};

/// The outcome of `identify`.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct Outcome {
    /// Format of the file.
    pub format: MetricsFormat,
    /// Its version.
    pub version: u32,
    /// Whether a network can learn from the auxiliary strokes.
    pub verdict: Verdict,
    /// One entry per recording that was identified.
    pub recordings: Vec<IdentifiedRecording>,
    /// Recordings that were not used, and why.
    pub left_out: Vec<String>,
    /// Warnings about the recordings.
    #[serde(default)]
    pub recording_warnings: Vec<Warning>,
    /// Hash of the scene and its mesh.
    pub scene_sha256: String,
    /// The command that made this.
    pub command: String,
    /// Commit of the program.
    pub commit: String,
}

/// A recording and the result of its identification.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct IdentifiedRecording {
    /// Its name.
    pub name: String,
    /// Counts and errors.
    #[serde(flatten)]
    pub summary: IdentificationSummary,
}

impl crate::shared::outcome::Outcome for Outcome {
    fn verdict(&self) -> Option<&Verdict> {
        Some(&self.verdict)
    }
}

impl Outcome {
    pub(super) fn new(
        recordings: Vec<IdentifiedRecording>,
        left_out: Vec<String>,
        findings: &Findings,
        (scene_sha256, context): (&str, &Context),
    ) -> Self {
        Self {
            format: MetricsFormat,
            version: 1,
            verdict: verdict(&recordings, &left_out),
            recordings,
            left_out,
            recording_warnings: findings.warnings().to_vec(),
            scene_sha256: scene_sha256.to_owned(),
            command: context.command.clone(),
            commit: COMMIT.to_owned(),
        }
    }
}

impl IdentifiedRecording {
    /// Out of a recording that was identified earlier.
    pub(super) fn read(path: &Path) -> anyhow::Result<Self> {
        let recording = Recording::read(path)?;
        let text = recording.meta().extra.get("identify.summary").map_or("", String::as_str);
        let summary = json::from_text(text).map_err(|error| {
            BadInput::new(path.display().to_string(), "the summary of an identification", error.to_string())
        })?;
        let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        Ok(Self { name, summary })
    }
}

/// Whether a network can learn from the auxiliary strokes of these recordings.
fn verdict(rows: &[IdentifiedRecording], left_out: &[String]) -> Verdict {
    let samples: usize = rows.iter().map(|row| row.summary.samples).sum();
    if samples == 0 {
        return Verdict::on("").because(Criterion::Missing, 1.0, "no recording was identified").verdict();
    }
    let rms = |of: fn(&IdentifiedRecording) -> f64| {
        let squares = rows.iter().map(|row| row.summary.samples as f64 * of(row).powi(2)).sum::<f64>();
        (squares / samples as f64).sqrt()
    };
    let (before, after) = (rms(|row| row.summary.before.rms_m), rms(|row| row.summary.after.rms_m));
    let qps = |range: std::ops::Range<usize>| -> f64 {
        rows.iter().flat_map(|row| &row.summary.qps[range.clone()]).sum::<usize>() as f64
    };
    let (solved, not) = (qps(0..1), qps(1..4));
    let at_bound: usize =
        rows.iter().map(|row| row.summary.samples_at_bound.iter().copied().max().unwrap_or(0)).sum();
    let at_bound = at_bound as f64 / samples as f64;
    let outside: usize = rows.iter().map(|row| row.summary.samples_outside_validation).sum();
    let outside = outside as f64 / samples as f64;
    let mm = |m: f64| format!("{:.3} mm", 1e3 * m);
    let n = rows.len() + left_out.len();
    let mut verdict = Verdict::on(format!(
        "auxiliary tendons bring the twin's tip within {} of the measured one",
        mm(after)
    ))
    .because(
        Criterion::ErrorOverBaseline,
        ratio(after, before),
        format!("the tip is off by {} with auxiliary tendons, {} without (RMS)", mm(after), mm(before)),
    )
    .because(
        Criterion::SolverFailures,
        if solved + not > 0.0 { not / (solved + not) } else { 0.0 },
        format!("{not:.0} of {:.0} QPs were not solved", solved + not),
    )
    .because(
        Criterion::AtLimit,
        at_bound,
        format!("auxiliary strokes are at a bound in {:.1} % of the samples", 100.0 * at_bound),
    )
    .because(
        Criterion::Missing,
        left_out.len() as f64 / n.max(1) as f64,
        format!("{} of {n} recordings were skipped", left_out.len()),
    );
    if outside > 0.0 {
        verdict = verdict.because(
            Criterion::OutsideTraining,
            outside,
            format!(
                "the chain is bent further than it was validated in {:.1} % of the samples",
                100.0 * outside
            ),
        );
    }
    verdict.verdict()
}
