//! The `Context` of a verb that runs in a terminal: progress, questions, cancellation.

use std::io::{IsTerminal, Write};

use hysteron_workflow::{Context, Progress, ProgressSink};

use crate::invocation::Invocation;
use crate::terminal::{escaped, is_json, print};
use crate::{interrupt, progress};

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
pub fn by_terminal(invocation: &Invocation, overwrite: bool) -> Context<'static> {
    let (command, watchdog) = (invocation.command_line(), invocation.watchdog());
    Context { progress: &Terminal, command, overwrite, watchdog }
}
