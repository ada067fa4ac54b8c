//! Who runs a verb: a terminal, a server, a test.

use std::ffi::OsString;
use std::path::Path;

use hysteron_learn::Provenance;
use hysteron_report::text::without_signs_of_zeros;

/// Hears how far a verb is, and may stop it.
pub trait ProgressSink: Sync {
    /// Long work begins: `length` things, `done` of them before this run.
    fn start(&self, of: &str, length: usize, done: usize) -> Box<dyn Progress>;

    /// True once the verb is to stop at the next good moment.
    fn is_cancelled(&self) -> bool;

    /// From here on [`ProgressSink::is_cancelled`] returns requests to stop. A verb that then runs for more than a
    /// second may be ended where it is: all that it must not lose is in files by then.
    fn listen(&self) {}

    /// As [`ProgressSink::listen`], but the verb drives a rig, and is given the time to switch its torque off.
    fn listen_on_rig(&self) {}

    /// A line of the result, for a person.
    fn print(&self, line: &str);

    /// Asks the user a yes-or-no question; `None` without a terminal.
    fn confirm(&self, _question: &str) -> Option<bool> {
        None
    }
}

/// How far long work is. Dropped, it is over.
pub trait Progress: Send + Sync {
    /// So many more are done.
    fn inc(&self, n: u64);
    /// So many are done.
    fn set_position(&self, n: u64);
    /// So many are to be done.
    fn set_length(&self, n: u64);
    /// Sets the message behind the count.
    fn set_message(&self, message: String);
    /// It is over.
    fn finish(&self);
}

/// Context in which a verb runs.
pub struct Context<'a> {
    /// Hears how far it is.
    pub progress: &'a dyn ProgressSink,
    /// Command that all results name as their origin; the same command may replace them.
    pub command: String,
    /// Whether results of other commands may be replaced too.
    pub overwrite: bool,
    /// A command that, with a rig file behind it, calls [`crate::shared::watchdog::watch`]; nothing moves on a rig's ports
    /// without.
    pub watchdog: Option<Vec<OsString>>,
}

/// Says nothing, shows nothing, stops nothing.
pub struct Silent;

impl ProgressSink for Silent {
    fn start(&self, _: &str, _: usize, _: usize) -> Box<dyn Progress> {
        Box::new(Self)
    }

    fn is_cancelled(&self) -> bool {
        false
    }

    fn print(&self, _: &str) {}
}

impl Progress for Silent {
    fn inc(&self, _: u64) {}
    fn set_position(&self, _: u64) {}
    fn set_length(&self, _: u64) {}
    fn set_message(&self, _: String) {}
    fn finish(&self) {}
}

impl Context<'static> {
    /// Runs a verb without output; its results name `command` as their origin. Results of others are not replaced, and
    /// nothing moves on a rig's ports.
    pub fn silent(command: impl Into<String>) -> Self {
        Self { progress: &Silent, command: command.into(), overwrite: false, watchdog: None }
    }
}

impl Context<'_> {
    /// See [`ProgressSink::start`].
    pub fn progress(&self, of: &str, length: usize, done: usize) -> Box<dyn Progress> {
        self.progress.start(of, length, done)
    }

    /// See [`ProgressSink::is_cancelled`].
    pub fn is_cancelled(&self) -> bool {
        self.progress.is_cancelled()
    }

    /// See [`ProgressSink::listen`].
    pub fn listen(&self) {
        self.progress.listen();
    }

    /// See [`ProgressSink::listen_on_rig`].
    pub fn listen_on_rig(&self) {
        self.progress.listen_on_rig();
    }

    /// See [`ProgressSink::print`].
    pub fn print(&self, line: impl std::fmt::Display) {
        self.progress.print(&without_signs_of_zeros(&line.to_string()));
    }

    /// See [`ProgressSink::confirm`].
    pub fn confirm(&self, question: &str) -> Option<bool> {
        self.progress.confirm(question)
    }

    /// The command and the program, as a checkpoint holds them.
    pub(crate) fn provenance(&self) -> Provenance {
        Provenance {
            command: self.command.clone(),
            commit: crate::COMMIT.to_owned(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
        }
    }

    /// A folder with a report, as the last line of a result.
    pub fn reported(&self, folder: &Path) {
        self.print(format_args!("report: {}", folder.join("report.html").display()));
    }

    /// A file that was written, as the last line of a result.
    pub fn wrote(&self, path: &Path) {
        self.print(path.display());
    }
}
