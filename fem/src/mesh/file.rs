//! Whole files only: written beside their place, then renamed into it.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;

use hysteron_base::BadInput;

use crate::{Error, Result};

/// Wraps a refusal of the file system; a missing file is bad input.
pub(crate) fn io_error(path: &Path, source: std::io::Error) -> Error {
    match hysteron_base::Error::io(path, source) {
        hysteron_base::Error::BadInput(bad) => Error::BadInput(bad),
        other => Error::File(other),
    }
}

/// Writes a file so that a reader finds the old one or the whole new one, never a part.
pub(crate) fn write_atomically(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<File>) -> std::io::Result<()>,
) -> Result<()> {
    let Some(name) = path.file_name() else {
        return Err(
            BadInput::new(path.display().to_string(), "the name of a file to write", "a folder").into()
        );
    };
    let mut hidden = std::ffi::OsString::from(".");
    hidden.push(name);
    hidden.push(format!(".{}.part", std::process::id()));
    let part = path.with_file_name(hidden);
    let written = File::create(&part).and_then(|file| {
        let mut out = BufWriter::new(file);
        write(&mut out)?;
        out.flush()?;
        drop(out);
        std::fs::rename(&part, path)
    });
    written.map_err(|e| {
        // The part is of no use; the first refusal is the one to report.
        let _ = std::fs::remove_file(&part);
        match e.kind() {
            std::io::ErrorKind::NotFound => {
                BadInput::new(path.display().to_string(), "a file in an existing folder", "no such folder")
                    .hint("make the folder first")
                    .into()
            }
            _ => io_error(path, e),
        }
    })
}
