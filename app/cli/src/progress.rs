//! How far a verb is: a bar in a terminal, a line of the log every half minute anywhere else.

use std::io::IsTerminal;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use hysteron_workflow::Progress;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};

/// Time between two lines of the log.
const EVERY: Duration = Duration::from_secs(30);

/// A bar, or lines of the log.
pub struct ProgressDisplay {
    bar: ProgressBar,
    of: String,
    /// Lines are logged, for no bar is drawn.
    is_logged: bool,
    start: Instant,
    /// Where it began.
    first: u64,
    /// When the last line was logged [ms after `start`].
    logged: AtomicU64,
}

/// A bar over `length` items, 0 for an unknown number, `done` of them before this run, with rate and
/// remaining time. None where the log shows warnings alone.
pub fn bar(of: &str, length: usize, done: usize) -> ProgressDisplay {
    let is_wanted = tracing::enabled!(tracing::Level::INFO);
    let is_drawn = is_wanted && std::io::stderr().is_terminal();
    let target = if is_drawn { ProgressDrawTarget::stderr() } else { ProgressDrawTarget::hidden() };
    // Without a length the bar stays empty: one of no length would be full.
    let bar = ProgressBar::with_draw_target((length > 0).then_some(length as u64), target);
    let template = format!("{{wide_bar}} {{count}} {of}, {{rate}}{{left}} {{msg}}");
    if let Ok(style) = ProgressStyle::with_template(&template) {
        let count = |state: &ProgressState, out: &mut dyn std::fmt::Write| {
            let of = known(state.len(), state.pos()).map_or(String::new(), |n| format!("/{}", grouped(n)));
            let _ = write!(out, "{}{of}", grouped(state.pos()));
        };
        let left = |state: &ProgressState, out: &mut dyn std::fmt::Write| {
            let seconds = state.eta().as_secs_f64();
            let _ = match known(state.len(), state.pos()) {
                Some(length) if state.pos() < length => write!(out, ", {} left", duration(seconds)),
                Some(_) => write!(out, ", finishing"),
                None => Ok(()),
            };
        };
        let rate = |state: &ProgressState, out: &mut dyn std::fmt::Write| {
            let _ = write!(out, "{}", per_second(state.per_sec()));
        };
        bar.set_style(style.with_key("count", count).with_key("rate", rate).with_key("left", left));
    }
    bar.set_position(done as u64);
    bar.reset_eta();
    ProgressDisplay {
        bar,
        of: of.to_owned(),
        is_logged: is_wanted && !is_drawn,
        start: Instant::now(),
        first: done as u64,
        logged: AtomicU64::new(0),
    }
}

impl Progress for ProgressDisplay {
    fn inc(&self, n: u64) {
        self.bar.inc(n);
        self.log();
    }

    fn set_position(&self, n: u64) {
        self.bar.set_position(n);
        self.log();
    }

    fn set_length(&self, n: u64) {
        self.bar.set_length(n);
    }

    fn set_message(&self, message: String) {
        self.bar.set_message(message);
    }

    fn finish(&self) {
        self.bar.finish_and_clear();
    }
}

impl ProgressDisplay {
    /// Logs a line where it is time for one.
    fn log(&self) {
        if !self.is_logged {
            return;
        }
        let (now, last) = (self.start.elapsed(), self.logged.load(Ordering::Relaxed));
        let millis = now.as_millis() as u64;
        if Duration::from_millis(millis.saturating_sub(last)) < EVERY {
            return;
        }
        // Of several threads, one.
        if self.logged.compare_exchange(last, millis, Ordering::Relaxed, Ordering::Relaxed).is_ok() {
            let (done, length) = (self.bar.position(), self.bar.length());
            tracing::info!("{}", line(&self.of, [self.first, done], length, now, &self.bar.message()));
        }
    }
}

/// How many there are to be done, where that is known: what is already exceeded was wrong.
fn known(length: Option<u64>, done: u64) -> Option<u64> {
    length.filter(|length| *length > 0 && *length >= done)
}

/// How far it is: done `from` the beginning of this run up `to` now.
fn line(of: &str, [from, to]: [u64; 2], length: Option<u64>, after: Duration, message: &str) -> String {
    let rate = to.saturating_sub(from) as f64 / after.as_secs_f64().max(1e-9);
    let mut line = grouped(to);
    let length = known(length, to);
    if let Some(length) = length {
        line.push_str(&format!(" of {}", grouped(length)));
    }
    line.push_str(&format!(" {of}, {}", per_second(rate)));
    match length {
        Some(length) if to < length && rate > 0.0 => {
            let left = (length - to) as f64 / rate;
            line.push_str(&format!(", about {} left", duration(left)));
        }
        Some(length) if to == length => line.push_str(", finishing"),
        _ => {}
    }
    if !message.is_empty() {
        line.push_str(&format!(", {message}"));
    }
    line
}

/// A rate for people: `1 276/s`, below ten with a digit, and what takes minutes by the hour.
fn per_second(rate: f64) -> String {
    match rate {
        r if !r.is_finite() || r <= 0.0 => "0/s".to_owned(),
        r if r < 0.05 => format!("{:.1}/h", 3600.0 * r),
        r if r < 9.95 => format!("{r:.1}/s"),
        r => format!("{}/s", grouped(r.round() as u64)),
    }
}

/// A number in groups of three digits: `258 000`.
pub fn grouped(n: u64) -> String {
    let digits = n.to_string();
    let mut out = String::with_capacity(digits.len() + digits.len() / 3);
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            out.push(' ');
        }
        out.push(digit);
    }
    out
}

/// A time for people.
pub fn duration(seconds: f64) -> String {
    match seconds {
        s if s < 99.5 => format!("{s:.0} s"),
        s if s < 5940.0 => format!("{:.0} min", s / 60.0),
        s => format!("{:.1} h", s / 3600.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_in_groups_of_three() {
        let shown = [0, 7, 999, 1000, 1276, 258_000, 1_000_000].map(grouped);
        assert_eq!(shown, ["0", "7", "999", "1 000", "1 276", "258 000", "1 000 000"]);
        assert_eq!(
            [0.0, 0.001, 0.25, 12.4, 1276.4].map(per_second),
            ["0/s", "3.6/h", "0.2/s", "12/s", "1 276/s"]
        );
    }

    #[test]
    fn a_line_of_the_log_has_distance_and_duration() {
        let minute = Duration::from_secs(60);
        assert_eq!(
            line("samples", [1000, 7000], Some(19_000), minute, "held out 0.1 mm"),
            "7 000 of 19 000 samples, 100/s, about 2 min left, held out 0.1 mm"
        );
        assert_eq!(line("evaluations", [0, 30], None, minute, ""), "30 evaluations, 0.5/s");
        // Nobody knows how many, or what was thought to be all is exceeded: no end is promised.
        assert_eq!(line("evaluations", [0, 30], Some(0), minute, ""), "30 evaluations, 0.5/s");
        assert_eq!(line("steps", [0, 600], Some(300), minute, ""), "600 steps, 10/s");
        assert_eq!(line("steps", [0, 300], Some(300), minute, ""), "300 of 300 steps, 5.0/s, finishing");
        assert_eq!(line("epochs", [0, 0], Some(30), minute, ""), "0 of 30 epochs, 0/s");
    }
}
