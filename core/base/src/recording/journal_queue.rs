//! A journal next to a control loop: rows are handed over in memory, and threads bring them to the file and
//! to the disk.
//!
//! A disk can stall for a long time, in a sync, and while it syncs in a write, too. The control loop must wait for
//! neither. One thread writes each frame as soon as it is there, so a crash of the process loses what the disk has not
//! taken; another one syncs once a second. What waits in memory is bounded: a queue that is full refuses.

use super::journal::{Frames, JournalFile, JournalWriter, Output, frame_length};
use std::io;
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

/// Most that waits for the disk [bytes]; at 200 bytes a row and 100 Hz, three minutes.
pub(super) const MAX_WAITING: usize = 4 << 20;
/// The journal is brought to the disk so often.
const SYNC_EVERY: Duration = Duration::from_secs(1);

/// Appends to a journal without waiting for the disk. Dropped, it writes what waits.
#[derive(Debug)]
pub struct JournalQueue {
    frames: Frames,
    file: Arc<dyn JournalFile>,
    shared: Arc<QueueShared>,
    writer: Option<JoinHandle<()>>,
    syncer: Option<(Sender<()>, JoinHandle<()>)>,
}

#[derive(Debug, Default)]
struct QueueShared {
    state: Mutex<QueueState>,
    /// Something is to be done for the writer.
    filled: Condvar,
    /// The writer has done something.
    emptied: Condvar,
}

#[derive(Debug, Default)]
struct QueueState {
    /// Whole frames that wait.
    waiting: Vec<u8>,
    /// The writer has frames that are not in the file yet.
    is_writing: bool,
    /// Last error of the file system; the writer then rests until it is called.
    error: Option<io::Error>,
    /// Frames were written since the last sync.
    is_dirty: bool,
    /// Nothing comes after what waits.
    is_closed: bool,
}

impl QueueShared {
    fn state(&self) -> MutexGuard<'_, QueueState> {
        // Whatever a panic left behind is whole: frames are added and taken at once.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

fn wait<'a>(condition: &Condvar, state: MutexGuard<'a, QueueState>) -> MutexGuard<'a, QueueState> {
    condition.wait(state).unwrap_or_else(PoisonError::into_inner)
}

impl JournalQueue {
    /// Puts threads between a journal and its writer.
    ///
    /// # Errors
    /// If the system gives no thread.
    pub fn start(journal: JournalWriter) -> io::Result<Self> {
        Self::syncing(journal, SYNC_EVERY)
    }

    fn syncing(journal: JournalWriter, every: Duration) -> io::Result<Self> {
        let JournalWriter { frames, output } = journal;
        let file = output.file.clone();
        let shared = Arc::new(QueueShared::default());
        let named = |name: &str| std::thread::Builder::new().name(name.to_owned());
        let for_writer = shared.clone();
        let writer = named("journal").spawn(move || write(output, &for_writer))?;
        let (stop, stopped) = channel();
        let (for_syncer, to_sync) = (shared.clone(), file.clone());
        let mut queue = Self { frames, file, shared, writer: Some(writer), syncer: None };
        let syncer = named("journal-sync").spawn(move || {
            while stopped.recv_timeout(every) == Err(RecvTimeoutError::Timeout) {
                let is_dirty = std::mem::take(&mut for_syncer.state().is_dirty);
                if is_dirty && let Err(error) = to_sync.sync() {
                    for_syncer.state().error.get_or_insert(error);
                }
            }
        })?;
        queue.syncer = Some((stop, syncer));
        Ok(queue)
    }

    /// Hands a row over: as [`JournalWriter::append`], but it is with the operating system a moment later.
    ///
    /// # Errors
    /// `InvalidInput` as there. `TimedOut` if the queue is full: the row is then lost. The error of the file system for an
    /// earlier one: the row is then kept, and all that wait are tried again.
    pub fn append(&mut self, time: f64, values: &[f64]) -> io::Result<()> {
        hand_over(&self.shared, self.frames.row(time, values)?)
    }

    /// Hands a line of text over that belongs to a time [s].
    ///
    /// # Errors
    /// As [`JournalWriter::note`] and [`JournalQueue::append`].
    pub fn note(&mut self, time: f64, text: &str) -> io::Result<()> {
        hand_over(&self.shared, self.frames.note(time, text)?)
    }

    /// Waits until the queue is at most half full, for callers without a clock.
    pub fn wait_for_room(&self) {
        let mut state = self.shared.state();
        while state.waiting.len() > MAX_WAITING / 2 && state.error.is_none() {
            state = wait(&self.shared.emptied, state);
        }
    }

    /// Waits until everything is on the disk.
    ///
    /// # Errors
    /// Errors of the file system; bytes that it did not take are tried again by the next call.
    pub fn flush(&mut self) -> io::Result<()> {
        let mut state = self.shared.state();
        // An earlier error may no longer hold.
        state.error = None;
        self.shared.filled.notify_all();
        while state.error.is_none() && (state.is_writing || !state.waiting.is_empty()) {
            state = wait(&self.shared.emptied, state);
        }
        let refused = state.error.take();
        drop(state);
        refused.map_or_else(|| self.file.sync(), Err)
    }
}

fn hand_over(shared: &QueueShared, frame: &[u8]) -> io::Result<()> {
    let mut state = shared.state();
    let error = state.error.take();
    if state.waiting.len() + frame.len() > MAX_WAITING {
        let full = || io::Error::new(io::ErrorKind::TimedOut, "the disk is too slow for the recording");
        return Err(error.unwrap_or_else(full));
    }
    state.waiting.extend_from_slice(frame);
    shared.filled.notify_all();
    error.map_or(Ok(()), Err)
}

/// Writes what waits until the queue is closed.
fn write(mut output: Output, shared: &QueueShared) {
    let (mut batch, mut at) = (Vec::new(), 0);
    loop {
        let mut state = shared.state();
        while !state.is_closed && (state.error.is_some() || at == batch.len() && state.waiting.is_empty()) {
            state = wait(&shared.filled, state);
        }
        if at == batch.len() {
            if state.waiting.is_empty() {
                return;
            }
            (batch, at) = (std::mem::take(&mut state.waiting), 0);
        }
        state.is_writing = true;
        let is_last = state.is_closed;
        drop(state);
        let mut refused = None;
        while at < batch.len() && refused.is_none() {
            let length = frame_length(&batch[at..]);
            match output.write(&batch[at..at + length]) {
                Ok(()) => at += length,
                Err(error) => refused = Some(error),
            }
        }
        let mut state = shared.state();
        state.is_dirty = true;
        state.is_writing = at < batch.len();
        let gives_up = is_last && refused.is_some();
        state.error = refused.or(state.error.take());
        shared.emptied.notify_all();
        if gives_up {
            return;
        }
    }
}

impl Drop for JournalQueue {
    fn drop(&mut self) {
        self.shared.state().is_closed = true;
        self.shared.filled.notify_all();
        // A thread that panicked has nothing left to write.
        if let Some(writer) = self.writer.take() {
            let _ = writer.join();
        }
        if let Some((stop, syncer)) = self.syncer.take() {
            drop(stop);
            let _ = syncer.join();
        }
    }
}

#[cfg(test)]
#[path = "journal_queue_tests.rs"]
mod tests;
