//! How the program was started, and how it is started again: by the watchdog of a rig, and by the stages of a study.

use std::ffi::OsString;

/// The hidden verb of the watchdog process.
pub(crate) const WATCHDOG: &str = "watchdog";

/// Arguments, and the words that start this program.
#[derive(Debug, Clone)]
pub struct Invocation {
    /// The arguments, from the verb on.
    pub arguments: Vec<OsString>,
    /// The words that start this program again, before its arguments; none where nobody knows.
    pub program: Vec<OsString>,
}

/// Starts this program again, with options of all verbs.
#[derive(Debug)]
pub(crate) struct Relaunch {
    /// See [`Invocation::program`].
    pub(crate) program: Vec<OsString>,
    /// Options that are passed on.
    pub(crate) options: Vec<String>,
}

impl Invocation {
    /// As this process was started, which is the program alone.
    pub fn of_process() -> Self {
        let program = std::env::current_exe().map(|program| vec![program.into_os_string()]);
        Self { arguments: std::env::args_os().skip(1).collect(), program: program.unwrap_or_default() }
    }

    /// The command line as typed, without the options that cannot change a result.
    pub(crate) fn command_line(&self) -> String {
        hysteron_workflow::shared::command_line::shown(
            self.arguments.iter().map(|argument| argument.to_string_lossy().into_owned()),
        )
    }

    /// The command of the watchdog process.
    pub(crate) fn watchdog(&self) -> Option<Vec<OsString>> {
        let words = ["--quiet", WATCHDOG].map(OsString::from);
        (!self.program.is_empty()).then(|| self.program.iter().cloned().chain(words).collect())
    }

    /// Starts this program again, with these options.
    pub(crate) fn relaunch(&self, options: Vec<String>) -> Relaunch {
        Relaunch { program: self.program.clone(), options }
    }
}
