//! Recordings of arms from the files of other programs.
//!
//! A file is a table of numbers; a description of its columns says which of them are what, in which unit. Descriptions of
//! known data sets are part of the program (`columns/`). Rows at uneven times are resampled onto a fixed rate, and what was
//! missing is interpolated and marked as a gap. Nothing is filtered. Currents that a file leaves out come from the voltage equation of its
//! drives, where these are known.

mod assemble;
mod bam;
mod columns;
mod drive;
mod suspicion;

use std::path::Path;

use hysteron_actuator::CatalogueDrive;
use hysteron_base::{BadInput, Filter, Metadata, Recording, Result, Table};

use crate::Model;
pub(crate) use assemble::MOST_LEFT_OUT;
pub use columns::Columns;
pub(crate) use drive::position_gain;
pub use drive::{CURRENTS_BY, POSITION_GAIN};

/// What becomes of rows that cannot be read: with a cell that is no number, with another number of cells, or with a time that is
/// not later than the one before.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum BadRows {
    /// The file is refused.
    #[default]
    Refuse,
    /// They are left out and counted; no more than a tenth of all.
    LeaveOut,
}

/// What becomes of numbers that look as if they had another unit than the one stated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum UnitCheck {
    /// The file is refused.
    #[default]
    Refuse,
    /// They are taken as they are.
    Accept,
}

/// How a file is read.
#[derive(Debug, Clone, Default)]
pub struct ImportOptions<'a> {
    /// What the columns are; found among the built-in descriptions where there is none.
    pub columns: Option<Columns>,
    /// The robot, whose joints name those of the recording and must be as many.
    pub model: Option<&'a Model>,
    /// Rate of the recording; that of the file where there is none [Hz].
    pub rate_hz: Option<f64>,
    /// The rows to read.
    pub filter: Option<Filter>,
    /// What becomes of rows that cannot be read.
    pub bad_rows: BadRows,
    /// What becomes of numbers that look as if they had another unit.
    pub unit_check: UnitCheck,
    /// The drive of every joint, by which currents are computed that the file leaves out.
    pub drive: Option<&'a CatalogueDrive>,
}

/// A recording, and what was done to get it.
#[derive(Debug, Clone, PartialEq)]
pub struct Imported {
    /// Channels in SI at a fixed rate, from time zero; see [`crate::Recorded`].
    pub recording: Recording,
    /// The description of the columns: a name or a file.
    pub columns: String,
    /// Rows of the file that were left out.
    pub n_left_out: usize,
    /// Why, of the first one.
    pub first_left_out: Option<BadInput>,
}

/// Reads `path` as a recording of an arm: a table (`.csv`, `.txt`, `.tsv`, `.npz`, `.npy`, `.parquet`), a log of bam (`.json`), or a
/// folder of lists. `meta` says who imports it; the source, the joints and the first time are added.
///
/// # Errors
/// `BadInput` naming the file, the row and the column: a cell without a number, a time that goes back, joints that differ in
/// number between quantities or from the model's, a column that is not there, numbers that look as if they had another
/// unit, or what currents of a drive need; `Io` if the file cannot be read.
pub fn import(path: &Path, options: &ImportOptions, meta: Metadata) -> Result<Imported> {
    let place = path.display().to_string();
    let filtered = |table: Table| match &options.filter {
        Some(filter) => table.filtered(filter),
        None => Ok(table),
    };
    let extension = path.extension().and_then(|extension| extension.to_str()).unwrap_or_default();
    let mut meta = meta;
    let (table, columns) = if path.is_dir() {
        let own = options.columns.clone().map_or_else(|| Columns::for_folder(path), Ok);
        let columns = own.map_err(|bad| bad.within(&place))?;
        (filtered(columns.read_lists(path)?).map_err(|bad| bad.within(&place))?, columns)
    } else {
        let (table, notes) = if extension.eq_ignore_ascii_case("json") {
            let (table, notes) = bam::read(path)?;
            (filtered(table).map_err(|bad| bad.within(&place))?, notes)
        } else {
            (Table::read(path, options.filter.as_ref())?, Vec::new())
        };
        let own = options.columns.clone().map_or_else(|| Columns::for_table(&table, &notes), Ok);
        meta.extra.extend(notes);
        (table, own.map_err(|bad| bad.within(&place))?)
    };
    let assembled = assemble::assemble(&table, &columns, options, meta).and_then(|imported| {
        let Some(drive) = options.drive else { return Ok(imported) };
        Ok(Imported { recording: drive::with_currents(imported.recording, drive)?, ..imported })
    });
    Ok(assembled.map_err(|bad| bad.within(place))?)
}
