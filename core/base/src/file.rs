//! Reading whole files and writing them atomically.
//!
//! A file is written under a temporary name in its own folder, flushed to the disk and then renamed; the folder's entry
//! is flushed too. Whatever goes wrong, an interrupt included, the final name holds either the old content or the new,
//! never a part. Only regular files are read, and none beyond a stated size.

use crate::size::check_memory;
use crate::{BadInput, Error, Result};
use sha2::{Digest, Sha256};
use std::collections::BTreeSet;
use std::fs::File;
use std::io::{BufWriter, Read, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// So begin and end the names of files that are being written; each is locked by the program that writes it.
const TEMPORARY: (&str, &str) = (".hysteron-", ".tmp");
/// Largest file that is read [byte].
const MAX_BYTES: u64 = 1 << 30;
/// Largest file of text that a person types [byte].
const MAX_TEXT: u64 = 16 << 20;

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
    let folder = folder_of(path);
    let is_there = |folder: &Path| folder.as_os_str().is_empty() || folder.exists();
    let there = folder.ancestors().position(is_there).unwrap_or(0);
    std::fs::create_dir_all(folder)?;
    // Removed when dropped, so an early return leaves nothing behind.
    let temporary = temporary_in(folder)?;
    let _unfinished = TemporaryFile(temporary.path().to_owned());
    // To the file itself: errors of what `tempfile` wraps around it name the temporary file, which the user does not know.
    let mut out = BufWriter::new(temporary.as_file());
    content(&mut out)?;
    out.into_inner().map_err(std::io::IntoInnerError::into_error)?.sync_all()?;
    temporary.persist(path).map_err(|e| e.error)?;
    // The entry of the file, and those of folders that are new.
    folder.ancestors().take(there + 1).try_for_each(sync_folder)
}

/// The folder of a file; `.` where its name has none.
pub fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

/// Longest name of a file that is written [byte]: of the 255 that file systems have, it leaves room for the names that are
/// made from it, of its lock, journal and events.
const MAX_NAME: usize = 240;

/// Accepts the name of a file that is to be written.
///
/// # Errors
/// `BadInput` for one that leaves no room for names that are made from it.
pub fn check_name(path: &Path) -> std::result::Result<(), BadInput> {
    let length = path.file_name().map_or(0, |name| name.as_encoded_bytes().len());
    if length <= MAX_NAME {
        return Ok(());
    }
    let shown = path.display().to_string();
    Err(BadInput::new(shown, format!("a name of at most {MAX_NAME} bytes"), format!("{length} bytes"))
        .hint("choose a shorter name: files that are kept next to it are named after it"))
}

/// Files of this process that have their temporary names.
static UNFINISHED: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

fn unfinished() -> MutexGuard<'static, BTreeSet<PathBuf>> {
    UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// One of them, until it is dropped.
struct TemporaryFile(PathBuf);

impl Drop for TemporaryFile {
    fn drop(&mut self) {
        unfinished().remove(&self.0);
    }
}

/// Removes the temporary files of this process, which then has to end: a thread that writes a file from here on waits.
pub(crate) fn abandon() {
    let files = unfinished();
    for path in &*files {
        // It may have its final name by now.
        let _ = std::fs::remove_file(path);
    }
    std::mem::forget(files);
}

/// A new file with a temporary name, locked, and among those that are unfinished.
fn temporary_in(folder: &Path) -> std::io::Result<tempfile::NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(TEMPORARY.0).suffix(TEMPORARY.1);
    let mut unfinished = unfinished();
    loop {
        // As a plain create makes it: readable by others where the umask allows it.
        let temporary = builder
            .make_in(folder, |path| File::options().read(true).write(true).create_new(true).open(path))?;
        temporary.as_file().lock()?;
        // `clear_temporary` of another program may have come before the lock.
        if temporary.path().exists() {
            unfinished.insert(temporary.path().to_owned());
            return Ok(temporary);
        }
    }
}

/// Flushes the entries of a folder, where the system can.
#[cfg(unix)]
fn sync_folder(folder: &Path) -> std::io::Result<()> {
    use std::io::ErrorKind::{InvalidInput, PermissionDenied, Unsupported};
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    match File::open(folder).and_then(|folder| folder.sync_all()) {
        // Some file systems have nothing to flush there, and some folders may be written but not read.
        Err(error) if !matches!(error.kind(), InvalidInput | PermissionDenied | Unsupported) => Err(error),
        _ => Ok(()),
    }
}

#[cfg(not(unix))]
fn sync_folder(_: &Path) -> std::io::Result<()> {
    Ok(())
}

/// Removes the temporary files in a folder that programs have left which were killed while they wrote. Those that a
/// living program writes are locked, and stay.
pub fn clear_temporary(folder: &Path) {
    let Ok(entries) = std::fs::read_dir(folder) else { return };
    for entry in entries.flatten() {
        let name = entry.file_name();
        let name = name.to_string_lossy();
        let is_file = entry.file_type().is_ok_and(|kind| kind.is_file());
        if !(is_file && name.starts_with(TEMPORARY.0) && name.ends_with(TEMPORARY.1)) {
            continue;
        }
        // The lock is held until the file is gone, so that its writer, if it is just beginning, sees that.
        if let Ok(file) = File::options().read(true).write(true).open(entry.path())
            && file.try_lock().is_ok()
        {
            // One that cannot be removed does no harm.
            let _ = std::fs::remove_file(entry.path());
        }
    }
}

/// Whether two names are of one existing file or folder, with any spelling: links, hard links, dots and,
/// on a disk that ignores it, letter case.
pub fn is_same(a: &Path, b: &Path) -> bool {
    matches!((identity(a), identity(b)), (Some(a), Some(b)) if a == b)
}

#[cfg(unix)]
fn identity(path: &Path) -> Option<(u64, u64)> {
    use std::os::unix::fs::MetadataExt;
    std::fs::metadata(path).ok().map(|metadata| (metadata.dev(), metadata.ino()))
}

#[cfg(not(unix))]
fn identity(path: &Path) -> Option<std::path::PathBuf> {
    path.canonicalize().ok()
}

/// Opens a regular file of at most `most` bytes, for reading.
///
/// # Errors
/// `BadInput` if there is no such file, if it is a folder, a device or a pipe, or larger; `Io` if it cannot be opened.
pub fn open(path: &Path, most: u64) -> Result<File> {
    // Looked at before it is opened: opening a pipe waits for its other end.
    let metadata = std::fs::metadata(path).map_err(|refusal| Error::io(path, refusal))?;
    if !metadata.is_file() {
        let found = if metadata.is_dir() { "a folder" } else { "a device or a pipe" };
        return Err(BadInput::new(path.display().to_string(), "a file", found).into());
    }
    if metadata.len() > most {
        return Err(too_large(path, most, format!("{} bytes", metadata.len())).into());
    }
    File::open(path).map_err(|refusal| Error::io(path, refusal))
}

fn too_large(path: &Path, most: u64, found: String) -> BadInput {
    BadInput::new(path.display().to_string(), format!("a file of at most {most} bytes"), found)
        .hint("is it the right file?")
}

/// The bytes of a regular file, at most a gibibyte.
///
/// # Errors
/// As [`open`].
pub fn read_bytes(path: &Path) -> Result<Vec<u8>> {
    read_up_to(path, MAX_BYTES)
}

/// The bytes of a regular file of at most `most` bytes.
///
/// # Errors
/// As [`open`].
pub fn read_up_to(path: &Path, most: u64) -> Result<Vec<u8>> {
    let file = open(path, most)?;
    let size = file.metadata().map_or(0, |metadata| metadata.len());
    check_memory(&path.display().to_string(), size as f64, "a smaller file, or more memory")?;
    let mut bytes = Vec::with_capacity(usize::try_from(size).unwrap_or(0).saturating_add(1));
    // It may grow, and not every file system knows its size.
    file.take(most + 1).read_to_end(&mut bytes).map_err(|refusal| Error::io(path, refusal))?;
    if bytes.len() as u64 > most {
        return Err(too_large(path, most, "more".to_owned()).into());
    }
    Ok(bytes)
}

/// The first bytes of a regular file, at most `n`.
///
/// # Errors
/// As [`open`].
pub fn read_head(path: &Path, n: usize) -> Result<Vec<u8>> {
    let mut head = Vec::new();
    let file = open(path, u64::MAX)?;
    file.take(n as u64).read_to_end(&mut head).map_err(|refusal| Error::io(path, refusal))?;
    Ok(head)
}

/// The text of a file that a person types, at most 16 MiB.
///
/// # Errors
/// As [`open`], and `BadInput` naming the line if it is not UTF-8.
pub fn read_text(path: &Path) -> Result<String> {
    Ok(text_of(read_up_to(path, MAX_TEXT)?, &path.display().to_string())?)
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

/// SHA-256 of a regular file, without having it in memory; see [`sha256_hex`].
///
/// # Errors
/// As [`open`].
pub fn sha256_of(path: &Path) -> Result<String> {
    let mut file = open(path, MAX_BYTES)?;
    let mut hash = Sha256::new();
    let mut part = vec![0; 1 << 16];
    loop {
        match file.read(&mut part).map_err(|refusal| Error::io(path, refusal))? {
            0 => return Ok(hexadecimal(&hash.finalize())),
            n => hash.update(&part[..n]),
        }
    }
}

fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// SHA-256 as 64 lower-case hexadecimal digits: how scenes and meshes are identified.
pub fn sha256_hex(bytes: &[u8]) -> String {
    hexadecimal(&Sha256::digest(bytes))
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
        let error = write_with(&path, |_| Err(std::io::Error::other("stopped"))).unwrap_err();
        assert!(error.to_string().ends_with("file.txt: stopped"), "{error}");
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
    fn only_regular_files_of_a_bounded_size_are_read() {
        let folder = tempfile::tempdir().unwrap();
        let refused = |path: &Path| match read_up_to(path, 8) {
            Err(Error::BadInput(bad)) => bad.to_string(),
            other => panic!("{other:?}"),
        };
        assert!(refused(Path::new("/dev/zero")).contains("a device or a pipe"));
        let pipe = folder.path().join("pipe");
        assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
        assert!(refused(&pipe).contains("a device or a pipe"));
        assert!(refused(folder.path()).contains("a folder"));
        let path = folder.path().join("nine");
        write_bytes(&path, "123456789").unwrap();
        assert!(refused(&path).contains("at most 8 bytes, got 9 bytes"));
        // Its size is not stated before it is read.
        #[cfg(target_os = "linux")]
        assert!(refused(Path::new("/proc/self/status")).contains("at most 8 bytes, got more"));
        assert_eq!(read_up_to(&path, 9).unwrap(), b"123456789");
    }

    #[test]
    fn temporary_files_of_killed_programs_are_cleared_and_those_of_living_ones_stay() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join(".hysteron-killed.tmp"), "half").unwrap();
        std::fs::write(folder.path().join(".hysteron-notes"), "mine").unwrap();
        let living = temporary_in(folder.path()).unwrap();
        clear_temporary(folder.path());
        let mut expected = vec![living.path().file_name().unwrap().to_str().unwrap().to_owned()];
        expected.push(".hysteron-notes".to_owned());
        expected.sort();
        let mut found = names_in(folder.path());
        found.sort();
        assert_eq!(found, expected);
    }

    #[cfg(unix)]
    #[test]
    fn a_file_is_the_same_under_every_name() {
        let folder = tempfile::tempdir().unwrap();
        let name = |name: &str| folder.path().join(name);
        write_bytes(&name("a"), "a").unwrap();
        write_bytes(&name("b"), "a").unwrap();
        std::fs::hard_link(name("a"), name("hard")).unwrap();
        std::os::unix::fs::symlink(name("a"), name("soft")).unwrap();
        for other in ["a", "./a", "hard", "soft"] {
            assert!(is_same(&name("a"), &name(other)), "{other}");
        }
        assert!(!is_same(&name("a"), &name("b")));
        assert!(!is_same(&name("none"), &name("none")), "nothing is there");
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

    #[cfg(target_os = "linux")]
    #[test]
    fn errors_of_writing_show_the_file_that_was_asked_for() {
        // In a place where no user may create a file.
        let path = Path::new("/proc/self/file.txt");
        let message = write_bytes(path, "a").unwrap_err().to_string();
        assert!(message.starts_with("/proc/self/file.txt: "), "{message}");
        assert!(!message.contains(TEMPORARY.0), "{message}");
    }

    #[test]
    fn a_file_has_the_hash_of_its_bytes() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("abc");
        write_bytes(&path, "abc").unwrap();
        assert_eq!(sha256_of(&path).unwrap(), sha256_hex(b"abc"));
    }

    #[test]
    fn sha256_of_abc_is_the_published_one() {
        // FIPS 180-2, appendix B.1.
        let expected = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
        assert_eq!(sha256_hex(b"abc"), expected);
    }
}
