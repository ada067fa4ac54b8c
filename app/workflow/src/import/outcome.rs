//! The outcome of an import: every channel with its unit, range and rate.

use std::path::{Path, PathBuf};

use hysteron_base::import::Assembled;
use hysteron_base::{Recording, units::Unit};
use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, Serialize};

use crate::shared::outcome::{self, MetricsFormat};

/// The outcome of `import`: recordings, or a proposed map.
#[derive(Debug, Clone, Serialize, JsonSchema)]
#[serde(untagged)]
pub enum Outcome {
    /// Recordings were made.
    Imported(Imported),
    /// A map was proposed.
    Proposed(Proposed),
}

impl outcome::Outcome for Outcome {}

impl<'de> Deserialize<'de> for Outcome {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        outcome::by_key(deserializer, "map", Self::Proposed, Self::Imported)
    }
}

/// A map to edit.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct Proposed {
    /// Its text.
    pub map: String,
    /// Its file, or `-` for the console.
    pub out: PathBuf,
}

/// Imported recordings.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct Imported {
    /// Format of the file.
    pub format: MetricsFormat,
    /// Its version.
    pub version: u32,
    /// Whether the recordings can be used, in one sentence.
    pub verdict: String,
    /// The map: a name or a file.
    pub columns: String,
    /// Joints of an arm, 0 of a tendon robot.
    pub joints: usize,
    /// Samples of all recordings.
    pub rows: usize,
    /// Samples that were not measured and are filled in.
    pub gaps: usize,
    /// Rows of the sources that were skipped.
    pub left_out: usize,
    /// One entry per recording.
    pub recordings: Vec<ImportedRecording>,
    /// The command that made this.
    pub command: String,
    /// Commit of the program.
    pub commit: String,
}

/// A recording.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct ImportedRecording {
    /// Its file.
    pub out: PathBuf,
    /// The value of the episode's column.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub episode: Option<String>,
    /// Number of samples.
    pub rows: usize,
    /// Samples that were not measured and are filled in.
    pub gaps: usize,
    /// Rows of the source that were skipped.
    pub left_out: usize,
    /// Rate [Hz]; none where rows have uneven times.
    pub rate_hz: Option<f64>,
    /// Time from the first to the last sample [s].
    pub duration_s: f64,
    /// One entry per channel.
    pub channels: Vec<ChannelRange>,
}

/// A channel.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct ChannelRange {
    /// Name.
    pub name: String,
    /// Unit of the two numbers.
    pub unit: String,
    /// Smallest value.
    pub smallest: f64,
    /// Largest value.
    pub largest: f64,
    /// Part of the samples that differ from the one before [-].
    pub changes_ratio: f64,
}

impl ImportedRecording {
    pub(super) fn of(out: &Path, imported: &Assembled) -> Self {
        let recording = &imported.recording;
        let time = recording.time();
        Self {
            out: out.to_owned(),
            episode: imported.episode.clone(),
            rows: recording.n_samples(),
            gaps: recording.gap().iter().filter(|gap| **gap).count(),
            left_out: imported.n_left_out,
            rate_hz: recording.rate_hz(),
            duration_s: time[time.len() - 1] - time[0],
            channels: recording.channels().iter().map(|c| ChannelRange::of(&c.name, &c.values)).collect(),
        }
    }

    /// `100.00 Hz`, or a note that rows have uneven times.
    pub(super) fn rate(&self) -> String {
        self.rate_hz.map_or_else(|| "times of its own".to_owned(), |rate| format!("{rate:.3} Hz"))
    }
}

impl ChannelRange {
    fn of(name: &str, values: &[f64]) -> Self {
        let (unit, shown) = shown_unit(name);
        let limits = values
            .iter()
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| [low.min(*x), high.max(*x)]);
        let [smallest, largest] = limits.map(|x| unit.map_or(x, |unit| unit.from_si(x)));
        let changes = values.windows(2).filter(|pair| pair[0] != pair[1]).count();
        let changes_ratio = changes as f64 / values.len().saturating_sub(1).max(1) as f64;
        Self { name: name.to_owned(), unit: shown, smallest, largest, changes_ratio }
    }
}

/// The unit in which people see a channel, millimetres for metres and degrees for radians, and how it is written.
pub(super) fn shown_unit(name: &str) -> (Option<&'static Unit>, String) {
    let Some((_, unit)) = Unit::of_name(name) else { return (None, "-".to_owned()) };
    let shown = match unit.suffix {
        "m" => "mm",
        "rad" => "deg",
        "rad_s" => "deg_s",
        other => other,
    };
    let written = match shown {
        "ratio" | "count" => "-".to_owned(),
        "n" => "N".to_owned(),
        "n_m" => "N m".to_owned(),
        "a" => "A".to_owned(),
        "v" => "V".to_owned(),
        "degc" => "°C".to_owned(),
        "deg_s" => "deg/s".to_owned(),
        "rad_s2" => "rad/s²".to_owned(),
        "m_s" => "m/s".to_owned(),
        other => other.replace('_', " "),
    };
    (Unit::from_suffix(shown), written)
}

/// One sentence on whether the recordings can be used.
pub(super) fn verdict(recordings: &[ImportedRecording]) -> String {
    let (rows, gaps) = recordings.iter().fold((0, 0), |(rows, gaps), one| (rows + one.rows, gaps + one.gaps));
    let frozen = |one: &ImportedRecording| {
        one.channels.iter().filter(|c| c.changes_ratio == 0.0).map(|c| c.name.clone()).collect()
    };
    let frozen: Vec<String> = recordings.first().map(frozen).unwrap_or_default();
    let gap_part = gaps as f64 / rows.max(1) as f64;
    match (gap_part, frozen.is_empty()) {
        (part, _) if part > MAX_GAPS => {
            format!("Usable with care: {:.1} % of {rows} samples are gaps that were filled in.", 100.0 * part)
        }
        (_, false) => format!("Usable with care: {} never changes.", frozen.join(", ")),
        (part, true) => format!("Usable: {rows} samples, {:.1} % of them gaps.", 100.0 * part),
    }
}

/// More gaps than this need care [-].
const MAX_GAPS: f64 = 0.05;

/// The file of an episode: `name-001.parquet` for the first of several.
pub(super) fn out_of(out: &Path, k: usize, n: usize) -> PathBuf {
    if n == 1 {
        return out.to_owned();
    }
    let stem = out.file_stem().unwrap_or_default().to_string_lossy();
    let extension = out.extension().map_or(String::new(), |e| format!(".{}", e.to_string_lossy()));
    let width = n.to_string().len().max(3);
    out.with_file_name(format!("{stem}-{:0width$}{extension}", k + 1))
}

/// True for the recording of an arm: it has a channel of a joint.
pub(super) fn is_of_arm(recording: &Recording) -> bool {
    let has = |name: &str| recording.channel(name).is_some();
    recording.strokes().is_empty() && (has("q_1_rad") || has("q_1_m"))
}
