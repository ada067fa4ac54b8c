//! Bounds of the parameters of a robot on a bench, and their conversion to SI.

use hysteron_base::BadInput;
use hysteron_base::plausible_range::on_a_bench;
use hysteron_base::schema::FixedArray;
use hysteron_base::units::Unit;

pub(super) type Check<T> = std::result::Result<T, BadInput>;

/// A number for which `holds`, in SI: the unit is the end of the key, where `base` knows it.
pub(super) fn require(key: &str, expected: &str, typed: f64, holds: bool) -> Check<f64> {
    let name = key.rsplit('.').next().and_then(|last| last.split('[').next()).unwrap_or(key);
    let si = Unit::of_name(name).map_or(typed, |(_, unit)| unit.to_si(typed));
    if !(holds && si.is_finite() && (si == 0.0) == (typed == 0.0)) {
        return Err(BadInput::new(key, expected, format!("{typed:?}")));
    }
    match on_a_bench(name) {
        Some(largest) if typed.abs() > largest => {
            let expected = format!("a number that a robot on a bench can have, at most {largest} either way");
            Err(BadInput::new(key, expected, format!("{typed:?}")))
        }
        _ => Ok(si),
    }
}

pub(super) fn finite(key: &str, typed: f64) -> Check<f64> {
    require(key, "a finite number", typed, typed.is_finite())
}

pub(super) fn positive(key: &str, typed: f64) -> Check<f64> {
    require(key, "a finite number > 0", typed, typed > 0.0)
}

pub(super) fn not_negative(key: &str, typed: f64) -> Check<f64> {
    require(key, "a finite number >= 0", typed, typed >= 0.0)
}

pub(super) fn vector<const N: usize>(key: &str, typed: FixedArray<f64, N>) -> Check<[f64; N]> {
    let mut si = [0.0; N];
    for (i, x) in typed.0.into_iter().enumerate() {
        si[i] = finite(&format!("{key}[{i}]"), x)?;
    }
    Ok(si)
}
