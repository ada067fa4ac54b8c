//! Outlines as CSV: columns `x_mm,y_mm` or `x_m,y_m`, and z where the outline leaves the plane; the only module of
//! this crate that knows the `csv` crate.

use super::outline::{MAX_CROSSING_POINTS, OutlinePoint};
use hysteron_base::BadInput;
use hysteron_base::size::check_at_most;
use hysteron_base::units::Unit;

/// The points [m] in the text of a file, and whether they have a z.
pub(super) fn read(text: &str) -> Result<(Vec<OutlinePoint>, bool), BadInput> {
    let text = text.trim_start_matches('\u{feff}'); // spreadsheets put it there
    let mut reader =
        ::csv::ReaderBuilder::new().comment(Some(b'#')).trim(::csv::Trim::All).from_reader(text.as_bytes());
    let header = reader.headers().map_err(|error| bad_csv(&error))?.clone();
    let columns = columns(&header)?;
    let mut points = Vec::new();
    let mut row = ::csv::StringRecord::new();
    while reader.read_record(&mut row).map_err(|error| bad_csv(&error))? {
        let line = row.position().map_or(0, ::csv::Position::line);
        let mut point = [0.0; 3];
        for (cell, (c, unit)) in row.iter().zip(&columns) {
            let number = unit.parse_si(cell).filter(|number| number.is_finite());
            point[*c] = number.ok_or_else(|| {
                BadInput::new(format!("line {line}"), "a finite number", format!("\"{cell}\""))
            })?;
        }
        points.push(point);
        check_at_most("points", points.len(), MAX_CROSSING_POINTS)?;
    }
    Ok((points, columns.len() == 3))
}

/// Which coordinate a column is, and its unit.
fn columns(header: &::csv::StringRecord) -> Result<Vec<(usize, &'static Unit)>, BadInput> {
    let bad = || {
        let found = header.iter().collect::<Vec<_>>().join(",");
        let found = if found.trim().is_empty() { "nothing" } else { &found };
        BadInput::new("header", "x, y and perhaps z with their unit, as in x_mm,y_mm", found)
            .hint("_mm or _m is the unit; a recording has a column time_s")
    };
    let mut columns: Vec<(usize, &Unit)> = Vec::new();
    for name in header {
        let (stem, unit) = Unit::of_name(name).filter(|(_, unit)| unit.si_suffix == "m").ok_or_else(bad)?;
        let stem = stem.strip_prefix("tip_").unwrap_or(stem);
        let c = ["x", "y", "z"].iter().position(|known| *known == stem).ok_or_else(bad)?;
        if columns.iter().any(|(earlier, _)| *earlier == c) {
            return Err(bad());
        }
        columns.push((c, unit));
    }
    let has = |c: usize| columns.iter().any(|(own, _)| *own == c);
    if has(0) && has(1) { Ok(columns) } else { Err(bad()) }
}

fn bad_csv(error: &::csv::Error) -> BadInput {
    let line = error.position().map_or(1, ::csv::Position::line);
    BadInput::new(format!("line {line}"), "CSV", error.to_string())
}
