//! Columns of Parquet as numbers: every physical type, and the logical types with the meaning of the numbers.
//!
//! Stamps and spans of time become seconds, stamps those after the whole second in which the first lies (a double of the seconds
//! since 1970 is good to a quarter of a microsecond only); decimals, halves and unsigned numbers what they are.

use super::arrow_schema::Durations;
use super::parquet_damage::{damaged, guarded};
use super::{Check, check_size};
use crate::BadInput;
use crate::table::TextColumn;
use ::parquet::basic::{ConvertedType, LogicalType, TimeUnit, Type as PhysicalType};
use ::parquet::data_type::{
    BoolType, ByteArrayType, DataType, DoubleType, FixedLenByteArrayType, FloatType, Int32Type, Int64Type,
    Int96Type,
};
use ::parquet::errors::ParquetError;
use ::parquet::file::reader::{FileReader, SerializedFileReader};
use ::parquet::schema::types::ColumnDescriptor;
use std::fs::File;

/// Records read at a time; memory then follows what is in the file, not what its header claims.
const CHUNK: usize = 4096;
/// Longest list of a row.
pub(crate) const MAX_LIST: usize = 1000;
const NANOSECONDS: i64 = 1_000_000_000;
const SECONDS_OF_DAY: i64 = 86_400;

/// Meaning of the stored whole numbers of a column.
#[derive(Debug, Clone, Copy, PartialEq)]
enum IntegerKind {
    Number,
    Unsigned,
    /// Counted from 1970, so many in a second.
    Stamp(i64),
    /// So many in a second.
    Span(i64),
    /// Days from 1970.
    Date,
    /// Digits after the point.
    Decimal(i32),
    Half,
    Text,
    Other,
}

/// The values of a column of any type.
#[derive(Debug, Default)]
pub(crate) struct ColumnValues {
    /// Row by row, or element by element of lists; NaN where there is none.
    pub numbers: Vec<f64>,
    /// Where the rows of a column of lists begin; empty of others.
    pub starts: Vec<usize>,
    /// Whether the numbers are seconds, independent of the column's name.
    pub are_seconds: bool,
    /// Of stamps: the whole second that they count from [s since 1970].
    pub origin: Option<i64>,
    /// The first row without a value.
    pub first_missing: Option<usize>,
    /// Of a column of text: its cells.
    pub text: Option<TextColumn>,
}

fn kind(column: &ColumnDescriptor, durations: &Durations) -> IntegerKind {
    let per_second = |unit: &TimeUnit| match unit {
        TimeUnit::MILLIS => 1000,
        TimeUnit::MICROS => 1_000_000,
        TimeUnit::NANOS => NANOSECONDS,
    };
    match column.logical_type_ref() {
        Some(LogicalType::Integer(int)) if !int.is_signed => return IntegerKind::Unsigned,
        Some(LogicalType::Decimal(decimal)) => return IntegerKind::Decimal(decimal.scale),
        Some(LogicalType::Date) => return IntegerKind::Date,
        Some(LogicalType::Time(time)) => return IntegerKind::Span(per_second(&time.unit)),
        Some(LogicalType::Timestamp(stamp)) => return IntegerKind::Stamp(per_second(&stamp.unit)),
        Some(LogicalType::Float16) => return IntegerKind::Half,
        Some(LogicalType::String | LogicalType::Enum) => return IntegerKind::Text,
        Some(LogicalType::Integer(_)) | None => {}
        Some(_) => return IntegerKind::Other,
    }
    match column.converted_type() {
        ConvertedType::UINT_8 | ConvertedType::UINT_16 | ConvertedType::UINT_32 | ConvertedType::UINT_64 => {
            IntegerKind::Unsigned
        }
        ConvertedType::DECIMAL => IntegerKind::Decimal(column.type_scale()),
        ConvertedType::DATE => IntegerKind::Date,
        ConvertedType::TIME_MILLIS => IntegerKind::Span(1000),
        ConvertedType::TIME_MICROS => IntegerKind::Span(1_000_000),
        ConvertedType::TIMESTAMP_MILLIS => IntegerKind::Stamp(1000),
        ConvertedType::TIMESTAMP_MICROS => IntegerKind::Stamp(1_000_000),
        ConvertedType::UTF8 | ConvertedType::ENUM => IntegerKind::Text,
        ConvertedType::NONE
        | ConvertedType::INT_8
        | ConvertedType::INT_16
        | ConvertedType::INT_32
        | ConvertedType::INT_64 => {
            let name = column.path().parts().first().map_or("", String::as_str);
            durations.per_second(name).map_or(IntegerKind::Number, IntegerKind::Span)
        }
        _ => IntegerKind::Other,
    }
}

/// The values of column `i`; `None` if it holds neither numbers nor text.
///
/// # Errors
/// `BadInput` naming the column, of a file that is damaged or larger than any recording.
pub(crate) fn read(
    reader: &SerializedFileReader<File>,
    i: usize,
    (name, durations): (&str, &Durations),
) -> Check<Option<ColumnValues>> {
    let column = reader.metadata().file_metadata().schema_descr().column(i);
    let kind = kind(&column, durations);
    guarded(name, || typed(reader, i, name, (column.physical_type(), kind)))
}

fn typed(
    reader: &SerializedFileReader<File>,
    i: usize,
    name: &str,
    (physical, kind): (PhysicalType, IntegerKind),
) -> Check<Option<ColumnValues>> {
    let mut values = ColumnValues::default();
    let place = (reader, i, name);
    match (physical, kind) {
        (PhysicalType::DOUBLE, _) => pages::<DoubleType>(place, &mut values, |values, x| values.push(*x))?,
        (PhysicalType::FLOAT, _) => {
            pages::<FloatType>(place, &mut values, |values, x| values.push(f64::from(*x)))?
        }
        (PhysicalType::BOOLEAN, _) => {
            pages::<BoolType>(place, &mut values, |values, x| values.push(f64::from(u8::from(*x))))?;
        }
        (PhysicalType::INT32, IntegerKind::Unsigned) => {
            pages::<Int32Type>(place, &mut values, |values, x| values.push(f64::from(x.cast_unsigned())))?;
        }
        (PhysicalType::INT64, IntegerKind::Unsigned) => {
            pages::<Int64Type>(place, &mut values, |values, x| values.push(x.cast_unsigned() as f64))?;
        }
        (PhysicalType::INT32, _) => {
            pages::<Int32Type>(place, &mut values, |values, x| values.push_whole(i64::from(*x), kind))?;
        }
        (PhysicalType::INT64, _) => {
            pages::<Int64Type>(place, &mut values, |values, x| values.push_whole(*x, kind))?
        }
        // A stamp of Julian days and nanoseconds, which nothing writes today without being asked.
        (PhysicalType::INT96, _) => pages::<Int96Type>(place, &mut values, |values, x| {
            let nanoseconds = i64::from(x.data()[0]) | i64::from(x.data()[1]) << 32;
            values.push_stamp(
                x.to_seconds().saturating_sub(nanoseconds / NANOSECONDS),
                nanoseconds,
                NANOSECONDS,
            );
        })?,
        (PhysicalType::FIXED_LEN_BYTE_ARRAY, IntegerKind::Half) => {
            pages::<FixedLenByteArrayType>(place, &mut values, |values, x| {
                let bits = x.data().try_into().map_or(0x7e00, u16::from_le_bytes);
                values.push(half::f16::from_bits(bits).to_f64());
            })?;
        }
        (PhysicalType::FIXED_LEN_BYTE_ARRAY, IntegerKind::Decimal(scale)) => {
            pages::<FixedLenByteArrayType>(place, &mut values, |values, x| {
                values.push(decimal(x.data(), scale))
            })?;
        }
        (PhysicalType::BYTE_ARRAY, IntegerKind::Decimal(scale)) => {
            pages::<ByteArrayType>(place, &mut values, |values, x| values.push(decimal(x.data(), scale)))?;
        }
        (PhysicalType::BYTE_ARRAY, IntegerKind::Text) => {
            values.text = Some(TextColumn::default());
            pages::<ByteArrayType>(place, &mut values, |values, x| {
                values.push(f64::NAN);
                let cell = String::from_utf8_lossy(x.data());
                values.text.iter_mut().for_each(|text| text.push_cell(cell.trim()));
            })?;
        }
        (PhysicalType::BYTE_ARRAY | PhysicalType::FIXED_LEN_BYTE_ARRAY, _) => return Ok(None),
    }
    values.are_seconds = matches!(kind, IntegerKind::Stamp(_) | IntegerKind::Span(_) | IntegerKind::Date)
        || physical == PhysicalType::INT96;
    Ok(Some(values))
}

/// The number of a decimal: two's complement of any width, the largest byte first.
fn decimal(bytes: &[u8], scale: i32) -> f64 {
    let Some((first, _)) = bytes.split_first() else { return f64::NAN };
    if bytes.len() <= 16 {
        let sign = if *first >= 0x80 { -1 } else { 0 };
        let whole = bytes.iter().fold(sign, |value: i128, byte| value << 8 | i128::from(*byte));
        return scaled(whole as f64, scale);
    }
    let sign = if *first >= 0x80 { -1.0 } else { 0.0 };
    scaled(bytes.iter().fold(sign, |value, byte| value * 256.0 + f64::from(*byte)), scale)
}

/// Divided, which rounds once, not multiplied by a rounded power.
fn scaled(whole: f64, scale: i32) -> f64 {
    if scale >= 0 { whole / 10_f64.powi(scale) } else { whole * 10_f64.powi(scale.saturating_neg()) }
}

impl ColumnValues {
    fn push(&mut self, value: f64) {
        self.numbers.push(value);
    }

    fn push_whole(&mut self, whole: i64, kind: IntegerKind) {
        match kind {
            IntegerKind::Stamp(per_second) => self.push_stamp(0, whole, per_second),
            IntegerKind::Span(per_second) => self.push(whole as f64 / per_second as f64),
            IntegerKind::Date => self.push_stamp(whole.saturating_mul(SECONDS_OF_DAY), 0, 1),
            IntegerKind::Decimal(scale) => self.push(scaled(whole as f64, scale)),
            _ => self.push(whole as f64),
        }
    }

    /// A stamp of `seconds` and `ticks`, of which `per_second` are a second.
    fn push_stamp(&mut self, seconds: i64, ticks: i64, per_second: i64) {
        let seconds = seconds.saturating_add(ticks.div_euclid(per_second));
        let origin = *self.origin.get_or_insert(seconds);
        let whole = seconds.saturating_sub(origin);
        // Ticks from the origin are a whole number, so that one division rounds.
        let ticks = i128::from(whole) * i128::from(per_second) + i128::from(ticks.rem_euclid(per_second));
        self.push(ticks as f64 / per_second as f64);
    }

    fn push_missing(&mut self, row: usize) {
        self.first_missing.get_or_insert(row);
        self.push(f64::NAN);
        self.text.iter_mut().for_each(TextColumn::push_missing);
    }
}

/// All values of a column, from every row group.
fn pages<T: DataType>(
    (reader, i, name): (&SerializedFileReader<File>, usize, &str),
    values: &mut ColumnValues,
    push: impl Fn(&mut ColumnValues, &T::T),
) -> Check<()> {
    let bad = |e: ParquetError| damaged(&e).within(name);
    let column = reader.metadata().file_metadata().schema_descr().column(i);
    let (most_defined, is_list) = (column.max_def_level(), column.max_rep_level() == 1);
    let mut n_rows = 0;
    for group in 0..reader.num_row_groups() {
        let claimed = usize::try_from(reader.metadata().row_group(group).num_rows()).unwrap_or(0);
        let before = n_rows;
        let pages = reader.get_row_group(group).and_then(|group| group.get_column_reader(i)).map_err(bad)?;
        let Some(mut typed) = T::get_column_reader(pages) else {
            return Err(BadInput::new(name, "the type that the schema states", "another"));
        };
        let (mut chunk, mut defined, mut repeated) = (Vec::new(), Vec::new(), Vec::new());
        loop {
            chunk.clear();
            defined.clear();
            repeated.clear();
            let levels = (most_defined > 0).then_some(&mut defined);
            let (records, ..) = typed
                .read_records(CHUNK, levels, is_list.then_some(&mut repeated), &mut chunk)
                .map_err(bad)?;
            if records == 0 {
                break;
            }
            let mut next = chunk.iter();
            for k in 0..defined.len().max(chunk.len()) {
                if !is_list || repeated.get(k) == Some(&0) {
                    n_rows += 1;
                    if is_list {
                        values.starts.push(values.numbers.len());
                    }
                }
                let is_there = defined.get(k).is_none_or(|level| *level == most_defined);
                match if is_there { next.next() } else { None } {
                    Some(value) => push(values, value),
                    None => values.push_missing(n_rows.max(1) - 1),
                }
            }
            // A run of one value is as short as its count: only the claim bounds the memory.
            if n_rows - before > claimed || values.numbers.len() > MAX_LIST * n_rows.max(1) {
                let more = ParquetError::General(format!("more than the {claimed} rows that it claims"));
                return Err(bad(more));
            }
        }
    }
    check_size(1, values.numbers.len() as u64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decimals_are_twos_complement_of_any_width() {
        // pyarrow: Decimal("-1.50") as decimal128(5, 2) is 0xff6a in the last bytes.
        assert_eq!(decimal(&[0xff, 0x6a], 2), -1.5);
        assert_eq!(decimal(&[0, 0, 1, 0x2c], 1), 30.0);
        let wide = [&[0xff; 30][..], &[0xff, 0x6a]].concat();
        assert!((decimal(&wide, 2) + 1.5).abs() < 1e-12);
        assert!(decimal(&[], 2).is_nan());
    }

    #[test]
    fn stamps_count_from_the_second_of_the_first() {
        let mut values = ColumnValues::default();
        values.push_stamp(0, 1_700_000_000_049_999_952, NANOSECONDS);
        values.push_stamp(0, 1_700_000_001_500_000_000, NANOSECONDS);
        values.push_stamp(0, 1_699_999_999_000_000_000, NANOSECONDS);
        assert_eq!(values.origin, Some(1_700_000_000));
        assert_eq!(values.numbers, [0.049999952, 1.5, -1.0]);
    }
}
