//! The outcome of `evaluate`.

use std::collections::BTreeMap;

use hysteron_actuator::health::Health;
use hysteron_base::checks::Warning;
use hysteron_control::TargetPath;
use hysteron_control::tracking::{Repeatability, TrackingScore};
use hysteron_report::verdict::{Criterion, Verdict};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::table::{Commanded, METRICS, Row, ScoredRecordings, results};
use crate::shared::outcome::MetricsFormat;
use crate::{COMMIT, Context};

/// The outcome of `evaluate`, and of `track` along a path.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct Outcome {
    /// Format of the file.
    pub format: MetricsFormat,
    /// Its version.
    pub version: u32,
    /// Whether the tip follows the target.
    pub verdict: Verdict,
    /// The target.
    pub target: TargetSummary,
    /// One entry per recording.
    pub recordings: Vec<RecordingScore>,
    /// Warnings about the recordings.
    #[serde(default)]
    pub recording_warnings: Vec<Warning>,
    /// How the strokes were commanded, where that is known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub commanded: Option<Commanded>,
    /// Condition of the rig's servos, where the recordings were made by the same command.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub health: Option<Health>,
    /// By metric, over the recordings, where they are repeats of one result.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub repeatability: BTreeMap<String, Repeatability>,
    /// Results that are compared, where they have names.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub results: Vec<ComparedResult>,
    /// The command that made this.
    pub command: String,
    /// Commit of the program.
    pub commit: String,
}

/// A target in numbers.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct TargetSummary {
    /// Name.
    pub name: String,
    /// Family of its curve.
    pub family: String,
    /// SHA-256 of what it was made from.
    pub sha256: String,
    /// Length of a lap [m].
    pub length_m: f64,
    /// Laps.
    pub laps: usize,
}

/// A recording and its score.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct RecordingScore {
    /// Name of the recording.
    pub name: String,
    /// The result that it is a repeat of, where results are compared.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub result: Option<String>,
    /// SHA-256 of its file.
    pub sha256: String,
    /// Its provenance.
    pub source: String,
    /// Its score.
    #[serde(flatten)]
    pub score: TrackingScore,
}

/// One of several results that are compared.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct ComparedResult {
    /// Name.
    pub name: String,
    /// Number of repeats.
    pub repeats: usize,
    /// By metric, over its repeats.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub repeatability: BTreeMap<String, Repeatability>,
}

impl crate::shared::outcome::Outcome for Outcome {
    fn verdict(&self) -> Option<&Verdict> {
        Some(&self.verdict)
    }
}

impl Outcome {
    /// Of recordings that were scored.
    pub(crate) fn new(shown: &ScoredRecordings, context: &Context) -> Self {
        let ScoredRecordings { target, rows, commanded, findings } = *shown;
        let compared = results(rows).filter_map(|rows| {
            let name = rows[0].result.clone()?;
            Some(ComparedResult { name, repeats: rows.len(), repeatability: repeatability(rows) })
        });
        let results: Vec<ComparedResult> = compared.collect();
        Self {
            format: MetricsFormat,
            version: 1,
            verdict: assess(rows, commanded),
            target: TargetSummary::new(target),
            recordings: rows.iter().map(RecordingScore::new).collect(),
            recording_warnings: findings.warnings().to_vec(),
            commanded: commanded.cloned(),
            health: commanded.and_then(|commanded| commanded.health.clone()),
            repeatability: if results.is_empty() { repeatability(rows) } else { BTreeMap::new() },
            results,
            command: context.command.clone(),
            commit: COMMIT.to_owned(),
        }
    }
}

impl TargetSummary {
    fn new(target: &TargetPath) -> Self {
        Self {
            name: target.name.clone(),
            family: target.family.clone(),
            sha256: target.hash.clone(),
            length_m: target.outline.length(),
            laps: target.laps().count(),
        }
    }
}

impl RecordingScore {
    fn new(row: &Row) -> Self {
        let Row { name, result, sha256, source, score, .. } = row;
        Self {
            name: name.clone(),
            result: result.clone(),
            sha256: sha256.clone(),
            source: source.clone(),
            score: *score,
        }
    }
}

/// By metric, over repeats of one result.
fn repeatability(rows: &[Row]) -> BTreeMap<String, Repeatability> {
    METRICS.iter().filter_map(|metric| Some((metric.key.to_owned(), metric.repeatability(rows)?))).collect()
}

/// Whether the tip follows the target: of several results the best, over its repeats.
fn assess(rows: &[Row], commanded: Option<&Commanded>) -> Verdict {
    let mean = |rows: &[Row], of: fn(&Row) -> f64| rows.iter().map(of).sum::<f64>() / rows.len() as f64;
    let nrmse = |rows: &[Row]| mean(rows, |row| row.score.nrmse.unwrap_or(f64::NAN));
    let best = results(rows).min_by(|a, b| nrmse(a).total_cmp(&nrmse(b))).unwrap_or(rows);
    let name = best.first().and_then(|row| row.result.as_deref());
    let name = name.map_or(String::new(), |name| format!(" by {name}, the best of these results,"));
    let (error, share) = (1e3 * mean(best, |row| row.score.rmse_m), nrmse(best));
    let mut assessment = Verdict::on(format!("the tip follows the target{name} within {error:.2} mm (RMSE)"))
        .because(
            Criterion::ErrorOverTarget,
            share,
            format!("the tip is off by {error:.2} mm, {:.1} % of the target's size (NRMSE)", 100.0 * share),
        );
    if let Some(Commanded { extrapolating, limited, .. }) = commanded {
        assessment = assessment
            .because(
                Criterion::OutsideTraining,
                *extrapolating,
                format!(
                    "the network is outside its training in {:.0} % of the samples",
                    100.0 * extrapolating
                ),
            )
            .because(
                Criterion::AtLimit,
                *limited,
                format!("strokes are limited in {:.0} % of the samples", 100.0 * limited),
            );
    }
    assessment.verdict()
}
