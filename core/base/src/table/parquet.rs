//! Parquet of any program: columns of numbers, flags, times and text, and lists of a fixed length, as LeRobot writes them.
//! Columns of lists that differ in length, of bytes and of tables are left out, and named.

use super::{Column, Table};
use crate::BadInput;
use crate::recording::parquet::{durations, most_rows, opened};
use crate::recording::parquet_column::{self, ColumnValues, MAX_LIST};
use crate::recording::{ColumnMemory, check_room};
use ::parquet::file::reader::FileReader;
use std::fs::File;

type Check<T> = std::result::Result<T, BadInput>;

pub(super) fn read(source: File) -> Check<Table> {
    let reader = opened(source)?;
    let schema = reader.metadata().file_metadata().schema_descr();
    check_room(schema.num_columns(), most_rows(&reader), ColumnMemory::Grown)?;
    let durations = durations(&reader);
    let mut table = Table::default();
    for i in 0..schema.num_columns() {
        let column = schema.column(i);
        let path = column.path().parts();
        // A list is called `observation.state.list.element`, or `.list.item`; a part of a table `pose.x`.
        let name = if column.max_rep_level() == 1 { path[0].clone() } else { path.join(".") };
        if column.max_rep_level() > 1 {
            table.left_out.push((name, "lists of lists"));
            continue;
        }
        match parquet_column::read(&reader, i, (&name, &durations))? {
            None => table.left_out.push((name, "bytes")),
            Some(values) if column.max_rep_level() == 1 => match spread(&values) {
                Some(lists) => table.add_lists(&name, lists),
                None => table.left_out.push((name, "lists that differ in length")),
            },
            Some(values) => table.add(name, values),
        }
    }
    let left_out = std::mem::take(&mut table.left_out);
    let (words, clocks, seconds) = (table.words, table.clocks, table.seconds);
    Ok(Table { words, clocks, seconds, left_out, ..Table::new(table.columns)? })
}

/// The elements of lists of one length (n_elements × n_rows); `None` of others. A row without a list has no numbers.
fn spread(values: &ColumnValues) -> Option<Vec<Vec<f64>>> {
    let ends = values.starts.iter().skip(1).copied().chain([values.numbers.len()]);
    let rows: Vec<&[f64]> =
        values.starts.iter().zip(ends).map(|(start, end)| &values.numbers[*start..end]).collect();
    let width = rows.iter().map(|row| row.len()).max()?;
    let is_absent = |row: &[f64]| row.len() == 1 && row[0].is_nan();
    let are_even = rows.iter().all(|row| row.len() == width || is_absent(row));
    let element = |k: usize| rows.iter().map(|row| row.get(k).copied().unwrap_or(f64::NAN)).collect();
    (width <= MAX_LIST && are_even && values.text.is_none()).then(|| (0..width).map(element).collect())
}

impl Table {
    fn add(&mut self, name: String, values: ColumnValues) {
        let k = self.columns.len();
        if let Some(text) = values.text {
            return self.add_text(k, name, text);
        }
        self.seconds.extend(values.are_seconds.then_some(k));
        self.clocks.extend(values.origin.map(|origin| (k, origin as f64)));
        self.columns.push(Column { name, values: values.numbers });
    }

    fn add_lists(&mut self, name: &str, lists: Vec<Vec<f64>>) {
        let column = |(k, values)| Column { name: format!("{name}[{}]", k + 1), values };
        self.columns.extend(lists.into_iter().enumerate().map(column));
    }
}
