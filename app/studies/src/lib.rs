//! Studies of learned inverse dynamics, cell by cell: finished cells are read again, others resume from their
//! files.

pub mod estimation;
pub mod force;
pub mod identification;
pub mod neural;
mod published;
mod real;
mod side_by_side;
mod simulated;

use std::path::Path;

use hysteron_base::{BadInput, file, json};
use hysteron_learn::{Error, Result, TrainingProgress};
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::Value;

pub use published::{PublishedRow, published, published_parts};
pub use real::{RealOptions, RealRow, real_study, shown_samples};
pub use simulated::{
    Parts, SimulatedRow, SimulatedStudy, Units, characters_study, simulated_study, simulated_test,
};

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

/// The cell of this name from its file, or computed and written there. None where it was ended before its time.
///
/// # Errors
/// A file of another study, or the error of the computation.
fn cell<R: Serialize + DeserializeOwned>(
    folder: &Path,
    name: &str,
    identity: &Value,
    compute: impl FnOnce() -> Result<Option<R>>,
) -> Result<Option<R>> {
    let path = folder.join(format!("{name}.json"));
    let damaged = |e: serde_json::Error| {
        BadInput::new(path.display().to_string(), "a cell of this study", e.to_string())
    };
    if path.exists() {
        let found: Value = json::from_text(&file::read_text(&path)?).map_err(damaged)?;
        if found["identity"] != *identity {
            return Err(BadInput::new(
                path.display().to_string(),
                "a cell of this study",
                "one of other settings",
            )
            .hint("remove the folder to begin anew")
            .into());
        }
        return Ok(Some(json::from_value(&found["row"].clone()).map_err(damaged)?));
    }
    let Some(row) = compute()? else { return Ok(None) };
    let text = json::to_text(&json!({ "identity": identity, "row": row })).map_err(damaged)?;
    file::write_bytes(&path, text)?;
    Ok(Some(row))
}

/// # Errors
/// If the folder cannot be made.
fn make_folder(path: &Path) -> Result<()> {
    std::fs::create_dir_all(path).map_err(|e| Error::from(hysteron_base::Error::io(path, e)))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)] // a test may stop where it stands
    use super::*;

    #[test]
    fn a_cell_reads_back_whatever_its_numbers_are() {
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
}
