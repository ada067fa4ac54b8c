//! A shard: the recordings of several trajectories in one Parquet file, for sets that are too large for a file each.
//!
//! One table: the column `trajectory` (`INT64`) has the number of the trajectory in its plan, the others are those of a
//! recording. Doubles are split into streams of bytes and compressed with zstd, which loses nothing and takes about half of what
//! a recording's own file takes. The metadata that all share are there once, the others as `trajectory.NUMBER.KEY`.

use super::names::ColumnKind;
use super::parquet_column::{self, ColumnValues};
use super::{
    Channel, Check, ColumnMemory, MAX_BYTES, Metadata, Recording, VERSION, check_room, check_size, metadata,
    names, parquet,
};
use crate::{BadInput, Result, file};
use ::parquet::basic::{Compression, Encoding, Repetition, Type as PhysicalType, ZstdLevel};
use ::parquet::data_type::{BoolType, DoubleType, Int64Type};
use ::parquet::errors::ParquetError;
use ::parquet::file::metadata::KeyValue;
use ::parquet::file::properties::{EnabledStatistics, WriterProperties};
use ::parquet::file::reader::{FileReader, SerializedFileReader};
use ::parquet::file::writer::{SerializedFileWriter, SerializedRowGroupWriter};
use ::parquet::schema::types::{ColumnPath, Type};
use std::collections::BTreeMap;
use std::fs::File;
use std::path::Path;
use std::sync::Arc;

/// Format that every shard states.
const FORMAT: &str = "hysteron-shard";
/// Column with the number of the trajectory.
const TRAJECTORY: &str = "trajectory";
/// More is slower and hardly smaller.
const ZSTD_LEVEL: i32 = 3;

/// Recordings of several trajectories of a plan, with the same channels. Equal shards are written as equal bytes.
#[derive(Debug, Clone, PartialEq)]
pub struct TrajectoryShard {
    meta: Metadata,
    parts: Vec<(u64, Recording)>,
}

impl TrajectoryShard {
    /// Puts a shard together: numbers of trajectories in rising order, each with its recording; `meta` holds what is true of all.
    ///
    /// # Errors
    /// `BadInput` naming the trajectory whose number or channels do not fit the one before, or for more than 50 million numbers.
    pub fn new(meta: Metadata, parts: Vec<(u64, Recording)>) -> Check<Self> {
        meta.check()?;
        for pair in parts.windows(2) {
            let [(before, first), (number, next)] = pair else { continue };
            let place = || format!("{TRAJECTORY} {number}");
            if number <= before {
                return Err(BadInput::new(place(), format!("a number above {before}"), number.to_string()));
            }
            let names = |one: &Recording| one.channels.iter().map(|c| c.name.clone()).collect::<Vec<_>>();
            if names(next) != names(first) {
                return Err(BadInput::new(place(), names(first).join(", "), names(next).join(", ")));
            }
        }
        let n_columns = parts.first().map_or(0, |(_, one)| one.channels.len()) + 3;
        check_size(n_columns, parts.iter().map(|(_, one)| one.n_samples() as u64).sum())?;
        Ok(Self { meta, parts })
    }

    /// The metadata of all trajectories.
    pub fn meta(&self) -> &Metadata {
        &self.meta
    }

    /// The recordings, each with the number of its trajectory.
    pub fn parts(&self) -> &[(u64, Recording)] {
        &self.parts
    }

    /// The bytes of the file.
    ///
    /// # Errors
    /// `Io` where the encoder refuses.
    pub fn to_bytes(&self) -> Result<Vec<u8>> {
        self.encode().map_err(|error| crate::Error::io(Path::new("shard"), std::io::Error::other(error)))
    }

    fn encode(&self) -> std::result::Result<Vec<u8>, ParquetError> {
        let column = |name: &str, kind| {
            let builder = Type::primitive_type_builder(name, kind).with_repetition(Repetition::REQUIRED);
            builder.build().map(Arc::new)
        };
        let channels = self.parts.first().map_or(&[][..], |(_, one)| &one.channels);
        let series: Vec<&str> = std::iter::once("time_s").chain(channels.iter().map(|c| &*c.name)).collect();
        let mut columns = vec![column(TRAJECTORY, PhysicalType::INT64)?];
        for name in &series {
            columns.push(column(name, PhysicalType::DOUBLE)?);
        }
        columns.push(column("gap", PhysicalType::BOOLEAN)?);
        let schema = Arc::new(Type::group_type_builder("shard").with_fields(columns).build()?);
        let mut writer = SerializedFileWriter::new(Vec::new(), schema, Arc::new(self.properties(&series)?))?;
        if !self.parts.is_empty() {
            let mut group = writer.next_row_group()?;
            self.encode_rows(&mut group, channels.len())?;
            group.close()?;
        }
        writer.into_inner()
    }

    fn properties(&self, series: &[&str]) -> std::result::Result<WriterProperties, ParquetError> {
        let pairs = self.pairs().into_iter().map(|(key, value)| KeyValue::new(key, value)).collect();
        let properties = WriterProperties::builder()
            .set_compression(Compression::ZSTD(ZstdLevel::try_new(ZSTD_LEVEL)?))
            .set_statistics_enabled(EnabledStatistics::Chunk)
            .set_created_by("hysteron".to_owned())
            .set_key_value_metadata(Some(pairs));
        let split = |properties: ::parquet::file::properties::WriterPropertiesBuilder, name: &&str| {
            let path = ColumnPath::from(*name);
            properties
                .set_column_dictionary_enabled(path.clone(), false)
                .set_column_encoding(path, Encoding::BYTE_STREAM_SPLIT)
        };
        Ok(series.iter().fold(properties, split).build())
    }

    fn encode_rows(
        &self,
        group: &mut SerializedRowGroupWriter<'_, Vec<u8>>,
        n_channels: usize,
    ) -> std::result::Result<(), ParquetError> {
        if let Some(mut column) = group.next_column()? {
            for (number, one) in &self.parts {
                let numbers = vec![number.cast_signed(); one.n_samples()];
                column.typed::<Int64Type>().write_batch(&numbers, None, None)?;
            }
            column.close()?;
        }
        for k in 0..=n_channels {
            if let Some(mut column) = group.next_column()? {
                for (_, one) in &self.parts {
                    let values = if k == 0 { &one.time } else { &one.channels[k - 1].values };
                    column.typed::<DoubleType>().write_batch(values, None, None)?;
                }
                column.close()?;
            }
        }
        if let Some(mut column) = group.next_column()? {
            for (_, one) in &self.parts {
                column.typed::<BoolType>().write_batch(&one.gap, None, None)?;
            }
            column.close()?;
        }
        Ok(())
    }

    /// All pairs of the file: those of the shard, and of each trajectory those that differ from them.
    fn pairs(&self) -> Vec<(String, String)> {
        let mut pairs: BTreeMap<String, String> = self.meta.to_pairs().into_iter().collect();
        pairs.insert("format".to_owned(), FORMAT.to_owned());
        for (number, one) in &self.parts {
            let own = one.meta.to_pairs().into_iter().filter(|(key, _)| key != "format");
            let own: Vec<_> = own.filter(|(key, value)| pairs.get(key) != Some(value)).collect();
            pairs.extend(own.into_iter().map(|(key, value)| (format!("{TRAJECTORY}.{number}.{key}"), value)));
        }
        pairs.into_iter().collect()
    }

    /// Reads a shard.
    ///
    /// # Errors
    /// `BadInput` naming file and column; `Io` if the file cannot be read.
    pub fn read(path: impl AsRef<Path>) -> Result<Self> {
        let path = path.as_ref();
        let source = file::open(path, MAX_BYTES)?;
        Ok(decode(source).map_err(|bad| bad.within(path.display()))?)
    }
}

fn decode(source: File) -> Check<TrajectoryShard> {
    let reader = parquet::opened(source)?;
    let (meta, mut own) = provenance(&reader)?;
    let schema = reader.metadata().file_metadata().schema_descr();
    check_room(schema.num_columns(), parquet::most_rows(&reader), ColumnMemory::Grown)?;
    let table: Vec<String> = schema.columns().iter().map(|column| column.path().string()).collect();
    let durations = parquet::durations(&reader);
    let read = |i: usize| -> Check<ColumnValues> {
        let values = parquet_column::read(&reader, i, (&table[i], &durations))?;
        values.ok_or_else(|| BadInput::new(&table[i], "a column of numbers", "another one"))
    };
    if table.first().is_none_or(|name| name != TRAJECTORY) {
        return Err(BadInput::new("columns", format!("{TRAJECTORY} first"), table.join(", ")));
    }
    let numbers = read(0)?.numbers;
    let read_rows = |i: usize| -> Check<Vec<f64>> {
        let values = read(i)?.numbers;
        match values.len() == numbers.len() {
            true => Ok(values),
            false => {
                let expected = format!("{} rows, as {TRAJECTORY} has", numbers.len());
                Err(BadInput::new(&table[i], expected, values.len().to_string()))
            }
        }
    };
    let (columns, named) = names::columns(&table[1..].iter().map(String::as_str).collect::<Vec<_>>())?;
    let (mut time, mut gap) = (Vec::new(), Vec::new());
    let mut series: Vec<Vec<f64>> = vec![Vec::new(); named.len()];
    for (i, column) in columns.iter().enumerate() {
        let values = read_rows(i + 1)?;
        match column {
            ColumnKind::Time(_) => time = values,
            ColumnKind::Gap => gap = values.iter().map(|flag| *flag != 0.0).collect(),
            ColumnKind::Channel(k, _) => series[*k] = values,
        }
    }
    let named = named.into_iter().zip(series);
    let channels: Vec<Channel> = named.map(|(channel, values)| Channel { values, ..channel }).collect();
    let (mut parts, mut start) = (Vec::new(), 0);
    for run in numbers.chunk_by(|a, b| a == b) {
        let rows = start..start + run.len();
        start = rows.end;
        let number = run[0] as u64;
        let mut pairs: BTreeMap<String, String> = meta.to_pairs().into_iter().collect();
        pairs.extend(own.remove(&number).unwrap_or_default());
        let channels =
            channels.iter().map(|c| Channel::new(c.name.clone(), c.values[rows.clone()].to_vec())).collect();
        let gap = gap.get(rows.clone()).map(<[bool]>::to_vec).unwrap_or_default();
        let one = Recording::new(time[rows].to_vec(), channels, gap, Metadata::from_pairs(pairs)?)?;
        parts.push((number, one));
    }
    TrajectoryShard::new(meta, parts)
}

/// Pairs of each trajectory, by its number.
type OwnPairs = BTreeMap<u64, Vec<(String, String)>>;

/// The metadata of all trajectories, and the pairs of each.
fn provenance(reader: &SerializedFileReader<File>) -> Check<(Metadata, OwnPairs)> {
    let pairs = reader.metadata().file_metadata().key_value_metadata().into_iter().flatten();
    let pairs = pairs.filter(|pair| metadata::is_key(&pair.key));
    let (mut shared, mut own) = (Vec::new(), OwnPairs::new());
    let mut header = [String::new(), String::new()];
    for pair in pairs {
        let value = pair.value.clone().unwrap_or_default();
        let of_one = pair.key.strip_prefix(TRAJECTORY).and_then(|rest| rest.strip_prefix('.'));
        match (of_one.and_then(|rest| rest.split_once('.')), pair.key.as_str()) {
            (Some((number, key)), _) => {
                let number = number.parse().map_err(|_| {
                    BadInput::new("metadata", format!("{TRAJECTORY}.NUMBER.KEY"), pair.key.clone())
                })?;
                own.entry(number).or_default().push((key.to_owned(), value));
            }
            (None, "format") => header[0] = value,
            (None, "version") => header[1] = value,
            (None, key) => shared.push((key.to_owned(), value)),
        }
    }
    let expected = [FORMAT.to_owned(), VERSION.to_string()];
    if header != expected {
        return Err(BadInput::new("metadata format and version", expected.join(" "), header.join(" ")));
    }
    Ok((Metadata::from_pairs(shared)?, own))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)] // a test may stop where it stands
    use super::*;

    fn recording(name: &str, n: usize) -> Recording {
        let time = (0..n).map(|i| i as f64 / 100.0).collect();
        let channel = |name: &str, part: f64| {
            Channel::new(name, (0..n).map(|i| part * (0.37 * i as f64).sin()).collect())
        };
        let extra = [("plan.trajectory".to_owned(), name.to_owned())].into();
        let meta = Metadata { commit: "c".into(), seed: Some(3), extra, ..Metadata::default() };
        let channels = vec![channel("stroke_1_m", 1e-3), channel("tip_x_m", 0.02)];
        Recording::new(time, channels, vec![], meta).unwrap()
    }

    fn shard() -> TrajectoryShard {
        let meta = Metadata { commit: "c".into(), ..Metadata::default() };
        let parts = vec![(4, recording("a", 7)), (5, recording("b", 30_000)), (9, recording("c", 1))];
        TrajectoryShard::new(meta, parts).unwrap()
    }

    #[test]
    fn a_shard_comes_back_with_every_bit_and_word() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("shard.parquet");
        for shard in [shard(), TrajectoryShard::new(Metadata::default(), vec![]).unwrap()] {
            let bytes = shard.to_bytes().unwrap();
            assert_eq!(bytes, shard.to_bytes().unwrap());
            std::fs::write(&path, bytes).unwrap();
            assert_eq!(TrajectoryShard::read(&path).unwrap(), shard);
        }
    }

    #[test]
    fn recordings_that_do_not_fit_are_refused() {
        let [a, b] = ["a", "b"].map(|name| recording(name, 3));
        let error = TrajectoryShard::new(Metadata::default(), vec![(2, a.clone()), (2, b)]).unwrap_err();
        assert_eq!(error.place, "trajectory 2");
        let bare = Recording::new(vec![0.0], vec![], vec![], Metadata::default()).unwrap();
        let error = TrajectoryShard::new(Metadata::default(), vec![(2, a), (3, bare)]).unwrap_err();
        assert!(error.to_string().contains("stroke_1_m"), "{error}");
    }

    #[test]
    fn a_shard_is_no_recording_and_no_recording_a_shard() {
        let folder = tempfile::tempdir().unwrap();
        let [one, other] = ["shard.parquet", "recording.parquet"].map(|name| folder.path().join(name));
        std::fs::write(&one, shard().to_bytes().unwrap()).unwrap();
        let error = Recording::read(&one).unwrap_err().to_string();
        assert!(error.contains("got hysteron-shard"), "{error}");
        recording("a", 3).write(&other).unwrap();
        let error = TrajectoryShard::read(&other).unwrap_err().to_string();
        assert!(error.contains("got hysteron-recording"), "{error}");
    }
}
