//! The log of the libraries, kept until the interpreter takes it: their threads never wait for the interpreter lock.

use std::fmt::{Debug, Write};
use std::sync::{Mutex, Once, PoisonError};

use pyo3::prelude::*;
use tracing::field::{Field, Visit};
use tracing::{Event, Level, Subscriber};
use tracing_subscriber::layer::{Context, Layer};
use tracing_subscriber::prelude::*;

/// A line of the log.
struct LoggedLine {
    level: Level,
    text: String,
}

static LINES: Mutex<Vec<LoggedLine>> = Mutex::new(Vec::new());

/// Collects warnings and summaries of this project's crates.
struct Collector;

impl<S: Subscriber> Layer<S> for Collector {
    fn on_event(&self, event: &Event<'_>, _: Context<'_, S>) {
        let level = *event.metadata().level();
        if level > Level::INFO || !event.metadata().target().starts_with("hysteron") {
            return;
        }
        let mut text = MessageText::default();
        event.record(&mut text);
        LINES.lock().unwrap_or_else(PoisonError::into_inner).push(LoggedLine { level, text: text.0 });
    }
}

/// The message of an event, and its further fields behind it.
#[derive(Default)]
struct MessageText(String);

impl Visit for MessageText {
    fn record_debug(&mut self, field: &Field, value: &dyn Debug) {
        // Writing to a string does not fail.
        let _ = match field.name() {
            "message" => write!(self.0, "{value:?}"),
            name => write!(self.0, " {name}={value:?}"),
        };
    }
}

/// Collects from here on, unless the process has a log already.
pub fn collect() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        let _ = tracing_subscriber::registry().with(Collector).try_init();
    });
}

/// Hands all lines on to Python's `logging`, logger `pyhysteron`.
pub fn hand_on(py: Python<'_>) -> PyResult<()> {
    let lines = std::mem::take(&mut *LINES.lock().unwrap_or_else(PoisonError::into_inner));
    if lines.is_empty() {
        return Ok(());
    }
    let logger = py.import("logging")?.call_method1("getLogger", ("pyhysteron",))?;
    for LoggedLine { level, text } in lines {
        let number = match level {
            Level::ERROR => 40,
            Level::WARN => 30,
            _ => 20,
        };
        logger.call_method1("log", (number, "%s", text))?;
    }
    Ok(())
}
