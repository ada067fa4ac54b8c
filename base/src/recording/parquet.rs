//! Recordings as Parquet, for programs; with `table/parquet.rs` the only module that knows the `parquet` crate.
//!
//! One required `DOUBLE` column per series and a `BOOLEAN` column `gap`, one row group, Snappy, metadata as
//! key-value pairs: what pyarrow, and pandas through it, read as they find it. Nothing in the file depends on the
//! machine or the time. Tables of other programs are read as CSV is: any known unit, any type of number, no metadata.

use super::names::Column;
use super::{Check, FORMAT, Metadata, Recording, check_size, metadata, names, not_finite, pages};
use crate::BadInput;
use crate::panics::caught;
use crate::units::Unit;
use ::parquet::basic::{Compression, ConvertedType, Repetition, Type as PhysicalType};
use ::parquet::data_type::{BoolType, DataType, DoubleType, FloatType, Int32Type, Int64Type};
use ::parquet::errors::ParquetError;
use ::parquet::file::metadata::KeyValue;
use ::parquet::file::properties::WriterProperties;
use ::parquet::file::reader::{FileReader, SerializedFileReader};
use ::parquet::file::writer::SerializedFileWriter;
use ::parquet::schema::types::Type;
use std::fs::File;
use std::sync::Arc;

/// Rows read at a time; memory then follows what is in the file, not what its header claims.
const CHUNK: usize = 8192;

pub(super) fn to_bytes(recording: &Recording) -> std::io::Result<Vec<u8>> {
    encode(recording).map_err(std::io::Error::other)
}

fn encode(recording: &Recording) -> Result<Vec<u8>, ParquetError> {
    let column = |name: &str, kind| {
        let builder = Type::primitive_type_builder(name, kind).with_repetition(Repetition::REQUIRED);
        builder.build().map(Arc::new)
    };
    let mut columns = vec![column("time_s", PhysicalType::DOUBLE)?];
    for channel in &recording.channels {
        columns.push(column(&channel.name, PhysicalType::DOUBLE)?);
    }
    columns.push(column("gap", PhysicalType::BOOLEAN)?);
    let schema = Arc::new(Type::group_type_builder("recording").with_fields(columns).build()?);
    let pairs = recording.meta.to_pairs().into_iter().map(|(key, value)| KeyValue::new(key, value)).collect();
    let properties = WriterProperties::builder()
        .set_compression(Compression::SNAPPY)
        .set_dictionary_enabled(false) // measured values hardly repeat
        .set_created_by("hysteron".to_owned())
        .set_key_value_metadata(Some(pairs))
        .build();

    let mut writer = SerializedFileWriter::new(Vec::new(), schema, Arc::new(properties))?;
    let mut group = writer.next_row_group()?;
    let series = std::iter::once(&recording.time).chain(recording.channels.iter().map(|c| &c.values));
    for values in series {
        if let Some(mut column) = group.next_column()? {
            column.typed::<DoubleType>().write_batch(values, None, None)?;
            column.close()?;
        }
    }
    if let Some(mut column) = group.next_column()? {
        column.typed::<BoolType>().write_batch(&recording.gap, None, None)?;
        column.close()?;
    }
    group.close()?;
    writer.into_inner()
}

pub(super) fn read(source: File) -> Check<Recording> {
    let reader = opened(source)?;
    let meta = provenance(&reader)?;
    let schema = reader.metadata().file_metadata().schema_descr();
    check_size(schema.num_columns(), most_rows(&reader))?;
    let table: Vec<String> = schema.columns().iter().map(|column| column.path().string()).collect();
    let (columns, mut channels) = names::columns(&table.iter().map(String::as_str).collect::<Vec<_>>())
        .map_err(|bad| if bad.place.is_empty() { bad.within("columns") } else { bad })?;
    let (mut time, mut gap) = (Vec::new(), Vec::new());
    for (i, (column, name)) in columns.iter().zip(&table).enumerate() {
        let si = |unit: &Unit, values: Vec<f64>| values.into_iter().map(|value| unit.to_si(value)).collect();
        match column {
            Column::Gap => gap = read_flags(&reader, i, name)?,
            Column::Time(unit) => time = si(unit, read_numbers(&reader, i, name)?),
            Column::Channel(k, Some(unit)) => channels[*k].values = si(unit, read_numbers(&reader, i, name)?),
            Column::Channel(k, None) => channels[*k].values = read_numbers(&reader, i, name)?,
        }
    }
    Recording::new(time, channels, gap, meta)
}

pub(super) fn read_metadata(source: File) -> Check<Metadata> {
    provenance(&opened(source)?)
}

/// The rows that a file claims, or a group of it if that is more.
pub(crate) fn most_rows(reader: &SerializedFileReader<File>) -> u64 {
    let rows = reader.metadata().row_groups().iter().map(|group| group.num_rows());
    let rows = rows.chain([reader.metadata().file_metadata().num_rows()]);
    rows.map(|rows| u64::try_from(rows).unwrap_or(u64::MAX)).max().unwrap_or(0)
}

pub(crate) fn opened(source: File) -> Check<SerializedFileReader<File>> {
    let length = source.metadata().map(|metadata| metadata.len());
    let of_pages = source.try_clone();
    let reader = SerializedFileReader::new(source).map_err(|e| damaged(&e))?;
    check_columns(&reader, &of_pages.map_err(|e| damaged(&e.into()))?, length.unwrap_or(u64::MAX))?;
    Ok(reader)
}

/// What the file says of itself; nothing where it is of another program.
fn provenance(reader: &SerializedFileReader<File>) -> Check<Metadata> {
    let pairs = reader.metadata().file_metadata().key_value_metadata().into_iter().flatten();
    let pairs: Vec<(String, String)> = pairs
        .filter(|pair| metadata::is_key(&pair.key)) // other programs leave theirs
        .map(|pair| (pair.key.clone(), pair.value.clone().unwrap_or_default()))
        .collect();
    let has = |key: &str| pairs.iter().any(|(found, _)| found == key);
    match (has("format"), has("version")) {
        (false, _) => Ok(Metadata::default()),
        (true, true) => Metadata::from_pairs(pairs),
        (true, false) => {
            Err(BadInput::new("metadata version", format!("a {FORMAT}"), "a parquet file without it"))
        }
    }
}

/// Refuses columns that would lie outside the file, which `parquet` itself asserts, and pages that claim more than
/// they can hold.
fn check_columns(reader: &SerializedFileReader<File>, file: &File, length: u64) -> Check<()> {
    let columns = reader.metadata().row_groups().iter().flat_map(|group| group.columns());
    for column in columns {
        let start = column.dictionary_page_offset().unwrap_or(column.data_page_offset());
        let (start, size) = (u64::try_from(start), u64::try_from(column.compressed_size()));
        let refused = |error| damaged(&error).within(column.column_path().string());
        let (Ok(start), Ok(size)) = (start, size) else { return Err(refused(outside())) };
        let end = start.saturating_add(size);
        if end > length {
            return Err(refused(outside()));
        }
        pages::check(file, [start, end])
            .map_err(|error| refused(ParquetError::General(error.to_string())))?;
    }
    Ok(())
}

fn outside() -> ParquetError {
    ParquetError::General("a column outside the file".into())
}

/// The numbers of column `i`, of whatever type.
fn read_numbers(reader: &SerializedFileReader<File>, i: usize, name: &str) -> Check<Vec<f64>> {
    let column = reader.metadata().file_metadata().schema_descr().column(i);
    let is_whole = |converted: ConvertedType| {
        use ConvertedType::{INT_8, INT_16, INT_32, INT_64, NONE};
        matches!(converted, NONE | INT_8 | INT_16 | INT_32 | INT_64)
    };
    match column.physical_type() {
        PhysicalType::DOUBLE => read_column::<DoubleType>(reader, i, name),
        PhysicalType::FLOAT => Ok(widened(read_column::<FloatType>(reader, i, name)?)),
        PhysicalType::INT32 if is_whole(column.converted_type()) => {
            Ok(widened(read_column::<Int32Type>(reader, i, name)?))
        }
        PhysicalType::INT64 if is_whole(column.converted_type()) => {
            let whole = read_column::<Int64Type>(reader, i, name)?;
            Ok(whole.into_iter().map(|value| value as f64).collect())
        }
        other => Err(BadInput::new(name, "a column of numbers", format!("one of {other}"))),
    }
}

fn widened<T: Into<f64>>(values: Vec<T>) -> Vec<f64> {
    values.into_iter().map(Into::into).collect()
}

/// The flags of column `i`: booleans, or numbers 0 and 1.
fn read_flags(reader: &SerializedFileReader<File>, i: usize, name: &str) -> Check<Vec<bool>> {
    if reader.metadata().file_metadata().schema_descr().column(i).physical_type() == PhysicalType::BOOLEAN {
        return read_column::<BoolType>(reader, i, name);
    }
    let flag = |(row, value): (usize, f64)| match value {
        0.0 => Ok(false),
        1.0 => Ok(true),
        _ => Err(BadInput::new(format!("row {}: {name}", row + 1), "0 or 1", value.to_string())),
    };
    read_numbers(reader, i, name)?.into_iter().enumerate().map(flag).collect()
}

/// What `pages` reads of the column `name`; `parquet` asserts what the pages of a damaged file do not keep.
pub(crate) fn guarded<T>(name: &str, pages: impl FnOnce() -> Check<T>) -> Check<T> {
    caught(pages).unwrap_or_else(|| {
        Err(damaged(&ParquetError::General("pages that contradict each other".into())).within(name))
    })
}

/// A whole column.
fn read_column<T: DataType>(reader: &SerializedFileReader<File>, i: usize, name: &str) -> Check<Vec<T::T>> {
    guarded(name, || read_pages::<T>(reader, i, name))
}

/// All values of column `i`, from every row group; there must be one in every row.
fn read_pages<T: DataType>(reader: &SerializedFileReader<File>, i: usize, name: &str) -> Check<Vec<T::T>> {
    let bad = |e: ParquetError| damaged(&e).within(name);
    let column = reader.metadata().file_metadata().schema_descr().column(i);
    if column.max_rep_level() != 0 || column.max_def_level() > 1 {
        return Err(BadInput::new(name, "one number a row", "lists or tables"));
    }
    let mut values = Vec::new();
    for group in 0..reader.num_row_groups() {
        let claimed = usize::try_from(reader.metadata().row_group(group).num_rows()).unwrap_or(0);
        let before = values.len();
        let column_reader =
            reader.get_row_group(group).and_then(|group| group.get_column_reader(i)).map_err(bad)?;
        let Some(mut of_type) = T::get_column_reader(column_reader) else {
            return Err(BadInput::new(name, "the type that the schema states", "another"));
        };
        // Of a column in which values may be missing: 1 where there is one.
        let mut there = Vec::new();
        loop {
            there.clear();
            let levels = (column.max_def_level() == 1).then_some(&mut there);
            let row = values.len();
            if of_type.read_records(CHUNK, levels, None, &mut values).map_err(bad)?.0 == 0 {
                break;
            }
            if let Some(missing) = there.iter().position(|level| *level == 0) {
                return Err(not_finite(&format!("row {}: {name}", row + missing + 1), "an empty cell"));
            }
            // A run of one value is as short as its count: only the claim bounds the memory.
            if values.len() - before > claimed {
                let more = ParquetError::General(format!("more than the {claimed} rows that it claims"));
                return Err(bad(more));
            }
        }
    }
    Ok(values)
}

pub(crate) fn damaged(error: &ParquetError) -> BadInput {
    BadInput::new("contents", "a whole parquet file", error.to_string())
        .hint("was it copied or downloaded to the end?")
}
