//! Recordings as Parquet, for programs; the only module that knows the `parquet` crate.
//!
//! One required `DOUBLE` column per series and a `BOOLEAN` column `gap`, one row group, Snappy, metadata as
//! key-value pairs: what pyarrow, and pandas through it, read as they find it. Nothing in the file depends on the
//! machine or the time.

use super::{Channel, Check, FORMAT, Metadata, Recording, metadata, names};
use crate::BadInput;
use ::parquet::basic::{Compression, Repetition, Type as PhysicalType};
use ::parquet::data_type::{BoolType, DataType, DoubleType};
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
    let length = source.metadata().map(|metadata| metadata.len());
    let reader = SerializedFileReader::new(source).map_err(|e| damaged(&e))?;
    check_extents(&reader, length.unwrap_or(u64::MAX))?;
    let file = reader.metadata().file_metadata();
    names::check_count(file.schema_descr().num_columns())?;
    let pairs: Vec<(String, String)> = file
        .key_value_metadata()
        .into_iter()
        .flatten()
        .filter(|pair| metadata::is_key(&pair.key)) // other programs leave theirs
        .map(|pair| (pair.key.clone(), pair.value.clone().unwrap_or_default()))
        .collect();
    for key in ["format", "version"] {
        if !pairs.iter().any(|(found, _)| found == key) {
            return Err(BadInput::new(
                format!("metadata {key}"),
                format!("a {FORMAT}"),
                "a parquet file without it",
            )
            .hint("tables of other programs can come as .csv"));
        }
    }
    let meta = Metadata::from_pairs(pairs)?;

    let (mut time, mut gap) = (None, Vec::new());
    let mut channels = Vec::new();
    for (i, column) in file.schema_descr().columns().iter().enumerate() {
        let name = column.path().string();
        let wanted = if name == "gap" { PhysicalType::BOOLEAN } else { PhysicalType::DOUBLE };
        if column.physical_type() != wanted || column.max_def_level() != 0 || column.max_rep_level() != 0 {
            let found =
                format!("{} {}", column.self_type().get_basic_info().repetition(), column.physical_type());
            return Err(BadInput::new(name, format!("REQUIRED {wanted}"), found));
        }
        match name.as_str() {
            "gap" => gap = read_column::<BoolType>(&reader, i, &name)?,
            "time_s" => time = Some(read_column::<DoubleType>(&reader, i, &name)?),
            _ => channels.push(Channel::new(&name, read_column::<DoubleType>(&reader, i, &name)?)),
        }
    }
    let Some(time) = time else {
        let found: Vec<&str> = channels.iter().map(|channel| channel.name.as_str()).collect();
        return Err(BadInput::new("columns", "a column time_s", found.join(", ")));
    };
    Recording::new(time, channels, gap, meta)
}

/// Refuses columns that would lie outside the file, which `parquet` itself asserts.
fn check_extents(reader: &SerializedFileReader<File>, length: u64) -> Check<()> {
    let columns = reader.metadata().row_groups().iter().flat_map(|group| group.columns());
    for column in columns {
        let start = column.dictionary_page_offset().unwrap_or(column.data_page_offset());
        let (start, size) = (u64::try_from(start), u64::try_from(column.compressed_size()));
        if !matches!((start, size), (Ok(start), Ok(size)) if start.saturating_add(size) <= length) {
            let place = column.column_path().string();
            return Err(damaged(&ParquetError::General("a column outside the file".into())).within(place));
        }
    }
    Ok(())
}

/// All values of column `i`, from every row group.
fn read_column<T: DataType>(reader: &SerializedFileReader<File>, i: usize, name: &str) -> Check<Vec<T::T>> {
    let bad = |e: ParquetError| damaged(&e).within(name);
    let mut values = Vec::new();
    for group in 0..reader.num_row_groups() {
        let column = reader.get_row_group(group).and_then(|group| group.get_column_reader(i)).map_err(bad)?;
        let Some(mut column) = T::get_column_reader(column) else {
            return Err(BadInput::new(name, "the type that the schema states", "another"));
        };
        while column.read_records(CHUNK, None, None, &mut values).map_err(bad)?.0 > 0 {}
    }
    Ok(values)
}

fn damaged(error: &ParquetError) -> BadInput {
    BadInput::new("contents", "a whole parquet file", error.to_string())
        .hint("was it copied or downloaded to the end?")
}
