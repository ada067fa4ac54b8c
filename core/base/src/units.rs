//! The only place that converts units; everything in memory is SI.
//!
//! A name that a person types or reads ends in its unit: `length_mm`, `tip_x_mm`, `youngs_modulus_mpa`. The
//! table here knows these endings; after `_per_` comes the divisor: `n_per_mm`. Numbers that come as text are converted by moving the decimal exponent
//! of the text, so `4.5` in millimetres is the double nearest to 0.0045 and a value survives a CSV bit for bit.

use std::fmt::Write;
use std::sync::LazyLock;

/// How a number in a unit becomes SI: times 10 to the `ten`, times π/180 to the `degrees`.
#[derive(Debug, Clone, Copy, PartialEq)]
struct UnitScale {
    ten: i32,
    degrees: i32,
}

/// A unit that a name may end in.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unit {
    /// Ending of a name without its underscore, e.g. `mm`.
    pub suffix: &'static str,
    /// Ending of the same quantity in SI, e.g. `m`.
    pub si_suffix: &'static str,
    scale: UnitScale,
}

const fn ten(suffix: &'static str, si_suffix: &'static str, exponent: i32) -> Unit {
    Unit { suffix, si_suffix, scale: UnitScale { ten: exponent, degrees: 0 } }
}

const fn degrees(suffix: &'static str, si_suffix: &'static str) -> Unit {
    Unit { suffix, si_suffix, scale: UnitScale { ten: 0, degrees: 1 } }
}

/// Units without a fraction line, each quantity with its SI unit first; `rad_s` and the like are rates. The last two are
/// plain numbers.
const UNITS: [Unit; 44] = [
    ten("m", "m", 0),
    ten("cm", "m", -2),
    ten("mm", "m", -3),
    ten("um", "m", -6),
    ten("n", "n", 0),
    ten("mn", "n", -3),
    ten("kn", "n", 3),
    ten("n_m", "n_m", 0),
    ten("n_mm", "n_m", -3),
    ten("n_m_s", "n_m_s", 0),
    ten("n_mm_s", "n_m_s", -3),
    ten("n_s", "n_s", 0),
    ten("pa", "pa", 0),
    ten("kpa", "pa", 3),
    ten("mpa", "pa", 6),
    ten("gpa", "pa", 9),
    ten("s", "s", 0),
    ten("ms", "s", -3),
    ten("us", "s", -6),
    ten("hz", "hz", 0),
    ten("rad", "rad", 0),
    degrees("deg", "rad"),
    ten("rad_s", "rad_s", 0),
    degrees("deg_s", "rad_s"),
    ten("rad_s2", "rad_s2", 0),
    degrees("deg_s2", "rad_s2"),
    ten("m_s", "m_s", 0),
    ten("mm_s", "m_s", -3),
    ten("m_s2", "m_s2", 0),
    ten("mm_s2", "m_s2", -3),
    ten("percent", "ratio", -2),
    ten("kg", "kg", 0),
    ten("kg_m", "kg_m", 0),
    ten("kg_m2", "kg_m2", 0),
    ten("kg_m3", "kg_m3", 0),
    ten("j", "j", 0),
    ten("a", "a", 0),
    ten("ma", "a", -3),
    ten("v", "v", 0),
    ten("mv", "v", -3),
    ten("degc", "degc", 0),
    ten("w", "w", 0),
    ten("ratio", "ratio", 0),
    ten("count", "count", 0),
];

/// Units that are only divisors: a name that ends in one of them does so by chance.
const DIVISORS: [Unit; 7] = [
    ten("k", "k", 0),
    ten("s2", "s2", 0),
    ten("m2", "m2", 0),
    ten("mm2", "m2", -6),
    ten("m3", "m3", 0),
    ten("mm3", "m3", -9),
    ten("rad2", "rad2", 0),
];

/// The fraction line of a name: `stiffness_n_per_mm`.
const PER: &str = "_per_";

/// Units that may be divisors.
fn divisors() -> impl Iterator<Item = &'static Unit> {
    UNITS.iter().chain(&DIVISORS)
}

/// Every unit with a fraction line: what is divided (one, then [`UNITS`]) by what divides it ([`divisors`]).
static FRACTIONS: LazyLock<Vec<Unit>> = LazyLock::new(|| {
    let over_one = ten("", "", 0);
    std::iter::once(&over_one)
        .chain(&UNITS)
        .flat_map(|above| divisors().map(move |below| Unit::fraction(above, below)))
        .collect()
});

impl Unit {
    /// The unit that is spelled like this, without underscore: `mm`, `n_per_mm`, `per_s`.
    pub fn from_suffix(suffix: &str) -> Option<&'static Unit> {
        // A name before the unit.
        let name = format!("x_{suffix}");
        Self::of_name(&name).filter(|(stem, _)| *stem == "x").map(|(_, unit)| unit)
    }

    /// Splits a name into what is before the unit and the unit: `tip_x_mm` is `tip_x` in millimetres, and
    /// `stiffness_n_per_mm` is `stiffness` in newtons for one millimetre.
    /// The longest ending wins, so `speed_rad_s` is in rad/s and not in seconds.
    pub fn of_name(name: &str) -> Option<(&str, &'static Unit)> {
        let fraction = name.rsplit_once(PER);
        let divisor = |below: &str| divisors().position(|unit| unit.suffix == below);
        let found = match fraction.and_then(|(above, below)| Some((above, divisor(below)?))) {
            Some((above, divisor)) => Self::with_divisor(above, divisor),
            None => Self::at_the_end(name),
        };
        // A fraction line behind the stem would be a second one, or one without anything above it.
        found.filter(|(stem, _)| *stem != "per" && !stem.ends_with("_per"))
    }

    /// Unit at the end of `above`, divided by that of number `divisor` in [`divisors`], and the name
    /// before it.
    fn with_divisor(above: &str, divisor: usize) -> Option<(&str, &'static Unit)> {
        let (stem, dividend) = match Self::at_the_end(above) {
            Some((stem, unit)) => (stem, 1 + UNITS.iter().position(|known| known == unit)?),
            None => (above, 0),
        };
        let unit = FRACTIONS.get(dividend * divisors().count() + divisor)?;
        (!stem.is_empty()).then_some((stem, unit))
    }

    /// The longest unit without a fraction line at the end of a name, and the name before it.
    fn at_the_end(name: &str) -> Option<(&str, &'static Unit)> {
        UNITS
            .iter()
            .filter_map(|unit| {
                let stem = name.strip_suffix(unit.suffix)?.strip_suffix('_')?;
                (!stem.is_empty()).then_some((stem, unit))
            })
            .max_by_key(|(_, unit)| unit.suffix.len())
    }

    /// So much of `above` for one of `below`: what divides makes a number in SI larger where its unit is small.
    fn fraction(above: &Unit, below: &Unit) -> Unit {
        let spelled = |above: &str, below: &str| -> &'static str {
            format!("{above}{PER}{below}").trim_start_matches('_').to_owned().leak()
        };
        Unit {
            suffix: spelled(above.suffix, below.suffix),
            si_suffix: spelled(above.si_suffix, below.si_suffix),
            scale: UnitScale {
                ten: above.scale.ten - below.scale.ten,
                degrees: above.scale.degrees - below.scale.degrees,
            },
        }
    }

    /// The same quantity as files for people have it: millimetres for metres, on both sides of a fraction line.
    pub fn in_millimetres(&'static self) -> &'static Unit {
        let side = |side: &'static str| if side == "m" { "mm" } else { side };
        let suffix = match self.suffix.split_once(PER) {
            Some((above, below)) => format!("{}{PER}{}", side(above), side(below)),
            None => self
                .suffix
                .strip_prefix("per_")
                .map_or_else(|| side(self.suffix).to_owned(), |below| format!("per_{}", side(below))),
        };
        Self::from_suffix(&suffix).unwrap_or(self)
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
        let UnitScale { ten, degrees } = self.scale;
        shifted(turned(value, degrees), ten)
    }

    /// A value in SI, in this unit.
    pub fn from_si(&self, value: f64) -> f64 {
        let UnitScale { ten, degrees } = self.scale;
        shifted(turned(value, -degrees), -ten)
    }

    /// Reads a number written in this unit and returns it in SI, rounded once. `None` if the text is no number;
    /// infinite or NaN if it is written so or is too large.
    pub fn parse_si(&self, text: &str) -> Option<f64> {
        let UnitScale { ten: shift, degrees: 0 } = self.scale else {
            return Some(self.to_si(text.parse().ok()?));
        };
        if let Some(value) = exact_decimal(text, shift) {
            return Some(value);
        }
        let value: f64 = text.parse().ok()?;
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

    /// Writes an SI value in this unit behind `out`, with as few digits as [`Unit::parse_si`] needs to return the same double
    /// (powers of ten only; degrees are rounded).
    pub fn write_si(&self, value: f64, out: &mut String) {
        // A string takes all that is written.
        let _ = match self.scale {
            UnitScale { ten, degrees: 0 } => write_shifted(value, -ten, out),
            _ => write!(out, "{}", self.from_si(value)),
        };
    }
}

/// A value times 10 to the `exponent`. Dividing by 1000 rounds once; multiplying by 0.001 rounds twice.
fn shifted(value: f64, exponent: i32) -> f64 {
    if exponent < 0 { value / 10_f64.powi(-exponent) } else { value * 10_f64.powi(exponent) }
}

/// A value times π/180 to the `exponent`, which is -1, 0 or 1.
fn turned(value: f64, exponent: i32) -> f64 {
    match exponent {
        0 => value,
        1 => value.to_radians(),
        _ => value.to_degrees(),
    }
}

/// Decimal digits with a point times ten to the `shift`, where whole number and power of ten are both exact as doubles, so that
/// one operation rounds once; none for any other text.
///
/// # Reference
/// Clinger (1990), How to read floating point numbers accurately.
fn exact_decimal(text: &str, shift: i32) -> Option<f64> {
    const POWERS: [f64; 23] = [
        1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16, 1e17,
        1e18, 1e19, 1e20, 1e21, 1e22,
    ];
    let (digits, sign) = text.strip_prefix('-').map_or((text, 1.0), |digits| (digits, -1.0));
    let (mut whole, mut power, mut is_behind_point) = (0_u64, shift, false);
    for byte in digits.bytes() {
        match byte {
            b'0'..=b'9' => {
                whole = 10 * whole + u64::from(byte - b'0');
                power -= i32::from(is_behind_point);
            }
            b'.' if !is_behind_point => is_behind_point = true,
            _ => return None,
        }
        if whole > 1 << f64::MANTISSA_DIGITS {
            return None;
        }
    }
    let power_of_ten = *POWERS.get(power.unsigned_abs() as usize)?;
    let has_digits = digits.len() > usize::from(is_behind_point);
    let value = if power < 0 { whole as f64 / power_of_ten } else { whole as f64 * power_of_ten };
    has_digits.then_some(sign * value)
}

/// `value` times ten to the `shift`, exactly, as the shortest decimal text behind `out`.
fn write_shifted(value: f64, shift: i32, out: &mut String) -> std::fmt::Result {
    let start = out.len();
    write!(out, "{value:e}")?;
    let Some((mantissa, exponent)) = out[start..].split_once('e') else { return Ok(()) };
    let Ok(exponent) = exponent.parse::<i32>() else { return Ok(()) };
    // Seventeen at most.
    let (mut digits, mut n) = ([0; 24], 0);
    for digit in mantissa.bytes().filter(u8::is_ascii_digit) {
        digits[n] = digit;
        n += 1;
    }
    let digits = str::from_utf8(&digits[..n]).unwrap_or_default();
    out.truncate(start);
    if value.is_sign_negative() {
        out.push('-');
    }
    if value == 0.0 {
        out.push('0');
        return Ok(());
    }
    let whole = usize::try_from(exponent + shift + 1);
    match (exponent + shift, whole) {
        // Far from one: scientific, the rest as people write it.
        (p, _) if !(-6..=16).contains(&p) => {
            let (first, rest) = digits.split_at(1);
            let point = if rest.is_empty() { "" } else { "." };
            write!(out, "{first}{point}{rest}e{p}")
        }
        (_, Ok(whole)) if whole >= n => write!(out, "{digits}{:0<1$}", "", whole - n),
        (_, Ok(whole)) if whole > 0 => write!(out, "{}.{}", &digits[..whole], &digits[whole..]),
        (p, _) => write!(out, "0.{:0<1$}{digits}", "", p.unsigned_abs() as usize - 1),
    }
}

/// Unit of length of a mesh file, which the file itself does not hold.
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

    /// The SI name of a column and the factor to its unit: `tip_x_mm` is (`tip_x_m`, 1e-3).
    fn si_name(name: &str) -> Option<(String, f64)> {
        let (stem, unit) = Unit::of_name(name)?;
        Some((format!("{stem}_{}", unit.si_suffix), unit.factor()))
    }

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
        for unit in UNITS.iter().chain(FRACTIONS.iter()) {
            let name = format!("quantity_{}", unit.suffix);
            assert_eq!(Unit::of_name(&name), Some(("quantity", unit)));
            let si = Unit::from_suffix(unit.si_suffix).unwrap();
            assert!(si.is_si() && si.factor() == 1.0, "{}", unit.suffix);
            // One rounding each way.
            assert!((unit.from_si(unit.to_si(1.7)) - 1.7).abs() <= 4.0 * f64::EPSILON, "{}", unit.suffix);
        }
        assert_eq!(Unit::from_suffix("deg").unwrap().to_si(180.0), std::f64::consts::PI);
    }

    #[test]
    fn what_divides_stands_behind_per() {
        let degree = std::f64::consts::PI / 180.0;
        for (name, si, factor) in [
            ("tau_1_by_q_2_n_m_per_mm", "tau_1_by_q_2_n_m_per_m", 1e3),
            ("tau_1_by_q_2_n_mm_per_mm", "tau_1_by_q_2_n_m_per_m", 1.0),
            ("tau_1_by_q_2_n_m_per_deg", "tau_1_by_q_2_n_m_per_rad", 1.0 / degree),
            ("tau_1_by_dq_2_n_m_s_per_mm", "tau_1_by_dq_2_n_m_s_per_m", 1e3),
            ("ddq_1_by_q_2_rad_s2_per_mm", "ddq_1_by_q_2_rad_s2_per_m", 1e3),
            ("ddq_1_by_q_2_deg_s2_per_deg", "ddq_1_by_q_2_rad_s2_per_rad", 1.0),
            ("ddq_1_by_tau_2_rad_s2_per_n_mm", "ddq_1_by_tau_2_rad_s2_per_n_m", 1e3),
            ("stiffness_n_per_mm", "stiffness_n_per_m", 1e3),
            ("compliance_mm_per_n", "compliance_m_per_n", 1e-3),
            ("gradient_kpa_per_mm", "gradient_pa_per_m", 1e6),
            ("tip_m_per_s", "tip_m_per_s", 1.0),
            ("tip_mm_per_ms", "tip_m_per_s", 1.0),
            ("slope_per_k", "slope_per_k", 1.0),
            ("pressure_n_per_mm2", "pressure_n_per_m2", 1e6),
            ("rate_per_tendon_mm", "rate_per_tendon_m", 1e-3),
        ] {
            let (found, scale) = si_name(name).unwrap();
            assert_eq!(found, si, "{name}");
            assert!((scale / factor - 1.0).abs() <= 4.0 * f64::EPSILON, "{name}: {scale}");
        }
        for name in ["a_per_mm_per_n", "per_mm", "per_per_mm", "alarms_per_hour", "_per_mm", "mm_per_"] {
            assert_eq!(si_name(name), None, "{name}");
        }
    }

    #[test]
    fn people_read_millimetres_on_both_sides_of_the_line() {
        for (si, people) in [
            ("m", "mm"),
            ("n_m", "n_m"),
            ("n_m_per_m", "n_m_per_mm"),
            ("m_per_n", "mm_per_n"),
            ("m_per_m", "mm_per_mm"),
            ("per_m", "per_mm"),
            ("rad_s2_per_n_m", "rad_s2_per_n_m"),
        ] {
            assert_eq!(Unit::from_suffix(si).unwrap().in_millimetres().suffix, people);
        }
    }

    fn written(unit: &Unit, value: f64) -> String {
        let mut text = String::new();
        unit.write_si(value, &mut text);
        text
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
        assert_eq!(written(mm, 0.0045), "4.5");
        assert_eq!(written(mm, -1.0), "-1000");
        assert_eq!(written(mm, 1e-7), "0.0001");
        assert_eq!(written(mm, 1.25e-12), "1.25e-9");
        assert_eq!(written(mm, -0.0), "-0");
    }

    proptest::proptest! {
        #[test]
        fn short_decimals_are_rounded_as_the_standard_library_does(
            whole in 0_u64..=1 << 53, decimals in 0_usize..18, shift in -9_i32..=9, sign in proptest::bool::ANY,
        ) {
            let digits = format!("{whole:0>width$}", width = decimals + 1);
            let (before, behind) = digits.split_at(digits.len() - decimals);
            let text = format!("{}{before}.{behind}", if sign { "-" } else { "" });
            let exact: f64 = format!("{text}e{shift}").parse().unwrap();
            let is_within = (shift - decimals as i32).abs() <= 22;
            proptest::prop_assert_eq!(exact_decimal(&text, shift), is_within.then_some(exact), "{}", text);
        }

        #[test]
        fn text_in_millimetres_returns_the_same_double(bits in proptest::num::u64::ANY) {
            let value = f64::from_bits(bits);
            if value.is_finite() {
                for suffix in ["m", "mm", "um", "gpa", "n_m_per_mm", "mm_per_n", "kpa_per_mm"] {
                    let unit = Unit::from_suffix(suffix).unwrap();
                    let text = written(unit, value);
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
