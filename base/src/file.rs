//! Reading whole files and writing them atomically.
//!
//! A file is written under a temporary name in its own folder, flushed to the disk and then renamed. Whatever
//! goes wrong, an interrupt included, the final name holds either the old content or the new, never a part.

use crate::{BadInput, Error, Result};
use sha2::{Digest, Sha256};
use std::io::{BufWriter, Write};
use std::path::Path;

/// Writes `path` through `content`, which is given a buffered writer. Parent folders are created.
///
/// # Errors
/// `Io` if the file system refuses or `content` fails; `path` is then as it was before.
pub fn write_with(path: &Path, content: impl FnOnce(&mut dyn Write) -> std::io::Result<()>) -> Result<()> {
    write_and_rename(path, content).map_err(|refusal| Error::Io { path: path.to_owned(), refusal })
}

/// Writes `path` with these bytes; see [`write_with`].
///
/// # Errors
/// `Io` if the file system refuses; `path` is then as it was before.
pub fn write_bytes(path: &Path, bytes: impl AsRef<[u8]>) -> Result<()> {
    write_with(path, |out| out.write_all(bytes.as_ref()))
}

fn write_and_rename(
    path: &Path,
    content: impl FnOnce(&mut dyn Write) -> std::io::Result<()>,
) -> std::io::Result<()> {
    let folder = match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    std::fs::create_dir_all(folder)?;
    let mut builder = tempfile::Builder::new();
    builder.prefix(".hysteron-").suffix(".tmp");
    #[cfg(unix)]
    {
        // What a plain create gives: readable by others where the umask allows it.
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    // Removed when dropped, so an early return leaves nothing behind.
    let mut out = BufWriter::new(builder.tempfile_in(folder)?);
    content(&mut out)?;
    let temporary = out.into_inner().map_err(std::io::IntoInnerError::into_error)?;
    temporary.as_file().sync_all()?;
    temporary.persist(path).map_err(|e| e.error)?;
    Ok(())
}

/// The bytes of a file.
///
/// # Errors
/// `BadInput` if there is no such file, `Io` if it cannot be read.
pub fn read_bytes(path: &Path) -> Result<Vec<u8>> {
    std::fs::read(path).map_err(|refusal| Error::io(path, refusal))
}

/// The text of a file.
///
/// # Errors
/// As [`read_bytes`], and `BadInput` naming the line if it is not UTF-8.
pub fn read_text(path: &Path) -> Result<String> {
    Ok(text_of(read_bytes(path)?, &path.display().to_string())?)
}

/// Takes bytes as UTF-8; `place` is named in the error.
pub(crate) fn text_of(bytes: Vec<u8>, place: &str) -> std::result::Result<String, BadInput> {
    String::from_utf8(bytes).map_err(|e| {
        let at = e.utf8_error().valid_up_to();
        let line = 1 + e.as_bytes()[..at].iter().filter(|b| **b == b'\n').count();
        BadInput::new(
            format!("{place}: line {line}"),
            "text in UTF-8",
            format!("byte {:#04x}", e.as_bytes()[at]),
        )
        .hint("save the file as UTF-8")
    })
}

/// SHA-256 as 64 lower-case hexadecimal digits: how scenes and meshes are identified.
pub fn sha256_hex(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)] // a test may stop where it stands
    use super::*;

    fn names_in(folder: &Path) -> Vec<String> {
        let names = std::fs::read_dir(folder).unwrap();
        names.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect()
    }

    #[test]
    fn parents_are_created_and_content_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a/b/file.txt");
        write_bytes(&path, "old").unwrap();
        write_bytes(&path, "new").unwrap();
        assert_eq!(read_text(&path).unwrap(), "new");
        assert_eq!(names_in(&folder.path().join("a/b")), ["file.txt"]);
    }

    #[test]
    fn failed_content_leaves_the_old_file_and_no_other() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("file.txt");
        write_bytes(&path, "old").unwrap();
        let result = write_with(&path, |out| {
            out.write_all(b"half")?;
            Err(std::io::Error::other("stopped"))
        });
        assert!(matches!(result, Err(Error::Io { .. })));
        assert_eq!(read_text(&path).unwrap(), "old");
        assert_eq!(names_in(folder.path()), ["file.txt"]);
    }

    #[test]
    fn failed_first_write_leaves_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("file.txt");
        assert!(write_with(&path, |_| Err(std::io::Error::other("stopped"))).is_err());
        assert!(names_in(folder.path()).is_empty());
    }

    #[test]
    fn a_folder_in_the_way_is_an_io_error() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::create_dir(folder.path().join("x")).unwrap();
        assert!(matches!(write_bytes(&folder.path().join("x"), "a"), Err(Error::Io { .. })));
        assert_eq!(names_in(folder.path()), ["x"]);
    }

    #[test]
    fn missing_file_and_wrong_encoding_are_bad_input() {
        let folder = tempfile::tempdir().unwrap();
        assert!(matches!(read_bytes(&folder.path().join("none")), Err(Error::BadInput(_))));
        let path = folder.path().join("latin1.txt");
        write_bytes(&path, b"one\ntw\xf6\n").unwrap();
        let Err(Error::BadInput(bad)) = read_text(&path) else { panic!("accepted") };
        assert!(bad.place.ends_with("latin1.txt: line 2"), "{bad}");
        assert_eq!(bad.found, "byte 0xf6");
    }

    #[cfg(unix)]
    #[test]
    fn files_are_as_readable_as_a_plain_create_makes_them() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let (plain, ours) = (folder.path().join("plain"), folder.path().join("ours"));
        std::fs::write(&plain, "").unwrap();
        write_bytes(&ours, "").unwrap();
        let mode = |path: &Path| std::fs::metadata(path).unwrap().permissions().mode();
        assert_eq!(mode(&ours), mode(&plain));
    }

    #[test]
    fn sha256_of_abc_is_the_published_one() {
        // FIPS 180-2, appendix B.1.
        let expected = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
        assert_eq!(sha256_hex(b"abc"), expected);
    }
}
