//! Memory that a verb needs for a recording, asked for before it works: an allocation that the system refuses ends a program
//! where it stands, without a message that helps.
//!
//! A reader reserves memory for its input. The memory of results is reserved here, by the sizes known then.

use std::path::Path;

use hysteron_base::size::check_memory;
use hysteron_base::{BadInput, Recording};

/// Memory of a verb's work on a recording, over that of its numbers: the rows that are measured, the series that it works with [-].
const COPIES: f64 = 2.0;
/// A number of a result as it is computed, in the recording, and in the file, which may have room for twice its length [byte].
const BYTES_OF_RESULT: f64 = 32.0;
const SHORTER: &str = "split the recording, resample it to a lower rate, or allow more memory";

/// Reads a recording that a verb works with.
///
/// # Errors
/// Those of reading; `BadInput` naming the file where there is no memory for what is made of it.
pub fn recording(path: &Path) -> hysteron_base::Result<Recording> {
    let recording = Recording::read(path)?;
    check_copies(&path.display().to_string(), [&recording])?;
    Ok(recording)
}

/// Accepts recordings that a verb works with at once.
///
/// # Errors
/// `BadInput` where there is no memory for what is made of them.
pub fn check_copies<'a>(
    place: &str,
    recordings: impl IntoIterator<Item = &'a Recording>,
) -> Result<(), BadInput> {
    let n_bytes: usize = recordings.into_iter().map(Recording::n_bytes).sum();
    check_memory(place, COPIES * n_bytes as f64, SHORTER)
}

/// Accepts a result of so many rows and columns.
///
/// # Errors
/// `BadInput` where there is no memory for it.
pub fn check_result(place: &Path, n_rows: usize, n_columns: usize) -> Result<(), BadInput> {
    let bytes = BYTES_OF_RESULT * n_rows as f64 * n_columns as f64;
    check_memory(&place.display().to_string(), bytes, SHORTER)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)] // a test may stop where it stands
    use super::*;

    #[test]
    fn a_result_counts_with_all_its_rows_and_columns() {
        let free = hysteron_base::size::free_memory() as f64;
        let n_columns = 16;
        let n_rows = |share: f64| (share * free / BYTES_OF_RESULT / n_columns as f64) as usize;
        // Eight tenths of the memory may be asked for; what is free varies meanwhile.
        check_result(Path::new("out"), n_rows(0.1), n_columns).unwrap();
        let error = check_result(Path::new("out"), n_rows(8.0), n_columns).unwrap_err();
        assert_eq!(error.place, "out");
        assert!(error.hint.contains("split the recording"), "{error:?}");
    }
}
