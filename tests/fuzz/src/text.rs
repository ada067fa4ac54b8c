//! Slips of the hand and worse in files of text, made from valid ones.

use proptest::prelude::*;
use proptest::sample::Index;

/// Replacements of a number or a value.
const TOKENS: [&str; 30] = [
    "nan",
    "inf",
    "-inf",
    "1e308",
    "-1e308",
    "1e-320",
    "1e999",
    "-0.0",
    "0",
    "1",
    "-1",
    "0.5",
    "1e4",
    "1e9",
    "65536",
    "4294967296",
    "9223372036854775807",
    "-9223372036854775808",
    "18446744073709551616",
    "\"\"",
    "\" \"",
    "\"\\u0000\"",
    "\"µ\u{202e}⊥\u{1F980}\"",
    "\"../../x\"",
    "[]",
    "[[1.0]]",
    "[0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18]",
    "{}",
    "true",
    "1979-05-27T07:32:00Z",
];
/// Text that may appear anywhere.
const SNIPPETS: [&str; 12] = ["\u{feff}", "µ", "\u{0}", "\"", "=", "[", "]", "#", ",", "\n", "\r", "⊥"];

/// One slip.
#[derive(Debug, Clone)]
pub enum Slip {
    /// A line less.
    Drop(Index),
    /// A line twice.
    Double(Index),
    /// Two lines in each other's place.
    Swap(Index, Index),
    /// Another number.
    Number(Index, usize),
    /// Another value of a key.
    Value(Index, usize),
    /// The key of one line before the value of another.
    Key(Index, Index),
    /// Something put in.
    Insert(Index, usize),
    /// A part that is missing.
    Cut(Index, Index),
    /// The end, too early.
    End(Index),
}

/// A few slips.
pub fn slips() -> impl Strategy<Value = Vec<Slip>> {
    let at = any::<Index>;
    let one = prop_oneof![
        1 => at().prop_map(Slip::Drop),
        1 => at().prop_map(Slip::Double),
        1 => (at(), at()).prop_map(|(a, b)| Slip::Swap(a, b)),
        6 => (at(), 0..TOKENS.len()).prop_map(|(a, token)| Slip::Number(a, token)),
        3 => (at(), 0..TOKENS.len()).prop_map(|(a, token)| Slip::Value(a, token)),
        1 => (at(), at()).prop_map(|(a, b)| Slip::Key(a, b)),
        1 => (at(), 0..SNIPPETS.len()).prop_map(|(a, snippet)| Slip::Insert(a, snippet)),
        1 => (at(), at()).prop_map(|(a, b)| Slip::Cut(a, b)),
        1 => at().prop_map(Slip::End),
    ];
    prop::collection::vec(one, 1..4)
}

/// A valid text with these slips.
pub fn slipped(text: &str, slips: &[Slip]) -> String {
    slips.iter().fold(text.to_owned(), |text, slip| if text.is_empty() { text } else { slip.apply(&text) })
}

/// A valid text of JSON, an entry on each line, with these slips.
pub fn slipped_json(text: &str, slips: &[Slip]) -> String {
    slipped(&text.replace("\": ", "\" = "), slips).replace("\" = ", "\": ")
}

impl Slip {
    fn apply(&self, text: &str) -> String {
        let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
        let n = lines.len();
        match self {
            Self::Drop(at) => drop(lines.remove(at.index(n))),
            Self::Double(at) => lines.insert(at.index(n), lines[at.index(n)].clone()),
            Self::Swap(a, b) => lines.swap(a.index(n), b.index(n)),
            Self::Value(at, token) => {
                let with_value: Vec<usize> = (0..n).filter(|i| lines[*i].contains('=')).collect();
                if let Some(&i) = with_value.get(at.index(with_value.len().max(1))) {
                    let (key, _) = lines[i].split_once('=').unwrap();
                    lines[i] = format!("{key}= {}", TOKENS[*token]);
                }
            }
            Self::Key(a, b) => {
                let (a, b) = (a.index(n), b.index(n));
                if let (Some((key, _)), Some((_, value))) =
                    (lines[a].split_once('='), lines[b].split_once('='))
                {
                    lines[b] = format!("{key}={value}");
                }
            }
            Self::Number(at, token) => return with_number(text, at, TOKENS[*token]),
            Self::Insert(at, snippet) => {
                let at = boundary(text, at);
                return [&text[..at], SNIPPETS[*snippet], &text[at..]].concat();
            }
            Self::Cut(a, b) => {
                let (a, b) = (boundary(text, a), boundary(text, b));
                return [&text[..a.min(b)], &text[a.max(b)..]].concat();
            }
            Self::End(at) => return text[..boundary(text, at)].to_owned(),
        }
        lines.join("\n") + "\n"
    }
}

/// The text with one of its numbers replaced.
fn with_number(text: &str, at: &Index, token: &str) -> String {
    let is_part = |c: char| c.is_ascii_digit() || matches!(c, '.' | '-' | '+' | 'e');
    let mut numbers: Vec<(usize, usize)> = Vec::new();
    let mut begin = None;
    for (i, c) in text.char_indices().chain([(text.len(), ' ')]) {
        match begin {
            None if c.is_ascii_digit() || c == '-' => begin = Some(i),
            Some(from) if !is_part(c) => {
                numbers.push((from, i));
                begin = None;
            }
            _ => {}
        }
    }
    let Some(&(from, to)) = numbers.get(at.index(numbers.len().max(1))) else { return text.to_owned() };
    [&text[..from], token, &text[to..]].concat()
}

fn boundary(text: &str, at: &Index) -> usize {
    let at = at.index(text.len() + 1);
    (0..=at).rev().find(|at| text.is_char_boundary(*at)).unwrap_or(0)
}
