//! Locks of outputs: one process at a time writes a folder or a file.
//!
//! A lock is a small file with the operating system's advisory lock (`flock`) on it, so it ends with its process,
//! however that ends; a file that a killed process has left is taken over. Within a process a lock may be taken
//! again.

use crate::file::{check_name, clear_temporary, folder_of};
use crate::{BadInput, Error, Result};
use std::collections::BTreeMap;
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};

/// Name of the lock of a folder, in it.
const FOLDER_LOCK: &str = ".hysteron.lock";

/// Exclusive use of an output for as long as it lives.
#[derive(Debug)]
pub struct Lock {
    /// Some until it is dropped.
    held: Option<Arc<HeldLock>>,
}

/// A lock of this process.
#[derive(Debug)]
struct HeldLock {
    /// The file with the lock on it.
    path: PathBuf,
    _file: File,
    /// A folder that was made for the lock; removed again if nothing was written to it.
    created: Option<PathBuf>,
}

/// Locks of this process.
static HELD: Mutex<BTreeMap<PathBuf, Weak<HeldLock>>> = Mutex::new(BTreeMap::new());

fn held_locks() -> MutexGuard<'static, BTreeMap<PathBuf, Weak<HeldLock>>> {
    HELD.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Lock {
    /// Locks a folder, which is created if there is none. What killed programs had half written there is removed.
    ///
    /// # Errors
    /// `BadInput` if another process writes there or it is no folder, `Io` if the file system refuses.
    pub fn folder(folder: &Path) -> Result<Self> {
        Self::take(folder, folder, FOLDER_LOCK.to_owned())
    }

    /// Locks a file that is to be written; its folder is created if there is none.
    ///
    /// # Errors
    /// As [`Lock::folder`].
    pub fn file(path: &Path) -> Result<Self> {
        let Some(name) = path.file_name() else {
            return Err(BadInput::new(path.display().to_string(), "the name of a file", "none").into());
        };
        check_name(path)?;
        Self::take(path, folder_of(path), format!(".{}.lock", name.to_string_lossy()))
    }

    fn take(output: &Path, folder: &Path, name: String) -> Result<Self> {
        let io = |refusal: io::Error| Error::Io { path: output.to_owned(), refusal };
        if let Some(file) = folder.ancestors().find(|path| path.exists()).filter(|path| !path.is_dir()) {
            return Err(BadInput::new(file.display().to_string(), "a folder", "a file").into());
        }
        let mut all = held_locks();
        let created = (!folder.exists()).then(|| folder.to_owned());
        std::fs::create_dir_all(folder).map_err(io)?;
        let path = folder.canonicalize().map_err(io)?.join(name);
        if let Some(again) = all.get(&path).and_then(Weak::upgrade) {
            return Ok(Self { held: Some(again) });
        }
        let file = loop {
            let mut file = OpenOptions::new()
                .read(true)
                .write(true)
                .create(true)
                .truncate(false)
                .open(&path)
                .map_err(io)?;
            match file.try_lock() {
                Ok(()) => {}
                Err(TryLockError::WouldBlock) => return Err(in_use(output, &mut file).into()),
                Err(TryLockError::Error(refusal)) => return Err(io(refusal)),
            }
            // Its last holder may have removed the name in the meantime: then this lock excludes no process.
            if is_named(&file, &path) {
                file.set_len(0).and_then(|()| write!(file, "{}", std::process::id())).map_err(io)?;
                break file;
            }
        };
        clear_temporary(folder);
        let lock = Arc::new(HeldLock { path: path.clone(), _file: file, created });
        all.insert(path, Arc::downgrade(&lock));
        Ok(Self { held: Some(lock) })
    }
}

/// Removes the temporary files and the locks of this process, because it is about to end: a thread that writes a
/// file, or takes or gives up a lock, waits from here on.
pub fn abandon_outputs() {
    crate::file::abandon();
    let all = held_locks();
    for lock in all.values().filter_map(Weak::upgrade) {
        lock.remove();
        // Not removed again when it is dropped.
        std::mem::forget(lock);
    }
    std::mem::forget(all);
}

/// Whether the open file still is the one of that name.
fn is_named(file: &File, path: &Path) -> bool {
    #[cfg(unix)]
    {
        use std::os::unix::fs::MetadataExt;
        let id = |metadata: io::Result<std::fs::Metadata>| metadata.ok().map(|at| (at.dev(), at.ino()));
        id(file.metadata()).is_some_and(|own| id(std::fs::metadata(path)) == Some(own))
    }
    #[cfg(not(unix))]
    {
        let _ = file;
        path.exists()
    }
}

fn in_use(output: &Path, file: &mut File) -> BadInput {
    let mut holder = String::new();
    // The holder may be about to write its number; it is only for people.
    let _ = file.take(20).read_to_string(&mut holder);
    let number: String = holder.chars().filter(char::is_ascii_digit).collect();
    let found = if number.is_empty() {
        "one that another process is writing".to_owned()
    } else {
        format!("one that process {number} is writing")
    };
    BadInput::new(output.display().to_string(), "an output of this command alone", found)
        .hint("wait until the other command has ended, or choose another output")
}

impl Drop for Lock {
    fn drop(&mut self) {
        // Nobody takes the lock again while it is being given up.
        let mut all = held_locks();
        if let Some(held) = self.held.take().and_then(Arc::into_inner) {
            all.remove(&held.path);
        }
    }
}

impl HeldLock {
    fn remove(&self) {
        // While the lock still holds. What cannot be removed is taken over by the next one.
        let _ = std::fs::remove_file(&self.path);
        if let Some(folder) = &self.created {
            // Only if it is empty.
            let _ = std::fs::remove_dir(folder);
        }
    }
}

impl Drop for HeldLock {
    fn drop(&mut self) {
        self.remove();
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)] // a test may stop where it stands
    use super::*;

    /// A lock as another process has it.
    fn of_another(path: &Path) -> File {
        let mut file = File::create(path).unwrap();
        file.try_lock().unwrap();
        write!(file, "4711").unwrap();
        file
    }

    fn refused(taken: Result<Lock>) -> String {
        let Err(Error::BadInput(bad)) = taken else { panic!("not refused: {taken:?}") };
        bad.to_string()
    }

    #[test]
    fn what_another_process_writes_is_refused_until_it_ends() {
        let place = tempfile::tempdir().unwrap();
        let out = place.path().join("a.parquet");
        let folder = of_another(&place.path().join(FOLDER_LOCK));
        let file = of_another(&place.path().join(".a.parquet.lock"));
        assert!(refused(Lock::folder(place.path())).contains("process 4711"));
        assert!(refused(Lock::file(&out)).contains("a.parquet: expected an output of this command alone"));
        drop((folder, file));
        // The files are still there, as after a kill.
        let locks = (Lock::folder(place.path()).unwrap(), Lock::file(&out).unwrap());
        drop(locks);
        assert_eq!(std::fs::read_dir(place.path()).unwrap().count(), 0, "nothing is left");
    }

    #[test]
    fn a_process_may_take_its_lock_again_and_holds_it_until_the_last_is_dropped() {
        let place = tempfile::tempdir().unwrap();
        let first = Lock::folder(place.path()).unwrap();
        let second = Lock::folder(&place.path().join(".")).unwrap();
        drop(first);
        let path = place.path().join(FOLDER_LOCK);
        let other = File::open(&path).unwrap();
        assert!(matches!(other.try_lock(), Err(TryLockError::WouldBlock)));
        drop(second);
        assert!(!path.exists());
    }

    #[test]
    fn threads_that_take_and_drop_never_meet_a_stranger() {
        let place = tempfile::tempdir().unwrap();
        std::thread::scope(|scope| {
            for _ in 0..4 {
                scope.spawn(|| (0..200).for_each(|_| drop(Lock::folder(place.path()).unwrap())));
            }
        });
    }

    #[test]
    fn a_folder_made_for_the_lock_goes_if_nothing_was_written() {
        let place = tempfile::tempdir().unwrap();
        let folder = place.path().join("out");
        drop(Lock::folder(&folder).unwrap());
        assert!(!folder.exists());
        let lock = Lock::folder(&folder).unwrap();
        std::fs::write(folder.join("result"), "").unwrap();
        drop(lock);
        assert!(folder.join("result").exists());
    }

    #[test]
    fn a_file_is_no_folder() {
        let place = tempfile::tempdir().unwrap();
        let path = place.path().join("file");
        std::fs::write(&path, "").unwrap();
        assert!(refused(Lock::folder(&path)).contains("expected a folder, got a file"));
        for inside in ["a", "a/b"] {
            assert!(refused(Lock::file(&path.join(inside))).contains("file: expected a folder, got a file"));
        }
        assert!(refused(Lock::file(Path::new("/"))).contains("the name of a file"));
    }

    #[test]
    fn a_name_leaves_room_for_those_that_are_made_from_it() {
        let place = tempfile::tempdir().unwrap();
        let named = |n: usize| place.path().join("n".repeat(n));
        assert!(Lock::file(&named(240)).is_ok());
        for n in [241, 245, 251, 255, 256, 4000] {
            let found = refused(Lock::file(&named(n)));
            assert!(found.contains(&format!("a name of at most 240 bytes, got {n} bytes")), "{found}");
        }
    }
}
