//! Recordings as Parquet, for programs; with `shard.rs` and `table/parquet.rs` the only module that knows the
//! `parquet` crate.
//!
//! One required `DOUBLE` column per series and a `BOOLEAN` column `gap`, one row group, Snappy, metadata as
//! key-value pairs: what pyarrow, and pandas through it, read as they find it. Nothing in the file depends on the
//! machine or the time. Tables of other programs are read as CSV is: any known unit, any type of number, no metadata.

use super::arrow_schema::Durations;
use super::names::ColumnKind;
use super::parquet_column::{self, ColumnValues};
use super::parquet_damage::damaged;
use super::{
    Check, ColumnMemory, FORMAT, Metadata, Recording, check_room, metadata, names, not_finite, pages,
};
use crate::BadInput;
use crate::units::Unit;
use ::parquet::basic::{Compression, Repetition, Type as PhysicalType};
use ::parquet::data_type::{BoolType, DoubleType};
use ::parquet::errors::ParquetError;
use ::parquet::file::metadata::KeyValue;
use ::parquet::file::properties::WriterProperties;
use ::parquet::file::reader::{FileReader, SerializedFileReader};
use ::parquet::file::writer::SerializedFileWriter;
use ::parquet::schema::types::Type;
use std::fs::File;
use std::sync::Arc;

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
    check_room(schema.num_columns(), most_rows(&reader), ColumnMemory::Grown)?;
    let table: Vec<String> = schema.columns().iter().map(|column| column.path().string()).collect();
    let (columns, mut channels) = names::columns(&table.iter().map(String::as_str).collect::<Vec<_>>())
        .map_err(|bad| if bad.place.is_empty() { bad.within("columns") } else { bad })?;
    let durations = durations(&reader);
    let (mut time, mut gap) = (Vec::new(), Vec::new());
    for (i, (column, name)) in columns.iter().zip(&table).enumerate() {
        let values = read_numbers(&reader, i, (name, &durations))?;
        match column {
            ColumnKind::Gap => gap = flags(&values, name)?,
            ColumnKind::Time(unit) => {
                let first = values.origin.and(values.numbers.first().copied());
                time = in_si(values, Some(unit), name)?;
                // Stamps of a calendar: the recording begins with its first.
                first.into_iter().for_each(|first| time.iter_mut().for_each(|t| *t -= first));
            }
            ColumnKind::Channel(k, unit) => channels[*k].values = in_si(values, *unit, name)?,
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

/// The columns that are durations in Arrow's schema.
pub(crate) fn durations(reader: &SerializedFileReader<File>) -> Durations {
    let pairs = reader.metadata().file_metadata().key_value_metadata().into_iter().flatten();
    let schema = pairs.filter(|pair| pair.key == "ARROW:schema").find_map(|pair| pair.value.as_deref());
    schema.map_or_else(Durations::default, Durations::of)
}

/// Metadata of the file; empty where it is of another program.
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
        let codec = column.compression();
        if codec == Compression::LZO {
            let expected = "snappy, gzip, brotli, lz4, zstd or no compression";
            return Err(BadInput::new(column.column_path().string(), expected, "LZO").hint(
                "write it again with zstd, as pandas does with to_parquet(path, compression=\"zstd\")",
            ));
        }
        pages::check(file, [start, end], codec)
            .map_err(|error| refused(ParquetError::General(error.to_string())))?;
    }
    Ok(())
}

fn outside() -> ParquetError {
    ParquetError::General("a column outside the file".into())
}

/// One finite number in every row of column `i`.
fn read_numbers(
    reader: &SerializedFileReader<File>,
    i: usize,
    (name, durations): (&str, &Durations),
) -> Check<ColumnValues> {
    let column = reader.metadata().file_metadata().schema_descr().column(i);
    if column.max_rep_level() != 0 || column.max_def_level() > 1 {
        return Err(BadInput::new(name, "one number a row", "lists or tables"));
    }
    let values = parquet_column::read(reader, i, (name, durations))?.filter(|values| values.text.is_none());
    let Some(values) = values else {
        return Err(BadInput::new(name, "a column of numbers", format!("one of {}", column.physical_type())));
    };
    match values.first_missing {
        Some(row) => Err(not_finite(&format!("row {}: {name}", row + 1), "an empty cell")),
        None => Ok(values),
    }
}

/// A column in SI; stamps and spans of time are seconds already, and of nothing but times.
fn in_si(values: ColumnValues, unit: Option<&Unit>, name: &str) -> Check<Vec<f64>> {
    match (values.are_seconds, unit) {
        (true, Some(unit)) if unit.si_suffix == "s" => Ok(values.numbers),
        (true, _) => Err(BadInput::new(name, "a column of numbers", "one of stamps or spans of time")),
        (false, Some(unit)) => Ok(values.numbers.into_iter().map(|value| unit.to_si(value)).collect()),
        (false, None) => Ok(values.numbers),
    }
}

/// The flags of a column: 0 or 1 of any type.
fn flags(values: &ColumnValues, name: &str) -> Check<Vec<bool>> {
    let flag = |(row, value): (usize, &f64)| match *value {
        0.0 => Ok(false),
        1.0 => Ok(true),
        _ => Err(BadInput::new(format!("row {}: {name}", row + 1), "0 or 1", value.to_string())),
    };
    values.numbers.iter().enumerate().map(flag).collect()
}
