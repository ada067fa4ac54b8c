//! Recordings as CSV, for people; the only module that knows the `csv` crate.
//!
//! Lengths are written in millimetres, with as many digits as give the same double back. The ending of a column
//! is its unit, and any known one is read. Lines `# key: value` before the header carry the metadata; both they
//! and the column `gap` may be missing.

use super::names::ColumnKind;
use super::{
    Channel, Check, ColumnMemory, MAX_NUMBERS, Metadata, Recording, check_room, check_size, metadata, names,
    not_finite, not_later,
};
use crate::units::Unit;
use crate::{BadInput, json};
use std::fmt::Write as _;
use std::io::Write;

/// Characters of a cell that a message shows.
const LONGEST_SHOWN: usize = 200;

pub(super) fn read(text: &str) -> Check<Recording> {
    // A quote that is never closed makes a cell of the rest of the file.
    parse(text).map_err(|bad| BadInput { place: shown(bad.place), found: shown(bad.found), ..bad })
}

/// The beginning of a text, for a message.
fn shown(text: String) -> String {
    let line = text.lines().next().unwrap_or_default();
    match line.char_indices().nth(LONGEST_SHOWN) {
        Some((end, _)) => format!("{}…", &line[..end]),
        None if line.len() < text.trim_end().len() => format!("{line}…"),
        None => text,
    }
}

/// Metadata in the lines before the header.
pub(super) fn read_metadata(text: &str) -> Check<Metadata> {
    head(text).map(|(meta, ..)| meta).map_err(|bad| BadInput { found: shown(bad.found), ..bad })
}

/// The metadata, what follows them, and the number of lines before that.
fn head(text: &str) -> Check<(Metadata, &str, u64)> {
    let mut body = text.trim_start_matches('\u{feff}'); // spreadsheets put it there
    let mut pairs = Vec::new();
    let mut lines_before = 0;
    while body.starts_with('#') {
        let (line, rest) = body.split_once('\n').unwrap_or((body, ""));
        lines_before += 1;
        if let Some((key, value)) = line[1..].split_once(':')
            && metadata::is_key(key.trim())
        {
            let key = key.trim().to_owned();
            let value = unquoted(value.trim()).ok_or_else(|| {
                BadInput::new(format!("line {lines_before}: {key}"), "text, or a JSON string", value.trim())
            })?;
            pairs.push((key, value));
        }
        body = rest;
    }
    Ok((Metadata::from_pairs(pairs)?, body, lines_before))
}

fn parse(text: &str) -> Check<Recording> {
    let (meta, body, lines_before) = head(text)?;
    let mut reader = ::csv::ReaderBuilder::new().trim(::csv::Trim::Headers).from_reader(body.as_bytes());
    let header = reader.headers().map_err(|e| bad_csv(&e, body, lines_before))?.clone();
    let (columns, mut channels) =
        columns(&header).map_err(|bad| bad.within(format!("line {}", lines_before + 1)))?;

    // No more rows than lines; room for them all is there before the first.
    let n_lines = body.bytes().filter(|b| *b == b'\n').count();
    let most = n_lines.min(MAX_NUMBERS as usize / columns.len().max(1));
    check_room(columns.len(), most as u64, ColumnMemory::Reserved)?;
    let mut time: Vec<f64> = Vec::with_capacity(most);
    channels.iter_mut().for_each(|channel| channel.values.reserve_exact(most));
    let mut gap = Vec::new();
    let mut row = ::csv::StringRecord::new();
    while reader.read_record(&mut row).map_err(|e| bad_csv(&e, body, lines_before))? {
        let line = lines_before + line_of(row.position(), body);
        check_size(columns.len(), time.len() as u64 + 1).map_err(|bad| bad.within(format!("line {line}")))?;
        for ((cell, column), name) in row.iter().zip(&columns).zip(&header) {
            let cell = cell.trim();
            let place = || format!("line {line}: {name}");
            match column {
                ColumnKind::Gap => gap.push(match cell {
                    "0" | "false" => false,
                    "1" | "true" => true,
                    _ => return Err(BadInput::new(place(), "0 or 1", format!("\"{cell}\""))),
                }),
                ColumnKind::Channel(i, unit) => channels[*i].values.push(number(cell, *unit, place)?),
                ColumnKind::Time(unit) => {
                    let t = number(cell, Some(unit), place)?;
                    if let Some(&before) = time.last().filter(|before| t <= **before) {
                        return Err(not_later(&place(), before, t));
                    }
                    time.push(t);
                }
            }
        }
    }
    if time.is_empty() {
        return Err(BadInput::new(
            format!("line {}", lines_before + 2),
            "at least one row of numbers",
            "none",
        ));
    }
    Recording::new(time, channels, gap, meta)
}

/// Kind of each column (n_columns), and a channel without values for each that is one.
fn columns(header: &::csv::StringRecord) -> Check<(Vec<ColumnKind>, Vec<Channel>)> {
    if let Some(name) = header.get(0).filter(|name| header.len() == 1 && name.contains([';', '\t'])) {
        return Err(BadInput::new("header", "columns separated by commas", format!("`{name}`"))
            .hint("`hysteron import FILE --propose` writes a map for such a table"));
    }
    let names: Vec<&str> = header.iter().collect();
    names::columns(&names).map_err(|bad| if bad.place.is_empty() { bad.within("header") } else { bad })
}

/// The number in a cell, in SI.
fn number(cell: &str, unit: Option<&Unit>, place: impl Fn() -> String) -> Check<f64> {
    let value = match unit {
        Some(unit) => unit.parse_si(cell),
        None => cell.parse().ok(),
    };
    match value {
        Some(value) if value.is_finite() => Ok(value),
        Some(_) => Err(not_finite(&place(), cell)),
        None if cell.is_empty() => Err(not_finite(&place(), "an empty cell")),
        None => Err(BadInput::new(place(), "a number", format!("\"{cell}\""))),
    }
}

/// Line of a row, from 1; the position may lie before blank lines.
fn line_of(position: Option<&::csv::Position>, body: &str) -> u64 {
    let Some(position) = position else { return 1 };
    let rest = body.as_bytes().iter().skip(position.byte() as usize);
    let blank = rest.take_while(|b| matches!(b, b'\r' | b'\n')).filter(|b| **b == b'\n').count();
    position.line() + blank as u64
}

fn bad_csv(error: &::csv::Error, body: &str, lines_before: u64) -> BadInput {
    let line = lines_before + line_of(error.position(), body);
    let place = format!("line {line}");
    match error.kind() {
        ::csv::ErrorKind::UnequalLengths { expected_len, len, .. } => {
            BadInput::new(place, format!("{expected_len} cells, as the header has"), len.to_string())
        }
        _ => BadInput::new(place, "CSV", error.to_string()),
    }
}

pub(super) fn write(recording: &Recording, out: &mut dyn Write) -> std::io::Result<()> {
    for (key, value) in recording.meta.to_pairs() {
        writeln!(out, "{}", format!("# {key}: {}", quoted(&value)).trim_end())?;
    }
    // What a channel is written in: millimetres for metres, under a fraction line too, else what it is.
    let units: Vec<Option<&Unit>> = recording.channels.iter().map(|c| written_unit(&c.name)).collect();
    let mut line = String::from("time_s");
    for (channel, unit) in recording.channels.iter().zip(&units) {
        let name = match (Unit::of_name(&channel.name), unit) {
            (Some((stem, _)), Some(unit)) => format!("{stem}_{}", unit.suffix),
            _ => channel.name.clone(),
        };
        line.push(',');
        line.push_str(&name);
    }
    writeln!(out, "{line},gap")?;
    for i in 0..recording.time.len() {
        line.clear();
        // A string takes all that is written.
        let _ = write!(line, "{}", recording.time[i]);
        for (channel, unit) in recording.channels.iter().zip(&units) {
            line.push(',');
            match unit {
                Some(unit) => unit.write_si(channel.values[i], &mut line),
                None => _ = write!(line, "{}", channel.values[i]),
            }
        }
        writeln!(out, "{line},{}", u8::from(recording.gap[i]))?;
    }
    Ok(())
}

fn written_unit(name: &str) -> Option<&'static Unit> {
    if names::is_unitless(name) {
        return None;
    }
    Unit::of_name(name).map(|(_, unit)| unit.in_millimetres())
}

/// A value of metadata on one line: as it is, or as a JSON string where that would not come back.
fn quoted(value: &str) -> String {
    if value.trim() != value || value.starts_with('"') || value.chars().any(char::is_control) {
        serde_json::Value::from(value).to_string()
    } else {
        value.to_owned()
    }
}

fn unquoted(value: &str) -> Option<String> {
    if value.starts_with('"') { json::from_text(value).ok() } else { Some(value.to_owned()) }
}
