//! Everything a person reads in the terminal: results on stdout; log, progress and errors on stderr.

use std::io::{IsTerminal, Write};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use tracing::level_filters::LevelFilter;
use tracing_subscriber::EnvFilter;

/// Prints a result.
pub fn say(line: impl std::fmt::Display) {
    // Whoever closed the pipe, as `head` does, has read enough.
    let _ = writeln!(std::io::stdout(), "{line}");
}

/// Prints why the program failed.
#[expect(clippy::print_stderr, reason = "the one place that writes errors")]
pub fn complain(error: &anyhow::Error) {
    eprintln!("error: {error:#}");
}

/// Logs to stderr: warnings at 0, summaries at 1, details above. `RUST_LOG` overrides.
pub fn start_log(verbosity: i8) {
    let level = match verbosity {
        ..0 => LevelFilter::ERROR,
        0 => LevelFilter::WARN,
        1 => LevelFilter::INFO,
        2 => LevelFilter::DEBUG,
        3.. => LevelFilter::TRACE,
    };
    let filter = std::env::var("RUST_LOG").unwrap_or_else(|_| level.to_string());
    tracing_subscriber::fmt()
        .with_env_filter(EnvFilter::new(filter))
        .with_writer(std::io::stderr)
        .with_ansi(std::io::stderr().is_terminal())
        .with_target(false)
        .without_time()
        .init();
}

/// A bar with rate and remaining time; drawn only in a terminal, and not when only warnings are wanted.
pub fn progress(of: &str, length: usize, done: usize) -> ProgressBar {
    let target = if tracing::enabled!(tracing::Level::INFO) {
        ProgressDrawTarget::stderr()
    } else {
        ProgressDrawTarget::hidden()
    };
    let bar = ProgressBar::with_draw_target(Some(length as u64), target);
    let template = format!("{{wide_bar}} {{pos}}/{{len}} {of}, {{per_sec}}, {{eta}} left {{msg}}");
    if let Ok(style) = ProgressStyle::with_template(&template) {
        bar.set_style(style);
    }
    bar.set_position(done as u64);
    bar.reset_eta();
    bar
}

/// The command line as typed, without the options that cannot change a result.
pub fn command_line() -> String {
    shown(std::env::args().skip(1))
}

/// A command line of this program as a person would type it.
pub fn shown(arguments: impl Iterator<Item = String>) -> String {
    let mut line = String::from("hysteron");
    let mut arguments = arguments.peekable();
    while let Some(argument) = arguments.next() {
        match argument.as_str() {
            "--threads" | "--shard" => {
                arguments.next();
            }
            "--verbose" | "--quiet" => {}
            text if text.starts_with("--threads=") || text.starts_with("--shard=") => {}
            text if text.len() > 1
                && text.starts_with('-')
                && text[1..].bytes().all(|byte| matches!(byte, b'v' | b'q')) => {}
            text => {
                line.push(' ');
                let is_plain = |c: char| c.is_alphanumeric() || "-_./=:,+%@".contains(c);
                if !text.is_empty() && text.chars().all(is_plain) {
                    line.push_str(text);
                } else {
                    line.push_str(&format!("'{}'", text.replace('\'', "'\\''")));
                }
            }
        }
    }
    line
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn command_line_keeps_what_shapes_the_result() {
        let typed = [
            "-v",
            "simulate",
            "my scene.toml",
            "--threads",
            "2",
            "--shard",
            "1/2",
            "--out",
            "a.csv",
            "-qq",
            "--threads=3",
        ];
        let line = shown(typed.into_iter().map(str::to_owned));
        assert_eq!(line, "hysteron simulate 'my scene.toml' --out a.csv");
    }
}
