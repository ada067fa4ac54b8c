//! From the columns of a table to a recording.

use hysteron_base::{BadInput, Channel, Metadata, Recording, Table, units::Unit};

use super::columns::{Columns, Selection};
use super::{BadRows, ImportOptions, Imported, UnitCheck, suspicion};
use crate::Recorded;
use crate::sampling::{STEP_SCATTER, Steps};

type Check<T> = Result<T, BadInput>;

/// Largest part of the rows that may be left out [-].
pub(crate) const MOST_LEFT_OUT: f64 = 0.1;
/// Ends the name of a channel that says where another has a label.
pub(crate) const LABELLED: &str = "labelled_ratio";

/// A channel, and where its numbers stand.
struct Source<'a> {
    /// Name with the SI unit.
    name: String,
    unit: &'static Unit,
    /// Index of the column.
    column: usize,
    selection: &'a Selection,
}

pub(super) fn assemble(
    table: &Table,
    columns: &Columns,
    options: &ImportOptions,
    meta: Metadata,
) -> Check<Imported> {
    let (time, sources) = sources(table, columns)?;
    let times = times(table, columns, time.as_ref())?;
    let (rows, first_left_out) = rows(table, columns, &sources, (&times, time.as_ref()), options.bad_rows)?;
    let n_left_out = table.n_rows() - rows.len();
    let origin = times[rows[0]];
    let time: Vec<f64> = rows.iter().map(|row| times[*row] - origin).collect();
    let mut channels = Vec::new();
    let mut without_values = Vec::new();
    for source in &sources {
        let (values, labelled) = values(table, columns, source, &rows);
        if values.iter().all(|value| value.is_nan()) {
            without_values.push(source.name.clone());
            continue;
        }
        let flags = labelled.map(|flags| Channel::new(labels_of(&source.name), flags));
        channels.push(Channel::new(&source.name, values));
        channels.extend(flags);
    }
    let mut meta = described(meta, columns, options);
    let mut note = |key: &str, value: String| meta.extra.insert(key.to_owned(), value);
    note("imported_as", columns.source.clone());
    note("time_origin_s", origin.to_string());
    if !without_values.is_empty() {
        note("without_values", without_values.join(", "));
    }
    if n_left_out > 0 {
        note("rows_left_out", n_left_out.to_string());
    }
    let recording = at_fixed_rate(Recording::with_missing(time, channels, meta)?, options.rate_hz)?;
    let recorded = Recorded::of(&recording)?;
    check_names(&recorded, options)?;
    if options.unit_check == UnitCheck::Refuse {
        suspicion::check(&recorded, options.model)?;
    }
    Ok(Imported { recording, columns: columns.source.clone(), n_left_out, first_left_out })
}

/// Name of the channel that says where `name` has a label: `force_z_labelled_ratio`.
fn labels_of(name: &str) -> String {
    let stem = Unit::of_name(name).map_or(name, |(stem, _)| stem);
    format!("{stem}_{LABELLED}")
}

/// The column of the times, if there is one, and the channels in the order of the description.
fn sources<'a>(table: &Table, columns: &'a Columns) -> Check<(Option<Source<'a>>, Vec<Source<'a>>)> {
    let (mut time, mut sources) = (None, Vec::new());
    for (key, selection) in &columns.channels {
        let place = format!("columns.{key}");
        let mut indices = Vec::new();
        for name in &selection.columns {
            let found = name.indices(table);
            if found.is_empty() {
                return Err(BadInput::new(place, name.to_string(), table.names())
                    .hint("columns count from 1; * stands for the number of the joint"));
            }
            indices.extend(found);
        }
        let has_star = key.contains('*');
        if !has_star && indices.len() != 1 {
            let expected = "one column, or a * in the name for the number of the joint";
            return Err(BadInput::new(place, expected, format!("{} columns", indices.len())));
        }
        for (k, column) in indices.into_iter().enumerate() {
            let typed = key.replace('*', &(k + 1).to_string());
            let Some((stem, unit)) = Unit::of_name(&typed) else {
                return Err(BadInput::new(place, "a name that ends in its unit", format!("`{key}`"))
                    .hint("as q_*_rad, q_*_deg, current_*_ma or force_x_n"));
            };
            let source = Source { name: format!("{stem}_{}", unit.si_suffix), unit, column, selection };
            if source.name == "time_s" {
                time = Some(source);
            } else {
                sources.push(source);
            }
        }
    }
    if sources.is_empty() {
        return Err(BadInput::new("columns", "a channel besides the time", "none"));
    }
    Ok((time, sources))
}

/// Time of every row [s]; NaN where there is none.
fn times(table: &Table, columns: &Columns, time: Option<&Source>) -> Check<Vec<f64>> {
    match (time, columns.rate_hz) {
        (Some(source), _) => {
            let cells = &table.columns()[source.column].values;
            Ok(cells.iter().map(|cell| source.unit.to_si(source.selection.value(*cell))).collect())
        }
        (None, Some(rate)) => Ok((0..table.n_rows()).map(|row| row as f64 / rate).collect()),
        (None, None) => Err(BadInput::new("columns", "a column time_s, or rate_hz", "neither")
            .hint("rate_hz = 100.0 above [columns] for rows at a fixed rate")),
    }
}

/// The rows that are taken, and what is wrong with the first that is not.
fn rows(
    table: &Table,
    columns: &Columns,
    sources: &[Source],
    (times, time): (&[f64], Option<&Source>),
    bad_rows: BadRows,
) -> Check<(Vec<usize>, Option<BadInput>)> {
    let mut flaws: Vec<Option<BadInput>> = vec![None; table.n_rows()];
    for (row, n) in table.uneven() {
        let expected = format!("{} cells, as the first row has", table.columns().len());
        flaws[*row] = Some(BadInput::new("", expected, n.to_string()));
    }
    for (row, found) in flaws.iter_mut().enumerate().filter(|(_, found)| found.is_none()) {
        *found = sources.iter().chain(time).find_map(|source| flaw(table, columns, source, row));
    }
    let whole: Vec<usize> = (0..table.n_rows()).filter(|row| flaws[*row].is_none()).collect();
    if bad_rows == BadRows::LeaveOut {
        let kept = longest_ascent(&whole, times);
        let mut is_kept = vec![false; table.n_rows()];
        kept.iter().for_each(|row| is_kept[*row] = true);
        for row in whole.iter().filter(|row| !is_kept[**row]) {
            flaws[*row] =
                Some(BadInput::new("time", "one between those around it", format!("{} s", times[*row])));
        }
    } else {
        for pair in whole.windows(2).filter(|pair| times[pair[1]] <= times[pair[0]]) {
            let (before, found) = (times[pair[0]], times[pair[1]]);
            flaws[pair[1]] =
                Some(BadInput::new("time", format!("one after {before} s"), format!("{found} s")));
        }
    }
    let rows: Vec<usize> = (0..table.n_rows()).filter(|row| flaws[*row].is_none()).collect();
    let n_left_out = table.n_rows() - rows.len();
    let first =
        flaws.into_iter().enumerate().find_map(|(row, found)| Some(found?.within(table.row_name(row))));
    match first {
        Some(flaw) if bad_rows == BadRows::Refuse => Err(flaw.hint(hint(table))),
        Some(flaw) if rows.is_empty() || n_left_out as f64 > MOST_LEFT_OUT * table.n_rows() as f64 => {
            let expected = format!("at most {:.0} % of rows that cannot be read", 100.0 * MOST_LEFT_OUT);
            let found = format!("{n_left_out} of {}; the first: {flaw}", table.n_rows());
            Err(BadInput::new("rows", expected, found))
        }
        first => Ok((rows, first)),
    }
}

/// The most rows whose times ascend strictly: one wild time costs its own row and no other.
fn longest_ascent(rows: &[usize], times: &[f64]) -> Vec<usize> {
    // Ends of the ascents of every length that end earliest, and what comes before each row in its ascent.
    let mut ends: Vec<usize> = Vec::new();
    let mut before: Vec<Option<usize>> = vec![None; rows.len()];
    for (k, row) in rows.iter().enumerate() {
        let length = ends.partition_point(|end| times[rows[*end]] < times[*row]);
        before[k] = length.checked_sub(1).map(|shorter| ends[shorter]);
        if length == ends.len() {
            ends.push(k);
        } else if times[*row] < times[rows[ends[length]]] {
            ends[length] = k;
        }
    }
    let mut kept: Vec<usize> =
        std::iter::successors(ends.last().copied(), |k| before[*k]).map(|k| rows[k]).collect();
    kept.reverse();
    kept
}

fn hint(table: &Table) -> &'static str {
    match table.index("episode_index") {
        Some(_) => "--where episode_index=0 takes one episode of several",
        None => "--leave-out-bad-rows takes the other rows, and marks the gap",
    }
}

/// What is wrong with a cell.
fn flaw(table: &Table, columns: &Columns, source: &Source, row: usize) -> Option<BadInput> {
    let column = &table.columns()[source.column];
    let cell = column.values[row];
    let is_known = cell.is_finite() || columns.missing.contains(&cell);
    let value = source.unit.to_si(source.selection.value(cell));
    (!is_known || !value.is_finite())
        .then(|| BadInput::new(&column.name, "a finite number", table.shown(source.column, row)))
}

/// The values of a channel in SI, NaN where they are missing; and where it has a label, if it may have none.
fn values(table: &Table, columns: &Columns, source: &Source, rows: &[usize]) -> (Vec<f64>, Option<Vec<f64>>) {
    let cells = &table.columns()[source.column].values;
    let selection = source.selection;
    let is_unlabelled = |row: usize| selection.unlabelled.is_some_and(|code| code == cells[row]);
    let has_label = rows.iter().any(|row| !is_unlabelled(*row));
    let value = |row: &usize| match cells[*row] {
        cell if columns.missing.contains(&cell) => f64::NAN,
        _ if is_unlabelled(*row) => {
            if has_label {
                0.0
            } else {
                f64::NAN
            }
        }
        cell => source.unit.to_si(selection.value(cell)),
    };
    let flags = || rows.iter().map(|row| f64::from(u8::from(!is_unlabelled(*row)))).collect();
    (rows.iter().map(value).collect(), selection.unlabelled.filter(|_| has_label).map(|_| flags()))
}

/// Who and what was recorded.
fn described(mut meta: Metadata, columns: &Columns, options: &ImportOptions) -> Metadata {
    let robot = options.model.map(|model| model.name().to_owned()).or_else(|| columns.robot.clone());
    let of_model = |model: &crate::Model| model.joints().iter().map(|joint| joint.name.clone()).collect();
    let names: Option<Vec<String>> = options.model.map(of_model).or_else(|| columns.joint_names.clone());
    meta.extra.extend(robot.map(|robot| ("robot".to_owned(), robot)));
    meta.extra.extend(names.map(|names| ("joint_names".to_owned(), names.join(", "))));
    meta
}

/// The recording as it is where it has a fixed rate and no other is asked for, else resampled.
fn at_fixed_rate(recording: Recording, rate_hz: Option<f64>) -> Check<Recording> {
    let own = recording.rate_hz();
    let Some(steps) = Steps::of(recording.time()) else { return Ok(recording) };
    let rate = match rate_hz {
        Some(rate) if own.is_some_and(|own| (own - rate).abs() <= 1e-9 * rate) => return Ok(recording),
        Some(rate) => rate,
        None if own.is_some() => return Ok(recording),
        None => usual_rate(&steps),
    };
    let resampled = recording.resampled(rate)?;
    // Between a label and none there is none.
    let whole = |channel: &Channel| match channel.name.ends_with(LABELLED) {
        true => Channel::new(&channel.name, channel.values.iter().map(|flag| flag.floor()).collect()),
        false => channel.clone(),
    };
    let channels = resampled.channels().iter().map(whole).collect();
    let mut meta = resampled.meta().clone();
    meta.extra.insert("resampled_hz".to_owned(), rate.to_string());
    meta.extra.insert(STEP_SCATTER.to_owned(), format!("{:.4}", steps.scatter()));
    Recording::new(resampled.time().to_vec(), channels, resampled.gap().to_vec(), meta)
}

/// The rate of the median step, to four digits [Hz].
fn usual_rate(steps: &Steps) -> f64 {
    let rate = 1.0 / steps.median();
    format!("{rate:.3e}").parse().unwrap_or(rate)
}

/// As many names as joints.
fn check_names(recorded: &Recorded, options: &ImportOptions) -> Check<()> {
    let n = recorded.joints.len();
    let (expected, whose) = match (options.model, recorded.joint_names.len()) {
        (Some(model), _) => (model.n_joints(), format!("\"{}\" has", model.name())),
        (None, 0) => return Ok(()),
        (None, names) => (names, "joint_names says".to_owned()),
    };
    if n == expected {
        return Ok(());
    }
    Err(BadInput::new("joints", format!("{expected}, as {whose}"), n.to_string()))
}
