//! Headers of Parquet's pages, looked at before `parquet` takes the memory that they claim.
//!
//! A page declares its size after decompression, and `parquet` clears as many bytes before it decompresses:
//! a damaged number there is gigabytes. Of most codecs the bytes which are there bound what they can become; zstd and Brotli
//! write a run of any length in a few bytes, and there the largest page that writers make is the bound.
//!
//! Headers are Thrift structs in the compact protocol (`parquet.thrift`, struct `PageHeader`).

use ::parquet::basic::Compression;
use std::io::{BufReader, Error, ErrorKind, Read, Result, Seek, SeekFrom};

/// Bytes that an empty page may become.
const MAX_OF_NONE: u64 = 64;
/// Largest page that is packed [byte]: writers end one after 1 MiB unless they are configured otherwise.
const MAX_PAGE: u64 = 64 << 20;
/// Structs within structs; a page's statistics are the third.
const DEEPEST: usize = 8;

/// Types of fields in the compact protocol.
mod field {
    pub const STOP: u8 = 0;
    pub const TRUE: u8 = 1;
    pub const FALSE: u8 = 2;
    pub const BYTE: u8 = 3;
    pub const I16: u8 = 4;
    pub const I64: u8 = 6;
    pub const DOUBLE: u8 = 7;
    pub const BINARY: u8 = 8;
    pub const LIST: u8 = 9;
    pub const SET: u8 = 10;
    pub const STRUCT: u8 = 12;
}

/// Most that a codec makes of a byte [-]: a copy of Snappy makes 64 bytes of 3, a match of deflate 258 of two bits, one of LZ4
/// 255 of a byte; the others have no such bound.
fn max_per_byte(codec: Compression) -> u64 {
    match codec {
        Compression::UNCOMPRESSED => 1,
        Compression::SNAPPY => 22,
        Compression::LZ4 | Compression::LZ4_RAW => 256,
        Compression::GZIP(_) => 1040,
        _ => u64::MAX,
    }
}

/// Refuses pages between the bytes `start` and `end` of `file` that claim more than their codec can make of them.
pub(super) fn check(file: impl Read + Seek, [start, end]: [u64; 2], codec: Compression) -> Result<()> {
    let per_byte = max_per_byte(codec);
    let mut file = BufReader::new(file);
    file.seek(SeekFrom::Start(start))?;
    while file.stream_position()? < end {
        let [uncompressed, compressed] = sizes(&mut file)?;
        let most = compressed.saturating_mul(per_byte).saturating_add(MAX_OF_NONE);
        let is_packed = codec != Compression::UNCOMPRESSED;
        if uncompressed > most || (is_packed && uncompressed > MAX_PAGE) {
            return Err(bad(format!(
                "a page of {compressed} bytes ({codec}) that claims to hold {uncompressed}"
            )));
        }
        skip(&mut file, compressed)?;
    }
    Ok(())
}

/// Bytes of a page after and before decompression, from its header.
fn sizes(file: &mut (impl Read + Seek)) -> Result<[u64; 2]> {
    let mut sizes = [None; 2];
    let mut id = 0;
    while let Some(kind) = next_field(file, &mut id)? {
        match id {
            2 | 3 if (field::I16..=field::I64).contains(&kind) => {
                let size =
                    u64::try_from(zigzag(varint(file)?)).map_err(|_| bad("a page of less than no bytes"))?;
                sizes[usize::from(id == 3)] = Some(size);
            }
            _ => skip_value(file, kind, DEEPEST)?,
        }
    }
    match sizes {
        [Some(uncompressed), Some(compressed)] => Ok([uncompressed, compressed]),
        _ => Err(bad("a page without its length")),
    }
}

/// The type of the next field, whose number goes into `id`; none at the end of the struct.
fn next_field(file: &mut impl Read, id: &mut i64) -> Result<Option<u8>> {
    let header = byte(file)?;
    let (delta, kind) = (i64::from(header >> 4), header & 0x0f);
    if kind == field::STOP {
        return Ok(None);
    }
    *id = if delta == 0 { zigzag(varint(file)?) } else { id.saturating_add(delta) };
    Ok(Some(kind))
}

fn skip_value(file: &mut (impl Read + Seek), kind: u8, depth: usize) -> Result<()> {
    let Some(deeper) = depth.checked_sub(1) else { return Err(bad("a page header without end")) };
    match kind {
        field::TRUE | field::FALSE => Ok(()),
        field::BYTE => skip(file, 1),
        field::I16..=field::I64 => varint(file).map(|_| ()),
        field::DOUBLE => skip(file, 8),
        field::BINARY => {
            let length = varint(file)?;
            skip(file, length)
        }
        field::LIST | field::SET => {
            let header = byte(file)?;
            let count = if header >> 4 == 15 { varint(file)? } else { u64::from(header >> 4) };
            match header & 0x0f {
                // In a list a flag is a byte.
                field::TRUE | field::FALSE | field::BYTE => skip(file, count),
                field::DOUBLE => skip(file, count.saturating_mul(8)),
                // Each takes a byte at least, so that the file's end ends a list without end.
                kind => (0..count).try_for_each(|_| skip_value(file, kind, deeper)),
            }
        }
        field::STRUCT => {
            let mut id = 0;
            while let Some(kind) = next_field(file, &mut id)? {
                skip_value(file, kind, deeper)?;
            }
            Ok(())
        }
        other => Err(bad(format!("a page header with a field of type {other}"))),
    }
}

fn byte(file: &mut impl Read) -> Result<u8> {
    let mut byte = [0];
    file.read_exact(&mut byte)?;
    Ok(byte[0])
}

fn varint(file: &mut impl Read) -> Result<u64> {
    let mut value = 0;
    for shift in (0..64).step_by(7) {
        let byte = byte(file)?;
        value |= u64::from(byte & 0x7f) << shift;
        if byte < 0x80 {
            return Ok(value);
        }
    }
    Err(bad("a number without end"))
}

fn zigzag(value: u64) -> i64 {
    (value >> 1).cast_signed() ^ -(value & 1).cast_signed()
}

/// Goes on by `count` bytes; beyond the end the next byte read is an error.
fn skip(file: &mut impl Seek, count: u64) -> Result<()> {
    file.seek_relative(i64::try_from(count).map_err(|_| bad("a page longer than any file"))?)
}

fn bad(what: impl Into<String>) -> Error {
    Error::new(ErrorKind::InvalidData, what.into())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Cursor;

    /// A data page of the first version: 5 values, statistics with a maximum of 3 bytes.
    fn page(uncompressed: u8, compressed: u8) -> Vec<u8> {
        let zigzag = |value: u8| 2 * value;
        let header = [0x15, 0, 0x15, zigzag(uncompressed), 0x15, zigzag(compressed)];
        let of_data = [0x2c, 0x15, 10, 0x15, 0, 0x15, 6, 0x15, 6, 0x1c, 0x18, 3, 1, 2, 3, 0, 0, 0];
        [&header[..], &of_data, &vec![7; usize::from(compressed)]].concat()
    }

    #[test]
    fn pages_are_walked_and_one_that_claims_too_much_is_found() {
        let good = [page(40, 40), page(63, 3)].concat();
        let all = |bytes: &[u8]| check(Cursor::new(bytes), [0, bytes.len() as u64], Compression::SNAPPY);
        assert!(all(&good).is_ok());
        let mut claims = page(63, 0);
        claims.splice(3..4, [0xfe, 0xff, 0xff, 0x0f]);
        let error = all(&[&good[..], &claims].concat()).map_err(|error| error.to_string());
        assert!(error.is_err_and(|error| error.contains("claims to hold 16777215")));
    }

    #[test]
    fn each_codec_has_its_own_bound() {
        // 63 bytes of none at all, and 2 MiB - 1 of 3 bytes.
        let (none, many) = (page(63, 0), {
            let mut page = page(0, 3);
            page.splice(3..4, [0xfe, 0xff, 0xff, 0x01]);
            page
        });
        let passes = |bytes: &[u8], codec| check(Cursor::new(bytes), [0, bytes.len() as u64], codec).is_ok();
        let codecs = [
            (Compression::UNCOMPRESSED, false),
            (Compression::SNAPPY, false),
            (Compression::LZ4_RAW, false),
            (Compression::GZIP(Default::default()), false),
            (Compression::ZSTD(Default::default()), true),
            (Compression::BROTLI(Default::default()), true),
        ];
        for (codec, may_be_long) in codecs {
            assert!(passes(&none, codec), "{codec}");
            assert_eq!(passes(&many, codec), may_be_long, "{codec}");
        }
        // 128 MiB of three bytes: of no codec.
        let mut page = page(0, 3);
        page.splice(3..4, [0x80, 0x80, 0x80, 0x80, 0x01]);
        assert!(codecs.iter().all(|(codec, _)| !passes(&page, *codec)));
    }

    #[test]
    fn headers_that_do_not_end_are_refused() {
        // A struct in a struct in a struct, without end; a file that ends in a number; a number without end; a list
        // of 2^35 flags, after which the file has ended.
        let lists = [0x19, 0xf1, 0x80, 0x80, 0x80, 0x80, 0x80, 1];
        let endless = [&[0x15_u8][..], &[0xff; 20]].concat();
        let refusal = |bytes: &[u8]| {
            check(Cursor::new(bytes), [0, 1 << 20], Compression::SNAPPY).expect_err("a header that ends")
        };
        for (bytes, expected) in
            [(&[0x1c; 100][..], "a page header without end"), (&endless[..], "a number without end")]
        {
            assert_eq!(refusal(bytes).to_string(), expected, "{bytes:?}");
        }
        for bytes in [&[0x15, 0xff, 0xff][..], &lists] {
            assert_eq!(refusal(bytes).kind(), ErrorKind::UnexpectedEof, "{bytes:?}");
        }
    }
}
