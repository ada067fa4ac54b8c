//! Numbers in text that people read.

/// The text with zeros that have no sign: what rounds to zero from below is no negative number. In columns, where a space stands
/// before it, the place of the sign stays.
pub fn without_signs_of_zeros(text: &str) -> String {
    let bytes = text.as_bytes();
    let mut shown = String::with_capacity(text.len());
    let mut begin = 0;
    for (at, _) in text.match_indices('-') {
        let before = text[..at].chars().next_back();
        let is_sign = before.is_none_or(|c| !c.is_alphanumeric() && !"-./_".contains(c));
        if !is_sign || !is_zero(&bytes[at + 1..]) {
            continue;
        }
        shown.push_str(&text[begin..at]);
        if before.is_some_and(char::is_whitespace) && shown.ends_with("  ") {
            shown.push(' ');
        }
        begin = at + 1;
    }
    shown.push_str(&text[begin..]);
    shown
}

/// Whether a number of zeros alone begins here.
fn is_zero(bytes: &[u8]) -> bool {
    let n = bytes.iter().take_while(|byte| matches!(byte, b'0' | b'.')).count();
    let after = bytes.get(n).copied().unwrap_or(b' ');
    bytes.first() == Some(&b'0') && !(after.is_ascii_alphanumeric() || matches!(after, b'_' | b'-' | b'/'))
}

#[cfg(test)]
mod tests {
    use super::without_signs_of_zeros as shown;

    #[test]
    fn zeros_have_no_sign_and_everything_else_stays() {
        for (text, expected) in [
            ("-0", "0"),
            ("lag -0 ms, x -0.00", "lag 0 ms, x 0.00"),
            ("a    -0.0   -1.0", "a     0.0   -1.0"),
            ("(-0.000, -0.001)", "(0.000, -0.001)"),
            ("-0.5 -0e-3 1e-0 2026-00-01 a-0 --0 -01", "-0.5 -0e-3 1e-0 2026-00-01 a-0 --0 -01"),
            ("−0 °, grün -0", "−0 °, grün 0"),
            ("repeat-0.parquet out/-0/x", "repeat-0.parquet out/-0/x"),
        ] {
            assert_eq!(shown(text), expected);
        }
    }
}
