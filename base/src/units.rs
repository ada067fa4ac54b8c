//! The only place that converts units; everything in memory is SI.
//!
//! A name that a person types or reads ends in its unit: `length_mm`, `tip_x_mm`, `youngs_modulus_mpa`. The
//! table here knows these endings. Numbers that come as text are converted by moving the decimal exponent
//! of the text, so `4.5` in millimetres is the double nearest to 0.0045 and a value survives a CSV bit for bit.

/// How a number in a unit becomes SI.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Scale {
    /// Times this power of ten.
    Ten(i32),
    /// Degrees to radians.
    Degrees,
}

/// A unit that a name may end in.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unit {
    /// Ending of a name without its underscore, e.g. `mm`.
    pub suffix: &'static str,
    /// Ending of the same quantity in SI, e.g. `m`.
    pub si_suffix: &'static str,
    scale: Scale,
}

const fn ten(suffix: &'static str, si_suffix: &'static str, exponent: i32) -> Unit {
    Unit { suffix, si_suffix, scale: Scale::Ten(exponent) }
}

/// Every unit known, each quantity with its SI unit first. The last two are plain numbers.
const UNITS: [Unit; 41] = [
    ten("m", "m", 0),
    ten("cm", "m", -2),
    ten("mm", "m", -3),
    ten("um", "m", -6),
    ten("n", "n", 0),
    ten("mn", "n", -3),
    ten("kn", "n", 3),
    ten("m_per_n", "m_per_n", 0),
    ten("mm_per_n", "m_per_n", -3),
    ten("n_m", "n_m", 0),
    ten("n_mm", "n_m", -3),
    ten("pa", "pa", 0),
    ten("kpa", "pa", 3),
    ten("mpa", "pa", 6),
    ten("gpa", "pa", 9),
    ten("s", "s", 0),
    ten("ms", "s", -3),
    ten("us", "s", -6),
    ten("hz", "hz", 0),
    ten("rad", "rad", 0),
    Unit { suffix: "deg", si_suffix: "rad", scale: Scale::Degrees },
    ten("rad_s", "rad_s", 0),
    Unit { suffix: "deg_s", si_suffix: "rad_s", scale: Scale::Degrees },
    ten("rad_s2", "rad_s2", 0),
    ten("m_s", "m_s", 0),
    ten("mm_s", "m_s", -3),
    ten("m_s2", "m_s2", 0),
    ten("percent", "ratio", -2),
    ten("kg", "kg", 0),
    ten("kg_m", "kg_m", 0),
    ten("kg_m2", "kg_m2", 0),
    ten("kg_m3", "kg_m3", 0),
    ten("j", "j", 0),
    ten("rad_per_m", "rad_per_m", 0),
    ten("a", "a", 0),
    ten("ma", "a", -3),
    ten("v", "v", 0),
    ten("mv", "v", -3),
    ten("degc", "degc", 0),
    ten("ratio", "ratio", 0),
    ten("count", "count", 0),
];

impl Unit {
    /// The unit that is spelled like this, without underscore: `mm`.
    pub fn from_suffix(suffix: &str) -> Option<&'static Unit> {
        UNITS.iter().find(|unit| unit.suffix == suffix)
    }

    /// Splits a name into what is before the unit and the unit: `tip_x_mm` is `tip_x` in millimetres.
    /// The longest ending wins, so `speed_rad_s` is in rad/s and not in seconds.
    pub fn of_name(name: &str) -> Option<(&str, &'static Unit)> {
        UNITS
            .iter()
            .filter_map(|unit| {
                let stem = name.strip_suffix(unit.suffix)?.strip_suffix('_')?;
                (!stem.is_empty()).then_some((stem, unit))
            })
            .max_by_key(|(_, unit)| unit.suffix.len())
    }

    /// True for the unit in which values are held in memory.
    pub fn is_si(&self) -> bool {
        self.suffix == self.si_suffix
    }

    /// SI units in one of this: 1e-3 for `mm`.
    pub fn factor(&self) -> f64 {
        self.to_si(1.0)
    }

    /// A value in this unit, in SI.
    pub fn to_si(&self, value: f64) -> f64 {
        match self.scale {
            // Dividing by 1000 rounds once; multiplying by 0.001 rounds twice.
            Scale::Ten(e) if e < 0 => value / 10_f64.powi(-e),
            Scale::Ten(e) => value * 10_f64.powi(e),
            Scale::Degrees => value.to_radians(),
        }
    }

    /// A value in SI, in this unit.
    pub fn from_si(&self, value: f64) -> f64 {
        match self.scale {
            Scale::Ten(e) if e < 0 => value * 10_f64.powi(-e),
            Scale::Ten(e) => value / 10_f64.powi(e),
            Scale::Degrees => value.to_degrees(),
        }
    }

    /// Reads a number written in this unit and returns it in SI, rounded once. `None` if the text is no number;
    /// infinite or NaN if it says so or is too large.
    pub fn parse_si(&self, text: &str) -> Option<f64> {
        let value: f64 = text.parse().ok()?;
        let Scale::Ten(shift) = self.scale else { return Some(self.to_si(value)) };
        if !text.bytes().any(|b| b.is_ascii_digit()) {
            return Some(value); // inf, nan
        }
        let (mantissa, exponent) = match text.find(['e', 'E']) {
            Some(at) => (&text[..at], text[at + 1..].parse::<i64>()),
            None => (text, Ok(0)),
        };
        match exponent {
            Ok(exponent) => format!("{mantissa}e{}", exponent.saturating_add(i64::from(shift))).parse().ok(),
            Err(_) => Some(value), // so many digits that a shift changes nothing: zero or infinite
        }
    }

    /// Writes an SI value in this unit with as few digits as [`Unit::parse_si`] needs to return the same double
    /// (powers of ten only; degrees are rounded).
    pub fn format_si(&self, value: f64) -> String {
        let Scale::Ten(shift) = self.scale else { return self.from_si(value).to_string() };
        shifted_decimal(value, -shift)
    }
}

/// `value` times ten to the `shift`, exactly, as the shortest decimal text.
fn shifted_decimal(value: f64, shift: i32) -> String {
    let text = format!("{value:e}");
    let Some((mantissa, exponent)) = text.split_once('e') else { return text };
    let Ok(exponent) = exponent.parse::<i32>() else { return text };
    let (sign, mantissa) = mantissa.strip_prefix('-').map_or(("", mantissa), |rest| ("-", rest));
    if value == 0.0 {
        return format!("{sign}0");
    }
    let point = exponent + shift;
    let digits: String = mantissa.chars().filter(|c| *c != '.').collect();
    let n = digits.len() as i32;
    match point {
        // Far from one: scientific, the rest as people write it.
        p if !(-6..=16).contains(&p) => format!("{sign}{mantissa}e{p}"),
        p if p < 0 => format!("{sign}0.{}{digits}", "0".repeat((-p - 1) as usize)),
        p if p + 1 >= n => format!("{sign}{digits}{}", "0".repeat((p + 1 - n) as usize)),
        p => format!("{sign}{}.{}", &digits[..(p + 1) as usize], &digits[(p + 1) as usize..]),
    }
}

/// The SI name of a column and the factor to its unit: `tip_x_mm` is (`tip_x_m`, 1e-3).
pub fn si_name(name: &str) -> Option<(String, f64)> {
    let (stem, unit) = Unit::of_name(name)?;
    Some((format!("{stem}_{}", unit.si_suffix), unit.factor()))
}

/// Unit of length of a mesh file; the file itself does not say.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub enum LengthUnit {
    /// Millimetres.
    #[serde(rename = "mm")]
    Millimetre,
    /// Centimetres.
    #[serde(rename = "cm")]
    Centimetre,
    /// Metres.
    #[serde(rename = "m")]
    Metre,
}

impl LengthUnit {
    /// Metres in one of this unit [m].
    pub fn to_m(self) -> f64 {
        match self {
            Self::Millimetre => 1e-3,
            Self::Centimetre => 1e-2,
            Self::Metre => 1.0,
        }
    }

    /// The unit spelled `mm`, `cm` or `m`.
    pub fn from_suffix(suffix: &str) -> Option<Self> {
        [Self::Millimetre, Self::Centimetre, Self::Metre].into_iter().find(|unit| unit.suffix() == suffix)
    }

    /// `mm`, `cm` or `m`.
    pub fn suffix(self) -> &'static str {
        match self {
            Self::Millimetre => "mm",
            Self::Centimetre => "cm",
            Self::Metre => "m",
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)] // a test may stop where it stands
    use super::*;

    #[test]
    fn names_give_their_si_name_and_factor() {
        assert_eq!(si_name("tip_x_mm"), Some(("tip_x_m".into(), 1e-3)));
        assert_eq!(si_name("tip_x_m"), Some(("tip_x_m".into(), 1.0)));
        assert_eq!(si_name("youngs_modulus_mpa"), Some(("youngs_modulus_pa".into(), 1e6)));
        assert_eq!(si_name("length_um"), Some(("length_m".into(), 1e-6)));
        assert_eq!(si_name("density_kg_m3"), Some(("density_kg_m3".into(), 1.0)));
        assert_eq!(si_name("speed_rad_s"), Some(("speed_rad_s".into(), 1.0)));
        assert_eq!(si_name("plane_deg").unwrap().0, "plane_rad");
        assert_eq!(si_name("torque_1_n_m"), Some(("torque_1_n_m".into(), 1.0)));
        assert_eq!(si_name("stroke_1"), None);
        assert_eq!(si_name("_mm"), None);
        assert_eq!(si_name("mm"), None);
    }

    #[test]
    fn every_unit_points_to_an_si_unit_and_back() {
        for unit in &UNITS {
            let si = Unit::from_suffix(unit.si_suffix).unwrap();
            assert!(si.is_si() && si.factor() == 1.0, "{}", unit.suffix);
            // One rounding each way.
            assert!((unit.from_si(unit.to_si(1.7)) - 1.7).abs() <= 4.0 * f64::EPSILON, "{}", unit.suffix);
        }
        assert_eq!(Unit::from_suffix("deg").unwrap().to_si(180.0), std::f64::consts::PI);
    }

    #[test]
    fn text_is_rounded_once() {
        let mm = Unit::from_suffix("mm").unwrap();
        assert_eq!(mm.parse_si("4.35"), Some(0.00435));
        assert_eq!(mm.parse_si("1e3"), Some(1.0));
        assert_eq!(mm.parse_si("-2.5E-1"), Some(-0.00025));
        assert_eq!(mm.parse_si("abc"), None);
        assert_eq!(mm.parse_si(""), None);
        assert!(mm.parse_si("nan").unwrap().is_nan());
        assert!(mm.parse_si("1e400").unwrap().is_infinite());
        assert_eq!(mm.parse_si("1e-99999999999999999999"), Some(0.0));
        assert_eq!(mm.format_si(0.0045), "4.5");
        assert_eq!(mm.format_si(-1.0), "-1000");
        assert_eq!(mm.format_si(1e-7), "0.0001");
        assert_eq!(mm.format_si(1.25e-12), "1.25e-9");
        assert_eq!(mm.format_si(-0.0), "-0");
    }

    proptest::proptest! {
        #[test]
        fn text_in_millimetres_returns_the_same_double(bits in proptest::num::u64::ANY) {
            let value = f64::from_bits(bits);
            if value.is_finite() {
                for suffix in ["m", "mm", "um", "gpa"] {
                    let unit = Unit::from_suffix(suffix).unwrap();
                    let text = unit.format_si(value);
                    let back = unit.parse_si(&text).unwrap();
                    proptest::prop_assert_eq!(back.to_bits(), bits, "{} {}", suffix, text);
                }
            }
        }
    }

    #[test]
    fn length_units_of_meshes() {
        for (text, metres) in [("mm", 1e-3), ("cm", 1e-2), ("m", 1.0)] {
            let unit = LengthUnit::from_suffix(text).unwrap();
            assert_eq!((unit.suffix(), unit.to_m()), (text, metres));
        }
        assert_eq!(LengthUnit::from_suffix("inch"), None);
    }
}
