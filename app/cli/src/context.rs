//! The `Context` of a verb that runs in a terminal: progress, questions, cancellation.

use std::io::{IsTerminal, Write};

use hysteron_workflow::{Context, Progress, ProgressSink};

use crate::terminal::{escaped, is_json, print};
use crate::{interrupt, progress};

/// The hidden verb of the watchdog process.
pub const WATCHDOG: &str = "watchdog";

/// `ProgressSink` of the terminal.
struct Terminal;

impl ProgressSink for Terminal {
    fn start(&self, of: &str, length: usize, done: usize) -> Box<dyn Progress> {
        Box::new(progress::bar(of, length, done))
    }

    fn is_cancelled(&self) -> bool {
        interrupt::is_requested()
    }

    fn listen(&self) {
        interrupt::listen();
    }

    fn listen_on_rig(&self) {
        interrupt::listen_on_rig();
    }

    fn print(&self, line: &str) {
        print(line);
    }

    fn confirm(&self, question: &str) -> Option<bool> {
        if is_json() || !std::io::stdin().is_terminal() {
            return None;
        }
        let mut stderr = std::io::stderr();
        write!(stderr, "{} [y/N] ", escaped(question)).and_then(|()| stderr.flush()).ok()?;
        let mut answer = String::new();
        std::io::stdin().read_line(&mut answer).ok()?;
        Some(["y", "yes"].contains(&answer.trim().to_lowercase().as_str()))
    }
}

/// Whoever typed the command, for the verbs.
pub fn by_terminal(overwrite: bool) -> Context<'static> {
    let watchdog = std::env::current_exe()
        .map(|program| vec![program.into_os_string(), "--quiet".into(), WATCHDOG.into()]);
    Context { progress: &Terminal, command: command_line(), overwrite, watchdog: watchdog.ok() }
}

/// The command line as typed, without the options that cannot change a result.
fn command_line() -> String {
    hysteron_workflow::shared::command_line::shown(
        std::env::args_os().skip(1).map(|argument| argument.to_string_lossy().into_owned()),
    )
}
