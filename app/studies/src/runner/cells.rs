//! Cells of a study: each is computed once, kept in a file with a stamp of what it was made from, and read again.

use std::path::Path;

use hysteron_base::{BadInput, file, json};
use hysteron_learn::{Error, Result, TrainingProgress};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

/// Progress of a study.
#[derive(Debug, Clone, Copy)]
pub struct StudyProgress<'a> {
    /// The cell at hand.
    pub cell: &'a str,
    /// Cells done, and in all.
    pub done: [usize; 2],
    /// Within the cell's training; none when the cell begins or is over.
    pub training: Option<TrainingProgress>,
}

/// Gets the progress; ends the study where it returns false.
pub type Listener<'a> = &'a mut dyn FnMut(&StudyProgress<'_>) -> bool;

/// Counts cells that are done one after the other, and reports each to a listener as it begins.
pub struct Steps<'a, 'b> {
    /// Hears of every cell.
    pub listener: &'a mut Listener<'b>,
    /// Cells done, and in all.
    pub done: [usize; 2],
}

impl Steps<'_, '_> {
    /// Reports the next cell; false where the study is to end.
    pub fn begin(&mut self, cell: &str) -> bool {
        let continues = (self.listener)(&StudyProgress { cell, done: self.done, training: None });
        self.done[0] += 1;
        continues
    }
}

/// The stamp in the file of a cell.
#[derive(Deserialize)]
struct CellStamp {
    identity: json::Value,
}

/// The file of a cell as it is read.
#[derive(Deserialize)]
struct CellFile<R> {
    row: R,
}

/// The cell of this name from its file, or computed and written there. None where it was ended before its time.
///
/// # Errors
/// A file of another study, or the error of the computation.
pub fn cell<R: Serialize + DeserializeOwned>(
    folder: &Path,
    name: &str,
    identity: &impl Serialize,
    compute: impl FnOnce() -> Result<Option<R>>,
) -> Result<Option<R>> {
    let path = folder.join(format!("{name}.json"));
    let damaged =
        |e: json::Error| BadInput::new(path.display().to_string(), "a cell of this study", e.to_string());
    if path.exists() {
        let text = file::read_text(&path)?;
        let stamp: CellStamp = json::from_text(&text).map_err(damaged)?;
        if stamp.identity != json::to_value(identity).map_err(damaged)? {
            return Err(BadInput::new(
                path.display().to_string(),
                "a cell of this study",
                "one of other settings",
            )
            .hint("remove the folder to begin anew")
            .into());
        }
        let found: CellFile<R> = json::from_text(&text).map_err(damaged)?;
        return Ok(Some(found.row));
    }
    let Some(row) = compute()? else { return Ok(None) };
    let text = json::to_text(&json!({ "identity": identity, "row": row })).map_err(damaged)?;
    file::write_bytes(&path, text)?;
    Ok(Some(row))
}

/// Makes the folder of the cells.
///
/// # Errors
/// If the folder cannot be made.
pub fn make_folder(path: &Path) -> Result<()> {
    std::fs::create_dir_all(path).map_err(|e| Error::from(hysteron_base::Error::io(path, e)))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)] // a test may stop where it stands
    use super::*;

    #[test]
    fn a_cell_reads_back_with_any_numbers() {
        let folder = tempfile::tempdir().unwrap();
        let identity = json!({ "seed": 1 });
        let numbers = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, -0.0, 5e-324, f64::MAX, 0.1];
        let row = (numbers, Some(f64::NAN), vec![[f64::INFINITY; 2]]);
        type Row = ([f64; 7], Option<f64>, Vec<[f64; 2]>);
        let of = |compute: &mut dyn FnMut() -> Result<Option<Row>>| {
            cell(folder.path(), "a", &identity, compute).unwrap().unwrap()
        };
        let computed = of(&mut || Ok(Some(row.clone())));
        let read = of(&mut || panic!("the cell is there"));
        assert_eq!(format!("{computed:?}"), format!("{read:?}"));
    }

    #[test]
    fn a_cell_of_other_settings_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let one = |seed: u64| cell(folder.path(), "a", &json!({ "seed": seed }), || Ok(Some(seed)));
        assert_eq!(one(1).unwrap(), Some(1));
        assert_eq!(one(1).unwrap(), Some(1));
        let error = one(2).unwrap_err().to_string();
        assert!(error.contains("expected a cell of this study, got one of other settings"), "{error}");
    }
}
