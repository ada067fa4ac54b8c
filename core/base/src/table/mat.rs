//! MAT files of version 5 (MATLAB's `-v6` and `-v7`, and scipy's `savemat`): real arrays with one or two axes, and those in
//! structs, as `log.x`.
//!
//! Kept by hand: the crate `matfile` inflates a variable to any size that it claims, before it can be refused. The format is
//! that of MathWorks' "MAT-File Format". Text, cells, sparse and complex arrays are left out; version 7.3 is HDF5 and refused.

use super::Table;
use super::npz::{MAX_BYTES, NpyArray, SMALLER, table};
use crate::BadInput;
use crate::size::check_memory;

type Check<T> = std::result::Result<T, BadInput>;

/// Bytes before the first variable.
const HEADER: usize = 128;
/// Most variables and fields.
const MAX_ARRAYS: usize = 1000;
/// Most columns of an array.
const MAX_COLUMNS: usize = 1000;
/// Bytes that one byte of deflated data can become: its longest match has 258, encoded in two bits.
const MAX_DEFLATED: usize = 1032;
/// Structs within structs.
const MAX_DEPTH: usize = 4;
const MATRIX: u32 = 14;
const COMPRESSED: u32 = 15;
/// Class of a struct, and those of numbers: double, single, int8 to uint64.
const STRUCT: u8 = 2;
const NUMBERS: std::ops::RangeInclusive<u8> = 6..=15;

/// An element: its type and content.
struct MatElement<'a> {
    kind: u32,
    content: &'a [u8],
}

/// Elements one after the other.
struct MatElements<'a> {
    bytes: &'a [u8],
    is_big_endian: bool,
}

fn damaged(found: &str) -> BadInput {
    BadInput::new("contents", "a whole MAT file of version 5", found)
        .hint("was it copied or downloaded to the end?")
}

impl<'a> MatElements<'a> {
    fn word(&self, at: usize) -> Check<u32> {
        let field = self.bytes.get(at..at + 4).and_then(|field| field.try_into().ok());
        let field = field.ok_or_else(|| damaged("an early end"))?;
        Ok(if self.is_big_endian { u32::from_be_bytes(field) } else { u32::from_le_bytes(field) })
    }

    /// The next element; none at the end.
    fn next(&mut self) -> Check<Option<MatElement<'a>>> {
        if self.bytes.is_empty() {
            return Ok(None);
        }
        let first = self.word(0)?;
        // A short one has its length in the upper half of its type, and its content within the tag.
        let (kind, at, length) = match first >> 16 {
            0 => (first, 8, self.word(4)? as usize),
            short => (first & 0xffff, 4, short as usize),
        };
        let content = self.bytes.get(at..).and_then(|rest| rest.get(..length));
        let content = content.ok_or_else(|| damaged("an early end"))?;
        let end = if at == 4 { 8 } else { at + length };
        // All but compressed ones fill up to eight bytes.
        let end = if kind == COMPRESSED { end } else { end.next_multiple_of(8) };
        self.bytes = self.bytes.get(end..).unwrap_or_default();
        Ok(Some(MatElement { kind, content }))
    }

    fn required(&mut self) -> Check<MatElement<'a>> {
        self.next()?.ok_or_else(|| damaged("an early end"))
    }

    fn of(&self, content: &'a [u8]) -> Self {
        Self { bytes: content, is_big_endian: self.is_big_endian }
    }
}

/// The numbers of an element, by the type in which they are stored.
fn numbers(element: &MatElement, is_big_endian: bool) -> Option<Vec<f64>> {
    let width = match element.kind {
        1 | 2 => 1,
        3 | 4 => 2,
        5..=7 => 4,
        9 | 12 | 13 => 8,
        _ => return None,
    };
    let value = |cell: &[u8]| {
        let byte = |k: usize| u64::from(cell[if is_big_endian { k } else { width - 1 - k }]);
        let bits = (0..width).fold(0_u64, |bits, k| bits << 8 | byte(k));
        let shift = 64 - 8 * width as u32;
        match element.kind {
            7 => f64::from(f32::from_bits(bits as u32)),
            9 => f64::from_bits(bits),
            1 | 3 | 5 | 12 => ((bits << shift).cast_signed() >> shift) as f64,
            _ => bits as f64,
        }
    };
    Some(element.content.chunks_exact(width).map(value).collect())
}

/// Content found in a file: arrays, and what is left out.
#[derive(Default)]
struct MatContent {
    arrays: Vec<(String, NpyArray)>,
    left_out: Vec<(String, &'static str)>,
    /// Bytes that were inflated.
    inflated: usize,
}

impl MatContent {
    fn matrix(&mut self, mut parts: MatElements, name: Option<&str>, depth: usize) -> Check<()> {
        crate::size::check_at_most("arrays", self.arrays.len() + self.left_out.len(), MAX_ARRAYS)?;
        if parts.bytes.is_empty() {
            return Ok(()); // an empty field
        }
        let is_big_endian = parts.is_big_endian;
        let flags = parts.required()?;
        let flags = parts.of(flags.content).word(0)?;
        let (class, is_complex) = (flags as u8, flags & 0x0800 != 0);
        let shape =
            numbers(&parts.required()?, is_big_endian).ok_or_else(|| damaged("a shape that is none"))?;
        let own = parts.required()?;
        let own = String::from_utf8_lossy(own.content).into_owned();
        let name = name.map_or(own, str::to_owned);
        if class == STRUCT {
            return self.fields(parts, (&name, &shape), depth);
        }
        let what = match class {
            _ if is_complex => "complex numbers",
            4 => "text",
            1 => "cells",
            5 => "a sparse array",
            _ if !NUMBERS.contains(&class) => "an object",
            _ if shape.len() != 2 => "more than two axes",
            _ => "",
        };
        if !what.is_empty() {
            self.left_out.push((name, what));
            return Ok(());
        }
        let stored = parts.required()?;
        // As doubles, of which a stored byte may be one, and by rows.
        check_memory(&name, 16.0 * stored.content.len() as f64, SMALLER)?;
        let values = numbers(&stored, is_big_endian).ok_or_else(|| damaged("numbers of no type"))?;
        let [n, m] = [shape[0], shape[1]].map(|size| size.max(0.0) as usize);
        if n.checked_mul(m) != Some(values.len()) {
            return Err(damaged("an array smaller than its header").within(name));
        }
        // A vector either way is a column.
        let (n_rows, n_columns) = if n == 1 { (m, 1) } else { (n, m) };
        crate::size::check_at_most("columns of an array", n_columns, MAX_COLUMNS)?;
        let by_rows = |k: usize| values[(k % n_columns) * n_rows + k / n_columns];
        let values = (0..values.len()).map(by_rows).collect();
        self.arrays.push((name, NpyArray { n_rows, n_columns, has_columns: n_columns > 1, values }));
        Ok(())
    }

    /// The fields of a single struct.
    fn fields(&mut self, mut parts: MatElements, (name, shape): (&str, &[f64]), depth: usize) -> Check<()> {
        let Some(deeper) = depth.checked_sub(1).filter(|_| shape.iter().all(|size| *size == 1.0)) else {
            self.left_out.push((name.to_owned(), "several structs, or structs too deep"));
            return Ok(());
        };
        let is_big_endian = parts.is_big_endian;
        let length = numbers(&parts.required()?, is_big_endian).and_then(|length| length.first().copied());
        let length =
            length.filter(|length| *length >= 1.0).ok_or_else(|| damaged("fields without names"))? as usize;
        let names = parts.required()?.content;
        for field in names.chunks_exact(length) {
            let end = field.iter().position(|byte| *byte == 0).unwrap_or(field.len());
            let field = format!("{name}.{}", String::from_utf8_lossy(&field[..end]));
            let element = parts.required()?;
            if element.kind == MATRIX {
                self.matrix(parts.of(element.content), Some(&field), deeper)?;
            }
        }
        Ok(())
    }
}

/// The arrays of the length that most have, as columns.
///
/// # Errors
/// `BadInput` for another version or a damaged file.
pub(super) fn read(bytes: &[u8]) -> Check<Table> {
    let version = "a MAT file of version 5";
    if bytes.starts_with(b"MATLAB 7.3") || bytes.starts_with(b"\x89HDF") {
        return Err(BadInput::new("contents", version, "one of version 7.3").hint(
            "save it in MATLAB with save(file, \"-v7\"), or its arrays in Python with h5py and scipy.io.savemat",
        ));
    }
    let is_big_endian = match bytes.get(HEADER - 2..HEADER) {
        Some(b"IM") => false,
        Some(b"MI") => true,
        _ => {
            return Err(BadInput::new("contents", version, "another")
                .hint("save it in MATLAB with save(file, \"-v7\"), in Python with scipy.io.savemat"));
        }
    };
    let mut found = MatContent::default();
    let mut elements = MatElements { bytes: &bytes[HEADER..], is_big_endian };
    while let Some(element) = elements.next()? {
        match element.kind {
            MATRIX => found.matrix(elements.of(element.content), None, MAX_DEPTH)?,
            COMPRESSED => {
                let room =
                    (MAX_BYTES - found.inflated).min(element.content.len().saturating_mul(MAX_DEFLATED));
                check_memory("contents", 2.0 * room as f64, SMALLER)?;
                let inflated = miniz_oxide::inflate::decompress_to_vec_zlib_with_limit(element.content, room)
                    .map_err(|error| damaged(&error.to_string()))?;
                found.inflated += inflated.len();
                let mut inside = MatElements { bytes: &inflated, is_big_endian };
                while let Some(element) = inside.next()? {
                    if element.kind == MATRIX {
                        found.matrix(inside.of(element.content), None, MAX_DEPTH)?;
                    }
                }
            }
            _ => {}
        }
    }
    table(found.arrays, found.left_out)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)] // a test may stop where it stands
    use super::*;
    use std::path::Path;

    fn file(name: &str) -> Vec<u8> {
        std::fs::read(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/tables").join(name)).unwrap()
    }

    #[test]
    fn arrays_and_structs_of_scipy_are_columns() {
        for name in ["v5.mat", "v5_compressed.mat"] {
            let table = read(&file(name)).unwrap();
            let values = |name: &str| table.columns()[table.index(name).unwrap()].values.clone();
            assert_eq!(values("t"), [0.0, 0.05, 0.1, 0.15000000000000002, 0.2], "{name}");
            assert_eq!(values("stroke[2]"), [1.0, 3.0, 5.0, 7.0, 9.0].map(|x: f64| x / 7.0), "{name}");
            assert_eq!(values("f32"), [1.5, -2.0, 0.25, 3.0, 4.0]);
            assert_eq!(values("i16"), [-2.0, -1.0, 0.0, 1.0, 2.0]);
            assert_eq!(values("u64")[0], 9_223_372_036_854_775_808.0);
            assert_eq!(values("flag"), [1.0, 0.0, 1.0, 1.0, 0.0]);
            assert_eq!((values("log.x")[4], values("log.deep.y")[4]), (5.0, 4.0));
            let left_out: Vec<&str> = table.left_out().iter().map(|(name, _)| name.as_str()).collect();
            assert_eq!(left_out, ["label", "cell", "cube", "z", "fs"], "{name}");
        }
    }

    #[test]
    fn other_versions_are_refused_by_name() {
        assert!(read(&file("v4.mat")).unwrap_err().to_string().contains("-v7"));
        let error = read(b"MATLAB 7.3 MAT-file, Platform: GLNXA64").unwrap_err().to_string();
        assert!(error.contains("version 7.3") && error.contains("h5py"), "{error}");
    }

    #[test]
    fn a_file_cut_or_altered_anywhere_is_refused_or_read() {
        for name in ["v5.mat", "v5_compressed.mat"] {
            let whole = file(name);
            for n in 0..whole.len() {
                let _ = read(&whole[..n]);
                for bits in [0xff, 0x01, 0x80] {
                    let mut altered = whole.clone();
                    altered[n] ^= bits;
                    let _ = read(&altered);
                }
            }
        }
    }
}
