//! Recordings from the files of other programs, of tendon robots and of arms.
//!
//! A file is a table of numbers; a map ([`ColumnMap`]) gives quantity, unit, sign, zero and
//! frame. Maps of known data sets are part of the program (`columns/`). Further files come to the rows of the first by a key or by
//! their times. Rows at uneven times are resampled onto a fixed rate, and what was missing is interpolated and marked as a gap.
//! Nothing is filtered.

mod assemble;
mod bam;
mod columns;
mod join;
mod pose;
mod propose;
mod streams;

use crate::size::check_memory;
use crate::{BadInput, Metadata, Recording, Result, RowFilter, Table, TextFormat};
pub use assemble::{LABELLED, MAX_LEFT_OUT};
pub use bam::POSITION_GAIN;
pub use columns::ColumnMap;
use std::path::{Path, PathBuf};

/// Results of an import over the numbers of its table: rows taken out, channels in SI, channels at a fixed rate [-].
const COPIES: f64 = 3.0;
/// Most episodes of a file.
const MAX_EPISODES: usize = 10_000;

/// Treatment of rows that cannot be read: with a cell that is no number, with another number of cells, or
/// with a time that is not later than the one before.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum BadRows {
    /// The file is refused.
    #[default]
    Refuse,
    /// They are left out and counted; no more than a tenth of all.
    LeaveOut,
}

/// How files are read.
#[derive(Debug, Clone, Default)]
pub struct Request {
    /// Meaning of the columns; found among the built-in maps where there is none.
    pub columns: Option<ColumnMap>,
    /// Rate of the recording; that of the file where there is none [Hz].
    pub rate_hz: Option<f64>,
    /// The rows to read.
    pub filter: Option<RowFilter>,
    /// The column with the number of the episode; overrides that of the map.
    pub episode: Option<String>,
    /// Treatment of rows that cannot be read.
    pub bad_rows: BadRows,
}

/// A recording, and what was done to get it.
#[derive(Debug, Clone, PartialEq)]
pub struct Assembled {
    /// Channels in SI at a fixed rate, from time zero.
    pub recording: Recording,
    /// The map: a name or a file.
    pub columns: String,
    /// The value of the episode's column; none of a file that is not split.
    pub episode: Option<String>,
    /// Rows of the file that were skipped.
    pub n_left_out: usize,
    /// Why, of the first one.
    pub first_left_out: Option<BadInput>,
}

/// Reads `paths` as recordings, one for each episode: tables (`.csv`, `.txt`, `.tsv`, `.dat`, `.parquet`, `.npz`, `.npy`), logs of
/// bam (`.json`), or a folder of lists. The rows are those of the first; the others are joined to them. `meta` is the provenance;
/// the map and the first time are added.
///
/// # Errors
/// `BadInput` naming the file, the row and the column: a cell without a number, a time that goes back, a column that is not
/// there; `Io` if a file cannot be read.
pub fn read(paths: &[PathBuf], request: &Request, meta: Metadata) -> Result<Vec<Assembled>> {
    let Some((path, others)) = paths.split_first() else {
        return Err(BadInput::new("", "a file to import", "none").into());
    };
    let place = path.display().to_string();
    let mut meta = meta;
    let (mut table, notes) = table(path, request.columns.as_ref())?;
    check_memory(&place, COPIES * table.n_bytes() as f64, "split the file, or import fewer columns of it")?;
    let found = request.columns.clone().map_or_else(|| ColumnMap::found(path, &table, &notes), Ok);
    let columns = found.map_err(|bad| bad.within(&place))?;
    meta.extra.extend(notes);
    if !others.is_empty() {
        let others: Vec<(String, Table)> = others
            .iter()
            .map(|path| Ok((path.display().to_string(), self::table(path, Some(&columns))?.0)))
            .collect::<Result<_>>()?;
        table = join::joined(table, &others, &columns)?;
    }
    let filters = request.filter.iter().chain(&columns.filter);
    let table = filters.into_iter().try_fold(table, |table, filter| table.filtered(filter));
    let table = table.map_err(|bad| bad.within(&place))?;
    let table = join::with_streams(table, &columns).map_err(|bad| bad.within(&place))?;
    let by = request.episode.as_ref().or(columns.episode.as_ref());
    let parts = episodes(table, by.map(String::as_str)).map_err(|bad| bad.within(&place))?;
    let assembled = parts.into_iter().map(|(episode, part)| {
        let mut meta = meta.clone();
        let inside = |bad: BadInput| match (&episode, by) {
            (Some(episode), Some(by)) => bad.within(format!("{by} {episode}")).within(&place),
            _ => bad.within(&place),
        };
        meta.extra.extend(episode.clone().map(|episode| ("episode".to_owned(), episode)));
        let assembled = assemble::assemble(&part, &columns, request, meta).map_err(inside)?;
        Ok(Assembled { episode, ..assembled })
    });
    assembled.collect()
}

/// The map that the program proposes for a file: TOML with comments, for a person to edit.
///
/// # Errors
/// `BadInput` naming the file and what is wrong in it; `Io` if it cannot be read.
pub fn propose_for(path: &Path) -> Result<String> {
    let (table, _) = table(path, None)?;
    Ok(propose::propose(&table, &path.display().to_string()))
}

/// The table of a file or a folder, and its metadata.
///
/// # Errors
/// As [`read`].
fn table(path: &Path, columns: Option<&ColumnMap>) -> Result<(Table, Vec<(String, String)>)> {
    if path.is_dir() {
        let found = columns.cloned().map_or_else(|| ColumnMap::for_folder(path), Ok);
        let columns = found.map_err(|bad| bad.within(path.display()))?;
        return Ok((columns.read_lists(path)?, Vec::new()));
    }
    let is_json = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("json"));
    if is_json {
        return bam::read(path);
    }
    let format = columns.map_or_else(TextFormat::default, |columns| columns.text);
    Ok((Table::read_as(path, None, &format)?, Vec::new()))
}

/// The rows of each episode, in the order in which they come, with its name.
fn episodes(table: Table, by: Option<&str>) -> std::result::Result<Vec<(Option<String>, Table)>, BadInput> {
    let Some(by) = by else { return Ok(vec![(None, table)]) };
    let Some(column) = table.index(by) else {
        return Err(BadInput::new("episode", format!("a column \"{by}\""), table.names()));
    };
    let name = |row: usize| match table.word(column, row) {
        Some(word) => word.to_owned(),
        None => table.columns()[column].values[row].to_string(),
    };
    let mut names: Vec<String> = Vec::new();
    let mut rows: std::collections::HashMap<String, (usize, Vec<usize>)> = std::collections::HashMap::new();
    for row in 0..table.n_rows() {
        let name = name(row);
        let entry = rows.entry(name.clone()).or_insert_with(|| (names.len(), Vec::new()));
        if entry.0 == names.len() {
            names.push(name);
        }
        entry.1.push(row);
        crate::size::check_at_most("episodes", names.len(), MAX_EPISODES)?;
    }
    Ok(names
        .into_iter()
        .map(|name| {
            let part = rows.get(&name).map_or_else(Table::default, |(_, rows)| table.taken(rows));
            (Some(name), part)
        })
        .collect())
}

#[cfg(test)]
mod tests;
