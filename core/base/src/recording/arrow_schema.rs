//! Durations in the schema that Arrow leaves in a Parquet file's metadata: Parquet itself stores them as whole numbers and does
//! not mark them as times.
//!
//! The metadata `ARROW:schema` is a FlatBuffers message in base64 (`Schema.fbs`, `Message.fbs`), as pyarrow, pandas and polars
//! write it. What cannot be read is no duration.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

/// Largest schema that is looked at [byte]; more than any table of 5 000 columns has.
const MAX_BYTES: usize = 4 << 20;
/// Most fields of a table.
const MAX_FIELDS: usize = 10_000;
/// `Duration` in the union `Type`.
const DURATION: u8 = 18;

/// Columns that hold spans of time, with their ticks in a second.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Durations(Vec<(String, i64)>);

impl Durations {
    /// Those of the metadata `ARROW:schema`.
    pub(crate) fn of(encoded: &str) -> Self {
        if encoded.len() > MAX_BYTES {
            return Self::default();
        }
        let bytes = STANDARD.decode(encoded.trim()).unwrap_or_default();
        Self(fields(&bytes).unwrap_or_default())
    }

    pub(crate) fn per_second(&self, column: &str) -> Option<i64> {
        self.0.iter().find(|(name, _)| name == column).map(|(_, per_second)| *per_second)
    }
}

/// A table of a FlatBuffer.
#[derive(Clone, Copy)]
struct Node<'a> {
    bytes: &'a [u8],
    at: usize,
}

fn u32_at(bytes: &[u8], at: usize) -> Option<usize> {
    let field = bytes.get(at..at.checked_add(4)?)?;
    usize::try_from(u32::from_le_bytes(field.try_into().ok()?)).ok()
}

fn u16_at(bytes: &[u8], at: usize) -> Option<usize> {
    Some(u16::from_le_bytes(bytes.get(at..at.checked_add(2)?)?.try_into().ok()?).into())
}

impl<'a> Node<'a> {
    /// Offset of field number `k`, if it is there.
    fn field(&self, k: usize) -> Option<usize> {
        let back = u32_at(self.bytes, self.at)? as u32 as i32;
        let vtable = usize::try_from(i64::try_from(self.at).ok()? - i64::from(back)).ok()?;
        let offset = 4 + 2 * k;
        if offset >= u16_at(self.bytes, vtable)? {
            return None;
        }
        let within = u16_at(self.bytes, vtable + offset)?;
        (within != 0).then_some(self.at + within)
    }

    fn follow(&self, k: usize) -> Option<usize> {
        let at = self.field(k)?;
        at.checked_add(u32_at(self.bytes, at)?)
    }

    fn node(&self, k: usize) -> Option<Self> {
        Some(Self { bytes: self.bytes, at: self.follow(k)? })
    }

    fn text(&self, k: usize) -> Option<&'a str> {
        let at = self.follow(k)?;
        let end = (at + 4).checked_add(u32_at(self.bytes, at)?)?;
        str::from_utf8(self.bytes.get(at + 4..end)?).ok()
    }

    fn nodes(&self, k: usize) -> Option<Vec<Self>> {
        let at = self.follow(k)?;
        let n = u32_at(self.bytes, at)?;
        let node = |k: usize| {
            let entry = at + 4 + 4 * k;
            Some(Self { bytes: self.bytes, at: entry.checked_add(u32_at(self.bytes, entry)?)? })
        };
        (n <= MAX_FIELDS).then(|| (0..n).map_while(node).collect())
    }
}

/// Fields that are durations: of a message (header in field 2) the schema, of which field 1 is the list of columns; of a column
/// the name is field 0, the kind of its type 2, the type 3.
fn fields(bytes: &[u8]) -> Option<Vec<(String, i64)>> {
    // A message begins with its length, and today with 0xffffffff before that.
    let start = if u32_at(bytes, 0)? == 0xffff_ffff { 8 } else { 4 };
    let bytes = bytes.get(start..)?;
    let schema = Node { bytes, at: u32_at(bytes, 0)? }.node(2)?;
    let duration = |column: Node| {
        let is_duration = bytes.get(column.field(2)?) == Some(&DURATION);
        let unit = column.node(3)?.field(0).map_or(Some(1), |at| u16_at(bytes, at))?;
        let per_second = [1, 1000, 1_000_000, 1_000_000_000].get(unit)?;
        is_duration.then(|| Some((column.text(0)?.to_owned(), *per_second)))?
    };
    Some(schema.nodes(1)?.into_iter().filter_map(duration).collect())
}
