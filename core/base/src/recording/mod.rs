//! Recordings: time-aligned channels in SI with their provenance, the one kind of data that crates exchange.
//!
//! One constructor validates everything, so a recording in hand is finite, ordered in time and well named, and it
//! is never edited in place. Two files hold it: Parquet for programs, CSV for people; both give back the same
//! doubles. A third, the journal, is what a running rig appends to; it is read, and kept as one of the two.

mod arrow_schema;
mod crc;
mod csv;
mod fill;
mod journal;
mod journal_queue;
mod metadata;
pub(crate) mod names;
mod pages;
pub(crate) mod parquet;
pub(crate) mod parquet_column;
mod parquet_damage;
mod shard;

use crate::size::check_memory;
use crate::{BadInput, Result, file};
pub use journal::{Journal, JournalFile, JournalWriter};
pub use journal_queue::JournalQueue;
pub use metadata::Metadata;
pub use names::MAX_CHANNELS;
pub use shard::TrajectoryShard;
use std::path::Path;

/// Format that every recording file states.
pub(crate) const FORMAT: &str = "hysteron-recording";
/// Version of that format that this program writes and reads.
pub(crate) const VERSION: u32 = 1;
/// Largest deviation of a time step from the mean that still counts as a fixed rate [-].
const UNIFORM: f64 = 0.01;

/// Largest file that is read [byte].
const MAX_BYTES: u64 = 1 << 30;
/// Most numbers in a recording, 400 MB of them: an hour of 130 channels at 100 Hz has fewer.
pub(crate) const MAX_NUMBERS: u64 = 50_000_000;

/// One named series of values.
#[derive(Debug, Clone, PartialEq)]
pub struct Channel {
    /// Name ending in its SI unit (`stroke_1_m`), or one of the unitless names.
    pub name: String,
    /// One finite value per time (n_samples) [unit of the name].
    pub values: Vec<f64>,
}

impl Channel {
    /// A channel; [`Recording::new`] checks it.
    pub fn new(name: impl Into<String>, values: Vec<f64>) -> Self {
        Self { name: name.into(), values }
    }
}

/// Time-aligned channels, see the module. Equal recordings are written as equal bytes.
#[derive(Debug, Clone, PartialEq)]
pub struct Recording {
    time: Vec<f64>,
    channels: Vec<Channel>,
    gap: Vec<bool>,
    meta: Metadata,
}

/// Result of a check that has no file to fail on.
type Check<T> = std::result::Result<T, BadInput>;

impl Recording {
    /// Puts a recording together, of at most 10 000 columns and 50 million numbers.
    ///
    /// `time` (n_samples) [s], strictly increasing; `gap` (n_samples), true where the sample was missing and has
    /// been filled in, or empty if none was. Channels have names of their own that end in an SI unit, or are
    /// `tip_qw` … `tip_qz`, `tick_goal_k`, `tick_present_k`, `load_k`; strokes and aux channels count from 1
    /// without holes.
    ///
    /// # Errors
    /// `BadInput` naming the row (from 1) and the channel.
    pub fn new(time: Vec<f64>, channels: Vec<Channel>, gap: Vec<bool>, meta: Metadata) -> Check<Self> {
        let n = time.len();
        if n == 0 {
            return Err(BadInput::new("time_s", "at least one row", "none"));
        }
        check_size(channels.len() + 2, n as u64)?;
        let gap = if gap.is_empty() { vec![false; n] } else { gap };
        if gap.len() != n {
            return Err(BadInput::new("gap", format!("{n} rows, as time_s has"), gap.len().to_string()));
        }
        finite("time_s", &time)?;
        if let Some(i) = (1..n).find(|&i| time[i] <= time[i - 1]) {
            return Err(not_later(&format!("row {}: time_s", i + 1), time[i - 1], time[i]));
        }
        names::check_count(channels.len())?;
        for (i, channel) in channels.iter().enumerate() {
            names::check(&channel.name)?;
            if channels[..i].iter().any(|earlier| earlier.name == channel.name) {
                return Err(names::duplicate(&channel.name, &channel.name));
            }
            if channel.values.len() != n {
                let expected = format!("{n} rows, as time_s has");
                return Err(BadInput::new(&channel.name, expected, channel.values.len().to_string()));
            }
            finite(&channel.name, &channel.values)?;
        }
        names::check_numbering(&channels)?;
        meta.check()?;
        Ok(Self { time, channels, gap, meta })
    }

    /// Puts a recording together in which values are missing (NaN): each is interpolated in time between its
    /// neighbours, before the first and after the last it is held, and its row is marked as a gap.
    ///
    /// # Errors
    /// `BadInput` for a channel without any value, and as [`Recording::new`].
    pub fn with_missing(time: Vec<f64>, channels: Vec<Channel>, meta: Metadata) -> Check<Self> {
        let n = time.len();
        if let Some(channel) = channels.iter().find(|channel| channel.values.len() != n) {
            let expected = format!("{n} rows, as time_s has");
            return Err(BadInput::new(&channel.name, expected, channel.values.len().to_string()));
        }
        fill::filled(time, channels, meta)
    }

    /// Times (n_samples) [s], strictly increasing.
    pub fn time(&self) -> &[f64] {
        &self.time
    }

    /// Number of samples, at least one.
    pub fn n_samples(&self) -> usize {
        self.time.len()
    }

    /// Memory of its numbers [byte].
    pub fn n_bytes(&self) -> usize {
        self.time.len() * (8 * (1 + self.channels.len()) + 1)
    }

    /// All channels, in the order of the file.
    pub fn channels(&self) -> &[Channel] {
        &self.channels
    }

    /// True where the sample was missing and has been filled in (n_samples).
    pub fn gap(&self) -> &[bool] {
        &self.gap
    }

    /// Where the recording comes from.
    pub fn meta(&self) -> &Metadata {
        &self.meta
    }

    /// The values of a channel (n_samples).
    pub fn channel(&self, name: &str) -> Option<&[f64]> {
        self.channels.iter().find(|channel| channel.name == name).map(|channel| channel.values.as_slice())
    }

    /// The values of a channel that must be there (n_samples).
    ///
    /// # Errors
    /// `BadInput` listing the channels that are there.
    pub fn require(&self, name: &str) -> Check<&[f64]> {
        self.channel(name).ok_or_else(|| {
            let there: Vec<&str> = self.channels.iter().map(|channel| channel.name.as_str()).collect();
            let found = if there.is_empty() { "no channel".into() } else { there.join(", ") };
            BadInput::new("recording", format!("a channel {name}"), found)
        })
    }

    /// All of `stroke_1_m`, `stroke_2_m`, … in order [m].
    pub fn strokes(&self) -> Vec<&[f64]> {
        self.numbered("stroke", "m")
    }

    /// All of `aux_01_m`, `aux_02_m`, … in order [m].
    pub fn aux(&self) -> Vec<&[f64]> {
        self.numbered("aux", "m")
    }

    /// All channels `stem_k_unit`, in order of k: `numbered("tension", "n")`; an empty unit for `load_k`.
    pub fn numbered(&self, stem: &str, unit: &str) -> Vec<&[f64]> {
        names::numbered(&self.channels, stem, unit).into_iter().map(|(_, c)| c.values.as_slice()).collect()
    }

    /// Position of the tip: `tip_x_m`, `tip_y_m`, `tip_z_m` [m].
    pub fn tip(&self) -> Option<[&[f64]; 3]> {
        Some([self.channel("tip_x_m")?, self.channel("tip_y_m")?, self.channel("tip_z_m")?])
    }

    /// Orientation of the tip as a quaternion: `tip_qw`, `tip_qx`, `tip_qy`, `tip_qz` [-].
    pub fn tip_orientation(&self) -> Option<[&[f64]; 4]> {
        let get = |name| self.channel(name);
        Some([get("tip_qw")?, get("tip_qx")?, get("tip_qy")?, get("tip_qz")?])
    }

    /// Samples per second if all time steps are equal within 1 % [Hz].
    pub fn rate_hz(&self) -> Option<f64> {
        let n = self.time.len();
        if n < 2 {
            return None;
        }
        let mean = (self.time[n - 1] - self.time[0]) / (n - 1) as f64;
        let uniform = self.time.windows(2).all(|pair| (pair[1] - pair[0] - mean).abs() <= UNIFORM * mean);
        uniform.then_some(1.0 / mean).filter(|rate| rate.is_finite())
    }

    /// Reads a recording, `.parquet`, `.csv` or `.journal` by its extension. Of a journal that was killed or is
    /// damaged, the valid part is read; [`Journal::read`] returns the loss.
    ///
    /// # Errors
    /// `BadInput` naming file, row and column; `Io` if the file cannot be read.
    pub fn read(path: impl AsRef<Path>) -> Result<Self> {
        let path = path.as_ref();
        let place = path.display().to_string();
        match FileKind::of(path, "a recording: .parquet, .csv or .journal")? {
            FileKind::Journal => Ok(Journal::read(path)?.recording),
            FileKind::Csv => Ok(csv::read(&csv_text(path)?).map_err(|bad| bad.within(place))?),
            FileKind::Parquet => {
                Ok(parquet::read(file::open(path, MAX_BYTES)?).map_err(|bad| bad.within(place))?)
            }
        }
    }

    /// Reads the metadata of a recording, of a `.parquet` or `.csv` without reading its rows.
    ///
    /// # Errors
    /// As [`Recording::read`].
    pub fn read_metadata(path: impl AsRef<Path>) -> Result<Metadata> {
        let path = path.as_ref();
        let place = path.display().to_string();
        match FileKind::of(path, "a recording: .parquet, .csv or .journal")? {
            FileKind::Journal => Ok(Journal::read(path)?.recording.meta),
            FileKind::Csv => Ok(csv::read_metadata(&csv_text(path)?).map_err(|bad| bad.within(place))?),
            FileKind::Parquet => {
                Ok(parquet::read_metadata(file::open(path, MAX_BYTES)?).map_err(|bad| bad.within(place))?)
            }
        }
    }

    /// Writes the recording atomically, `.parquet` or `.csv` by its extension. A CSV holds lengths in mm.
    ///
    /// # Errors
    /// `BadInput` for another extension, `Io` if the file system refuses.
    pub fn write(&self, path: impl AsRef<Path>) -> Result<()> {
        let path = path.as_ref();
        let expected = "a recording to write: .parquet or .csv";
        match FileKind::of(path, expected)? {
            FileKind::Journal => Err(BadInput::new(path.display().to_string(), expected, ".journal").into()),
            FileKind::Csv => file::write_with(path, |out| csv::write(self, out)),
            FileKind::Parquet => file::write_with(path, |out| out.write_all(&parquet::to_bytes(self)?)),
        }
    }
}

/// The text of a table, which is longer than what a person types.
pub(crate) fn csv_text(path: &Path) -> Result<String> {
    Ok(file::text_of(file::read_up_to(path, MAX_BYTES)?, &path.display().to_string())?)
}

/// Refuses more numbers than [`MAX_NUMBERS`], before they are read.
pub(crate) fn check_size(columns: usize, rows: u64) -> Check<()> {
    let numbers = rows.saturating_mul(columns as u64);
    if numbers > MAX_NUMBERS {
        let found = format!("{rows} rows of {columns} columns");
        return Err(BadInput::new("rows", format!("at most {MAX_NUMBERS} numbers"), found)
            .hint("split the recording, or resample it"));
    }
    Ok(())
}

/// How the columns of a reader get their memory.
#[derive(Debug, Clone, Copy)]
pub(crate) enum ColumnMemory {
    /// Reserved once, for all rows.
    Reserved,
    /// Grown as rows are read, to twice their length at most.
    Grown,
}

impl ColumnMemory {
    /// Memory of so many numbers [byte].
    fn n_bytes(self, columns: usize, rows: u64) -> f64 {
        let per_number = match self {
            Self::Reserved => 8.0,
            Self::Grown => 16.0,
        };
        per_number * rows as f64 * columns as f64
    }
}

/// As [`check_size`], and refuses more than the memory has room for.
pub(crate) fn check_room(columns: usize, rows: u64, memory: ColumnMemory) -> Check<()> {
    check_size(columns, rows)?;
    check_memory("rows", memory.n_bytes(columns, rows), "split the recording, or resample it")
}

/// Kind of a file of recordings.
enum FileKind {
    Csv,
    Parquet,
    Journal,
}

impl FileKind {
    fn of(path: &Path, expected: &str) -> Check<Self> {
        match path.extension().and_then(|extension| extension.to_str()) {
            Some("csv") => Ok(Self::Csv),
            Some("parquet") => Ok(Self::Parquet),
            Some("journal") => Ok(Self::Journal),
            extension => {
                let found = extension.map_or("no extension".into(), |extension| format!(".{extension}"));
                Err(BadInput::new(path.display().to_string(), expected, found))
            }
        }
    }
}

fn finite(name: &str, values: &[f64]) -> Check<()> {
    match values.iter().position(|value| !value.is_finite()) {
        Some(i) => Err(not_finite(&format!("row {}: {name}", i + 1), &values[i].to_string())),
        None => Ok(()),
    }
}

fn not_finite(place: &str, found: &str) -> BadInput {
    BadInput::new(place, "a finite number", found)
        .hint("fill in the missing values and set gap to 1 in that row")
}

fn not_later(place: &str, before: f64, time: f64) -> BadInput {
    BadInput::new(place, format!("a time after {before} s"), format!("{time} s"))
        .hint("rows are in order of time, without repeats")
}

#[cfg(test)]
mod tests;
