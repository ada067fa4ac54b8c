//! Tables of numbers that other programs wrote: CSV, Parquet, NumPy's `.npy` and `.npz`, MATLAB's `.mat`.
//!
//! Nothing is assumed of names, units or completeness: a cell without a number is NaN, and a caller that takes a column
//! decides what that means. Recordings of this project have a reader of their own, which is stricter.

mod cells;
mod mat;
mod npz;
mod parquet;
mod stamps;
mod text;

use crate::recording::check_size;
use crate::{BadInput, Result, file};
pub(crate) use cells::TextColumn;
use cells::Words;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
pub use text::TextFormat;

/// Largest file that is read [byte].
const MAX_BYTES: u64 = 1 << 30;

/// One column of a [`Table`].
#[derive(Debug, Clone, PartialEq)]
pub struct Column {
    /// As in the file; columns of a list or of an array are `name[1]`, `name[2]`, …; `1`, `2`, … where the file has no
    /// names.
    pub name: String,
    /// One number for each row (n_rows), NaN where there is none.
    pub values: Vec<f64>,
}

/// Columns of equal length.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Table {
    columns: Vec<Column>,
    /// Number of each row in messages (n_rows): its line, or its number from 1.
    rows: Vec<u64>,
    is_text: bool,
    /// The cells of a column that are words, by column.
    words: BTreeMap<usize, Words>,
    /// Columns of stamps: the second that their numbers count from [s].
    clocks: BTreeMap<usize, f64>,
    /// Columns whose numbers are seconds, independent of their names.
    seconds: BTreeSet<usize>,
    /// Columns that came from another clock: where they have no number is a gap.
    with_gaps: BTreeSet<usize>,
    /// Units by a row of units (n_columns), or nothing.
    units: Vec<String>,
    /// Columns of the file that are no columns here, and what they are.
    left_out: Vec<(String, &'static str)>,
    /// Rows that have another number of cells than the first: row, cells.
    uneven: Vec<(usize, usize)>,
}

/// Rows to keep: those in which a column has this value.
#[derive(Debug, Clone, PartialEq)]
pub struct RowFilter {
    /// Name of the column.
    pub column: String,
    /// The cell as in the file, or a number equal to it.
    pub value: String,
}

impl RowFilter {
    /// The filter of `COLUMN=VALUE`.
    ///
    /// # Errors
    /// `BadInput` at `place` for anything else.
    pub fn parse(place: &str, text: &str) -> std::result::Result<Self, BadInput> {
        match text.split_once('=') {
            Some((column, value)) if !column.trim().is_empty() => {
                Ok(Self { column: column.trim().to_owned(), value: value.trim().to_owned() })
            }
            _ => Err(BadInput::new(place, "COLUMN=VALUE", format!("\"{text}\""))),
        }
    }
}

impl Table {
    /// A table of these columns, as a program that has its own format makes it.
    ///
    /// # Errors
    /// `BadInput` where there is no row, or columns differ in length.
    pub fn new(columns: Vec<Column>) -> std::result::Result<Self, BadInput> {
        let n = columns.first().map_or(0, |column| column.values.len());
        if n == 0 {
            return Err(BadInput::new("rows", "at least one", "none"));
        }
        if let Some(other) = columns.iter().find(|column| column.values.len() != n) {
            let expected = format!("{n} rows, as \"{}\" has", columns[0].name);
            return Err(BadInput::new(&other.name, expected, other.values.len().to_string()));
        }
        check_size(columns.len(), n as u64)?;
        Ok(Self { columns, rows: (1..=n as u64).collect(), ..Self::default() })
    }

    /// Reads a table, `.csv`, `.txt`, `.tsv`, `.dat`, `.parquet`, `.npz`, `.npy` or `.mat` by its extension; with a filter only the
    /// rows that it accepts.
    ///
    /// # Errors
    /// `BadInput` naming the file and what is wrong in it; `Io` if it cannot be read.
    pub fn read(path: &Path, filter: Option<&RowFilter>) -> Result<Self> {
        Self::read_as(path, filter, &TextFormat::default())
    }

    /// The same, with the separator of a text table given by the user.
    ///
    /// # Errors
    /// As [`Table::read`].
    pub fn read_as(path: &Path, filter: Option<&RowFilter>, format: &TextFormat) -> Result<Self> {
        let place = path.display().to_string();
        let extension = path.extension().and_then(|extension| extension.to_str()).unwrap_or_default();
        let table = match extension.to_ascii_lowercase().as_str() {
            "csv" | "txt" | "tsv" | "dat" => {
                text::read(&text::decoded(file::read_up_to(path, MAX_BYTES)?), format)
            }
            "parquet" => parquet::read(file::open(path, MAX_BYTES)?),
            "npz" => npz::read_archive(&file::read_up_to(path, MAX_BYTES)?),
            "npy" => npz::read_single(&file::read_up_to(path, MAX_BYTES)?),
            "mat" => mat::read(&file::read_up_to(path, MAX_BYTES)?),
            other => {
                let found = if other.is_empty() { "no extension".to_owned() } else { format!(".{other}") };
                Err(BadInput::new("", "a table: .csv, .txt, .tsv, .dat, .parquet, .npz, .npy or .mat", found))
            }
        };
        let filtered = table.and_then(|table| match filter {
            Some(filter) => table.filtered(filter),
            None => Ok(table),
        });
        Ok(filtered.map_err(|bad| bad.within(place))?)
    }

    /// All columns, in the order of the file.
    pub fn columns(&self) -> &[Column] {
        &self.columns
    }

    /// Number of rows, at least one.
    pub fn n_rows(&self) -> usize {
        self.rows.len()
    }

    /// Memory of its numbers [byte].
    pub(crate) fn n_bytes(&self) -> usize {
        8 * self.n_rows() * (1 + self.columns.len())
    }

    /// Index of the column called `name`.
    pub fn index(&self, name: &str) -> Option<usize> {
        self.columns.iter().position(|column| column.name == name)
    }

    /// Name of row `row` (from 0) in messages: `line 3` or `row 2`.
    pub fn row_name(&self, row: usize) -> String {
        format!("{} {}", if self.is_text { "line" } else { "row" }, self.rows[row])
    }

    /// Rows that have another number of cells than the first (n_cells), with it; their numbers are NaN.
    pub fn uneven(&self) -> &[(usize, usize)] {
        &self.uneven
    }

    /// The word in a cell that holds one.
    pub fn word(&self, column: usize, row: usize) -> Option<&str> {
        self.words.get(&column)?.at(row)
    }

    /// True where a column holds a word.
    pub fn has_words(&self, column: usize) -> bool {
        self.words.contains_key(&column)
    }

    /// Of a column of stamps: the second that its numbers count from [s since 1970, or since midnight].
    pub fn clock(&self, column: usize) -> Option<f64> {
        self.clocks.get(&column).copied()
    }

    /// Whether a column's numbers are seconds, independent of its name: stamps and durations.
    pub fn is_in_seconds(&self, column: usize) -> bool {
        self.seconds.contains(&column) || self.clocks.contains_key(&column)
    }

    /// True where a row without a number is a gap of the column, and not a fault.
    pub(crate) fn has_gaps(&self, column: usize) -> bool {
        self.with_gaps.contains(&column)
    }

    /// One more column, of another clock (n_rows).
    pub(crate) fn add_with_gaps(&mut self, name: String, values: Vec<f64>) {
        self.with_gaps.insert(self.columns.len());
        self.columns.push(Column { name, values });
    }

    /// Other values of a column, at the times of the rows (n_rows).
    pub(crate) fn replace_with_gaps(&mut self, column: usize, values: Vec<f64>) {
        self.with_gaps.insert(column);
        self.columns[column].values = values;
    }

    /// Unit of a column by the row of units; empty where there is none.
    pub fn unit(&self, column: usize) -> &str {
        self.units.get(column).map_or("", String::as_str)
    }

    /// Columns of the file that are left out, and what they hold.
    pub fn left_out(&self) -> &[(String, &'static str)] {
        &self.left_out
    }

    /// Content of a cell, for messages.
    pub fn shown(&self, column: usize, row: usize) -> String {
        match self.word(column, row) {
            Some(text) => format!("\"{text}\""),
            None if self.columns[column].values[row].is_nan() => "no number".to_owned(),
            None => self.columns[column].values[row].to_string(),
        }
    }

    /// The rows that a filter accepts: by the words of a column, or by its numbers.
    ///
    /// # Errors
    /// `BadInput` where there is no such column, or no such row.
    pub fn filtered(self, filter: &RowFilter) -> std::result::Result<Self, BadInput> {
        let Some(by) = self.index(&filter.column) else {
            return Err(BadInput::new("filter", format!("a column \"{}\"", filter.column), self.names()));
        };
        let number = filter.value.parse::<f64>().ok();
        let accepts = |row: &usize| match self.word(by, *row) {
            Some(word) => word == filter.value,
            None => number == Some(self.columns[by].values[*row]),
        };
        let keep: Vec<usize> = (0..self.n_rows()).filter(accepts).collect();
        if keep.is_empty() {
            let expected = format!("a row with {} = {}", filter.column, filter.value);
            return Err(BadInput::new("filter", expected, "none"));
        }
        Ok(self.taken(&keep))
    }

    /// These rows, from 0, in this order.
    pub fn taken(&self, rows: &[usize]) -> Self {
        let column = |column: &Column| {
            let values = rows.iter().map(|row| column.values[*row]).collect();
            Column { name: column.name.clone(), values }
        };
        let mut place = vec![None; self.n_rows()];
        rows.iter().enumerate().for_each(|(k, row)| place[*row] = Some(k));
        Self {
            columns: self.columns.iter().map(column).collect(),
            rows: rows.iter().map(|row| self.rows[*row]).collect(),
            words: self.words.iter().map(|(k, words)| (*k, words.taken(rows))).collect(),
            uneven: self.uneven.iter().filter_map(|(row, n)| Some((place[*row]?, *n))).collect(),
            is_text: self.is_text,
            clocks: self.clocks.clone(),
            with_gaps: self.with_gaps.clone(),
            seconds: self.seconds.clone(),
            units: self.units.clone(),
            left_out: self.left_out.clone(),
        }
    }

    /// The names of the columns, for a message.
    pub fn names(&self) -> String {
        let most = 60;
        let mut names: Vec<&str> =
            self.columns.iter().take(most).map(|column| column.name.as_str()).collect();
        if self.columns.len() > most {
            names.push("…");
        }
        names.join(", ")
    }
}

#[cfg(test)]
mod parquet_tests;
#[cfg(test)]
mod tests;
