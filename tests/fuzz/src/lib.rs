//! Damaged input for the tests of every reader: drawn from seeds, in any number, with the memory measured.
//!
//! A test draws its default number of cases. `HYSTERON_FUZZ=100` draws a hundred times as many,
//! `HYSTERON_FUZZ_CASES=1000000` so many for each test; `HYSTERON_FUZZ_S=600` ends a test after so many seconds and
//! says how far it came. Whoever asks for so many gets a line of CSV for each reader: its name, cases, the slowest of them
//! [ms of processor time], the most memory of the process meanwhile [MB]. Then no process may have more than 256 MB, so
//! that one test at a time is asked for; no case may ever take longer than a second.

#![allow(clippy::unwrap_used, reason = "a test may stop where it stands")]

pub mod checkpoint;
mod recorded;
pub mod text;

pub use recorded::{data_folder, recorded};

use hysteron_base::{BadInput, rng};
use proptest::prelude::*;
use proptest::sample::Index;
use proptest::test_runner::{RngAlgorithm, TestCaseError, TestError, TestRng, TestRunner};
use std::time::{Duration, Instant};

/// Most time of a processor that a case may take, and most time by the clock, of a machine with other work to do.
const TIME_MAX: Duration = Duration::from_secs(1);
const PATIENCE: Duration = Duration::from_secs(30);
/// Most memory of a process that does nothing but read [bytes].
const MEMORY_MAX: u64 = 256 << 20;
/// Cases of a batch, which has a seed of its own.
const BATCH: u32 = 1000;

fn number(name: &str) -> Option<u64> {
    std::env::var(name)
        .ok()
        .map(|value| value.parse().unwrap_or_else(|_| panic!("{name}={value} is no number")))
}

/// Number of cases in place of `usual` ones.
pub fn n_cases(usual: u32) -> u64 {
    number("HYSTERON_FUZZ_CASES").unwrap_or(u64::from(usual) * number("HYSTERON_FUZZ").unwrap_or(1))
}

/// The configuration of a property that draws so many cases, or a multiple.
pub fn cases(usual: u32) -> ProptestConfig {
    ProptestConfig::with_cases(u32::try_from(n_cases(usual)).unwrap_or(u32::MAX))
}

/// Tries `usual` cases, or as many as the environment asks for, on `reader`, which panics where something is wrong.
/// The same cases on every machine; the smallest that fails is shown. The process never has more than `memory_max`
/// bytes, nor more than 256 MB where cases were asked for; no case takes longer than a second.
///
/// # Panics
/// Where a case fails.
pub fn drive<S: Strategy>(
    name: &str,
    usual: u32,
    memory_max: u64,
    strategy: S,
    reader: impl Fn(S::Value) + std::panic::RefUnwindSafe,
) {
    let (n, start) = (n_cases(usual), Instant::now());
    let is_asked = number("HYSTERON_FUZZ_CASES").is_some() || number("HYSTERON_FUZZ").is_some();
    let memory_max = if is_asked { memory_max.min(MEMORY_MAX) } else { memory_max };
    if is_asked {
        reset_peak_memory();
    }
    let slowest = std::cell::Cell::new(Duration::ZERO);
    let patience = number("HYSTERON_FUZZ_S").map(Duration::from_secs);
    let mut done = 0;
    while done < n && patience.is_none_or(|patience| start.elapsed() < patience) {
        let mut seed = [0; 32];
        rng(1, &format!("fuzz/{name}/{done}")).fill_bytes(&mut seed);
        let batch = u32::try_from(n - done).map_or(BATCH, |left| left.min(BATCH));
        let config = ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(batch) };
        let mut runner = TestRunner::new_with_rng(config, TestRng::from_seed(RngAlgorithm::ChaCha, &seed));
        let outcome = runner.run(&strategy, |case| {
            let (begin, by_clock) = (processor_time(), Instant::now());
            reader(case);
            let took = processor_time().saturating_sub(begin);
            slowest.set(slowest.get().max(took));
            assert!(took < TIME_MAX && by_clock.elapsed() < PATIENCE, "{took:?}, {:?}", by_clock.elapsed());
            Ok::<(), TestCaseError>(())
        });
        match outcome {
            Ok(()) => {}
            Err(TestError::Fail(why, case)) => panic!("{name}, after {done} cases: {why}\n{case:?}"),
            Err(TestError::Abort(why)) => panic!("{name}, after {done} cases: {why}"),
        }
        done += u64::from(batch);
        assert_memory_is_below(memory_max);
    }
    if is_asked {
        let peak = peak_memory().map_or("unknown".to_owned(), |bytes| (bytes >> 20).to_string());
        log(&format!("fuzz,\"{name}\",{done},{:.1},{peak}", 1e3 * slowest.get().as_secs_f64()));
    }
}

/// Time that this thread had a processor; by the clock, where the system does not give it.
fn processor_time() -> Duration {
    #[cfg(target_os = "linux")]
    {
        let time = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
        let part = |part: i64| u64::try_from(part).unwrap_or(0);
        Duration::from_secs(part(time.tv_sec)) + Duration::from_nanos(part(time.tv_nsec))
    }
    #[cfg(not(target_os = "linux"))]
    {
        static START: std::sync::LazyLock<Instant> = std::sync::LazyLock::new(Instant::now);
        START.elapsed()
    }
}

/// From here on [`peak_memory`] is that of what follows, where the system can reset it.
fn reset_peak_memory() {
    let _ = std::fs::write("/proc/self/clear_refs", "5");
}

#[expect(clippy::print_stderr, reason = "whoever asks for a million cases wants to know how it went")]
fn log(line: &str) {
    eprintln!("{line}");
}

/// The most memory that this process had at any time [bytes], other tests in it included; none where the system does
/// not log.
pub fn peak_memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    Some(1024 * line.split_whitespace().next()?.parse::<u64>().ok()?)
}

/// # Panics
/// If this process ever had as much memory [bytes].
pub fn assert_memory_is_below(most: u64) {
    if let Some(peak) = peak_memory() {
        assert!(peak < most, "{} MB", peak >> 20);
    }
}

/// An error has place, expectation and finding, and is no book.
///
/// # Panics
/// If it is none, or not in that form.
pub fn assert_in_house_form(bad: Option<&BadInput>, error: &dyn std::fmt::Display) {
    let Some(bad) = bad else { panic!("not bad input but: {error}") };
    assert!(![&bad.place, &bad.expected, &bad.found].iter().any(|part| part.trim().is_empty()), "{bad:?}");
    assert!(bad.to_string().len() < 2000, "{bad}");
}

/// One damage of bytes.
#[derive(Debug, Clone)]
pub enum Damage {
    /// Another value.
    Byte(Index, u8),
    /// A bit turned round.
    Bit(Index, u8),
    /// Eight bytes of all the same, as of a count.
    Word(Index, u8),
    /// One more.
    Insert(Index, u8),
    /// One less.
    Remove(Index),
    /// A part that is missing.
    Cut(Index, Index),
    /// The end, too early.
    End(Index),
}

/// A few damages.
pub fn damages() -> impl Strategy<Value = Vec<Damage>> {
    let at = any::<Index>;
    let byte = || prop_oneof![Just(0), Just(0xff), Just(0x7f), any::<u8>()];
    let one = prop_oneof![
        4 => (at(), byte()).prop_map(|(at, byte)| Damage::Byte(at, byte)),
        4 => (at(), 0..8_u8).prop_map(|(at, bit)| Damage::Bit(at, bit)),
        2 => (at(), byte()).prop_map(|(at, byte)| Damage::Word(at, byte)),
        1 => (at(), byte()).prop_map(|(at, byte)| Damage::Insert(at, byte)),
        1 => at().prop_map(Damage::Remove),
        1 => (at(), at()).prop_map(|(a, b)| Damage::Cut(a, b)),
        1 => at().prop_map(Damage::End),
    ];
    prop::collection::vec(one, 1..5)
}

/// Bytes with these damages.
pub fn damaged(bytes: &[u8], damages: &[Damage]) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    for damage in damages {
        let n = bytes.len();
        if n == 0 {
            break;
        }
        match damage {
            Damage::Byte(at, byte) => bytes[at.index(n)] = *byte,
            Damage::Bit(at, bit) => bytes[at.index(n)] ^= 1 << bit,
            Damage::Word(at, byte) => {
                let at = at.index(n);
                bytes[at..(at + 8).min(n)].fill(*byte);
            }
            Damage::Insert(at, byte) => bytes.insert(at.index(n), *byte),
            Damage::Remove(at) => drop(bytes.remove(at.index(n))),
            Damage::Cut(a, b) => {
                let (a, b) = (a.index(n), b.index(n));
                bytes.drain(a.min(b)..a.max(b));
            }
            Damage::End(at) => bytes.truncate(at.index(n)),
        }
    }
    bytes
}
