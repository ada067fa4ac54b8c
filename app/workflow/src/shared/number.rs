//! Numbers on the command line: what each may be, refused before anything else is done.
//!
//! A parser does not know its option; the caller adds it as the place.

use hysteron_base::BadInput;

type Parsed<T> = Result<T, BadInput>;

/// Characters of what was typed that a message shows.
const LONGEST_SHOWN: usize = 40;
/// Most threads for a processor, and on small machines: each has a stack and a workspace of its own.
const THREADS_PER_CORE: usize = 4;
const MIN_THREADS: usize = 32;

fn bad(expected: String, typed: &str) -> BadInput {
    let found: String = typed.chars().take(LONGEST_SHOWN).collect();
    BadInput::new("", expected, if found.is_empty() { "nothing".to_owned() } else { found })
}

/// A whole number from 1 to `MAX`.
pub fn count<const MAX: usize>(typed: &str) -> Parsed<usize> {
    counted(typed, MAX)
}

/// A whole number from 0 to `MAX`.
pub fn up_to<const MAX: u32>(typed: &str) -> Parsed<u32> {
    match typed {
        "0" => Ok(0),
        _ => Ok(counted(typed, MAX as usize)? as u32),
    }
}

/// A number of threads that this machine can make use of.
pub fn threads(typed: &str) -> Parsed<usize> {
    let n_cores = std::thread::available_parallelism().map_or(1, std::num::NonZeroUsize::get);
    counted(typed, MIN_THREADS.max(THREADS_PER_CORE * n_cores))
        .map_err(|bad| bad.hint(format!("this machine has {n_cores} cores")))
}

fn counted(typed: &str, most: usize) -> Parsed<usize> {
    let is_large = !typed.is_empty() && typed.bytes().all(|byte| byte.is_ascii_digit());
    match typed.parse::<usize>() {
        Ok(n) if (1..=most).contains(&n) => Ok(n),
        Ok(0) => Err(bad("at least 1".to_owned(), typed)),
        _ if is_large => Err(bad(format!("at most {most}"), typed)),
        _ => Err(bad(format!("a whole number from 1 to {most}"), typed)),
    }
}

fn between(typed: &str, [least, most]: [f64; 2], what: &str) -> Parsed<f64> {
    match typed.parse::<f64>() {
        Ok(value) if (least..=most).contains(&value) => Ok(value),
        Ok(value) if value > most => Err(bad(format!("at most {most:?}{what}"), typed)),
        Ok(value) if value < least => Err(bad(format!("at least {least:?}{what}"), typed)),
        _ => Err(bad(format!("a number from {least:?} to {most:?}{what}"), typed)),
    }
}

/// A length above zero [mm].
pub fn length_mm(typed: &str) -> Parsed<f64> {
    between(typed, [1e-9, 1e6], " mm")
}

/// A length of any sign [mm].
pub fn position_mm(typed: &str) -> Parsed<f64> {
    between(typed, [-1e6, 1e6], " mm")
}

/// A length that may be zero [mm].
pub fn distance_mm(typed: &str) -> Parsed<f64> {
    between(typed, [0.0, 1e6], " mm")
}

/// A speed above zero [mm/s].
pub fn speed_mm_s(typed: &str) -> Parsed<f64> {
    between(typed, [1e-6, 1e6], " mm/s")
}

/// A time above zero [s].
pub fn time_s(typed: &str) -> Parsed<f64> {
    between(typed, [1e-3, 1e9], " s")
}

/// A weight above zero.
pub fn weight(typed: &str) -> Parsed<f64> {
    between(typed, [1e-15, 1e15], "")
}

/// A step size of training: with none nothing is learned, with more than one nothing converges.
pub fn learning_rate(typed: &str) -> Parsed<f64> {
    between(typed, [1e-8, 1.0], "")
}

/// A part of a whole.
pub fn part(typed: &str) -> Parsed<f64> {
    between(typed, [0.0, 1.0], "")
}

/// A cut-off frequency [Hz].
pub fn cutoff_hz(typed: &str) -> Parsed<f64> {
    between(typed, [1e-3, 1e5], " Hz")
}

/// A gain of an observer [1/s].
pub fn gain(typed: &str) -> Parsed<f64> {
    between(typed, [1e-3, 1e5], " 1/s")
}

/// The step of a simulation [s].
pub fn period_s(typed: &str) -> Parsed<f64> {
    between(typed, [1e-5, 10.0], " s")
}

/// An angle that may be zero, up to half a turn [rad].
pub fn angle_rad(typed: &str) -> Parsed<f64> {
    between(typed, [0.0, std::f64::consts::PI], " rad")
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)] // a test may stop where it stands
    use super::*;

    #[test]
    fn counts_end_where_they_say() {
        assert_eq!(count::<100>("100").unwrap(), 100);
        for (typed, expected) in [
            ("101", "at most 100"),
            ("1000000000", "at most 100"),
            ("99999999999999999999999999", "at most 100"),
            ("0", "at least 1"),
            ("-1", "a whole number from 1 to 100"),
            ("1e3", "a whole number from 1 to 100"),
            ("", "a whole number from 1 to 100"),
        ] {
            assert_eq!(count::<100>(typed).unwrap_err().expected, expected, "{typed}");
        }
        assert_eq!(up_to::<64>("0").unwrap(), 0);
        assert_eq!(up_to::<64>("64").unwrap(), 64);
        assert_eq!(up_to::<64>("4000000000").unwrap_err().expected, "at most 64");
        assert_eq!(threads("2").unwrap(), 2);
        let bad = threads("100000").unwrap_err();
        assert!(bad.expected.starts_with("at most") && bad.hint.contains("cores"), "{bad}");
    }

    #[test]
    fn what_cannot_be_meant_is_refused() {
        for bad in
            [learning_rate("0"), learning_rate("1e3"), part("1.1"), cutoff_hz("0"), gain("0"), period_s("-1")]
        {
            assert!(bad.unwrap_err().expected.starts_with("at "));
        }
        assert!(learning_rate("1e-4").is_ok() && part("0").is_ok() && angle_rad("0").is_ok());
    }

    #[test]
    fn lengths_end_where_they_say() {
        assert_eq!(length_mm("0.5").unwrap(), 0.5);
        assert_eq!(position_mm("-3").unwrap(), -3.0);
        for typed in ["0", "-1", "1e-300", "1e300", "inf", "nan", "NaN", "1mm", ""] {
            let bad = length_mm(typed).unwrap_err();
            assert!(bad.expected.ends_with(" mm"), "{bad}");
        }
        let long = length_mm(&"9".repeat(10_000)).unwrap_err();
        assert!(long.to_string().len() < 100, "{long}");
    }
}
