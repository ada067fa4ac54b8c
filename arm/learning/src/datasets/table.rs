//! Numbers in columns of a text file.

use std::path::Path;

use hysteron_base::{BadInput, file};

use hysteron_base::Result;

/// A text file of columns with a header.
pub(crate) struct TextTable {
    path: String,
    names: Vec<String>,
    rows: Vec<Vec<String>>,
}

impl TextTable {
    /// Reads columns parted by `separator`.
    ///
    /// # Errors
    /// `BadInput` naming the line that has another number of columns.
    pub fn read(path: &Path, separator: char) -> Result<Self> {
        let bytes = file::read_bytes(path)?;
        let text = String::from_utf8_lossy(&bytes).into_owned();
        let name = path.display().to_string();
        let cells =
            |line: &str| line.trim().split(separator).map(|c| c.trim().to_owned()).collect::<Vec<_>>();
        let mut lines = text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty());
        let names = lines.next().map(|(_, line)| cells(line)).unwrap_or_default();
        let mut rows = Vec::new();
        for (i, line) in lines {
            let row = cells(line);
            if row.len() != names.len() {
                let place = format!("{name}: line {}", i + 1);
                return Err(
                    BadInput::new(place, format!("{} columns", names.len()), row.len().to_string()).into()
                );
            }
            rows.push(row);
        }
        Ok(Self { path: name, names, rows })
    }

    fn index(&self, name: &str) -> std::result::Result<usize, BadInput> {
        let found = self.names.iter().position(|n| n == name);
        found.ok_or_else(|| BadInput::new(&self.path, format!("a column {name}"), self.names.join(", ")))
    }

    /// The texts of a column.
    ///
    /// # Errors
    /// Where there is no such column.
    pub fn texts(&self, name: &str) -> std::result::Result<Vec<&str>, BadInput> {
        let k = self.index(name)?;
        Ok(self.rows.iter().map(|row| &row[k][..]).collect())
    }

    /// These columns side by side: [row][column].
    ///
    /// # Errors
    /// Naming the column that is missing, or the line and column that holds no number.
    pub fn columns(&self, names: &[String]) -> std::result::Result<Vec<f64>, BadInput> {
        let indices: Vec<usize> =
            names.iter().map(|name| self.index(name)).collect::<std::result::Result<_, _>>()?;
        let mut values = Vec::with_capacity(self.rows.len() * names.len());
        for (i, row) in self.rows.iter().enumerate() {
            for (k, name) in indices.iter().zip(names) {
                let value = row[*k].parse::<f64>().ok().filter(|v| v.is_finite());
                values.push(value.ok_or_else(|| {
                    BadInput::new(
                        format!("{}: line {}: {name}", self.path, i + 2),
                        "a finite number",
                        &row[*k][..],
                    )
                })?);
            }
        }
        Ok(values)
    }
}
