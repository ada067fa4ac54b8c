//! Which part of a recording is its path: strokes begin and end at rest, so an approach comes before and a return after.
//!
//! The span is in the metadata, in seconds after the first row, and goes with the strokes into what a rig records of
//! them. Whoever does not know it reads a recording as before.

use hysteron_base::{BadInput, Recording};
use std::collections::BTreeMap;

/// Keys of the metadata.
const KEYS: [&str; 2] = ["path.begins_s", "path.ends_s"];

/// First and last instant of the path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PathSpan {
    /// Of its first row, after the first of the recording [s].
    pub begins: f64,
    /// Of its last row, after the first of the recording [s].
    pub ends: f64,
}

impl PathSpan {
    /// The span in a recording's metadata; the whole recording where there is none.
    ///
    /// # Errors
    /// `BadInput` for two entries that are no span.
    pub fn of(recording: &Recording) -> Result<Self, BadInput> {
        let time = recording.time();
        let whole = Self { begins: 0.0, ends: time[time.len() - 1] - time[0] };
        let span = KEYS.map(|key| recording.meta().extra.get(key));
        let [Some(begins), Some(ends)] = span else { return Ok(whole) };
        let bad = || {
            let found = format!("{begins} to {ends} s");
            BadInput::new(KEYS.join(", "), "two times in the recording, the first before the second", found)
        };
        let of = |text: &str| text.parse::<f64>().ok().filter(|time| time.is_finite() && *time >= 0.0);
        let (begins, ends) = (of(begins).ok_or_else(bad)?, of(ends).ok_or_else(bad)?);
        if ends < begins || begins > whole.ends {
            return Err(bad());
        }
        Ok(Self { begins, ends: ends.min(whole.ends) })
    }

    /// Writes it into metadata.
    pub fn write(&self, extra: &mut BTreeMap<String, String>) {
        for (key, time) in KEYS.into_iter().zip([self.begins, self.ends]) {
            extra.insert(key.to_owned(), time.to_string());
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)] // a test may stop where it stands
    use super::*;
    use hysteron_base::Metadata;

    fn recording(extra: &[(&str, &str)]) -> Recording {
        let extra = extra.iter().map(|(key, value)| ((*key).to_owned(), (*value).to_owned()));
        let meta = Metadata { extra: extra.collect(), ..Metadata::default() };
        Recording::new(vec![-1.0, 0.0, 1.0, 2.0], Vec::new(), Vec::new(), meta).unwrap()
    }

    #[test]
    fn a_span_comes_back_and_all_is_the_path_without_one() {
        assert_eq!(PathSpan::of(&recording(&[])).unwrap(), PathSpan { begins: 0.0, ends: 3.0 });
        let span = PathSpan { begins: 1.0, ends: 2.5 };
        let mut extra = BTreeMap::new();
        span.write(&mut extra);
        let pairs: Vec<(&str, &str)> =
            extra.iter().map(|(key, value)| (key.as_str(), value.as_str())).collect();
        assert_eq!(PathSpan::of(&recording(&pairs)).unwrap(), span);
        for bad in [["2", "1"], ["-1", "1"], ["x", "1"], ["4", "5"], ["NaN", "1"]] {
            let bad = [("path.begins_s", bad[0]), ("path.ends_s", bad[1])];
            assert_eq!(PathSpan::of(&recording(&bad)).unwrap_err().place, KEYS.join(", "), "{bad:?}");
        }
    }
}
