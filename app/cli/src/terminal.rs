//! Everything a person reads in the terminal: results on stdout; log, progress and errors on stderr.
//!
//! The outcome of a verb is one value: with `--json` it is the only output on stdout, without it the verb's own lines
//! do.

use std::io::{self, IsTerminal, Write};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};

use hysteron_workflow::shared::outcome::Printed;
use hysteron_workflow::shared::verdict;
use tracing::level_filters::LevelFilter;
use tracing_subscriber::filter::Targets;
use tracing_subscriber::prelude::*;

static IS_JSON: AtomicBool = AtomicBool::new(false);

/// From here on stdout holds nothing but what [`print_outcome`] prints.
pub fn use_json() {
    IS_JSON.store(true, Ordering::Relaxed);
}

/// True where stdout is for a program.
pub fn is_json() -> bool {
    IS_JSON.load(Ordering::Relaxed)
}

/// Prints a result for a person.
pub fn print(line: impl std::fmt::Display) {
    if !is_json() {
        print_raw(escaped(&line.to_string()));
    }
}

/// Prints the outcome of a verb: with `--json` the same object as in `metrics.json`, where the verb writes one; without
/// it the verdict, where there is one, and the lines below it.
pub fn print_outcome(outcome: &Printed) {
    outcome.verdict.iter().flat_map(verdict::lines).for_each(print);
    outcome.lines.iter().for_each(print);
    if is_json() {
        print_raw(outcome.json.trim_end());
    }
}

/// The first thing that went wrong with stdout.
static UNPRINTED: Mutex<Option<io::Error>> = Mutex::new(None);

/// Prints a text that is itself the result. A failure of stdout becomes an error at the end: the files
/// of a verb matter more than its printed lines.
pub fn print_raw(text: impl std::fmt::Display) {
    keep_first(writeln!(io::stdout(), "{text}").and_then(|()| io::stdout().flush()));
}

/// Keeps the first error of printing.
pub fn keep_first(printed: io::Result<()>) {
    if let Err(error) = printed {
        UNPRINTED.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(error);
    }
}

/// 0 if all output was written; 1 with the reason if not; if the reader has closed the pipe, as
/// `head` does when it has read enough, the program is quiet and ends as others do that the signal of it ends.
pub fn exit_code_of_printing() -> u8 {
    match UNPRINTED.lock().unwrap_or_else(PoisonError::into_inner).take() {
        None => 0,
        Some(error) if error.kind() == io::ErrorKind::BrokenPipe => CLOSED_PIPE,
        Some(error) => {
            report_error(&anyhow::Error::new(error).context("stdout"));
            1
        }
    }
}

/// 128 + SIGPIPE, as shells do.
const CLOSED_PIPE: u8 = 141;

/// Prints why the program failed.
pub fn report_error(error: &anyhow::Error) {
    // If stderr is closed, only the exit code reports the error.
    let _ = writeln!(io::stderr(), "error: {}", escaped_list(&format!("{error:#}")));
}

/// A text on one line: characters that would move the cursor, colour the terminal, ring its bell or turn the
/// direction of writing, as names of files may have them, are shown as they are written in a program, `\n`.
pub fn escaped(text: &str) -> String {
    let is_unseen = |c: char| {
        c.is_control()
            || matches!(c, '\u{2028}' | '\u{2029}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
    };
    let mut shown = String::with_capacity(text.len());
    for c in text.chars() {
        if is_unseen(c) { shown.extend(c.escape_default()) } else { shown.push(c) }
    }
    shown
}

/// Beginning of each line of a list below its head.
const BELOW: &str = "\n  ";

/// As [`escaped`], but of a head with a list below, as all that is wrong with a bus: its lines stay lines. They are indented,
/// so that none looks like output of the program.
fn escaped_list(text: &str) -> String {
    text.split(BELOW).map(escaped).collect::<Vec<_>>().join(BELOW)
}

/// Lines of the log on stderr, each escaped.
struct LogLine {
    /// Whether the log colours its own words.
    is_coloured: bool,
}

impl Write for LogLine {
    /// Is given a line of the log at a time.
    fn write(&mut self, line: &[u8]) -> std::io::Result<usize> {
        let text = String::from_utf8_lossy(line);
        let text = text.trim_end_matches('\n');
        // Colours begin with this character; the log itself escapes it in what it is given.
        let shown = match self.is_coloured {
            true => text.split('\u{1b}').map(escaped_list).collect::<Vec<_>>().join("\u{1b}"),
            false => escaped_list(text),
        };
        writeln!(std::io::stderr(), "{shown}")?;
        Ok(line.len())
    }

    fn flush(&mut self) -> std::io::Result<()> {
        std::io::stderr().flush()
    }
}

/// Logs to stderr: errors below 0, warnings at 0, summaries at 1, details of this program at 2, everything above. `RUST_LOG` decides
/// where no option sets it.
pub fn start_log(verbosity: Option<i8>) {
    let by_environment = std::env::var("RUST_LOG").ok().filter(|_| verbosity.is_none());
    let filter =
        by_environment.and_then(|targets| targets.parse().ok()).unwrap_or_else(|| shown_at(verbosity));
    let is_coloured = std::io::stderr().is_terminal() && has_colours(std::env::var_os("NO_COLOR"));
    let lines = tracing_subscriber::fmt::layer()
        .with_writer(move || LogLine { is_coloured })
        .with_ansi(is_coloured)
        .with_target(false)
        .without_time();
    // A process that has a log already keeps it.
    let _ = tracing_subscriber::registry().with(lines.with_filter(filter)).try_init();
}

/// Log levels at a verbosity, where nothing was typed the usual.
fn shown_at(verbosity: Option<i8>) -> Targets {
    let everywhere = |level: LevelFilter| Targets::new().with_default(level);
    match verbosity.unwrap_or(1) {
        ..0 => everywhere(LevelFilter::ERROR),
        0 => everywhere(LevelFilter::WARN),
        1 => everywhere(LevelFilter::INFO),
        // The project's own crates, whose names all begin alike; of others, what they report anyway.
        2 => everywhere(LevelFilter::INFO).with_target("hysteron", LevelFilter::DEBUG),
        3.. => everywhere(LevelFilter::TRACE),
    }
}

/// <https://no-color.org>: colours are off where the variable is there and not empty.
fn has_colours(no_color: Option<std::ffi::OsString>) -> bool {
    no_color.is_none_or(|value| value.is_empty())
}

#[cfg(test)]
mod tests {
    use tracing::Level;

    use super::*;

    #[test]
    fn colours_are_off_on_request() {
        assert!(has_colours(None) && has_colours(Some("".into())) && !has_colours(Some("1".into())));
    }

    #[test]
    fn details_are_those_of_the_project() {
        let shown = |verbosity, target, level| shown_at(verbosity).would_enable(target, &level);
        assert!(
            shown(Some(2), "hysteron_twin::step", Level::DEBUG) && shown(Some(2), "hysteron", Level::DEBUG)
        );
        assert!(!shown(Some(2), "candle_core", Level::DEBUG) && shown(Some(3), "candle_core", Level::TRACE));
        assert!(shown(None, "hysteron", Level::INFO) && !shown(None, "hysteron", Level::DEBUG));
        assert!(shown(Some(0), "hysteron", Level::WARN) && !shown(Some(0), "hysteron", Level::INFO));
        assert!(shown(Some(-1), "hysteron", Level::ERROR) && !shown(Some(-1), "hysteron", Level::WARN));
    }

    #[test]
    fn nothing_in_a_name_moves_the_cursor_or_forges_a_line() {
        assert_eq!(
            escaped("a\nerror: b\u{1b}[31m\r\u{7}\u{202e}é"),
            "a\\nerror: b\\u{1b}[31m\\r\\u{7}\\u{202e}é"
        );
    }

    #[test]
    fn a_list_below_its_head_stays_a_list_and_a_forged_line_is_none() {
        assert_eq!(
            escaped_list("wrong:\n  servo 1: \r\n  servo 2: b"),
            "wrong:\n  servo 1: \\r\n  servo 2: b"
        );
        assert_eq!(escaped_list("a\nerror: b\n c\n  \u{1b}"), "a\\nerror: b\\n c\n  \\u{1b}");
    }
}
