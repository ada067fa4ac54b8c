//! CSV of any program: commas, semicolons, tabs or spaces between cells, with a header or without.

use super::{Column, Filter, Table};
use crate::recording::check_size;
use crate::{BadInput, size};

type Check<T> = std::result::Result<T, BadInput>;

/// Most columns of a table; one of a robot with fifty joints has fewer than a thousand.
const MOST_COLUMNS: usize = 5000;
/// Characters of a cell that a message shows.
const LONGEST_SHOWN: usize = 60;

/// What stands between cells: a character, or spaces.
type Separator = Option<char>;

fn separator(line: &str) -> Separator {
    [';', ',', '\t'].into_iter().find(|c| line.contains(*c))
}

fn cells(line: &str, separator: Separator) -> Vec<&str> {
    match separator {
        Some(c) => line.split(c).map(unquoted).collect(),
        None => line.split_whitespace().map(unquoted).collect(),
    }
}

fn unquoted(cell: &str) -> &str {
    let cell = cell.trim();
    cell.strip_prefix('"').and_then(|inner| inner.strip_suffix('"')).unwrap_or(cell)
}

/// The number in a cell; NaN where it says so or has none.
fn number(cell: &str) -> Option<f64> {
    match cell {
        "" | "null" | "NULL" | "None" | "NA" => Some(f64::NAN),
        _ => cell.parse().ok(),
    }
}

pub(super) fn read(text: &str, filter: Option<&Filter>) -> Check<Table> {
    let text = text.trim_start_matches('\u{feff}'); // spreadsheets put it there
    let is_content = |line: &str| !line.trim().is_empty() && !line.starts_with('#');
    let mut lines = text.lines().enumerate().filter(|(_, line)| is_content(line)).peekable();
    let Some((at, first)) = lines.peek().copied() else {
        return Err(BadInput::new("line 1", "a table of numbers", "nothing"));
    };
    let separator = separator(first);
    let head = cells(first, separator);
    size::check_at_most("columns", head.len(), MOST_COLUMNS)
        .map_err(|bad| bad.within(format!("line {}", at + 1)))?;
    let has_header = head.iter().any(|cell| number(cell).is_none());
    let names: Vec<String> = match has_header {
        true => head.iter().map(|name| shortened(name)).collect(),
        false => (1..=head.len()).map(|k| k.to_string()).collect(),
    };
    if has_header {
        lines.next();
    }
    let by = match filter {
        Some(filter) => Some((filter, filtered_by(filter, &names)?)),
        None => None,
    };
    let mut table = Table { is_text: true, ..Table::default() };
    let mut values: Vec<Vec<f64>> = vec![Vec::new(); names.len()];
    let mut has_word = vec![false; names.len()];
    for (at, line) in lines {
        let row = cells(line, separator);
        if by.is_some_and(|(filter, column)| !row.get(column).is_some_and(|cell| filter.accepts(cell))) {
            continue;
        }
        let r = table.rows.len();
        check_size(names.len(), r as u64 + 1).map_err(|bad| bad.within(format!("line {}", at + 1)))?;
        table.rows.push(at as u64 + 1);
        if row.len() != names.len() {
            table.uneven.push((r, row.len()));
            values.iter_mut().for_each(|column| column.push(f64::NAN));
            continue;
        }
        for (c, cell) in row.iter().enumerate() {
            let found = number(cell);
            if found.is_none() && !has_word[c] {
                has_word[c] = true;
                table.words.push((c, r, shortened(cell)));
            }
            values[c].push(found.unwrap_or(f64::NAN));
        }
    }
    if table.rows.is_empty() {
        let (expected, found) = match filter {
            Some(filter) => (format!("a row with {} = {}", filter.column, filter.value), "none"),
            None => ("at least one row of numbers".to_owned(), "none"),
        };
        return Err(BadInput::new(format!("line {}", at + 2), expected, found));
    }
    table.columns = names.into_iter().zip(values).map(|(name, values)| Column { name, values }).collect();
    Ok(table)
}

fn filtered_by(filter: &Filter, names: &[String]) -> Check<usize> {
    names.iter().position(|name| *name == filter.column).ok_or_else(|| {
        let shown: Vec<&str> = names.iter().take(LONGEST_SHOWN).map(String::as_str).collect();
        BadInput::new("filter", format!("a column \"{}\"", filter.column), shown.join(", "))
    })
}

/// The beginning of a cell, for a message; the rest of a garbled line is no name.
fn shortened(cell: &str) -> String {
    match cell.char_indices().nth(LONGEST_SHOWN) {
        Some((end, _)) => format!("{}…", &cell[..end]),
        None => cell.to_owned(),
    }
}
