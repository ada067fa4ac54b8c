//! Journals on disks that stall, refuse and recover.
#![allow(clippy::unwrap_used)] // a test may stop where it stands

use super::super::{Journal, Metadata};
use super::*;
use std::path::{Path, PathBuf};

/// Behaviour of a disk.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Disk {
    Works,
    StallsWrites,
    StallsSyncs,
    /// No room beyond so many bytes.
    Full(usize),
}

/// A file in memory on a disk whose behaviour can be set.
#[derive(Debug)]
struct TestFile {
    bytes: Mutex<Vec<u8>>,
    disk: Mutex<Disk>,
    changed: Condvar,
}

impl TestFile {
    fn new() -> Arc<Self> {
        let (bytes, changed) = Default::default();
        Arc::new(Self { bytes, disk: Mutex::new(Disk::Works), changed })
    }

    fn set(&self, disk: Disk) {
        *self.disk.lock().unwrap() = disk;
        self.changed.notify_all();
    }

    /// Waits while the disk does this.
    fn wait_while(&self, stalls: Disk) -> Disk {
        *self.changed.wait_while(self.disk.lock().unwrap(), |disk| *disk == stalls).unwrap()
    }

    fn len(&self) -> usize {
        self.bytes.lock().unwrap().len()
    }
}

impl JournalFile for TestFile {
    fn append_all(&self, more: &[u8]) -> io::Result<()> {
        let disk = self.wait_while(Disk::StallsWrites);
        let mut bytes = self.bytes.lock().unwrap();
        match disk {
            Disk::Full(room) if bytes.len() + more.len() > room => {
                let n = room.saturating_sub(bytes.len());
                bytes.extend(&more[..n]);
                Err(io::ErrorKind::StorageFull.into())
            }
            _ => {
                bytes.extend(more);
                Ok(())
            }
        }
    }

    fn cut(&self, length: u64) -> io::Result<()> {
        self.bytes.lock().unwrap().truncate(length as usize);
        Ok(())
    }

    fn sync(&self) -> io::Result<()> {
        self.wait_while(Disk::StallsSyncs);
        Ok(())
    }
}

fn names() -> [String; 2] {
    ["stroke_1_m", "stroke_2_m"].map(str::to_owned)
}

fn begun(file: &Arc<TestFile>) -> JournalWriter {
    JournalWriter::over(file.clone(), &names(), &Metadata::default()).unwrap()
}

fn queue(file: &Arc<TestFile>) -> JournalQueue {
    JournalQueue::syncing(begun(file), Duration::from_millis(1)).unwrap()
}

/// Rows from `first` on, a note after every tenth.
fn append(queue: &mut JournalQueue, first: u32, n: u32) -> io::Result<()> {
    (first..first + n).try_for_each(|i| {
        queue.append(f64::from(i), &[f64::from(i), -1.0])?;
        if i % 10 == 0 { queue.note(f64::from(i), "ten") } else { Ok(()) }
    })
}

/// Content of a journal of `n` rows that is written without a queue [byte].
fn expected(n: u32) -> Vec<u8> {
    let file = TestFile::new();
    let mut journal = begun(&file);
    for i in 0..n {
        journal.append(f64::from(i), &[f64::from(i), -1.0]).unwrap();
        if i % 10 == 0 {
            journal.note(f64::from(i), "ten").unwrap();
        }
    }
    file.bytes.lock().unwrap().clone()
}

fn wait_until(holds: impl Fn() -> bool) {
    let start = std::time::Instant::now();
    while !holds() {
        assert!(start.elapsed() < Duration::from_secs(20), "never");
        std::thread::sleep(Duration::from_millis(1));
    }
}

fn n_rows(bytes: &[u8], folder: &Path) -> usize {
    let path: PathBuf = folder.join("a.journal");
    std::fs::write(&path, bytes).unwrap();
    Journal::read(&path).unwrap().recording.n_samples()
}

#[test]
fn rows_are_in_the_file_in_order_and_promptly_and_a_drop_writes_the_rest() {
    let file = TestFile::new();
    let mut queue = queue(&file);
    append(&mut queue, 0, 50).unwrap();
    // Without a flush.
    wait_until(|| file.len() == expected(50).len());
    append(&mut queue, 50, 50).unwrap();
    queue.flush().unwrap();
    assert!(*file.bytes.lock().unwrap() == expected(100));
    append(&mut queue, 100, 100).unwrap();
    drop(queue);
    assert!(*file.bytes.lock().unwrap() == expected(200));
}

#[test]
fn a_disk_that_stalls_delays_no_cycle() {
    let file = TestFile::new();
    for (i, stalls) in [Disk::StallsWrites, Disk::StallsSyncs].into_iter().enumerate() {
        file.bytes.lock().unwrap().clear();
        let mut queue = queue(&file);
        append(&mut queue, 0, 10).unwrap();
        file.set(stalls);
        // It would wait for good here.
        append(&mut queue, 10, 1000).unwrap();
        if stalls == Disk::StallsSyncs {
            // What is syncing keeps no row from the operating system.
            wait_until(|| file.len() == expected(1010).len());
        }
        file.set(Disk::Works);
        queue.flush().unwrap();
        assert!(*file.bytes.lock().unwrap() == expected(1010), "{i}");
    }
}

#[test]
fn what_waits_is_bounded_and_what_was_taken_is_kept() {
    let file = TestFile::new();
    let mut queue = queue(&file);
    file.set(Disk::StallsWrites);
    let mut n = 0;
    let error = loop {
        match append(&mut queue, n, 1) {
            Ok(()) => n += 1,
            Err(error) => break error,
        }
    };
    assert_eq!(error.kind(), io::ErrorKind::TimedOut);
    // The writer may have one batch of its own.
    assert!(n as usize * 33 <= 2 * MAX_WAITING, "{n} rows");
    file.set(Disk::Works);
    queue.flush().unwrap();
    let folder = tempfile::tempdir().unwrap();
    assert_eq!(n_rows(&file.bytes.lock().unwrap(), folder.path()), n as usize);
}

#[test]
fn who_can_wait_finds_room() {
    let file = TestFile::new();
    let mut queue = queue(&file);
    // Five times as much as may wait, as fast as it can be made.
    let n = (5 * MAX_WAITING / 33) as u32;
    for i in 0..n {
        queue.wait_for_room();
        append(&mut queue, i, 1).unwrap();
    }
    queue.flush().unwrap();
    assert!(*file.bytes.lock().unwrap() == expected(n));
}

#[test]
fn a_full_disk_is_reported_and_nothing_is_lost_once_there_is_room() {
    let file = TestFile::new();
    let mut queue = queue(&file);
    append(&mut queue, 0, 5).unwrap();
    queue.flush().unwrap();
    let whole = file.len();
    file.set(Disk::Full(whole + 40));
    append(&mut queue, 5, 2).unwrap();
    wait_until(|| queue.shared.state().error.is_some());
    let error = append(&mut queue, 7, 1).unwrap_err();
    assert_eq!(error.kind(), io::ErrorKind::StorageFull);
    let refused = queue.flush().unwrap_err();
    assert_eq!(refused.kind(), io::ErrorKind::StorageFull);
    let folder = tempfile::tempdir().unwrap();
    assert_eq!(n_rows(&file.bytes.lock().unwrap(), folder.path()), 6, "only whole frames");
    file.set(Disk::Works);
    queue.flush().unwrap();
    // The row with which the error came is among them.
    assert!(*file.bytes.lock().unwrap() == expected(8));
}

#[test]
fn a_disk_that_stays_full_does_not_keep_a_queue_from_ending() {
    let file = TestFile::new();
    let mut queue = queue(&file);
    file.set(Disk::Full(0));
    let _ = append(&mut queue, 0, 20);
    drop(queue);
}
