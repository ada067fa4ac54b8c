//! Messages of the TOML reader and of serde in the house's shape, with line and key.
//!
//! Both give text and a position only; the key is found by walking the lines above. A file whose tables are
//! written inline gets the right line and a shorter key. `serde_path_to_error` would give the key without the line, and
//! counts tables from 0 where a person counts them from 1; both are wanted here.

use crate::BadInput;

/// The error as place, expected, found, hint; the place has no file yet.
pub(super) fn bad_toml(error: &toml::de::Error, text: &str) -> BadInput {
    let message = error.message().lines().next().unwrap_or_default();
    let at = error.span().map_or(0, |span| span.start.min(text.len()));
    let line = 1 + text.as_bytes()[..at].iter().filter(|byte| **byte == b'\n').count();
    let (table, key) = key_at(text, line);
    let quoted: Vec<&str> = message.split('`').skip(1).step_by(2).collect();

    if let (Some(_), [name, ..]) = (message.strip_prefix("missing field"), &quoted[..]) {
        return BadInput::new(joined(&table, name), "this key", "nothing").hint(format!(
            "it belongs to {}",
            if table.is_empty() { "the top".into() } else { format!("[{table}]") }
        ));
    }
    if let (Some(_), [name, known @ ..]) = (message.strip_prefix("unknown field"), &quoted[..]) {
        let place = format!("line {line}: {}", joined(&table, name));
        let bad = BadInput::new(place, format!("one of {}", known.join(", ")), format!("`{name}`"));
        return match nearest(name, known) {
            Some(known) => bad.hint(format!("did you mean {known}?")),
            None => bad,
        };
    }
    let place = format!("line {line}: {}", joined(&table, &key));
    let typed = error
        .span()
        .and_then(|span| text.get(span))
        .and_then(|typed| typed.lines().next())
        .unwrap_or_default();
    if let (Some(_), [name, known @ ..]) = (message.strip_prefix("unknown variant"), &quoted[..]) {
        return BadInput::new(place, format!("one of {}", known.join(", ")), format!("\"{name}\""));
    }
    for start in ["invalid type: ", "invalid value: ", "invalid length "] {
        if let Some((found, expected)) = message.strip_prefix(start).and_then(|m| m.split_once(", expected "))
        {
            let expected = match expected {
                "f64" => "a number",
                "u64" => "a whole number >= 0",
                "i64" => "a whole number",
                table if table.starts_with("struct ") => "a table",
                other => other,
            };
            // A date is a map to that reader.
            let found = if found == "map" { typed.to_owned() } else { found.replace('`', "") };
            return BadInput::new(place, expected, found);
        }
    }
    if let Some(expected) = message.strip_prefix("wanted ") {
        return BadInput::new(place, format!("a {expected}"), typed);
    }
    // Syntax.
    BadInput::new(format!("line {line}"), "valid TOML", message)
}

fn joined(table: &str, key: &str) -> String {
    match (table.is_empty(), key.is_empty()) {
        (true, _) => key.to_owned(),
        (false, true) => table.to_owned(),
        (false, false) => format!("{table}.{key}"),
    }
}

/// Table and key that line `line` (from 1) belongs to. Of several tables `[[name]]`, the number counts from 1.
fn key_at(text: &str, line: usize) -> (String, String) {
    let mut table = String::new();
    let mut arrays: Vec<&str> = Vec::new();
    let mut key = String::new();
    for line in text.lines().take(line) {
        let line = line.trim();
        if let Some(name) = line.strip_prefix("[[").and_then(|rest| Some(rest.split_once("]]")?.0.trim())) {
            arrays.push(name);
            table = format!("{name}[{}]", arrays.iter().filter(|earlier| **earlier == name).count());
            key.clear();
        } else if let Some(name) =
            line.strip_prefix('[').and_then(|rest| Some(rest.split_once(']')?.0.trim()))
            && name.chars().all(|c| c.is_alphanumeric() || "_-.".contains(c))
            && name.starts_with(|c: char| c.is_alphabetic())
        {
            table = name.to_owned();
            key.clear();
        } else if let Some((name, _)) = line.split_once('=')
            && !name.starts_with('#')
        {
            key = name.trim().to_owned();
        }
    }
    (table, key)
}

/// The known name that needs the fewest changes, if these are few.
fn nearest<'a>(name: &str, known: &[&'a str]) -> Option<&'a str> {
    let (changes, best) = known.iter().map(|&k| (strsim::levenshtein(name, k), k)).min()?;
    (changes <= name.len().min(best.len()) / 2).then_some(best)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slip_of_the_hand_finds_the_name() {
        assert_eq!(nearest("possion_ratio", &["law", "poisson_ratio"]), Some("poisson_ratio"));
        assert_eq!(nearest("colour", &["law", "poisson_ratio"]), None);
    }
}
