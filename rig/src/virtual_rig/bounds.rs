//! What numbers a robot on a bench can have, and their conversion to SI.

use hysteron_base::BadInput;
use hysteron_base::units::Unit;

pub(super) type Check<T> = std::result::Result<T, BadInput>;

/// Largest magnitudes of what a robot on a bench can have, by the end of the key; the first that fits counts.
const LARGEST: [(&str, f64); 27] = [
    ("_m_s2", 100.0),
    ("_kg_m2", 1.0),
    ("_n_m2", 1e6),
    ("_n_m_s", 1e3),
    ("_n_m", 1e3),
    ("_rad_s", 1e3),
    ("_k_w", 1e4),
    ("_j_k", 1e6),
    ("_1_m", 1e3),
    ("_mm", 1e4),
    ("_deg", 3600.0),
    ("_degc", 150.0),
    ("_hz", 1e3),
    ("_ms", 1e4),
    ("_kg", 1e3),
    ("_v", 100.0),
    ("_a", 100.0),
    ("_s", 1e7),
    ("_n", 1e8),
    ("_ticks", 4096.0),
    ("_coefficient", 10.0),
    ("_relative", 3.0),
    ("_weights", 10.0),
    ("_probability", 1.0),
    ("_factor", 100.0),
    ("_ratio", 100.0),
    ("section_stiffness", 100.0),
];

/// A number for which `holds`, in SI: the unit is the end of the key, where `base` knows it.
pub(super) fn require(key: &str, expected: &str, typed: f64, holds: bool) -> Check<f64> {
    let name = key.rsplit('.').next().and_then(|last| last.split('[').next()).unwrap_or(key);
    let si = Unit::of_name(name).map_or(typed, |(_, unit)| unit.to_si(typed));
    if !(holds && si.is_finite() && (si == 0.0) == (typed == 0.0)) {
        return Err(BadInput::new(key, expected, format!("{typed:?}")));
    }
    match LARGEST.iter().find(|(ending, _)| name.ends_with(ending)) {
        Some((_, largest)) if typed.abs() > *largest => {
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

pub(super) fn vector<const N: usize>(key: &str, typed: [f64; N]) -> Check<[f64; N]> {
    let mut si = [0.0; N];
    for (i, x) in typed.into_iter().enumerate() {
        si[i] = finite(&format!("{key}[{i}]"), x)?;
    }
    Ok(si)
}
