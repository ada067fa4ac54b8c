//! Tables of numbers that other programs wrote: CSV, Parquet, NumPy's `.npy` and `.npz`.
//!
//! Nothing is assumed of names, units or completeness: a cell without a number is NaN, and whoever takes a column
//! decides what that means. Recordings of this project have a reader of their own, which is stricter.

mod npz;
mod parquet;
mod text;

use crate::recording::{check_size, csv_text};
use crate::{BadInput, Result, file};
use std::path::Path;

/// Largest file that is read [byte].
const MOST: u64 = 1 << 30;

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
    /// What a message calls a row (n_rows): its line, or its number from 1.
    rows: Vec<u64>,
    is_text: bool,
    /// The first cell of a column that is no number: column, row, what stands there.
    words: Vec<(usize, usize, String)>,
    /// Rows that have another number of cells than the first: row, cells.
    uneven: Vec<(usize, usize)>,
}

/// Rows to keep: those in which a column has this value.
#[derive(Debug, Clone, PartialEq)]
pub struct Filter {
    /// Name of the column.
    pub column: String,
    /// The cell as it stands in the file, or a number equal to it.
    pub value: String,
}

impl Filter {
    fn accepts(&self, cell: &str) -> bool {
        cell == self.value || self.number().is_some_and(|wanted| cell.parse() == Ok(wanted))
    }

    fn number(&self) -> Option<f64> {
        self.value.parse().ok()
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

    /// Reads a table, `.csv`, `.txt`, `.tsv`, `.parquet`, `.npz` or `.npy` by its extension; with a filter only the
    /// rows that it accepts.
    ///
    /// # Errors
    /// `BadInput` naming the file and what is wrong in it; `Io` if it cannot be read.
    pub fn read(path: &Path, filter: Option<&Filter>) -> Result<Self> {
        let place = path.display().to_string();
        let extension = path.extension().and_then(|extension| extension.to_str()).unwrap_or_default();
        let table = match extension.to_ascii_lowercase().as_str() {
            "csv" | "txt" | "tsv" | "dat" => {
                return Ok(text::read(&csv_text(path)?, filter).map_err(|bad| bad.within(place))?);
            }
            "parquet" => parquet::read(file::open(path, MOST)?),
            "npz" => npz::read_archive(&file::read_up_to(path, MOST)?),
            "npy" => npz::read_single(&file::read_up_to(path, MOST)?),
            other => {
                let found = if other.is_empty() { "no extension".to_owned() } else { format!(".{other}") };
                Err(BadInput::new("", "a table: .csv, .txt, .tsv, .parquet, .npz or .npy", found))
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

    /// Index of the column called `name`.
    pub fn index(&self, name: &str) -> Option<usize> {
        self.columns.iter().position(|column| column.name == name)
    }

    /// What a message calls row `row` (from 0): `line 3` or `row 2`.
    pub fn row_name(&self, row: usize) -> String {
        format!("{} {}", if self.is_text { "line" } else { "row" }, self.rows[row])
    }

    /// Rows that have another number of cells than the first (n_cells), with it; their numbers are NaN.
    pub fn uneven(&self) -> &[(usize, usize)] {
        &self.uneven
    }

    /// What stands in a cell that has no number.
    pub fn shown(&self, column: usize, row: usize) -> String {
        let word = self.words.iter().find(|(c, r, _)| (*c, *r) == (column, row));
        match word {
            Some((.., text)) => format!("\"{text}\""),
            None if self.columns[column].values[row].is_nan() => "no number".to_owned(),
            None => self.columns[column].values[row].to_string(),
        }
    }

    /// The rows that a filter accepts, by numbers.
    ///
    /// # Errors
    /// `BadInput` where there is no such column, or no such row.
    pub fn filtered(self, filter: &Filter) -> std::result::Result<Self, BadInput> {
        let Some(by) = self.index(&filter.column) else {
            return Err(BadInput::new("filter", format!("a column \"{}\"", filter.column), self.names()));
        };
        let wanted = filter.number();
        let keep: Vec<bool> = self.columns[by].values.iter().map(|value| Some(*value) == wanted).collect();
        if !keep.contains(&true) {
            return Err(BadInput::new(
                "filter",
                format!("a row with {} = {}", filter.column, filter.value),
                "none",
            ));
        }
        let kept =
            |values: &[f64]| values.iter().zip(&keep).filter(|(_, keep)| **keep).map(|(x, _)| *x).collect();
        let columns =
            self.columns.iter().map(|c| Column { name: c.name.clone(), values: kept(&c.values) }).collect();
        let rows = self.rows.iter().zip(&keep).filter(|(_, keep)| **keep).map(|(row, _)| *row).collect();
        Ok(Self { columns, rows, ..Self::default() })
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
mod tests;
