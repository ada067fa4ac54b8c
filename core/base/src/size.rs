//! Sizes that a file or an option asks for: refused before memory or time is spent on them.
//!
//! A count has a largest value of its own where the format or the field knows one. Whatever is then still too large for
//! this machine is refused by its memory, with [`check_memory`].

use crate::BadInput;

/// Assumed free memory where the system does not report it [bytes].
const ASSUMED: u64 = 4 << 30;
/// Not worth a look at the machine [byte].
const MIN_ASKED: f64 = 1e6;
/// Part of the free memory that one task may ask for; the rest is for allocations that are not counted [-].
const SHARE: f64 = 0.8;

/// Memory that this process may still take [bytes]: what the machine has left, and where the process is in a control
/// group, at most what the group may have. 4 GiB where the system does not report it.
pub fn free_memory() -> u64 {
    let read = |path: &str| std::fs::read_to_string(path).ok();
    let machine = read("/proc/meminfo").and_then(|text| available(&text));
    let number = |path: &str| read(path)?.trim().parse::<u64>().ok();
    // What the group uses counts the cache of files too, which is freed on demand: only the limit is meaningful.
    let group = number("/sys/fs/cgroup/memory.max");
    [machine, group, address_space()].into_iter().flatten().min().unwrap_or(ASSUMED)
}

/// Free part of the address space that this process may have (`ulimit -v`) [bytes]; none where it is not
/// limited.
pub fn address_space() -> Option<u64> {
    let limit = limit_of(&std::fs::read_to_string("/proc/self/limits").ok()?)?;
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmSize:"))?;
    let used = 1024 * line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()?;
    Some(limit.saturating_sub(used))
}

/// The soft limit of the address space in /proc/self/limits [bytes].
fn limit_of(text: &str) -> Option<u64> {
    let line = text.lines().find_map(|line| line.strip_prefix("Max address space"))?;
    line.split_whitespace().next()?.parse().ok()
}

/// `MemAvailable` of /proc/meminfo [bytes].
fn available(text: &str) -> Option<u64> {
    let line = text.lines().find_map(|line| line.strip_prefix("MemAvailable:"))?;
    Some(1024 * line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()?)
}

/// Accepts a task that needs so much memory [bytes], estimated.
///
/// # Errors
/// `BadInput` where this machine does not have it free.
pub fn check_memory(place: &str, bytes: f64, hint: &str) -> Result<(), BadInput> {
    if bytes <= MIN_ASKED {
        return Ok(());
    }
    let most = SHARE * free_memory() as f64;
    if bytes <= most {
        return Ok(());
    }
    let expected = format!("at most {} of memory, which this machine has free", gigabytes(most));
    Err(BadInput::new(place, expected, gigabytes(bytes)).hint(hint))
}

fn gigabytes(bytes: f64) -> String {
    let gb = 1e-9 * bytes;
    if gb < 1e4 { format!("{gb:.2} GB") } else { format!("{gb:.0e} GB") }
}

/// Accepts a count from 1 to `most`.
///
/// # Errors
/// `BadInput` naming both.
pub fn check_count(place: &str, n: usize, most: usize) -> Result<(), BadInput> {
    if n == 0 {
        return Err(BadInput::new(place, "at least 1", "0"));
    }
    check_at_most(place, n, most)
}

/// Accepts a number of things up to `most`.
///
/// # Errors
/// `BadInput` naming both.
pub fn check_at_most(place: &str, n: usize, most: usize) -> Result<(), BadInput> {
    if n <= most { Ok(()) } else { Err(BadInput::new(place, format!("at most {most}"), n.to_string())) }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)] // a test may stop where it stands
    use super::*;

    #[test]
    fn what_the_machine_has_free_is_read() {
        let text = "MemTotal:       16384 kB\nMemFree:            1 kB\nMemAvailable:    8192 kB\n";
        assert_eq!(available(text), Some(8 << 20));
        assert_eq!(available("MemTotal: 5 kB\n"), None);
        assert!(free_memory() > 1 << 20);
    }

    #[test]
    fn a_limit_of_the_address_space_is_read() {
        let line = |limit: &str| {
            format!("Limit  Soft Limit  Hard Limit  Units\nMax address space  {limit}  unlimited  bytes\n")
        };
        assert_eq!(limit_of(&line("61440000")), Some(61_440_000));
        assert_eq!(limit_of(&line("unlimited")), None);
    }

    #[test]
    fn a_size_beyond_the_machine_is_refused() {
        check_memory("x", 1.0, "").unwrap();
        for bytes in [1e15, 1e300, f64::INFINITY, f64::NAN] {
            let bad = check_memory("--hidden", bytes, "a smaller one").unwrap_err();
            assert!(bad.to_string().starts_with("--hidden: expected at most "), "{bad}");
            assert!(bad.to_string().len() < 200, "{bad}");
        }
    }

    #[test]
    fn counts_have_a_largest_value() {
        check_count("n", 5, 5).unwrap();
        assert_eq!(check_count("n", 6, 5).unwrap_err().to_string(), "n: expected at most 5, got 6");
        assert_eq!(check_count("n", 0, 5).unwrap_err().to_string(), "n: expected at least 1, got 0");
    }
}
