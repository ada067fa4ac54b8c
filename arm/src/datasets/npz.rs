//! Arrays of `f64` in a stored (not compressed) `.npz` file: what `numpy.savez` writes.

use std::collections::BTreeMap;

use hysteron_base::BadInput;

/// Rows and columns of an array; a vector has one column.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Array {
    pub columns: usize,
    pub values: Vec<f64>,
}

/// Signature of a local file header, and its length without name and extra field.
const LOCAL: &[u8] = b"PK\x03\x04";
const LOCAL_LENGTH: usize = 30;
const MAGIC: &[u8] = b"\x93NUMPY";

/// All arrays of a file by name.
///
/// # Errors
/// `BadInput` naming the array that is compressed, cut short, of another type, or in Fortran order.
pub(crate) fn arrays(bytes: &[u8]) -> Result<BTreeMap<String, Array>, BadInput> {
    let mut found = BTreeMap::new();
    let mut rest = bytes;
    if !rest.starts_with(LOCAL) {
        return Err(BadInput::new("", "an .npz file", "something else"));
    }
    while rest.starts_with(LOCAL) {
        let cut = || BadInput::new("", "a whole .npz file", "one that is cut short");
        let number = |at: usize, len: usize| -> Result<usize, BadInput> {
            let bytes = rest.get(at..at + len).ok_or_else(cut)?;
            Ok(bytes.iter().rev().fold(0, |n, b| n << 8 | usize::from(*b)))
        };
        let (name_length, extra) = (number(26, 2)?, number(28, 2)?);
        let start = LOCAL_LENGTH + name_length + extra;
        let name = rest.get(LOCAL_LENGTH..LOCAL_LENGTH + name_length).ok_or_else(cut)?;
        let name = String::from_utf8_lossy(name).trim_end_matches(".npy").to_owned();
        let mut size = number(18, 4)?;
        if size == 0xffff_ffff {
            // The true size stands in the extra field of zip64: tag, length, size, compressed size.
            size = number(LOCAL_LENGTH + name_length + 12, 8)?;
        }
        if number(8, 2)? != 0 || number(6, 2)? & 8 != 0 {
            return Err(BadInput::new(name, "an array that is stored as it is", "a compressed one")
                .hint("numpy.savez writes such files"));
        }
        let data = start.checked_add(size).and_then(|end| rest.get(start..end)).ok_or_else(cut)?;
        found.insert(name.clone(), array(data).map_err(|bad| bad.within(name))?);
        rest = &rest[start + size..];
    }
    Ok(found)
}

fn array(data: &[u8]) -> Result<Array, BadInput> {
    let cut = || BadInput::new("", "a whole array", "one that is cut short");
    let (version, lengths) =
        data.strip_prefix(MAGIC).and_then(|d| d.split_first_chunk::<2>()).ok_or_else(cut)?;
    let width = if version[0] == 1 { 2 } else { 4 };
    let length = lengths.get(..width).ok_or_else(cut)?.iter().rev().fold(0, |n, b| n << 8 | usize::from(*b));
    let header = lengths.get(width..width + length).ok_or_else(cut)?;
    let header = String::from_utf8_lossy(header);
    if !header.contains("'<f8'") || !header.contains("'fortran_order': False") {
        return Err(BadInput::new("", "<f8 row by row", header.trim().to_owned()));
    }
    let shape = header.split_once('(').and_then(|(_, s)| s.split_once(')')).map_or("", |(s, _)| s);
    let counts: Vec<usize> = shape.split(',').filter_map(|n| n.trim().parse().ok()).collect();
    let (bytes, _) = lengths[width + length..].as_chunks::<8>();
    let values: Vec<f64> = bytes.iter().map(|b| f64::from_le_bytes(*b)).collect();
    let (rows, columns) = (counts.first().copied().unwrap_or(1), counts.get(1).copied().unwrap_or(1));
    if counts.len() > 2 || rows.checked_mul(columns) != Some(values.len()) {
        return Err(BadInput::new(
            "",
            format!("{} numbers as the shape ({shape})", values.len()),
            "another count",
        ));
    }
    Ok(Array { columns, values })
}

#[cfg(test)]
#[allow(clippy::unwrap_used)] // a test may stop where it stands
mod tests {
    use super::*;

    /// A file with one array, as numpy lays it out.
    fn file(shape: &str, values: &[f64], method: u8) -> Vec<u8> {
        let header = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': ({shape}), }}\n");
        let mut data = [MAGIC, &[1, 0], &(header.len() as u16).to_le_bytes(), header.as_bytes()].concat();
        data.extend(values.iter().flat_map(|v| v.to_le_bytes()));
        let size = (data.len() as u32).to_le_bytes();
        let fields = [
            &[20, 0, 0, 0, method, 0, 0, 0, 0, 0, 0, 0, 0, 0][..],
            &size,
            &size,
            &5u16.to_le_bytes(),
            &[0, 0],
        ];
        [LOCAL, &fields.concat(), b"q.npy", &data, b"PK\x01\x02 and so on"].concat()
    }

    #[test]
    fn arrays_are_read_with_their_shapes() {
        let found = arrays(&file("2, 3", &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0], 0)).unwrap();
        assert_eq!(found["q"], Array { columns: 3, values: vec![1.0, 2.0, 3.0, 4.0, 5.0, 6.0] });
    }

    #[test]
    fn what_is_damaged_or_compressed_is_refused() {
        let whole = file("2,", &[1.0, 2.0], 0);
        assert!(arrays(&file("2,", &[1.0, 2.0], 8)).unwrap_err().to_string().contains("stored as it is"));
        assert!(arrays(&file("3,", &[1.0, 2.0], 0)).is_err());
        for end in 0..whole.len() - 16 {
            assert!(arrays(&whole[..end]).is_err(), "{end}");
        }
    }
}
