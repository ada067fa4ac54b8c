//! Further files, and columns with a clock of their own, come to the rows of the first file: by a key that both have, or by time.

use super::columns::ColumnMap;
use crate::statistics::nearest_quantile;
use crate::{BadInput, Table, units::Unit};
use std::collections::HashMap;

type Check<T> = Result<T, BadInput>;

/// Neighbours further apart than this many usual steps have nothing between them [-].
const WIDEST: f64 = 1.5;

/// Samples of a clock of their own: ascending times, and their place.
struct Clock {
    times: Vec<f64>,
    rows: Vec<usize>,
    /// The median step [s].
    step: f64,
}

impl Clock {
    fn of(table: &Table, column: usize, unit: &Unit, shift: f64) -> Check<Self> {
        let (mut times, mut rows) = (Vec::new(), Vec::new());
        for (row, value) in table.columns()[column].values.iter().enumerate().filter(|(_, t)| t.is_finite()) {
            let time = shift + if table.is_in_seconds(column) { *value } else { unit.to_si(*value) };
            if let Some(before) = times.last().filter(|before| time <= **before) {
                let place = format!("{}: {}", table.row_name(row), table.columns()[column].name);
                return Err(BadInput::new(place, format!("a time after {before} s"), format!("{time} s"))
                    .hint("the times of a stream ascend; sort the file by them"));
            }
            times.push(time);
            rows.push(row);
        }
        let mut steps: Vec<f64> = times.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let Some(step) = nearest_quantile(&mut steps, 0.5) else {
            let place = table.columns()[column].name.clone();
            return Err(BadInput::new(place, "at least two times", times.len().to_string()));
        };
        Ok(Self { times, rows, step })
    }

    /// The values at other times, NaN where there are none.
    fn at(&self, times: &[f64], values: &[f64], (hold, step): (bool, f64)) -> Vec<f64> {
        let value = |t: &f64| {
            let next = self.times.partition_point(|time| time <= t);
            let Some(before) = next.checked_sub(1) else { return f64::NAN };
            let (t0, v0) = (self.times[before], values[self.rows[before]]);
            if hold || t0 == *t {
                return v0;
            }
            let Some(t1) = self.times.get(next) else { return f64::NAN };
            if t1 - t0 > WIDEST * self.step.max(step) {
                return f64::NAN;
            }
            let part = (t - t0) / (t1 - t0);
            v0 * (1.0 - part) + values[self.rows[next]] * part
        };
        times.iter().map(value).collect()
    }
}

/// The times of the rows of the first file [s], their unit, and the second that they count from.
fn times(table: &Table, columns: &ColumnMap) -> Check<(Vec<f64>, &'static Unit, f64)> {
    let found = columns.time().and_then(|(unit, selection)| {
        let indices: Vec<usize> = selection.columns.iter().flat_map(|name| name.indices(table)).collect();
        let [column] = indices[..] else { return None };
        let si = |value: &f64| {
            if table.is_in_seconds(column) { *value } else { unit.to_si(selection.value(*value)) }
        };
        let times = table.columns()[column].values.iter().map(si).collect();
        Some((times, unit, table.clock(column).unwrap_or(0.0)))
    });
    found.ok_or_else(|| {
        BadInput::new("join", "a column time_s in the map, or a key to join by", "neither")
            .hint("[join] by = \"ID\" joins rows with equal values of a column ID")
    })
}

fn step_of(times: &[f64]) -> f64 {
    let mut steps: Vec<f64> =
        times.windows(2).map(|pair| pair[1] - pair[0]).filter(|step| *step > 0.0).collect();
    nearest_quantile(&mut steps, 0.5).unwrap_or(0.0)
}

/// The first table with the columns of the others; one that it has already is called `2.name`, `3.name`, ….
///
/// # Errors
/// `BadInput` naming the file and column.
pub(super) fn joined(table: Table, others: &[(String, Table)], columns: &ColumnMap) -> Check<Table> {
    let join = &columns.join;
    let mut all = table;
    for (k, (place, other)) in others.iter().enumerate() {
        let within = |bad: BadInput| bad.within(place);
        let (skipped, values): (usize, Vec<Vec<f64>>) = match &join.by {
            Some(by) => {
                let (key, rows) = rows_by_key(&all, other, by).map_err(within)?;
                let pick =
                    |values: &[f64]| rows.iter().map(|row| row.map_or(f64::NAN, |row| values[row])).collect();
                (key, other.columns().iter().map(|column| pick(&column.values)).collect())
            }
            None => {
                let (times, unit, origin) = times(&all, columns)?;
                let named = join.time.clone().or_else(|| name_of_time(&all, columns));
                let name = named.unwrap_or_default();
                let Some(column) = other.index(&name) else {
                    let bad = BadInput::new("join", format!("a column \"{name}\" of times"), other.names());
                    return Err(within(
                        bad.hint("[join] time = \"NAME\" names it, by = \"NAME\" joins by a key"),
                    ));
                };
                let shift = join.offset_s + other.clock(column).unwrap_or(0.0) - origin;
                let clock = Clock::of(other, column, unit, shift).map_err(within)?;
                let how = (join.hold, step_of(&times));
                (column, other.columns().iter().map(|column| clock.at(&times, &column.values, how)).collect())
            }
        };
        for (c, (column, values)) in other.columns().iter().zip(values).enumerate() {
            if c != skipped {
                let is_taken = all.index(&column.name).is_some();
                let name = if is_taken { format!("{}.{}", k + 2, column.name) } else { column.name.clone() };
                all.add_with_gaps(name, values);
            }
        }
    }
    Ok(all)
}

fn name_of_time(table: &Table, columns: &ColumnMap) -> Option<String> {
    let (_, selection) = columns.time()?;
    let column = selection.columns.iter().flat_map(|name| name.indices(table)).next()?;
    Some(table.columns()[column].name.clone())
}

/// The key's column in the other table, and its row for each row of the first.
fn rows_by_key(table: &Table, other: &Table, by: &str) -> Check<(usize, Vec<Option<usize>>)> {
    let missing =
        |table: &Table| BadInput::new("join", format!("a column \"{by}\" to join by"), table.names());
    let here = table.index(by).ok_or_else(|| missing(table))?;
    let there = other.index(by).ok_or_else(|| missing(other))?;
    let key = |table: &Table, column: usize, row: usize| match table.word(column, row) {
        Some(word) => word.to_owned(),
        None => table.columns()[column].values[row].to_string(),
    };
    let mut index = HashMap::new();
    for row in 0..other.n_rows() {
        let key = key(other, there, row);
        if let Some(before) = index.insert(key.clone(), row) {
            let found = format!("it in {} and {}", other.row_name(before), other.row_name(row));
            return Err(BadInput::new(format!("join: {by}"), format!("{key} once"), found));
        }
    }
    let rows: Vec<Option<usize>> =
        (0..table.n_rows()).map(|row| index.get(&key(table, here, row)).copied()).collect();
    if rows.iter().all(Option::is_none) {
        return Err(BadInput::new(format!("join: {by}"), "values that both files have", "none"));
    }
    Ok((there, rows))
}

/// Columns with a clock of their own, at the times of the rows.
///
/// # Errors
/// `BadInput` naming the column.
pub(super) fn with_streams(table: Table, columns: &ColumnMap) -> Check<Table> {
    let mut table = table;
    for stream in &columns.streams {
        let (times, unit, origin) = times(&table, columns)?;
        let find = |name: &String| {
            table
                .index(name)
                .ok_or_else(|| BadInput::new("streams", format!("a column \"{name}\""), table.names()))
        };
        let own = find(&stream.time)?;
        let clock = Clock::of(&table, own, unit, stream.offset_s + table.clock(own).unwrap_or(0.0) - origin)?;
        let indices = stream.columns.iter().map(find).collect::<Check<Vec<_>>>()?;
        let how = (stream.hold, step_of(&times));
        for k in indices {
            let values = clock.at(&times, &table.columns()[k].values, how);
            table.replace_with_gaps(k, values);
        }
    }
    Ok(table)
}
