//! Files that people type, in TOML: reading them, and checking their keys one by one.
//!
//! A checker takes the key and the typed number and returns the number in SI; the unit is the end of the key. What
//! is refused comes back as [`BadInput`] with line, key, what was expected and what was found.

mod array;
mod message;
#[cfg(test)]
mod tests;

use crate::BadInput;
use crate::units::Unit;
pub use array::FixedArray;
use serde::de::DeserializeOwned;

type Check<T> = std::result::Result<T, BadInput>;

/// Reads the text of a file into the struct that has one field per key.
///
/// # Errors
/// `BadInput` naming line and key; prefix the file with [`BadInput::within`].
pub fn parse<T: DeserializeOwned>(text: &str) -> Check<T> {
    toml::from_str(text).map_err(|error| message::bad_toml(&error, text))
}

/// Accepts a file whose format and version (as typed) are those that are read here.
///
/// # Errors
/// `BadInput` naming `format` or `version`.
pub fn check_header(typed: (&str, i64), read: (&str, i64)) -> Check<()> {
    if typed.0 != read.0 {
        return Err(BadInput::new("format", format!("\"{}\"", read.0), format!("\"{}\"", typed.0)));
    }
    if typed.1 != read.1 {
        return Err(BadInput::new("version", read.1.to_string(), typed.1.to_string())
            .hint(format!("this program reads only that version of a {}", read.0)));
    }
    Ok(())
}

/// A number for which `holds`.
pub fn require(key: &str, expected: &str, typed: f64, holds: bool) -> Check<f64> {
    // `tendon.p0.points_mm[1][2]` ends in `_mm`.
    let name = key.rsplit('.').next().and_then(|last| last.split('[').next()).unwrap_or(key);
    let unit = Unit::of_name(name);
    let si = unit.map_or(typed, |(_, unit)| unit.to_si(typed));
    // The conversion may overflow or vanish: 1e308 GPa, 1e-323 mm.
    if holds && si.is_finite() && (si == 0.0) == (typed == 0.0) {
        return Ok(si);
    }
    Err(BadInput::new(key, expected, format!("{typed:?}")))
}

/// A finite number.
pub fn finite(key: &str, typed: f64) -> Check<f64> {
    require(key, "a finite number", typed, typed.is_finite())
}

/// A number above zero.
pub fn positive(key: &str, typed: f64) -> Check<f64> {
    require(key, "a finite number > 0", typed, typed > 0.0)
}

/// A number not below zero.
pub fn not_negative(key: &str, typed: f64) -> Check<f64> {
    require(key, "a finite number >= 0", typed, typed >= 0.0)
}

/// A number whose size is at most `most`, in the unit of the key.
pub fn within(key: &str, typed: f64, most: f64) -> Check<f64> {
    require(key, &format!("a number from -{most} to {most}"), typed, typed.abs() <= most)
}

/// A number above zero, from `least` to `most` in the unit of the key.
pub fn between(key: &str, typed: f64, [least, most]: [f64; 2]) -> Check<f64> {
    require(key, &format!("a number from {least} to {most}"), typed, (least..=most).contains(&typed))
}

/// Three numbers whose magnitude is at most `most`; an error names the wrong one.
pub fn vector_within(key: &str, typed: impl Into<[f64; 3]>, most: f64) -> Check<[f64; 3]> {
    let mut si = [0.0; 3];
    for (axis, x) in typed.into().into_iter().enumerate() {
        si[axis] = within(key, x, most).map_err(|bad| BadInput { place: format!("{key}[{axis}]"), ..bad })?;
    }
    Ok(si)
}

/// Three finite numbers; an error names the wrong one.
pub fn vector(key: &str, typed: impl Into<[f64; 3]>) -> Check<[f64; 3]> {
    let mut si = [0.0; 3];
    for (axis, x) in typed.into().into_iter().enumerate() {
        si[axis] = finite(key, x).map_err(|bad| BadInput { place: format!("{key}[{axis}]"), ..bad })?;
    }
    Ok(si)
}

/// A whole number from 1 to `most`.
pub fn count(key: &str, typed: i64, most: i64) -> Check<usize> {
    match usize::try_from(typed) {
        Ok(n) if (1..=most).contains(&typed) => Ok(n),
        _ => Err(BadInput::new(key, format!("a whole number from 1 to {most}"), typed.to_string())),
    }
}

/// A name: something to see, on one line.
pub fn text(key: &str, typed: String) -> Check<String> {
    if typed.trim().is_empty() || typed.chars().any(char::is_control) {
        return Err(BadInput::new(key, "a name", format!("{typed:?}")));
    }
    Ok(typed)
}
