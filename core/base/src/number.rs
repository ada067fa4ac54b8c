//! Numbers in messages: as many digits as a person reads, none that a computation has left over.

/// Digits of a number that was computed, in a message.
const DIGITS: i32 = 9;

/// A computed number for a message: nine significant digits at most, more than any measurement has, without zeros at the end. A number that a person typed, or that is in a file, is shown
/// as it is instead.
pub fn shown(value: f64) -> String {
    if value == 0.0 {
        return "0".to_owned();
    }
    if !value.is_finite() {
        return value.to_string();
    }
    let exponent = value.abs().log10().floor() as i32;
    if !(-4..=DIGITS).contains(&exponent) {
        let (digits, power) = split(&format!("{value:.*e}", (DIGITS - 1) as usize));
        return format!("{}e{power}", without_zeros(&digits));
    }
    without_zeros(&format!("{value:.*}", (DIGITS - 1 - exponent).max(0) as usize)).to_owned()
}

/// A number with so many significant digits, without an exponent: nine decimals at most, and all digits of a whole number.
pub fn significant(value: f64, n_digits: i32) -> String {
    if value == 0.0 {
        return "0".to_owned();
    }
    let decimals = (n_digits - 1).saturating_sub(value.abs().log10().floor() as i32).clamp(0, 9);
    format!("{value:.*}", decimals as usize)
}

/// A number for a sentence: three significant digits, with an exponent below a thousandth and from ten thousand on.
pub fn digits(value: f64) -> String {
    match value.abs() {
        size if size == 0.0 || (1e-3..1e4).contains(&size) => significant(value, 3),
        _ => format!("{value:.2e}"),
    }
}

fn split(text: &str) -> (String, String) {
    text.split_once('e')
        .map_or_else(|| (text.to_owned(), "0".to_owned()), |(a, b)| (a.to_owned(), b.to_owned()))
}

fn without_zeros(digits: &str) -> &str {
    if digits.contains('.') { digits.trim_end_matches('0').trim_end_matches('.') } else { digits }
}

#[cfg(test)]
mod tests {
    use super::{digits, shown, significant};

    #[test]
    fn what_a_computation_left_over_is_not_shown() {
        for (value, text) in [
            (0.020000000000002932, "0.02"),
            (-0.1 - 0.2, "-0.3"),
            (1.0 / 3.0, "0.333333333"),
            (200.0, "200"),
            (19_999.99, "19999.99"),
            (2e9 / 3.0, "666666667"),
            (9.999_999_999_9, "10"),
            (2.5e-7, "2.5e-7"),
            (6.02214076e23, "6.02214076e23"),
            (0.0, "0"),
            (-0.0, "0"),
            (f64::NAN, "NaN"),
            (f64::NEG_INFINITY, "-inf"),
        ] {
            assert_eq!(shown(value), text);
        }
    }

    #[test]
    fn numbers_have_as_many_digits_as_requested() {
        for (value, three, four) in [
            (0.0, "0", "0"),
            (12.3456, "12.3", "12.35"),
            (-0.012_345_6, "-0.0123", "-0.01235"),
            (1234.56, "1235", "1235"),
            (1.234e-9, "0.000000001", "0.000000001"),
        ] {
            assert_eq!((significant(value, 3).as_str(), significant(value, 4).as_str()), (three, four));
        }
        for (value, text) in [
            (0.0, "0"),
            (0.001, "0.00100"),
            (9999.0, "9999"),
            (1e4, "1.00e4"),
            (-1.234e-4, "-1.23e-4"),
            (f64::NAN, "NaN"),
            (f64::INFINITY, "inf"),
        ] {
            assert_eq!(digits(value), text);
        }
    }
}
