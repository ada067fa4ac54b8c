//! CSV of any program: any character or spaces between cells, decimal points or commas, with a header or without.
//!
//! The separator is found by trying: of all separators and decimal signs the one by which most cells of the first lines are
//! numbers and most lines are as long as each other. A header may have lines of text before it and a row of units after it.

use super::cells::{Decimal, TextColumn, number, shortened};
use super::{Column, Table, stamps};
use crate::recording::{ColumnMemory, MAX_NUMBERS, check_room, check_size};
use crate::{BadInput, size};
use std::borrow::Cow;
use std::collections::BTreeMap;

type Check<T> = std::result::Result<T, BadInput>;

/// Most columns of a table; one of a robot with fifty joints has fewer than a thousand.
const MAX_COLUMNS: usize = 5000;
/// Lines by which the separator is found.
const MAX_SAMPLE: usize = 200;
/// Lines before the header of an instrument's export.
const MAX_PREAMBLE: usize = 100;
/// Lines of a quoted cell.
const MAX_LINES_OF_CELL: usize = 20;
/// Separators, the first of equals first; `None` is any number of spaces.
const SEPARATORS: [Option<char>; 5] = [Some(';'), Some('\t'), Some(','), Some('|'), None];

/// Format of a table of text as the caller states it; the rest is found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct TextFormat {
    /// Separator of cells; a space is any number of spaces.
    pub delimiter: Option<char>,
    /// Separator before a fraction: `.` or `,`.
    pub decimal: Option<char>,
}

#[derive(Debug, Clone, Copy)]
struct TextLayout {
    separator: Option<char>,
    decimal: Decimal,
    /// Cells of most lines.
    width: usize,
}

/// A line with its number from 1.
type NumberedLine<'a> = (usize, Cow<'a, str>);

/// The cells of a line.
fn cells(line: &str, separator: Option<char>) -> Vec<Cow<'_, str>> {
    let Some(separator) = separator else {
        return line.split_whitespace().map(|cell| Cow::Borrowed(unquoted(cell))).collect();
    };
    if !line.contains('"') {
        return line.split(separator).map(|cell| Cow::Borrowed(cell.trim())).collect();
    }
    let (mut found, mut rest) = (Vec::new(), line);
    loop {
        let begins = rest.trim_start_matches(|c: char| c.is_whitespace() && c != separator);
        let (cell, after) = match begins.strip_prefix('"').and_then(closed) {
            Some((cell, after)) => (Cow::Owned(cell), after.split_once(separator).map(|(_, rest)| rest)),
            None => match begins.split_once(separator) {
                Some((cell, rest)) => (Cow::Borrowed(cell.trim()), Some(rest)),
                None => (Cow::Borrowed(begins.trim()), None),
            },
        };
        found.push(cell);
        let Some(after) = after else { return found };
        rest = after;
    }
}

/// A cell up to its closing quote, two of which are one, and what follows.
fn closed(inner: &str) -> Option<(String, &str)> {
    let mut cell = String::new();
    let mut rest = inner;
    loop {
        let (part, after) = rest.split_once('"')?;
        cell.push_str(part);
        let Some(quoted) = after.strip_prefix('"') else {
            return Some((cell.split_whitespace().collect::<Vec<_>>().join(" "), after));
        };
        cell.push('"');
        rest = quoted;
    }
}

fn unquoted(cell: &str) -> &str {
    cell.strip_prefix('"').and_then(|inner| inner.strip_suffix('"')).unwrap_or(cell)
}

/// Lines with content, those of a cell in quotes as one.
fn lines(text: &str) -> impl Iterator<Item = NumberedLine<'_>> {
    let mut numbered = text.lines().enumerate();
    std::iter::from_fn(move || {
        let (at, line) = numbered.by_ref().find(|(_, line)| !line.trim().is_empty())?;
        let is_open = |line: &str| line.matches('"').count() % 2 == 1;
        let begins_cell = |line: &str| {
            line.match_indices('"')
                .any(|(k, _)| line[..k].trim_end().ends_with([';', ',', '\t', '|']) || k == 0)
        };
        let mut line = Cow::Borrowed(line);
        if is_open(&line) && begins_cell(&line) {
            let mut ahead = numbered.clone();
            let mut joined = line.to_string();
            for _ in 0..MAX_LINES_OF_CELL {
                let Some((_, next)) = ahead.next() else { break };
                joined = format!("{joined} {next}");
                if !is_open(&joined) {
                    (line, numbered) = (Cow::Owned(joined), ahead);
                    break;
                }
            }
        }
        Some((at + 1, line))
    })
}

fn comment(line: &str) -> Option<&str> {
    ["#", "%", "//"].iter().find_map(|mark| line.trim_start().strip_prefix(mark))
}

/// How a sample of lines is divided, by the share of numbers among cells and of lines that are as wide as most.
fn layout(sample: &[NumberedLine], format: &TextFormat) -> TextLayout {
    let separators = SEPARATORS.iter().copied().filter(|separator| match format.delimiter {
        Some(' ') => separator.is_none(),
        Some(stated) => *separator == Some(stated),
        None => true,
    });
    let decimals = [Decimal::Point, Decimal::Comma].into_iter().filter(|decimal| match format.decimal {
        Some(',') => *decimal == Decimal::Comma,
        Some(_) => *decimal == Decimal::Point,
        None => true,
    });
    let mut best: Option<((f64, usize), TextLayout)> = None;
    // A separator of one's own is the only one.
    let own = format.delimiter.filter(|c| *c != ' ' && !SEPARATORS.contains(&Some(*c)));
    for separator in separators.chain(own.map(Some)) {
        for decimal in decimals.clone().filter(|d| (separator, *d) != (Some(','), Decimal::Comma)) {
            let (score, width) = score(sample, separator, decimal);
            if best.as_ref().is_none_or(|(known, _)| (score, width) > *known) {
                best = Some(((score, width), TextLayout { separator, decimal, width }));
            }
        }
    }
    best.map_or(TextLayout { separator: None, decimal: Decimal::Point, width: 1 }, |(_, layout)| layout)
}

/// The part of the cells that are numbers or stamps, times that of the lines of one width; and that width.
fn score(sample: &[NumberedLine], separator: Option<char>, decimal: Decimal) -> (f64, usize) {
    let (mut numbers, mut filled) = (0, 0);
    let mut widths: BTreeMap<usize, usize> = BTreeMap::new();
    for (k, (_, line)) in sample.iter().enumerate() {
        let row = cells(line, separator);
        *widths.entry(row.len()).or_default() += 1;
        if k == 0 && sample.len() > 1 {
            continue; // a header, mostly
        }
        for cell in row.iter().filter(|cell| !cell.is_empty()) {
            filled += 1;
            numbers += usize::from(number(cell, decimal).is_some() || stamps::parse(cell).is_some());
        }
    }
    let (width, n) = widths.into_iter().max_by_key(|(_, n)| *n).unwrap_or((1, 0));
    let part = |n: usize, of: usize| n as f64 / of.max(1) as f64;
    (part(numbers, filled) * part(n, sample.len()), width)
}

/// Where a table begins: its names, units and first row of numbers.
struct TableHead {
    names: Vec<String>,
    units: Vec<String>,
    /// Lines before the first row, of those with content.
    n_lines: usize,
}

fn head(sample: &[NumberedLine], last_comment: Option<&str>, layout: TextLayout) -> Check<TableHead> {
    let is_number = |cell: &str| number(cell, layout.decimal).is_some() || stamps::parse(cell).is_some();
    let split = |k: usize| sample.get(k).map(|(_, line)| cells(line, layout.separator));
    let is_row = |row: &[Cow<str>]| row.iter().any(|cell| !cell.is_empty() && is_number(cell));
    let all_numbers = |row: &[Cow<str>]| row.iter().all(|cell| is_number(cell));
    let first =
        (0..sample.len().min(MAX_PREAMBLE)).find(|k| split(*k).is_some_and(|row| row.len() == layout.width));
    let first = first.unwrap_or(0);
    let Some(row) = split(first) else {
        return Err(BadInput::new("line 1", "a table of numbers", "nothing"));
    };
    let has_header = !all_numbers(&row);
    if first > 0 && !has_header {
        // The text above rows of numbers alone would be their header, and has another width.
        let above = split(first - 1).unwrap_or_default();
        if above.len() > 1 || layout.width == 1 {
            let place = format!("line {}", sample[first - 1].0);
            let expected = format!("a header of {} cells, as the rows below have", layout.width);
            return Err(BadInput::new(place, expected, above.len().to_string()));
        }
    }
    let named: Option<Vec<String>> = match has_header {
        true => Some(row.iter().map(|name| shortened(name)).collect()),
        false => last_comment
            .map(|line| cells(line.trim(), layout.separator))
            .filter(|names| names.len() == layout.width && !all_numbers(names))
            .map(|names| names.iter().map(|name| shortened(name)).collect()),
    };
    let below = if has_header { split(first + 1).unwrap_or_default() } else { Vec::new() };
    let has_units = below.len() == layout.width && !is_row(&below) && below.iter().any(|cell| is_unit(cell));
    let units =
        if has_units { below.iter().map(|cell| bare_unit(cell).to_owned()).collect() } else { Vec::new() };
    let names = named.unwrap_or_else(|| (1..=row.len()).map(|k| k.to_string()).collect());
    Ok(TableHead { names, units, n_lines: first + usize::from(has_header) + usize::from(has_units) })
}

/// Whether a cell can be in a row of units: text in brackets, or a short word that is a unit.
fn is_unit(cell: &str) -> bool {
    const WORDS: [&str; 24] = [
        "s", "ms", "us", "µs", "ns", "m", "cm", "mm", "um", "µm", "rad", "deg", "°", "N", "mN", "Nm", "A",
        "mA", "V", "mV", "rad/s", "deg/s", "m/s", "mm/s",
    ];
    WORDS.contains(&cell) || bare_unit(cell) != cell
}

fn bare_unit(cell: &str) -> &str {
    let inside = |[open, close]: [char; 2]| cell.strip_prefix(open)?.strip_suffix(close);
    [['[', ']'], ['(', ')'], ['<', '>']].into_iter().find_map(inside).unwrap_or(cell).trim()
}

/// Reads a table of text.
///
/// # Errors
/// `BadInput` naming the line: nothing, more columns or numbers than any table has, a header of another width.
pub(super) fn read(text: &str, format: &TextFormat) -> Check<Table> {
    let mut text = text.trim_start_matches('\u{feff}'); // spreadsheets put it there
    let mut format = *format;
    let mut skipped = 0;
    if let Some((first, rest)) = text.split_once('\n')
        && let Some(stated) = first.trim().strip_prefix("sep=")
    {
        format.delimiter = format.delimiter.or(stated.chars().next());
        (text, skipped) = (rest, 1);
    }
    let is_content = |(_, line): &NumberedLine| comment(line).is_none();
    let mut last_comment = None;
    let leading = text
        .lines()
        .map_while(|line| if line.trim().is_empty() { Some(None) } else { comment(line).map(Some) });
    leading.flatten().for_each(|line| last_comment = Some(line));
    let sample: Vec<NumberedLine> = lines(text).filter(is_content).take(MAX_SAMPLE).collect();
    let Some((at, first)) = sample.first() else {
        return Err(BadInput::new("line 1", "a table of numbers", "nothing"));
    };
    // The widest that any separator makes of it.
    let widest = 1 + first.matches([';', ',', '\t', '|']).count();
    size::check_at_most("columns", widest, MAX_COLUMNS).map_err(|bad| bad.within(format!("line {at}")))?;
    let layout = layout(&sample, &format);
    let head = head(&sample, last_comment, layout)?;
    // A column more, of the numbers of the lines.
    let n_columns = head.names.len() + 1;
    let most = text.lines().count().min(MAX_NUMBERS as usize / n_columns);
    check_room(n_columns, most as u64, ColumnMemory::Grown)?;
    let mut table = Table { is_text: true, ..Table::default() };
    let mut columns: Vec<TextColumn> = head.names.iter().map(|_| TextColumn::default()).collect();
    for (at, line) in lines(text).filter(is_content).skip(head.n_lines) {
        let row = cells(&line, layout.separator);
        let r = table.rows.len();
        check_size(columns.len(), r as u64 + 1).map_err(|bad| bad.within(format!("line {at}")))?;
        table.rows.push((at + skipped) as u64);
        if row.len() != columns.len() {
            table.uneven.push((r, row.len()));
            columns.iter_mut().for_each(TextColumn::push_missing);
            continue;
        }
        for (cell, column) in row.iter().zip(&mut columns) {
            column.push(cell, layout.decimal);
        }
    }
    if table.rows.is_empty() {
        let (at, _) = sample.last().map_or((1, ""), |(at, line)| (*at, line));
        return Err(BadInput::new(format!("line {}", at + 1), "at least one row of numbers", "none"));
    }
    for (k, (name, column)) in head.names.into_iter().zip(columns).enumerate() {
        table.add_text(k, name, column);
    }
    table.units = head.units;
    Ok(table)
}

impl Table {
    pub(super) fn add_text(&mut self, k: usize, name: String, column: TextColumn) {
        self.words.extend(column.words.map(|words| (k, words)));
        self.clocks.extend(column.origin.map(|origin| (k, origin as f64)));
        self.columns.push(Column { name, values: column.values });
    }
}

/// The text of a file: UTF-8, UTF-16 with a byte order mark, else Latin-1, of which only labels can suffer.
pub(super) fn decoded(bytes: Vec<u8>) -> String {
    let units = |of: fn([u8; 2]) -> u16| {
        let units = bytes[2..].chunks_exact(2).map(|pair| of([pair[0], pair[1]]));
        char::decode_utf16(units).map(|c| c.unwrap_or(char::REPLACEMENT_CHARACTER)).collect()
    };
    match bytes.get(..2) {
        Some([0xff, 0xfe]) => units(u16::from_le_bytes),
        Some([0xfe, 0xff]) => units(u16::from_be_bytes),
        _ => String::from_utf8(bytes)
            .unwrap_or_else(|error| error.as_bytes().iter().map(|b| char::from(*b)).collect()),
    }
}
