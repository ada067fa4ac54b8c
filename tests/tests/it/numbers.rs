//! Numbers in documents come from archived files: `docs/numbers.toml` names them, and this compares.

use std::collections::BTreeMap;

use hysteron_tests::root;
use serde_json::Value;

/// Entries of `docs/numbers.toml`: texts and lists by key.
struct Entry {
    kind: String,
    texts: BTreeMap<String, String>,
    lists: BTreeMap<String, Vec<String>>,
    factor: f64,
}

impl Entry {
    fn text(&self, key: &str) -> &str {
        self.texts.get(key).unwrap_or_else(|| panic!("an entry without {key}: {:?}", self.texts))
    }
}

fn entries() -> Vec<Entry> {
    let text = std::fs::read_to_string(root().join("docs/numbers.toml")).unwrap();
    let document: toml::Table = text.parse().unwrap();
    let mut entries = Vec::new();
    for (kind, tables) in document {
        for table in tables.as_array().unwrap() {
            let mut entry =
                Entry { kind: kind.clone(), texts: BTreeMap::new(), lists: BTreeMap::new(), factor: 1.0 };
            for (key, value) in table.as_table().unwrap() {
                match value {
                    toml::Value::String(text) => drop(entry.texts.insert(key.clone(), text.clone())),
                    toml::Value::Array(list) => {
                        let list = list.iter().map(|text| text.as_str().unwrap().to_owned()).collect();
                        entry.lists.insert(key.clone(), list);
                    }
                    toml::Value::Integer(number) => entry.factor = *number as f64,
                    toml::Value::Float(number) => entry.factor = *number,
                    other => panic!("{key}: {other}"),
                }
            }
            entries.push(entry);
        }
    }
    entries
}

/// Numbers of a text: as written, and their values. Spaces between groups of three digits belong to a number; digits within a word do
/// not.
fn numbers(text: &str) -> Vec<(String, f64)> {
    let characters: Vec<char> = text.chars().collect();
    let is_digit = |at: usize| characters.get(at).is_some_and(char::is_ascii_digit);
    let mut found = Vec::new();
    let mut at = 0;
    while at < characters.len() {
        let before = at.checked_sub(1).map(|at| characters[at]);
        let begins = is_digit(at) || (characters[at] == '.' && is_digit(at + 1));
        if !begins || before.is_some_and(|c| c.is_alphanumeric() || c == '_' || c == '.') {
            at += 1;
            continue;
        }
        let begin = at;
        while is_digit(at)
            || (characters.get(at) == Some(&'.') && is_digit(at + 1))
            || (characters.get(at) == Some(&' ')
                && (1..=3).all(|k| is_digit(at + k))
                && !is_digit(at + 4)
                && at - begin <= 3
                && !characters[begin..at].contains(&'.'))
        {
            at += 1;
        }
        if characters.get(at) == Some(&'e') && (is_digit(at + 1) || is_digit(at + 2)) {
            at += 2;
            while is_digit(at) {
                at += 1;
            }
        }
        let written: String = characters[begin..at].iter().collect();
        let value = written.replace(' ', "").parse().unwrap_or_else(|e| panic!("{written}: {e}"));
        found.push((written, value));
    }
    found
}

/// Whether `written` is `value` with as many digits.
fn is_rounded(written: &str, value: f64) -> bool {
    let (mantissa, exponent) = written.split_once('e').unwrap_or((written, "0"));
    let digits = mantissa.split_once('.').map_or(0, |(_, decimals)| decimals.len()) as i32;
    let shown: f64 = written.replace(' ', "").parse().unwrap();
    // Half a digit of the last place, and the rounding of both.
    let half = 0.5 * 10f64.powi(exponent.parse::<i32>().unwrap() - digits);
    (shown - value).abs() <= half * (1.0 + 1e-9)
}

fn spaced(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

fn archived(entry: &Entry) -> Vec<f64> {
    let file = entry.text("file");
    let path = root().join("bench/runs").join(file);
    let text = std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{file}: {e}"));
    if let Some(keys) = entry.lists.get("keys") {
        let json: Value = serde_json::from_str(&text).unwrap();
        let of = |key: &String| json.pointer(key).and_then(Value::as_f64);
        return keys.iter().map(|key| of(key).unwrap_or_else(|| panic!("{file} has no {key}"))).collect();
    }
    let text = spaced(&text);
    let lines = &entry.lists["lines"];
    lines.iter().for_each(|line| assert!(text.contains(&spaced(line)), "{file} has no line `{line}`"));
    lines.iter().flat_map(|line| numbers(line)).map(|(_, value)| value).collect()
}

#[test]
fn figures_of_the_documents_are_those_of_archived_runs() {
    let (mut n, mut failures) = (0, Vec::new());
    for entry in entries() {
        let (document, shown) = (entry.text("document"), entry.text("shown"));
        let text = std::fs::read_to_string(root().join(document)).unwrap();
        assert!(spaced(&text).contains(&spaced(shown)), "{document} does not say `{shown}`");
        if entry.kind == "exempt" {
            assert!(!entry.text("why").is_empty());
            continue;
        }
        let archived = archived(&entry);
        for (written, _) in numbers(shown) {
            if !archived.iter().any(|value| is_rounded(&written, entry.factor * value)) {
                failures.push(format!("{document}: {written} of `{shown}` is not in {}", entry.text("file")));
            }
            n += 1;
        }
    }
    assert!(failures.is_empty(), "{failures:#?}");
    assert!(n > 80, "{n}");
}

#[test]
fn every_figure_of_the_tables_of_measurements_has_a_source() {
    let entries = entries();
    let mut open = Vec::new();
    for document in ["README.md", "docs/measured.md"] {
        let text = std::fs::read_to_string(root().join(document)).unwrap();
        let (_, table) = text.split_once("| what | measured | run |").unwrap();
        let table = table.split("\n\n").next().unwrap();
        for row in table.lines().filter(|row| row.starts_with("| ")) {
            let measured = row.split('|').nth(2).unwrap();
            // Phrases with a source are removed; the rest has no number.
            let mut left = format!("|{measured}|");
            for entry in entries.iter().filter(|entry| entry.text("document") == document) {
                left = left.replace(entry.text("shown"), "");
            }
            let found = numbers(&left).into_iter();
            open.extend(found.map(|(written, _)| format!("{document}: {written} in `{measured}`")));
        }
    }
    assert!(open.is_empty(), "without a source in docs/numbers.toml: {open:#?}");
}

#[test]
fn numbers_are_read_as_people_write_them() {
    let values = |text: &str| numbers(text).into_iter().map(|(_, value)| value).collect::<Vec<_>>();
    assert_eq!(values("4 966 a second, .69 and 8.4e-6 in x1 (69)"), [4966.0, 0.69, 8.4e-6, 69.0]);
    assert_eq!(values("387 025 of 2 x 128"), [387_025.0, 2.0, 128.0]);
    assert!(is_rounded("0.58", 0.5773) && !is_rounded("0.58", 0.573) && is_rounded("1 005", 1005.2));
    assert!(is_rounded("5.8e-6", 5.77e-6) && !is_rounded("5.8e-6", 5.7e-6));
}
