//! Parquet of any program: columns of numbers and flags, and lists of a fixed length, as LeRobot writes them.
//! Columns of text, of lists that differ in length and of tables are left out.

use super::{Column, Table};
use crate::BadInput;
use crate::recording::check_size;
use crate::recording::parquet::{damaged, guarded, most_rows, opened};
use ::parquet::basic::Type as PhysicalType;
use ::parquet::data_type::{BoolType, DataType, DoubleType, FloatType, Int32Type, Int64Type};
use ::parquet::errors::ParquetError;
use ::parquet::file::reader::{FileReader, SerializedFileReader};
use std::fs::File;

type Check<T> = std::result::Result<T, BadInput>;

/// Records read at a time.
const CHUNK: usize = 4096;
/// Longest list of a row.
const LONGEST: usize = 1000;

pub(super) fn read(source: File) -> Check<Table> {
    let reader = opened(source)?;
    let rows = most_rows(&reader);
    let schema = reader.metadata().file_metadata().schema_descr();
    check_size(schema.num_columns(), rows)?;
    let mut columns = Vec::new();
    for i in 0..schema.num_columns() {
        let column = schema.column(i);
        // A list is called `observation.state.list.element`, or `.list.item`.
        let path = column.path().parts();
        let is_list = column.max_rep_level() == 1 && path.len() == 3;
        if column.max_rep_level() > 1 || (path.len() > 1 && !is_list) {
            continue;
        }
        let Some(rows) = numbers(&reader, i, &path[0])? else { continue };
        if is_list {
            columns.extend(spread(&path[0], &rows));
        } else {
            let values = rows.values.into_iter().map(|value| value.unwrap_or(f64::NAN)).collect();
            columns.push(Column { name: path[0].clone(), values });
        }
    }
    Table::new(columns)
}

/// The values of a column, and where its rows begin.
struct Rows {
    values: Vec<Option<f64>>,
    starts: Vec<usize>,
}

/// `name[1]`, `name[2]`, … of lists of one length; nothing of others.
fn spread(name: &str, rows: &Rows) -> Vec<Column> {
    let ends = rows.starts.iter().skip(1).copied().chain([rows.values.len()]);
    let lengths: Vec<usize> = rows.starts.iter().zip(ends).map(|(start, end)| end - start).collect();
    let width = lengths.first().copied().unwrap_or(0);
    if width > LONGEST || lengths.iter().any(|length| *length != width) {
        return Vec::new();
    }
    let column = |k: usize| Column {
        name: format!("{name}[{}]", k + 1),
        values: rows.starts.iter().map(|start| rows.values[start + k].unwrap_or(f64::NAN)).collect(),
    };
    (0..width).map(column).collect()
}

/// A column of whatever type; `None` if it holds no numbers.
fn numbers(reader: &SerializedFileReader<File>, i: usize, name: &str) -> Check<Option<Rows>> {
    let column = reader.metadata().file_metadata().schema_descr().column(i);
    let pages = || {
        let rows = match column.physical_type() {
            PhysicalType::DOUBLE => read_pages::<DoubleType>(reader, i, name, |x| *x),
            PhysicalType::FLOAT => read_pages::<FloatType>(reader, i, name, |x| f64::from(*x)),
            PhysicalType::INT32 => read_pages::<Int32Type>(reader, i, name, |x| f64::from(*x)),
            PhysicalType::INT64 => read_pages::<Int64Type>(reader, i, name, |x| *x as f64),
            PhysicalType::BOOLEAN => read_pages::<BoolType>(reader, i, name, |x| f64::from(u8::from(*x))),
            _ => return Ok(None),
        };
        rows.map(Some)
    };
    guarded(name, pages)
}

fn read_pages<T: DataType>(
    reader: &SerializedFileReader<File>,
    i: usize,
    name: &str,
    to_f64: impl Fn(&T::T) -> f64,
) -> Check<Rows> {
    let bad = |e: ParquetError| damaged(&e).within(name);
    let column = reader.metadata().file_metadata().schema_descr().column(i);
    let (most_defined, is_list) = (column.max_def_level(), column.max_rep_level() == 1);
    let mut rows = Rows { values: Vec::new(), starts: Vec::new() };
    for group in 0..reader.num_row_groups() {
        let claimed = usize::try_from(reader.metadata().row_group(group).num_rows()).unwrap_or(0);
        let before = rows.starts.len();
        let pages = reader.get_row_group(group).and_then(|group| group.get_column_reader(i)).map_err(bad)?;
        let Some(mut typed) = T::get_column_reader(pages) else {
            return Err(BadInput::new(name, "the type that the schema states", "another"));
        };
        let (mut values, mut defined, mut repeated) = (Vec::new(), Vec::new(), Vec::new());
        loop {
            values.clear();
            defined.clear();
            repeated.clear();
            let levels = (most_defined > 0).then_some(&mut defined);
            let (records, ..) = typed
                .read_records(CHUNK, levels, is_list.then_some(&mut repeated), &mut values)
                .map_err(bad)?;
            if records == 0 {
                break;
            }
            let mut next = values.iter();
            for k in 0..defined.len().max(values.len()) {
                if !is_list || repeated.get(k) == Some(&0) {
                    rows.starts.push(rows.values.len());
                }
                let is_there = defined.get(k).is_none_or(|level| *level == most_defined);
                rows.values.push(if is_there { next.next().map(&to_f64) } else { None });
            }
            if rows.starts.len() - before > claimed || rows.values.len() > LONGEST * rows.starts.len() {
                let more = ParquetError::General(format!("more than the {claimed} rows that it claims"));
                return Err(bad(more));
            }
        }
    }
    check_size(1, rows.values.len() as u64)?;
    Ok(rows)
}
