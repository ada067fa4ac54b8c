//! Plausible ranges: numbers beyond them are not of a robot, but of a typing error or a wrong unit.
//!
//! One table for robot files, and one for keys that end in their unit. Both are wide: what a machine somewhere has lies inside.

use crate::BadInput;

/// A quantity with its largest plausible magnitude.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlausibleRange {
    what: &'static str,
    unit: &'static str,
    /// In that unit, which is SI.
    most: f64,
}

/// Between two parts of a machine.
pub const LENGTH: PlausibleRange = PlausibleRange { what: "a length", unit: "m", most: 1e3 };
/// Of one part; a loaded dump truck has 6e5 kg.
pub const MASS: PlausibleRange = PlausibleRange { what: "a mass", unit: "kg", most: 1e6 };
/// Of one part about its centre of mass, or of a rotor as a joint feels it.
pub const INERTIA: PlausibleRange = PlausibleRange { what: "an inertia", unit: "kg m²", most: 1e7 };
/// That a pose is turned by.
pub const ANGLE: PlausibleRange = PlausibleRange { what: "an angle", unit: "rad", most: 1e4 };
/// Of a joint.
pub const DAMPING: PlausibleRange =
    PlausibleRange { what: "a damping", unit: "N m s/rad or N s/m", most: 1e7 };
/// Of a joint.
pub const DRY_FRICTION: PlausibleRange = PlausibleRange { what: "a friction", unit: "N m or N", most: 1e6 };
/// Of another joint, for one of its own.
pub const RATIO: PlausibleRange = PlausibleRange { what: "a ratio of joints", unit: "", most: 1e4 };

impl PlausibleRange {
    /// Accepts a number in SI whose magnitude is plausible.
    ///
    /// # Errors
    /// `BadInput` with the range.
    pub fn check(&self, place: &str, value: f64) -> Result<f64, BadInput> {
        let Self { what, unit, most } = *self;
        if value.abs() <= most {
            return Ok(value);
        }
        let expected = format!("{what} that a machine has, at most {most} {unit}");
        Err(BadInput::new(place, expected.trim_end(), format!("{value:?}"))
            .hint("robot files are in m, kg, s and rad"))
    }

    /// Accepts numbers that are all plausible.
    ///
    /// # Errors
    /// `BadInput` with the range and the first that is not.
    pub fn check_all(&self, place: &str, values: &[f64]) -> Result<(), BadInput> {
        values.iter().try_for_each(|value| self.check(place, *value).map(drop))
    }
}

/// Largest magnitudes of what a robot on a bench can have, by the end of the key; the first that fits counts.
const ON_A_BENCH: [(&str, f64); 27] = [
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

/// Largest magnitude that the key of a robot on a bench can have, in the unit of its name.
pub fn on_a_bench(key: &str) -> Option<f64> {
    ON_A_BENCH.iter().find(|(ending, _)| key.ends_with(ending)).map(|(_, largest)| *largest)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_no_machine_has_is_refused_with_its_range() {
        assert_eq!(MASS.check("m", 200.0), Ok(200.0));
        for (quantity, value) in [(LENGTH, 1e300), (MASS, 1e9), (INERTIA, f64::INFINITY), (RATIO, f64::NAN)] {
            let bad = quantity.check("r.urdf: line 3", value).expect_err("believed");
            assert!(bad.to_string().contains("at most"), "{bad}");
        }
        let bad = LENGTH.check_all("p", &[0.0, 1.0, -1e4]).expect_err("believed");
        assert_eq!((bad.place.as_str(), bad.found.as_str()), ("p", "-10000.0"));
        assert_eq!((on_a_bench("tube.length_mm"), on_a_bench("name")), (Some(1e4), None));
    }
}
