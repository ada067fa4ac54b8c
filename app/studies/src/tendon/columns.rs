//! Tables of other people: CSV files with a heading.

use std::path::Path;

use anyhow::{Context, Result};
use csv::StringRecord;

/// A file in memory.
pub struct Columns {
    /// Its path, for errors.
    place: String,
    /// Names of the columns.
    pub header: StringRecord,
    /// Its rows.
    pub rows: Vec<StringRecord>,
}

impl Columns {
    /// Reads a file.
    ///
    /// # Errors
    /// It cannot be read, or is no table.
    pub fn read(path: &Path) -> Result<Self> {
        let place = path.display().to_string();
        let mut reader = csv::ReaderBuilder::new()
            .comment(Some(b'#'))
            .trim(csv::Trim::All)
            .from_path(path)
            .with_context(|| place.clone())?;
        let header = reader.headers().with_context(|| place.clone())?.clone();
        let rows = reader.records().collect::<Result<_, _>>().with_context(|| place.clone())?;
        Ok(Self { place, header, rows })
    }

    /// Where the column of this name is.
    ///
    /// # Errors
    /// There is none.
    pub fn at(&self, name: &str) -> Result<usize> {
        self.header.iter().position(|h| h == name).with_context(|| format!("{}: no {name}", self.place))
    }

    /// The numbers in the columns of these names, row by row.
    ///
    /// # Errors
    /// A column is missing, or an entry is no number.
    pub fn rows_of(&self, names: &[impl AsRef<str>]) -> Result<Vec<Vec<f64>>> {
        let at = names.iter().map(|name| self.at(name.as_ref())).collect::<Result<Vec<usize>>>()?;
        self.rows.iter().map(|row| at.iter().map(|&k| self.number(row, k)).collect()).collect()
    }

    /// The number in that column of a row.
    ///
    /// # Errors
    /// It is none.
    pub fn number(&self, row: &StringRecord, column: usize) -> Result<f64> {
        row[column].parse().with_context(|| format!("{}: {:?}", self.place, &row[column]))
    }
}

/// The columns `names` of a file, each of them numbers.
///
/// # Errors
/// A missing file or column, or an entry that is not a number.
pub fn read_columns(path: &Path, names: &[&str]) -> Result<Vec<Vec<f64>>> {
    let table = Columns::read(path)?;
    let column = |name: &&str| -> Result<Vec<f64>> {
        let at = table.at(name)?;
        table.rows.iter().map(|row| table.number(row, at)).collect()
    };
    names.iter().map(column).collect()
}
