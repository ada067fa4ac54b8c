//! From the columns of a table to a recording.

use super::columns::{ColumnMap, Selection, Zero};
use super::{Assembled, BadRows, Request};
use crate::recording::names::is_unitless;
use crate::sampling::{STEP_SCATTER, SampleSteps};
use crate::{BadInput, Channel, Metadata, Recording, Table, units::Unit};

type Check<T> = Result<T, BadInput>;

/// Largest part of the rows that may be left out [-].
pub const MAX_LEFT_OUT: f64 = 0.1;
/// Ends the name of a channel that marks the labelled rows of another.
pub const LABELLED: &str = "labelled_ratio";

/// A channel, and the place of its numbers.
struct ChannelSource<'a> {
    /// Name with the SI unit.
    name: String,
    unit: &'static Unit,
    /// Index of the column.
    column: usize,
    selection: &'a Selection,
}

pub(super) fn assemble(
    table: &Table,
    columns: &ColumnMap,
    request: &Request,
    meta: Metadata,
) -> Check<Assembled> {
    let (time, sources) = sources(table, columns)?;
    let times = times(table, columns, &time)?;
    let clock: f64 = time.iter().filter_map(|source| table.clock(source.column)).sum();
    let (rows, first_left_out) = rows(table, columns, &sources, (&times, &time), request.bad_rows)?;
    let n_left_out = table.n_rows() - rows.len();
    let origin = times[rows[0]];
    let times: Vec<f64> = rows.iter().map(|row| times[*row] - origin).collect();
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
    channels
        .extend(columns.constants.iter().map(|(name, value)| Channel::new(name, vec![*value; rows.len()])));
    if let Some(tracker) = &columns.tracker {
        tracker.apply(&mut channels)?;
    }
    let mut meta = described(meta, columns);
    let mut note = |key: &str, value: String| meta.extra.insert(key.to_owned(), value);
    note("imported_as", columns.source.clone());
    note("time_origin_s", (clock + origin).to_string());
    if !without_values.is_empty() {
        note("without_values", without_values.join(", "));
    }
    if n_left_out > 0 {
        note("rows_left_out", n_left_out.to_string());
    }
    let recording = Recording::with_missing(times, channels, meta)?;
    let recording = match columns.keep_times && request.rate_hz.is_none() {
        true => recording,
        false => at_fixed_rate(recording, request.rate_hz)?,
    };
    Ok(Assembled { recording, columns: columns.source.clone(), episode: None, n_left_out, first_left_out })
}

/// Name of the channel that marks the labelled rows of `name`: `force_z_labelled_ratio`.
fn labels_of(name: &str) -> String {
    let stem = Unit::of_name(name).map_or(name, |(stem, _)| stem);
    format!("{stem}_{LABELLED}")
}

/// The columns of the times, if there are any (a date and a time of day are two), and the channels in the order of the map.
fn sources<'a>(
    table: &Table,
    columns: &'a ColumnMap,
) -> Check<(Vec<ChannelSource<'a>>, Vec<ChannelSource<'a>>)> {
    let (mut time, mut sources) = (Vec::new(), Vec::new());
    for (key, selection) in &columns.channels {
        let place = format!("columns.{key}");
        let mut indices = Vec::new();
        for name in &selection.columns {
            let found = name.indices(table);
            if found.is_empty() {
                return Err(BadInput::new(place, name.to_string(), table.names())
                    .hint("columns count from 1; * is the number of the joint"));
            }
            indices.extend(found);
        }
        let has_star = key.contains('*');
        let is_time = matches!(Unit::of_name(key), Some(("time", unit)) if unit.si_suffix == "s");
        if !has_star && indices.len() != 1 && !(is_time && indices.len() == 2) {
            let expected = "one column, or a * in the name for the number of the joint";
            return Err(BadInput::new(place, expected, format!("{} columns", indices.len())));
        }
        for (k, column) in indices.into_iter().enumerate() {
            let typed = key.replace('*', &(k + 1).to_string());
            let Some((name, unit)) = channel(&typed) else {
                return Err(BadInput::new(place, "a name that ends in its unit", format!("`{key}`"))
                    .hint("as q_*_rad, q_*_deg, current_*_ma or force_x_n"));
            };
            let source = ChannelSource { name, unit, column, selection };
            if source.name == "time_s" {
                time.push(source);
            } else {
                sources.push(source);
            }
        }
    }
    if sources.is_empty() {
        return Err(BadInput::new("columns", "a channel in addition to the time", "none"));
    }
    Ok((time, sources))
}

/// The channel of a name, and its unit: plain numbers of the names that have none, as `tip_qw` and `load_1`.
fn channel(typed: &str) -> Option<(String, &'static Unit)> {
    if is_unitless(typed) {
        return Some((typed.to_owned(), Unit::of_name("plain_ratio")?.1));
    }
    Unit::of_name(typed).map(|(stem, unit)| (format!("{stem}_{}", unit.si_suffix), unit))
}

/// Time of every row after the clocks of its columns [s]; NaN where there is none.
fn times(table: &Table, columns: &ColumnMap, time: &[ChannelSource]) -> Check<Vec<f64>> {
    match (time, columns.rate_hz) {
        ([], Some(rate)) => Ok((0..table.n_rows()).map(|row| row as f64 / rate).collect()),
        ([], None) => Err(BadInput::new("columns", "a column time_s, or rate_hz", "neither")
            .hint("rate_hz = 100.0 above [columns] for rows at a fixed rate")),
        _ => {
            let time_of = |row| time.iter().map(|source| source.si(table, row)).sum();
            Ok((0..table.n_rows()).map(time_of).collect())
        }
    }
}

impl ChannelSource<'_> {
    /// The number of a row in SI.
    fn si(&self, table: &Table, row: usize) -> f64 {
        let value = self.selection.value(table.columns()[self.column].values[row]);
        let is_si = self.unit.si_suffix == "s" && table.is_in_seconds(self.column);
        if is_si { value } else { self.unit.to_si(value) }
    }
}

/// The rows that are taken, and what is wrong with the first that is not.
fn rows(
    table: &Table,
    columns: &ColumnMap,
    sources: &[ChannelSource],
    (times, time): (&[f64], &[ChannelSource]),
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
            flaws[*row] = Some(BadInput::new(
                "time",
                "one between those around it",
                format!("{} s", crate::number::shown(times[*row])),
            ));
        }
    } else {
        for pair in whole.windows(2).filter(|pair| times[pair[1]] <= times[pair[0]]) {
            let (before, found) = (times[pair[0]], times[pair[1]]);
            let before = format!("one after {before} s of {}", table.row_name(pair[0]));
            flaws[pair[1]] = Some(BadInput::new("time", before, format!("{found} s")));
        }
    }
    let rows: Vec<usize> = (0..table.n_rows()).filter(|row| flaws[*row].is_none()).collect();
    let n_left_out = table.n_rows() - rows.len();
    let first =
        flaws.into_iter().enumerate().find_map(|(row, found)| Some(found?.within(table.row_name(row))));
    match first {
        Some(flaw) if bad_rows == BadRows::Refuse => Err(flaw.hint(hint(table, n_left_out))),
        Some(flaw) if rows.is_empty() || n_left_out as f64 > MAX_LEFT_OUT * table.n_rows() as f64 => {
            let expected = format!("at most {:.0} % of rows that cannot be read", 100.0 * MAX_LEFT_OUT);
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

/// Hint where `n_bad` rows cannot be read.
fn hint(table: &Table, n_bad: usize) -> &'static str {
    let is_split = |column: usize| {
        let values = &table.columns()[column].values;
        values.iter().any(|value| *value != values[0])
    };
    if table.index("episode_index").is_some_and(is_split) {
        return "--where episode_index=0 takes one episode of several";
    }
    if n_bad as f64 > MAX_LEFT_OUT * table.n_rows() as f64 {
        return "so many rows are not numbers that their format or their columns are others than stated";
    }
    "--leave-out-bad-rows takes the other rows, and marks the gap"
}

/// Error in a cell; `None` where its value is a finite number or a gap.
fn flaw(table: &Table, columns: &ColumnMap, source: &ChannelSource, row: usize) -> Option<BadInput> {
    let column = &table.columns()[source.column];
    let cell = column.values[row];
    let is_gap = columns.missing.contains(&cell) || (cell.is_nan() && table.has_gaps(source.column));
    (!is_gap && !source.si(table, row).is_finite())
        .then(|| BadInput::new(&column.name, "a finite number", table.shown(source.column, row)))
}

/// The values of a channel in SI, NaN where they are missing; and where it has a label, if it may have none.
fn values(
    table: &Table,
    columns: &ColumnMap,
    source: &ChannelSource,
    rows: &[usize],
) -> (Vec<f64>, Option<Vec<f64>>) {
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
        _ => source.si(table, *row),
    };
    let flags = || rows.iter().map(|row| f64::from(u8::from(!is_unlabelled(*row)))).collect();
    let mut values: Vec<f64> = rows.iter().map(value).collect();
    if selection.zero == Some(Zero::First)
        && let Some(first) = values.iter().copied().find(|value| !value.is_nan())
    {
        values.iter_mut().for_each(|value| *value -= first);
    }
    (values, selection.unlabelled.filter(|_| has_label).map(|_| flags()))
}

/// Metadata with the robot and the names of its joints, where the caller did not give them.
fn described(mut meta: Metadata, columns: &ColumnMap) -> Metadata {
    let mut note = |key: &str, value: Option<String>| {
        if let Some(value) = value {
            meta.extra.entry(key.to_owned()).or_insert(value);
        }
    };
    note("robot", columns.robot.clone());
    note("joint_names", columns.joint_names.as_ref().map(|names| names.join(", ")));
    meta
}

/// The recording as it is where it has a fixed rate and no other is asked for, else resampled.
fn at_fixed_rate(recording: Recording, rate_hz: Option<f64>) -> Check<Recording> {
    let own = recording.rate_hz();
    let Some(steps) = SampleSteps::of(recording.time()) else { return Ok(recording) };
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
fn usual_rate(steps: &SampleSteps) -> f64 {
    let rate = 1.0 / steps.median();
    format!("{rate:.3e}").parse().unwrap_or(rate)
}
