//! Recordings that grow: a file to which a running rig appends row by row, and which survives a crash.
//!
//! Everything else is written whole or not at all (`file.rs`); a measurement cannot be repeated, so here each row
//! is in the file as soon as it was appended. The file is the magic and then frames: length and CRC-32 of the
//! payload (`u32` each, little endian), payload. The first byte of a payload is its kind: `H` the header as JSON,
//! `R` time and values as `f64`, `N` time and a line of text. The first frame that is not whole ends the data.
//! A value that was missing is NaN in the file, and only there: reading fills it in and marks the row as a gap.

use super::crc::crc32;
use super::{Channel, Check, ColumnMemory, Metadata, Recording, check_room, fill};
use crate::{BadInput, Error, Result, file};
use serde::{Deserialize, Serialize};
use std::fmt::Debug;
use std::fs::{File, OpenOptions};
use std::io::{self, Write};
use std::path::Path;
use std::sync::Arc;

const MAGIC: &[u8; 8] = b"hystjrnl";
const FORMAT: &str = "hysteron-journal";
const VERSION: u32 = 1;
const HEADER: u8 = b'H';
const ROW: u8 = b'R';
const NOTE: u8 = b'N';
/// Length and CRC-32 before each payload.
const FRAME: usize = 8;
/// Longest note [bytes].
const LONGEST_NOTE: usize = 4096;
/// Key of the metadata with the channels that never had a value, separated by blanks.
const EMPTY_CHANNELS: &str = "journal.empty_channels";
/// Key of the metadata with the bytes that could not be read.
const LOST_BYTES: &str = "journal.lost_bytes";

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct JournalHeader {
    format: String,
    version: u32,
    channels: Vec<String>,
    metadata: Vec<(String, String)>,
}

/// A file that a journal is written to.
pub trait JournalFile: Debug + Send + Sync {
    /// Appends all bytes.
    ///
    /// # Errors
    /// Errors of the file system; a part may then be in the file.
    fn append_all(&self, bytes: &[u8]) -> io::Result<()>;
    /// Cuts the file to this many bytes.
    ///
    /// # Errors
    /// Errors of the file system.
    fn cut(&self, length: u64) -> io::Result<()>;
    /// Waits until all that was appended is on the disk.
    ///
    /// # Errors
    /// Errors of the file system.
    fn sync(&self) -> io::Result<()>;
}

impl JournalFile for File {
    fn append_all(&self, bytes: &[u8]) -> io::Result<()> {
        let mut file = self;
        file.write_all(bytes)
    }

    fn cut(&self, length: u64) -> io::Result<()> {
        self.set_len(length)
    }

    fn sync(&self) -> io::Result<()> {
        self.sync_data()
    }
}

/// Appends to a journal. Equal calls give equal bytes.
#[derive(Debug)]
pub struct JournalWriter {
    pub(super) frames: Frames,
    pub(super) output: Output,
}

impl JournalWriter {
    /// Begins a journal of these channels, named as in a [`Recording`]; parent folders are created. The planned
    /// rate, if there is one, goes into the metadata: key `rate_hz`.
    ///
    /// # Errors
    /// `BadInput` if there is such a file already or a name is none, `Io` if the file system refuses.
    pub fn create(path: impl AsRef<Path>, names: &[String], meta: &Metadata) -> Result<Self> {
        let path = path.as_ref();
        let place = path.display().to_string();
        if path.extension().is_none_or(|extension| extension != "journal") {
            return Err(BadInput::new(place, "a name ending in .journal", "another").into());
        }
        let header = header(names, meta).map_err(|bad| bad.within(&place))?;
        let io = |refusal| Error::Io { path: path.to_owned(), refusal };
        let folder = file::folder_of(path);
        std::fs::create_dir_all(folder).map_err(io)?;
        let file = match OpenOptions::new().append(true).create_new(true).open(path) {
            Err(e) if e.kind() == io::ErrorKind::AlreadyExists => {
                return Err(BadInput::new(place, "a new file", "one that exists")
                    .hint("a measurement is never overwritten; choose another name")
                    .into());
            }
            file => file.map_err(io)?,
        };
        let journal = Self::begin(Arc::new(file), &header, names.len()).map_err(io)?;
        // The name too must be on the disk.
        File::open(folder).and_then(|folder| folder.sync_all()).map_err(io)?;
        Ok(journal)
    }

    /// Begins a journal in an empty file of another kind.
    ///
    /// # Errors
    /// `InvalidInput` for invalid names; else the error of the file.
    pub fn over(file: Arc<dyn JournalFile>, names: &[String], meta: &Metadata) -> io::Result<Self> {
        let header = header(names, meta).map_err(|bad| invalid(bad.to_string()))?;
        Self::begin(file, &header, names.len())
    }

    fn begin(file: Arc<dyn JournalFile>, header: &[u8], n_channels: usize) -> io::Result<Self> {
        let mut output = Output { file, length: 0, is_broken: false };
        let mut start = MAGIC.to_vec();
        framed_into(&mut start, |payload| payload.extend_from_slice(header));
        output.write(&start)?;
        output.sync()?;
        Ok(Self { frames: Frames::new(n_channels), output })
    }

    /// Appends a row: its time [s] and one value per channel, NaN where it is missing. The row is with the
    /// operating system when this returns, in one write; only a crash of the whole machine can still lose it, see
    /// [`JournalWriter::sync`]. Nothing is allocated.
    ///
    /// # Errors
    /// `InvalidInput` for another number of values, an infinite one, or a time that is not later; else what the
    /// file system says. The row is then not in the file, and the next one may be tried.
    pub fn append(&mut self, time: f64, values: &[f64]) -> io::Result<()> {
        let before = self.frames.last;
        let written = self.frames.row(time, values).and_then(|frame| self.output.write(frame));
        if written.is_err() {
            self.frames.last = before;
        }
        written
    }

    /// Appends a line of text that belongs to a time [s].
    ///
    /// # Errors
    /// `InvalidInput` for more than 4096 bytes or a time that is not finite; else as [`JournalWriter::append`].
    pub fn note(&mut self, time: f64, text: &str) -> io::Result<()> {
        self.frames.note(time, text).and_then(|frame| self.output.write(frame))
    }

    /// Waits until all that was appended is on the disk; call it every second or so.
    ///
    /// # Errors
    /// Errors of the file system.
    pub fn sync(&self) -> io::Result<()> {
        self.output.sync()
    }
}

/// Makes frames of rows and notes.
#[derive(Debug)]
pub(super) struct Frames {
    n_channels: usize,
    /// Time of the last row [s].
    last: f64,
    /// The frame under way; holds any row without growing.
    frame: Vec<u8>,
}

impl Frames {
    fn new(n_channels: usize) -> Self {
        let frame = Vec::with_capacity(FRAME + 1 + 8 * (1 + n_channels));
        Self { n_channels, last: f64::NEG_INFINITY, frame }
    }

    /// The frame of a row, as [`JournalWriter::append`] takes it.
    pub(super) fn row(&mut self, time: f64, values: &[f64]) -> io::Result<&[u8]> {
        if values.len() != self.n_channels {
            let (expected, found) = (self.n_channels, values.len());
            return Err(invalid(format!("expected {expected} values, got {found}")));
        }
        if !(time.is_finite() && time > self.last) {
            return Err(invalid(format!("expected a time after {} s, got {time} s", self.last)));
        }
        if let Some(i) = values.iter().position(|value| value.is_infinite()) {
            return Err(invalid(format!(
                "value {}: expected a finite number or NaN, got {}",
                i + 1,
                values[i]
            )));
        }
        self.last = time;
        self.frame.clear();
        framed_into(&mut self.frame, |payload| {
            payload.push(ROW);
            payload.extend_from_slice(&time.to_le_bytes());
            for value in values {
                // One NaN of the many, for equal bytes.
                let value = if value.is_nan() { f64::NAN } else { *value };
                payload.extend_from_slice(&value.to_le_bytes());
            }
        });
        Ok(&self.frame)
    }

    /// The frame of a note, as [`JournalWriter::note`] takes it.
    pub(super) fn note(&mut self, time: f64, text: &str) -> io::Result<&[u8]> {
        if text.len() > LONGEST_NOTE || !time.is_finite() {
            return Err(invalid(format!("expected at most {LONGEST_NOTE} bytes at a finite time")));
        }
        self.frame.clear();
        framed_into(&mut self.frame, |payload| {
            payload.push(NOTE);
            payload.extend_from_slice(&time.to_le_bytes());
            payload.extend_from_slice(text.as_bytes());
        });
        Ok(&self.frame)
    }
}

/// The file of a journal, which always ends with a whole frame.
#[derive(Debug)]
pub(super) struct Output {
    pub(super) file: Arc<dyn JournalFile>,
    /// Bytes of the file that are whole frames.
    length: u64,
    /// A torn frame is at the end and cannot be removed.
    is_broken: bool,
}

impl Output {
    /// Writes a frame, or leaves the file as it was: after a torn frame a reader would stop.
    pub(super) fn write(&mut self, frame: &[u8]) -> io::Result<()> {
        if self.is_broken {
            self.cut_torn_end()?;
        }
        if let Err(error) = self.file.append_all(frame) {
            self.is_broken = self.cut_torn_end().is_err();
            return Err(error);
        }
        self.length += frame.len() as u64;
        Ok(())
    }

    fn sync(&self) -> io::Result<()> {
        self.file.sync()
    }

    fn cut_torn_end(&mut self) -> io::Result<()> {
        self.file.cut(self.length)?;
        self.is_broken = false;
        Ok(())
    }
}

/// Bytes of the first of these frames.
pub(super) fn frame_length(frames: &[u8]) -> usize {
    let length = frames.first_chunk::<4>().map_or(0, |length| u32::from_le_bytes(*length) as usize);
    (FRAME + length).min(frames.len())
}

/// Payload of the header frame, if a recording may have these channels and metadata.
fn header(names: &[String], meta: &Metadata) -> Check<Vec<u8>> {
    let channels = names.iter().map(|name| Channel::new(name, vec![0.0])).collect();
    Recording::new(vec![0.0], channels, vec![], meta.clone())?;
    let header = JournalHeader {
        format: FORMAT.to_owned(),
        version: VERSION,
        channels: names.to_vec(),
        metadata: meta.to_pairs(),
    };
    let json = crate::json::to_line(&header).map_err(|e| BadInput::new("header", "text", e.to_string()))?;
    Ok([&[HEADER], json.as_bytes()].concat())
}

/// Appends a frame around what `payload` appends.
fn framed_into(out: &mut Vec<u8>, payload: impl FnOnce(&mut Vec<u8>)) {
    let start = out.len();
    out.extend_from_slice(&[0; FRAME]);
    payload(out);
    let payload = &out[start + FRAME..];
    let (length, crc) = (payload.len() as u32, crc32(payload));
    out[start..start + 4].copy_from_slice(&length.to_le_bytes());
    out[start + 4..start + FRAME].copy_from_slice(&crc.to_le_bytes());
}

fn invalid(message: String) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidInput, message)
}

/// A journal as it was found.
#[derive(Debug, Clone, PartialEq)]
pub struct Journal {
    /// Its rows, without what was lost. Missing values are filled in and their rows marked as gaps. A channel that
    /// never had a value is left out, and named in the metadata under `journal.empty_channels`.
    pub recording: Recording,
    /// Its notes with their times [s], in the order of the file.
    pub notes: Vec<(f64, String)>,
    /// Bytes after the last whole frame, which cannot be read: a torn row after a crash, or more where the file is
    /// damaged. If there are any, the metadata name them under `journal.lost_bytes`.
    pub lost_bytes: usize,
}

impl Journal {
    /// Reads a journal, up to its end or the first frame that is not whole.
    ///
    /// # Errors
    /// `BadInput` if not even the header and one row are whole, `Io` if the file cannot be read.
    pub fn read(path: impl AsRef<Path>) -> Result<Self> {
        let path = path.as_ref();
        Ok(parse(&file::read_bytes(path)?).map_err(|bad| bad.within(path.display()))?)
    }
}

fn parse(bytes: &[u8]) -> Check<Journal> {
    let not_one = |found: String| {
        BadInput::new("start of the file", "a journal with a whole header", found)
            .hint("a run that was killed before its first row leaves nothing to read")
    };
    let Some(mut rest) = bytes.strip_prefix(MAGIC) else {
        let is_short = MAGIC.starts_with(bytes);
        return Err(not_one(if is_short { format!("{} bytes", bytes.len()) } else { "another file".into() }));
    };
    let Some((HEADER, json)) = frame(&mut rest) else {
        return Err(not_one("a torn or damaged one".into()));
    };
    let header: JournalHeader = crate::json::from_text(json).map_err(|e| not_one(e.to_string()))?;
    if header.format != FORMAT || header.version != VERSION {
        return Err(BadInput::new(
            "header",
            format!("{FORMAT} version {VERSION}"),
            format!("{} version {}", header.format, header.version),
        ));
    }
    let mut meta = Metadata::from_pairs(header.metadata)?;

    let n = header.channels.len();
    // A row has its time and its numbers.
    check_room(n + 1, (rest.len() / (8 * (n + 1))) as u64, ColumnMemory::Grown)?;
    let mut time: Vec<f64> = Vec::new();
    let mut columns: Vec<Vec<f64>> = vec![Vec::new(); n];
    let mut notes = Vec::new();
    let mut lost_bytes = rest.len();
    while let Some((kind, payload)) = frame(&mut rest) {
        let Some((at, body)) = payload.split_first_chunk().map(|(at, body)| (f64::from_le_bytes(*at), body))
        else {
            break;
        };
        match kind {
            ROW if body.len() == 8 * n && at.is_finite() && time.last().is_none_or(|last| at > *last) => {
                let (values, _) = body.as_chunks::<8>();
                if values.iter().any(|value| f64::from_le_bytes(*value).is_infinite()) {
                    break;
                }
                time.push(at);
                for (column, value) in columns.iter_mut().zip(values) {
                    column.push(f64::from_le_bytes(*value));
                }
            }
            NOTE if at.is_finite() => match std::str::from_utf8(body) {
                Ok(text) => notes.push((at, text.to_owned())),
                Err(_) => break,
            },
            _ => break,
        }
        lost_bytes = rest.len();
    }
    if time.is_empty() {
        return Err(BadInput::new(
            "rows",
            "at least one that is whole",
            format!("none in {} bytes", bytes.len()),
        )
        .hint("the run ended before its first row"));
    }
    if lost_bytes > 0 {
        meta.extra.insert(LOST_BYTES.to_owned(), lost_bytes.to_string());
    }
    let channels = header.channels.into_iter().zip(columns).map(|(name, column)| Channel::new(name, column));
    let (empty, channels): (Vec<Channel>, Vec<Channel>) =
        channels.partition(|channel| channel.values.iter().all(|value| value.is_nan()));
    if !empty.is_empty() {
        let names: Vec<&str> = empty.iter().map(|channel| channel.name.as_str()).collect();
        meta.extra.insert(EMPTY_CHANNELS.to_owned(), names.join(" "));
    }
    Ok(Journal { recording: fill::filled(time, channels, meta)?, notes, lost_bytes })
}

/// Takes the next frame off `rest`, as kind and payload, if it is whole. Zeros, which a crash may leave at the
/// end, are none: a payload has at least its kind.
fn frame<'a>(rest: &mut &'a [u8]) -> Option<(u8, &'a [u8])> {
    let (length, after) = rest.split_first_chunk::<4>()?;
    let (crc, after) = after.split_first_chunk::<4>()?;
    let (payload, after) = after.split_at_checked(u32::from_le_bytes(*length) as usize)?;
    if crc32(payload) != u32::from_le_bytes(*crc) {
        return None;
    }
    let (kind, body) = payload.split_first()?;
    *rest = after;
    Some((*kind, body))
}

#[cfg(test)]
#[path = "journal_tests.rs"]
mod tests;
