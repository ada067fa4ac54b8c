//! Long work on a thread of its own. The interpreter lock is free meanwhile; the calling thread takes it now and then, hears
//! Ctrl-C, and hands lines and progress on to Python.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::Duration;

use hysteron_workflow::{Progress, ProgressSink};
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;

use crate::log;

/// How often the calling thread looks.
const LOOK_EVERY: Duration = Duration::from_millis(50);
/// Stack of the thread [byte]: that of a program's first thread.
const STACK: usize = 8 << 20;

/// Progress and lines of the work, until they are handed on.
#[derive(Default)]
struct CallerSink {
    is_cancelled: AtomicBool,
    lines: Mutex<Vec<String>>,
    bars: Mutex<Vec<Arc<BarCount>>>,
}

/// How far a part of the work is.
struct BarCount {
    of: String,
    length: AtomicU64,
    position: AtomicU64,
    message: Mutex<String>,
    is_finished: AtomicBool,
}

/// The end of a part of the work that writes to [`BarCount`].
struct BarHandle(Arc<BarCount>);

impl ProgressSink for CallerSink {
    fn start(&self, of: &str, length: usize, done: usize) -> Box<dyn Progress> {
        let bar = Arc::new(BarCount {
            of: of.to_owned(),
            length: AtomicU64::new(length as u64),
            position: AtomicU64::new(done as u64),
            message: Mutex::default(),
            is_finished: AtomicBool::new(false),
        });
        self.bars.lock().unwrap_or_else(PoisonError::into_inner).push(Arc::clone(&bar));
        Box::new(BarHandle(bar))
    }

    fn is_cancelled(&self) -> bool {
        self.is_cancelled.load(Ordering::Relaxed)
    }

    fn print(&self, line: &str) {
        self.lines.lock().unwrap_or_else(PoisonError::into_inner).push(line.to_owned());
    }
}

impl Progress for BarHandle {
    fn inc(&self, n: u64) {
        self.0.position.fetch_add(n, Ordering::Relaxed);
    }

    fn set_position(&self, n: u64) {
        self.0.position.store(n, Ordering::Relaxed);
    }

    fn set_length(&self, n: u64) {
        self.0.length.store(n, Ordering::Relaxed);
    }

    fn set_message(&self, message: String) {
        *self.0.message.lock().unwrap_or_else(PoisonError::into_inner) = message;
    }

    fn finish(&self) {
        self.0.is_finished.store(true, Ordering::Relaxed);
    }
}

impl Drop for BarHandle {
    fn drop(&mut self) {
        self.finish();
    }
}

/// Runs `work` on a thread of its own. `listener` is a `pyhysteron._listener.Listener`, which prints lines and draws progress.
///
/// # Errors
/// `KeyboardInterrupt` where Ctrl-C was pressed, once the work has ended; an exception of the listener; a panic of the work.
pub fn run<T: Send>(
    py: Python<'_>,
    listener: Option<&Bound<'_, PyAny>>,
    work: impl FnOnce(&dyn ProgressSink) -> T + Send,
) -> PyResult<Ended<T>> {
    log::collect();
    let sink = CallerSink::default();
    let is_done = AtomicBool::new(false);
    let caller = thread::current();
    let mut stopped_by = None;
    let joined = thread::scope(|scope| -> PyResult<thread::Result<T>> {
        let builder = thread::Builder::new().name("hysteron".to_owned()).stack_size(STACK);
        let worker = builder.spawn_scoped(scope, || {
            let result = work(&sink);
            is_done.store(true, Ordering::Release);
            caller.unpark();
            result
        })?;
        while !is_done.load(Ordering::Acquire) && !worker.is_finished() {
            py.detach(|| thread::park_timeout(LOOK_EVERY));
            let heard = py.check_signals().and_then(|()| hand_on(py, listener, &sink));
            if let Err(error) = heard {
                sink.is_cancelled.store(true, Ordering::Relaxed);
                stopped_by.get_or_insert(error);
            }
        }
        Ok(py.detach(|| worker.join()))
    })?;
    let last = hand_on(py, listener, &sink);
    let result =
        joined.map_err(|_| PyRuntimeError::new_err("internal error: a panic, reported on stderr"))?;
    if stopped_by.is_none() {
        last?;
    }
    Ok(Ended { result, stopped_by })
}

/// The result of work, and the exception that cancelled it.
pub struct Ended<T> {
    result: T,
    stopped_by: Option<PyErr>,
}

impl<T, E> Ended<Result<T, E>> {
    /// The value of work that was neither cancelled nor failed. An exception that cancelled it has the error of the work as its
    /// cause, which names what is kept.
    pub fn value(self, py: Python<'_>, exception: impl FnOnce(E) -> PyErr) -> PyResult<T> {
        match (self.result, self.stopped_by) {
            (Ok(value), None) => Ok(value),
            (Ok(_), Some(stopped_by)) => Err(stopped_by),
            (Err(error), None) => Err(exception(error)),
            (Err(error), Some(stopped_by)) => {
                stopped_by.set_cause(py, Some(exception(error)));
                Err(stopped_by)
            }
        }
    }
}

/// Hands lines, progress and log on to Python.
fn hand_on(py: Python<'_>, listener: Option<&Bound<'_, PyAny>>, sink: &CallerSink) -> PyResult<()> {
    log::hand_on(py)?;
    let lines = std::mem::take(&mut *sink.lines.lock().unwrap_or_else(PoisonError::into_inner));
    let bars = sink.bars.lock().unwrap_or_else(PoisonError::into_inner).clone();
    let Some(listener) = listener else { return Ok(()) };
    for line in lines {
        listener.call_method1("line", (line,))?;
    }
    for (number, bar) in bars.iter().enumerate() {
        let [length, position] = [&bar.length, &bar.position].map(|n| n.load(Ordering::Relaxed));
        let message = bar.message.lock().unwrap_or_else(PoisonError::into_inner).clone();
        let is_finished = bar.is_finished.load(Ordering::Relaxed);
        listener.call_method1("progress", (number, &bar.of, length, position, message, is_finished))?;
    }
    Ok(())
}
