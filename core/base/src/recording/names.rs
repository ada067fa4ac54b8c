//! Names of channels.
//!
//! A name ends in its SI unit, so no number is without one. The few quantities that have none are listed here.

use super::{Channel, Check};
use crate::BadInput;
use crate::units::Unit;

/// Quantities without unit.
const UNITLESS: [&str; 9] = [
    "tip_qw",
    "tip_qx",
    "tip_qy",
    "tip_qz",
    "extrapolating",
    "outside_validation",
    "limited",
    "contact",
    "feedback",
];
/// Quantities without unit that are numbered: `tick_goal_1`.
const UNITLESS_NUMBERED: [&str; 3] = ["tick_goal", "tick_present", "load"];
/// Families of which every member must be there, because they are used as one vector.
const WITHOUT_HOLES: [&str; 2] = ["stroke", "aux"];

pub(crate) fn is_unitless(name: &str) -> bool {
    UNITLESS.contains(&name) || UNITLESS_NUMBERED.iter().any(|stem| number_of(name, stem, "").is_some())
}

/// Most channels of a recording: 500 auxiliary tendons, and what each of them does to the tip's x, y and z, are fewer.
pub const MAX_CHANNELS: usize = 5000;

/// Accepts a number of columns, before anything is done for each of them.
pub(super) fn check_count(n: usize) -> Check<()> {
    crate::size::check_at_most("columns", n, MAX_CHANNELS)
}

/// Kind of a column of a table.
pub(super) enum ColumnKind {
    Time(&'static Unit),
    Gap,
    /// Index of the channel; no unit for plain numbers.
    Channel(usize, Option<&'static Unit>),
}

/// Kind of each column of a table (n_columns), and a channel without values for each that is one.
pub(super) fn columns(table: &[&str]) -> Check<(Vec<ColumnKind>, Vec<Channel>)> {
    check_count(table.len())?;
    let mut columns = Vec::new();
    let mut channels: Vec<Channel> = Vec::new();
    let mut seen: Vec<String> = Vec::new();
    for &name in table {
        let (si, column) = match Unit::of_name(name) {
            _ if name == "gap" => (name.to_owned(), ColumnKind::Gap),
            _ if is_unitless(name) => (name.to_owned(), ColumnKind::Channel(channels.len(), None)),
            Some(("time", unit)) if unit.si_suffix == "s" => ("time_s".to_owned(), ColumnKind::Time(unit)),
            Some((stem, unit)) => {
                (format!("{stem}_{}", unit.si_suffix), ColumnKind::Channel(channels.len(), Some(unit)))
            }
            None => return Err(unknown(name)),
        };
        if seen.contains(&si) {
            return Err(duplicate(name, &si));
        }
        if matches!(column, ColumnKind::Channel(..)) {
            check(&si).map_err(|_| unknown(name))?;
            channels.push(Channel::new(si.clone(), Vec::new()));
        }
        seen.push(si);
        columns.push(column);
    }
    if !columns.iter().any(|column| matches!(column, ColumnKind::Time(_))) {
        let found = table.join(", ");
        return Err(BadInput::new("", "a column time_s", if found.is_empty() { "none" } else { &found }));
    }
    Ok((columns, channels))
}

/// Accepts the names that a channel may have in memory.
pub(super) fn check(name: &str) -> Check<()> {
    if name == "time_s" {
        return Err(duplicate("time_s", "time_s").hint("times are no channel"));
    }
    let spelled = name.bytes().all(|b| b.is_ascii_lowercase() || b.is_ascii_digit() || b == b'_');
    match Unit::of_name(name) {
        _ if spelled && is_unitless(name) => Ok(()),
        Some((_, unit)) if spelled && unit.is_si() => Ok(()),
        Some((stem, unit)) if spelled => Err(BadInput::new(name, "a name ending in an SI unit", name)
            .hint(format!("convert it to {stem}_{}", unit.si_suffix))),
        _ => Err(unknown(name)),
    }
}

/// The error for a name without a known unit.
pub(super) fn unknown(name: &str) -> BadInput {
    let parts: Vec<&str> = name.split('_').take(2).collect();
    let hint = match (parts[0], parts.get(1)) {
        ("time", _) => "time_s".to_owned(),
        ("stroke" | "aux" | "tip", Some(which)) => format!("{}_{which}_mm", parts[0]),
        ("tension", Some(which)) => format!("tension_{which}_n"),
        _ => "lower-case letters, digits and _, and at the end the unit, e.g. _mm or _n".to_owned(),
    };
    let shown = if name.is_empty() { "an empty name" } else { name };
    BadInput::new(shown, "a name ending in its unit", format!("`{name}`")).hint(hint)
}

/// The error for two columns of the same quantity.
pub(super) fn duplicate(column: &str, name: &str) -> BadInput {
    BadInput::new(column, "each quantity once", format!("{name} twice"))
}

/// k of `stem_k_unit` or, with an empty unit, of `stem_k`.
fn number_of(name: &str, stem: &str, unit: &str) -> Option<u32> {
    let rest = name.strip_prefix(stem)?.strip_prefix('_')?;
    let digits = if unit.is_empty() { rest } else { rest.strip_suffix(unit)?.strip_suffix('_')? };
    // `parse` alone would take a sign.
    if digits.bytes().all(|b| b.is_ascii_digit()) { digits.parse().ok() } else { None }
}

/// The channels `stem_k_unit` with their k, in order.
pub(super) fn numbered<'a>(channels: &'a [Channel], stem: &str, unit: &str) -> Vec<(u32, &'a Channel)> {
    let mut found: Vec<(u32, &Channel)> =
        channels.iter().filter_map(|c| Some((number_of(&c.name, stem, unit)?, c))).collect();
    found.sort_by_key(|(k, _)| *k);
    found
}

/// Strokes and aux channels are numbered 1, 2, … without holes.
pub(super) fn check_numbering(channels: &[Channel]) -> Check<()> {
    for stem in WITHOUT_HOLES {
        for (i, (k, channel)) in numbered(channels, stem, "m").into_iter().enumerate() {
            if k as usize != i + 1 {
                let expected = format!("{stem} number {} next", i + 1);
                return Err(BadInput::new(&channel.name, expected, format!("number {k}"))
                    .hint("number them from 1 without holes"));
            }
        }
    }
    Ok(())
}
