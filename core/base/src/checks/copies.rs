//! Rows that occur twice: in two recordings that are used together, or in one.
//!
//! A measurement is never repeated to the last bit for long. Stretches of rows are compared by their hashes, of which every
//! eighth is kept; so the cost is linear in the rows.

use std::collections::HashMap;

use super::series::is_command;
use super::{Finding, Warning};
use crate::Recording;

/// Rows of a stretch.
const STRETCH: usize = 64;
/// Fewest changes within a stretch: a robot at rest, for which a coarse sensor has one value, is no copy.
const MIN_CHANGES: u32 = 8;
/// One of so many hashes is kept.
const KEPT: u64 = 8;
/// Fewest kept stretches that agree: some hundred rows.
const MIN_MATCHES: usize = 4;
/// And the least part of the shorter recording [-]: simulations that all begin at rest have that in common.
const MIN_PART: f64 = 0.01;
/// Odd multiplier of the hash of a stretch.
const MULTIPLIER: u64 = 0x9e37_79b9_7f4a_7c15;

/// A stretch: recording, first row.
type Place = (usize, usize);

/// Rows shared by two recordings, or by one with itself.
#[derive(Clone, Copy)]
struct SharedRows {
    /// First and last row in the later one, and the first in the earlier.
    rows: [usize; 2],
    from: usize,
    matches: usize,
}

pub fn check(recordings: &[(&str, &Recording)]) -> Vec<Warning> {
    let mut seen: HashMap<u64, Place> = HashMap::new();
    let mut shared: Vec<((usize, usize), SharedRows)> = Vec::new();
    let mut kept = vec![0usize; recordings.len()];
    for (k, (_, recording)) in recordings.iter().enumerate() {
        let mut of_this: HashMap<usize, SharedRows> = HashMap::new();
        for (hash, row) in stretches(recording) {
            kept[k] += 1;
            match seen.get(&hash) {
                Some(&(other, from)) if other != k || row >= from + STRETCH => {
                    let shared =
                        of_this.entry(other).or_insert(SharedRows { rows: [row, row], from, matches: 0 });
                    shared.rows[1] = row;
                    shared.matches += 1;
                }
                Some(_) => {}
                None => {
                    seen.insert(hash, (k, row));
                }
            }
        }
        let mut of_this: Vec<(usize, SharedRows)> = of_this.into_iter().collect();
        of_this.sort_by_key(|(other, _)| *other);
        shared.extend(of_this.into_iter().map(|(other, what)| ((other, k), what)));
    }
    shared
        .into_iter()
        .filter(|((other, k), what)| {
            let shorter = kept[*k].min(kept[*other]);
            what.matches >= MIN_MATCHES && what.matches as f64 >= MIN_PART * shorter as f64
        })
        .map(|((other, k), what)| warning(recordings, (other, k), what, kept[k]))
        .collect()
}

fn warning(
    recordings: &[(&str, &Recording)],
    (other, k): (usize, usize),
    what: SharedRows,
    kept: usize,
) -> Warning {
    let part = 100.0 * what.matches as f64 / kept as f64;
    let [first, last] = [what.rows[0], what.rows[1] + STRETCH - 1];
    let (kind, finding, hint) = if other == k {
        let finding = format!(
            "{part:.0} % of the motion occurs twice, identical to the last bit, from row {} on",
            what.from + 1
        );
        (Finding::CopyWithin, finding, "a measurement never repeats so: leave one of the two out")
    } else {
        let name = recordings[other].0;
        let finding = format!(
            "{part:.0} % of the motion is that of {name} to the last bit, from its row {} on",
            what.from + 1
        );
        (Finding::CopyOfRecording, finding, "test data must not be training data: remove one of the two")
    };
    Warning::new(kind, "all measured", finding)
        .measured(part, 0.0, "%")
        .at_rows(first, last)
        .hint(hint)
        .of(recordings[k].0)
}

/// Kept hashes of the stretches of a recording with their first rows, in order.
fn stretches(recording: &Recording) -> Vec<(u64, usize)> {
    let measured: Vec<&[f64]> = recording
        .channels()
        .iter()
        .filter(|channel| !is_command(&channel.name))
        .map(|channel| channel.values.as_slice())
        .collect();
    let n = recording.n_samples();
    if measured.is_empty() || n < STRETCH {
        return Vec::new();
    }
    let row = |i: usize| {
        measured.iter().fold(0u64, |hash, values| mixed(hash.rotate_left(5) ^ (values[i] + 0.0).to_bits()))
    };
    let rows: Vec<u64> = (0..n).map(row).collect();
    let leaves = (1..STRETCH).fold(1u64, |power, _| power.wrapping_mul(MULTIPLIER));
    let is_change = |i: usize| u32::from(rows[i] != rows[i - 1]);
    let mut hash =
        rows[..STRETCH].iter().fold(0u64, |hash, row| hash.wrapping_mul(MULTIPLIER).wrapping_add(*row));
    let mut changes: u32 = (1..STRETCH).map(is_change).sum();
    let mut found = Vec::new();
    for first in 0..=n - STRETCH {
        if first > 0 {
            let end = first + STRETCH - 1;
            hash = hash.wrapping_sub(rows[first - 1].wrapping_mul(leaves));
            hash = hash.wrapping_mul(MULTIPLIER).wrapping_add(rows[end]);
            changes = changes + is_change(end) - is_change(first);
        }
        // The low bits of a product are those of its factors alone.
        let hash = mixed(hash);
        if changes >= MIN_CHANGES && hash.is_multiple_of(KEPT) {
            found.push((hash, first));
        }
    }
    found
}

/// Every bit of the input in every bit of the result (the finaliser of SplitMix64).
fn mixed(mut bits: u64) -> u64 {
    bits = bits.wrapping_add(MULTIPLIER);
    bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    bits ^ (bits >> 31)
}
