//! NumPy's `.npy` and `.npz`: arrays of real numbers with one or two axes, stored or deflated.
//!
//! Kept by hand: `npyz` allocates any length that a header claims, up to 4 GiB, and leaves it to its caller to bound what an
//! archive inflates to; here both are refused before.
//! The formats are those of NumPy's `lib.format` (versions 1 to 3) and of PKWARE's APPNOTE without the 64-bit
//! records, which archives beyond 4 GiB need. Arrays of text or objects, with another number of axes, or of another
//! length than most are left out.

use super::{Column, Table};
use crate::BadInput;
use crate::recording::{ColumnMemory, check_room, check_size};
use crate::size::check_memory;
use std::collections::BTreeMap;

type Check<T> = std::result::Result<T, BadInput>;

/// Most arrays of an archive.
const MAX_ARRAYS: usize = 1000;
/// Most columns of an array.
const MAX_COLUMNS: usize = 1000;
/// Largest array [byte].
pub(super) const MAX_BYTES: usize = 400_000_000;
/// Hint where an array is too large for the memory.
pub(super) const SMALLER: &str = "a smaller array, or more memory";
const END_OF_DIRECTORY: &[u8] = b"PK\x05\x06";
const ENTRY: &[u8] = b"PK\x01\x02";
const LOCAL_ENTRY: &[u8] = b"PK\x03\x04";

/// An array as its file has it.
pub(super) struct NpyArray {
    pub(super) n_rows: usize,
    pub(super) n_columns: usize,
    /// False for a column that needs no number behind its name.
    pub(super) has_columns: bool,
    /// Row by row.
    pub(super) values: Vec<f64>,
}

pub(super) fn read_single(bytes: &[u8]) -> Check<Table> {
    if let Some(columns) = structured(bytes)? {
        return Table::new(columns);
    }
    match array(bytes)? {
        Some(array) => table(vec![("array".to_owned(), array)], Vec::new()),
        None => Err(BadInput::new("contents", "an array of numbers with one or two axes", "another")),
    }
}

pub(super) fn read_archive(bytes: &[u8]) -> Check<Table> {
    let (mut arrays, mut left_out) = (Vec::new(), Vec::new());
    let mut total = 0;
    for entry in directory(bytes)? {
        let Some(name) = entry.name.strip_suffix(".npy") else { continue };
        let array = array(&contents(bytes, &entry)?).map_err(|bad| bad.within(name))?;
        let Some(array) = array else {
            left_out.push((name.to_owned(), "text, objects or more than two axes"));
            continue;
        };
        total += array.values.len() as u64;
        check_size(1, total)?;
        arrays.push((name.to_owned(), array));
    }
    table(arrays, left_out)
}

/// The arrays of the length that most of them have, as columns.
pub(super) fn table(arrays: Vec<(String, NpyArray)>, left_out: Vec<(String, &'static str)>) -> Check<Table> {
    let mut lengths: BTreeMap<usize, usize> = BTreeMap::new();
    arrays.iter().for_each(|(_, array)| *lengths.entry(array.n_rows).or_default() += 1);
    let Some(n) = lengths.iter().max_by_key(|(_, count)| **count).map(|(length, _)| *length) else {
        return Err(BadInput::new("contents", "arrays of numbers", "none"));
    };
    let (mut columns, mut left_out) = (Vec::new(), left_out);
    for (name, array) in arrays {
        if array.n_rows != n {
            left_out.push((name, "an array of another length than most"));
            continue;
        }
        let width = array.n_columns;
        columns.extend((0..width).map(|k| Column {
            name: if array.has_columns { format!("{name}[{}]", k + 1) } else { name.clone() },
            values: array.values.iter().skip(k).step_by(width).copied().collect(),
        }));
    }
    Ok(Table { left_out, ..Table::new(columns)? })
}

/// The columns of an array of records, each with a name and a type; none of another array.
fn structured(bytes: &[u8]) -> Check<Option<Vec<Column>>> {
    let Some((header, data)) = parts(bytes)? else { return Ok(None) };
    let Some((_, fields)) =
        header.split_once("'descr':").filter(|(_, rest)| rest.trim_start().starts_with('['))
    else {
        return Ok(None);
    };
    let fields = fields.split_once(']').map_or("", |(fields, _)| fields);
    let mut columns: Vec<(String, NumberType, usize)> = Vec::new();
    let mut width = 0;
    for field in fields.split('(').skip(1) {
        let texts: Vec<&str> = field.split('\'').skip(1).step_by(2).collect();
        let [name, kind] = texts[..] else { return Ok(None) };
        let Some(kind) = NumberType::of(kind) else { return Ok(None) };
        columns.push((name.to_owned(), kind, width));
        width += kind.size;
        crate::size::check_at_most("columns of an array", columns.len(), MAX_COLUMNS)?;
    }
    if width == 0 {
        return Ok(None);
    }
    check_room(columns.len(), (data.len() / width) as u64, ColumnMemory::Reserved)?;
    let column = |(name, kind, at): (String, NumberType, usize)| {
        let values = data.chunks_exact(width).map(|record| kind.value(&record[at..at + kind.size])).collect();
        Column { name, values }
    };
    Ok(Some(columns.into_iter().map(column).collect()))
}

/// A file of the archive.
struct ArchiveEntry {
    name: String,
    method: usize,
    packed: usize,
    size: usize,
    at: usize,
}

fn damaged(found: &str) -> BadInput {
    BadInput::new("contents", "a whole archive of arrays (npz)", found)
        .hint("was it copied or downloaded to the end?")
}

/// The little-endian number of `width` bytes at `at`.
fn number(bytes: &[u8], at: usize, width: usize) -> Check<usize> {
    let field =
        at.checked_add(width).and_then(|end| bytes.get(at..end)).ok_or_else(|| damaged("an early end"))?;
    Ok(field.iter().rev().fold(0, |value, byte| value << 8 | usize::from(*byte)))
}

fn slice(bytes: &[u8], at: usize, length: usize) -> Check<&[u8]> {
    at.checked_add(length).and_then(|end| bytes.get(at..end)).ok_or_else(|| damaged("an early end"))
}

fn directory(bytes: &[u8]) -> Check<Vec<ArchiveEntry>> {
    // The record has 22 bytes and a comment of at most 65 535.
    let from = bytes.len().saturating_sub(22 + 65_535);
    let tail = &bytes[from..];
    let end = tail.windows(4).rposition(|window| window == END_OF_DIRECTORY);
    let end = from + end.ok_or_else(|| damaged("a file without directory"))?;
    let n = number(bytes, end + 10, 2)?;
    crate::size::check_at_most("arrays", n, MAX_ARRAYS)?;
    let mut at = number(bytes, end + 16, 4)?;
    let mut entries = Vec::new();
    for _ in 0..n {
        if slice(bytes, at, 4)? != ENTRY {
            return Err(damaged("a directory that is none"));
        }
        let field = |offset, width| number(bytes, at + offset, width);
        let name_length = field(28, 2)?;
        entries.push(ArchiveEntry {
            name: String::from_utf8_lossy(slice(bytes, at + 46, name_length)?).into_owned(),
            method: field(10, 2)?,
            packed: field(20, 4)?,
            size: field(24, 4)?,
            at: field(42, 4)?,
        });
        at += 46 + name_length + field(30, 2)? + field(32, 2)?;
    }
    Ok(entries)
}

fn contents(bytes: &[u8], entry: &ArchiveEntry) -> Check<Vec<u8>> {
    let place = |bad: BadInput| bad.within(&entry.name);
    if slice(bytes, entry.at, 4).map_err(place)? != LOCAL_ENTRY {
        return Err(place(damaged("an entry that is none")));
    }
    let names = number(bytes, entry.at + 26, 2)? + number(bytes, entry.at + 28, 2)?;
    let packed = slice(bytes, entry.at + 30 + names, entry.packed).map_err(place)?;
    if entry.size > MAX_BYTES {
        let found = format!("{} bytes", entry.size);
        return Err(BadInput::new(&entry.name, format!("at most {MAX_BYTES} bytes"), found));
    }
    check_memory(&entry.name, entry.size.max(packed.len()) as f64, SMALLER)?;
    match entry.method {
        0 => Ok(packed.to_vec()),
        8 => miniz_oxide::inflate::decompress_to_vec_with_limit(packed, entry.size)
            .map_err(|error| place(damaged(&error.to_string()))),
        other => Err(BadInput::new(&entry.name, "stored or deflated", format!("compression method {other}"))),
    }
}

/// The header of an array and its numbers; `None` for what is no array.
fn parts(bytes: &[u8]) -> Check<Option<(String, &[u8])>> {
    if bytes.get(..6) != Some(b"\x93NUMPY") {
        return Ok(None);
    }
    let width = if bytes.get(6) == Some(&1) { 2 } else { 4 };
    let length = number(bytes, 8, width)?;
    let header = String::from_utf8_lossy(slice(bytes, 8 + width, length)?).into_owned();
    Ok(Some((header, &bytes[8 + width + length..])))
}

/// An array of numbers with one or two axes; `None` for another.
fn array(bytes: &[u8]) -> Check<Option<NpyArray>> {
    let bad = |found: &str| BadInput::new("contents", "a NumPy array", found);
    let Some((header, data)) = parts(bytes)? else { return Err(bad("another beginning")) };
    let Some((kind, is_fortran, shape)) = parse_header(&header) else {
        return Err(bad("a header that is none"));
    };
    let Some(kind) = NumberType::of(kind) else { return Ok(None) };
    let (n_rows, n_columns, has_columns) = match shape[..] {
        [n] => (n, 1, false),
        [n, m] => (n, m, true),
        _ => return Ok(None),
    };
    crate::size::check_at_most("columns of an array", n_columns, MAX_COLUMNS)?;
    let n =
        n_rows.checked_mul(n_columns).filter(|n| *n <= MAX_BYTES).ok_or_else(|| bad("a shape too large"))?;
    let data = slice(data, 0, n.saturating_mul(kind.size))?;
    // The numbers of a Fortran array are there twice while they are brought into the order of rows.
    let memory = if is_fortran && has_columns { ColumnMemory::Grown } else { ColumnMemory::Reserved };
    check_room(n_columns, n_rows as u64, memory)?;
    let mut values: Vec<f64> = data.chunks_exact(kind.size).map(|cell| kind.value(cell)).collect();
    if is_fortran && has_columns {
        let index = |k: usize| values[(k % n_columns) * n_rows + k / n_columns];
        values = (0..n).map(index).collect();
    }
    Ok(Some(NpyArray { n_rows, n_columns, has_columns, values }))
}

/// Type, order and shape of a header like `{'descr': '<f8', 'fortran_order': False, 'shape': (5027, 7), }`.
fn parse_header(header: &str) -> Option<(&str, bool, Vec<usize>)> {
    let after = |key: &str| Some(header.split_once(key)?.1.split_once(':')?.1.trim_start());
    let kind = after("'descr'")?.strip_prefix('\'').map_or("", |rest| rest.split('\'').next().unwrap_or(""));
    let is_fortran = after("'fortran_order'")?.starts_with("True");
    let shape = after("'shape'")?.strip_prefix('(')?.split_once(')')?.0;
    let sizes = shape.split(',').map(str::trim).filter(|size| !size.is_empty());
    Some((kind, is_fortran, sizes.map(|size| size.parse().ok()).collect::<Option<_>>()?))
}

/// Type of the numbers of an array.
#[derive(Debug, Clone, Copy)]
struct NumberType {
    letter: u8,
    size: usize,
    is_big_endian: bool,
}

impl NumberType {
    fn of(text: &str) -> Option<Self> {
        let (order, letter, size) = match *text.as_bytes() {
            [order, letter, digit] => (order, letter, usize::from(digit.wrapping_sub(b'0'))),
            [letter @ b'?'] | [_, letter @ b'?'] => (b'|', letter, 1),
            _ => return None,
        };
        let is_known = match letter {
            b'f' => matches!(size, 2 | 4 | 8),
            b'i' | b'u' => matches!(size, 1 | 2 | 4 | 8),
            b'b' => size == 1,
            b'?' => true,
            _ => false,
        };
        is_known.then_some(Self { letter, size, is_big_endian: order == b'>' })
    }

    fn value(self, cell: &[u8]) -> f64 {
        let at = |k: usize| cell[if self.is_big_endian { k } else { self.size - 1 - k }];
        let bits = (0..self.size).fold(0_u64, |bits, k| bits << 8 | u64::from(at(k)));
        let shift = 64 - 8 * self.size as u32;
        match (self.letter, self.size) {
            (b'f', 8) => f64::from_bits(bits),
            (b'f', 2) => half::f16::from_bits(bits as u16).to_f64(),
            (b'f', _) => f64::from(f32::from_bits(bits as u32)),
            (b'i', _) => ((bits << shift) as i64 >> shift) as f64,
            _ => bits as f64,
        }
    }
}
