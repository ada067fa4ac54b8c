//! Dates and times of day as text: ISO 8601 and RFC 3339 with or without a zone, and the German order with points.
//!
//! Days and months in the order `05/06/2024` are not read: they are ambiguous.

use chrono::{NaiveDate, NaiveTime, Timelike};

/// Whole seconds since 1970 (of a time of day, since midnight), and the fraction [s].
pub(super) type Timestamp = (i64, f64);

const DATES: [&str; 3] = ["%Y-%m-%d", "%Y/%m/%d", "%d.%m.%Y"];
const TIMES: [&str; 2] = ["%H:%M:%S%.f", "%H:%M"];
/// No stamp is longer [byte].
const MAX_LENGTH: usize = 40;

/// The stamp in a cell. Without a zone it is taken as UTC: only differences count.
pub(super) fn parse(text: &str) -> Option<Timestamp> {
    let begins = text.as_bytes().first().is_some_and(u8::is_ascii_digit);
    if !begins || text.len() > MAX_LENGTH || !text.contains([':', '-', '/', '.']) {
        return None;
    }
    if let Some(date) = date(text) {
        return Some((seconds_of(date), 0.0));
    }
    let (date_part, clock) = match text.split_once(['T', ' ']) {
        Some((date_part, clock)) => (Some(date(date_part)?), clock),
        None => (None, text),
    };
    let (clock, offset) = without_zone(clock.trim())?;
    let time = time_of_day(clock)?;
    let whole = date_part.map_or(0, seconds_of) + i64::from(time.num_seconds_from_midnight()) - offset;
    Some((whole, f64::from(time.nanosecond()) * 1e-9))
}

fn date(text: &str) -> Option<NaiveDate> {
    DATES.iter().find_map(|format| NaiveDate::parse_from_str(text, format).ok())
}

fn seconds_of(date: NaiveDate) -> i64 {
    date.and_time(NaiveTime::MIN).and_utc().timestamp()
}

fn time_of_day(text: &str) -> Option<NaiveTime> {
    let text = text.replace(',', ".");
    TIMES.iter().find_map(|format| NaiveTime::parse_from_str(&text, format).ok())
}

/// A time without its zone, and how far the zone is east of UTC [s].
fn without_zone(text: &str) -> Option<(&str, i64)> {
    if let Some(local) = text.strip_suffix(['Z', 'z']).or_else(|| text.strip_suffix(" UTC")) {
        return Some((local, 0));
    }
    let Some(at) = text.rfind(['+', '-']) else { return Some((text, 0)) };
    let digits: String = text[at + 1..].chars().filter(|c| *c != ':').collect();
    let is_zone = matches!(digits.len(), 2 | 4) && digits.bytes().all(|b| b.is_ascii_digit());
    let (hours, minutes) = if is_zone { digits.split_at(2) } else { return None };
    let minutes: i64 = if minutes.is_empty() { 0 } else { minutes.parse().ok()? };
    let east = hours.parse::<i64>().ok()? * 3600 + minutes * 60;
    Some((text[..at].trim_end(), if text[at..].starts_with('-') { -east } else { east }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stamps_of_every_spelling_are_the_same_moment() {
        for text in [
            "2024-05-06T12:00:00.25Z",
            "2024-05-06T14:00:00.250+02:00",
            "2024-05-06 05:00:00.25-0700",
            "2024/05/06 12:00:00,25",
            "06.05.2024 12:00:00.25",
            "2024-05-06 12:00:00.25 UTC",
            "2024-05-06T17:30:00.25+05:30",
        ] {
            // By Python: datetime(2024, 5, 6, 12, tzinfo=timezone.utc).timestamp()
            assert_eq!(parse(text), Some((1_714_996_800, 0.25)), "{text}");
        }
        assert_eq!(parse("2024-05-06"), Some((1_714_953_600, 0.0)));
        assert_eq!(parse("00:01:30.5"), Some((90, 0.5)));
    }

    #[test]
    fn what_is_no_stamp_or_could_be_two_is_none() {
        for text in
            ["05/06/2024", "2024-13-01", "1.5", "1-2", "12:61:00", "tendon0", "2024-05-06T12:00:00+2", ""]
        {
            assert_eq!(parse(text), None, "{text}");
        }
    }
}
