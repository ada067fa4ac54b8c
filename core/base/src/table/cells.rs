//! Cells of a column of text: numbers, flags, stamps or words.

use super::stamps;
use std::collections::HashMap;

/// Most different words of a column that are distinguished; the rest of a column of free text is one word.
const MAX_WORDS: usize = 4096;
/// Characters of a word that are kept.
const MAX_CHARACTERS: usize = 60;
/// Texts of a cell without a number.
const MISSING: [&str; 18] = [
    "", "null", "NULL", "None", "none", "NA", "N/A", "n/a", "<NA>", "#N/A", "NaT", "nil", "?", "-", "--",
    "1.#QNAN", "-1.#IND", "1.#IND",
];

/// Separator between whole numbers and their fractions.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Decimal {
    Point,
    Comma,
}

/// The number in a cell: NaN for a missing value, 0 or 1 of a flag; `None` of a word.
pub(super) fn number(cell: &str, decimal: Decimal) -> Option<f64> {
    let first = cell.as_bytes().first().copied().unwrap_or(b' ');
    let is_like_one = first.is_ascii_digit() || matches!(first, b'-' | b'+' | b'.' | b',');
    if is_like_one && let Some(value) = figure(cell, decimal) {
        return Some(value);
    }
    match cell {
        "true" | "True" | "TRUE" => Some(1.0),
        "false" | "False" | "FALSE" => Some(0.0),
        _ if MISSING.contains(&cell) => Some(f64::NAN),
        _ => figure(cell, decimal), // inf, nan, a minus sign of typesetters
    }
}

fn figure(cell: &str, decimal: Decimal) -> Option<f64> {
    match decimal {
        Decimal::Point => {}
        Decimal::Comma if cell.contains('.') => return None,
        Decimal::Comma if cell.contains(',') => return figure(&cell.replacen(',', ".", 1), Decimal::Point),
        Decimal::Comma => {}
    }
    match cell.parse() {
        Ok(value) => Some(value),
        // Fortran's exponent, and the minus sign of typesetters.
        Err(_) if cell.contains(['D', 'd']) && cell.as_bytes()[0] < b'A' => {
            cell.replacen(['D', 'd'], "e", 1).parse().ok()
        }
        Err(_) => cell.strip_prefix('\u{2212}')?.parse::<f64>().ok().map(|value| -value),
    }
}

/// The words of a column.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Words {
    words: Vec<String>,
    index: HashMap<String, u32>,
    /// For each row 0, or the word's place from 1 (n_rows).
    codes: Vec<u32>,
}

impl Words {
    fn push(&mut self, row: usize, word: &str) {
        self.codes.resize(row, 0);
        let word = shortened(word);
        let code = match self.index.get(&word) {
            Some(code) => *code,
            None if self.words.len() == MAX_WORDS => MAX_WORDS as u32,
            None => {
                self.words.push(word.clone());
                let code = self.words.len() as u32;
                self.index.insert(word, code);
                code
            }
        };
        self.codes.push(code);
    }

    /// The word in row `row`.
    pub(super) fn at(&self, row: usize) -> Option<&str> {
        let code = self.codes.get(row).copied().unwrap_or(0) as usize;
        Some(self.words.get(code.checked_sub(1)?)?.as_str())
    }

    pub(super) fn taken(&self, rows: &[usize]) -> Self {
        let codes = rows.iter().map(|row| self.codes.get(*row).copied().unwrap_or(0)).collect();
        Self { codes, ..self.clone() }
    }
}

/// A column of text as it is read.
#[derive(Debug, Default)]
pub(crate) struct TextColumn {
    pub(super) values: Vec<f64>,
    pub(super) words: Option<Words>,
    /// Of a column of stamps: the second that its values count from [s since 1970 or midnight].
    pub(super) origin: Option<i64>,
    has_numbers: bool,
}

impl TextColumn {
    pub(super) fn push(&mut self, cell: &str, decimal: Decimal) {
        if let Some(origin) = self.origin
            && let Some((whole, fraction)) = stamps::parse(cell)
        {
            self.values.push((whole - origin) as f64 + fraction);
            return;
        }
        match number(cell, decimal) {
            Some(value) if value.is_nan() || self.origin.is_none() => {
                self.has_numbers |= !value.is_nan();
                self.values.push(value);
            }
            _ => self.push_text(cell),
        }
    }

    /// A cell of a program that writes decimal points.
    pub(crate) fn push_cell(&mut self, cell: &str) {
        self.push(cell, Decimal::Point);
    }

    /// The first of a column may be a stamp: then all are.
    fn push_text(&mut self, cell: &str) {
        let is_first = !self.has_numbers && self.words.is_none() && self.origin.is_none();
        if is_first && let Some((whole, fraction)) = stamps::parse(cell) {
            self.origin = Some(whole);
            self.values.push(fraction);
            return;
        }
        self.words.get_or_insert_default().push(self.values.len(), cell);
        self.values.push(f64::NAN);
    }

    pub(crate) fn push_missing(&mut self) {
        self.values.push(f64::NAN);
    }
}

/// The beginning of a cell; the rest of a garbled line is no name.
pub(super) fn shortened(cell: &str) -> String {
    match cell.char_indices().nth(MAX_CHARACTERS) {
        Some((end, _)) => format!("{}…", &cell[..end]),
        None => cell.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_every_spelling() {
        let point = |cell: &str| number(cell, Decimal::Point);
        for (cell, value) in [
            ("1.5", 1.5),
            ("-2e3", -2000.0),
            ("+3", 3.0),
            ("1.5D-3", 0.0015),
            ("\u{2212}4", -4.0),
            ("TRUE", 1.0),
        ] {
            assert_eq!(point(cell), Some(value), "{cell}");
        }
        for cell in MISSING.iter().chain(&["nan", "NaN", "-nan"]) {
            assert!(point(cell).is_some_and(f64::is_nan), "{cell}");
        }
        assert_eq!(
            (number("0,25", Decimal::Comma), number("-1,5e-3", Decimal::Comma)),
            (Some(0.25), Some(-0.0015))
        );
        // A thousand, or a fraction of three digits: ambiguous.
        for (cell, decimal) in
            [("1,000.5", Decimal::Point), ("1.000,5", Decimal::Comma), ("1.5", Decimal::Comma)]
        {
            assert_eq!(number(cell, decimal), None, "{cell}");
        }
        assert_eq!((point("12 mm"), point("tendon0"), point("0x10")), (None, None, None));
    }

    #[test]
    fn a_column_keeps_its_words_and_begins_its_clock_at_its_first_stamp() {
        let mut column = TextColumn::default();
        for cell in ["1", "a", "", "b", "a"] {
            column.push(cell, Decimal::Point);
        }
        let words = column.words.unwrap_or_default();
        let read: Vec<Option<&str>> = (0..5).map(|row| words.at(row)).collect();
        assert_eq!(read, [None, Some("a"), None, Some("b"), Some("a")]);
        let mut column = TextColumn::default();
        for cell in ["", "2024-05-06T12:00:00.5Z", "2024-05-06T14:00:01+02:00", "7"] {
            column.push(cell, Decimal::Point);
        }
        assert_eq!(column.origin, Some(1_714_996_800));
        assert_eq!((column.values[1], column.values[2]), (0.5, 1.0));
        assert!(column.values[0].is_nan() && column.values[3].is_nan());
    }
}
