//! Reads numbers one after the other from the bytes of an MSH file, text or binary.
//!
//! Main decision: nothing is assumed. Every number is checked to be there before it is read, and counts
//! never reserve more memory than the rest of the file could fill.

use hysteron_base::BadInput;

/// How the numbers of a binary file are stored.
#[derive(Debug, Clone, Copy)]
pub(super) struct Binary {
    /// Most significant byte first.
    pub(super) big_endian: bool,
    /// Bytes of a count or tag: 4 or 8.
    pub(super) size_bytes: usize,
}

/// A position in the file.
pub(super) struct Scan<'a> {
    bytes: &'a [u8],
    at: usize,
    /// Set once the header has been read, for binary files.
    pub(super) binary: Option<Binary>,
}

impl<'a> Scan<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, at: 0, binary: None }
    }

    fn rest(&self) -> &'a [u8] {
        &self.bytes[self.at.min(self.bytes.len())..]
    }

    /// Bytes read so far.
    pub(super) fn position(&self) -> usize {
        self.at
    }

    /// Where byte `at` is: its line in a text file, itself in a binary one.
    pub(super) fn place_of(&self, at: usize) -> String {
        if self.binary.is_some() {
            return format!("byte {at}");
        }
        let newlines = self.bytes[..at.min(self.bytes.len())].iter().filter(|&&b| b == b'\n').count();
        format!("line {}", newlines + 1)
    }

    /// Where the next byte is.
    pub(super) fn place(&self) -> String {
        self.place_of(self.at)
    }

    /// An error at this position.
    pub(super) fn bad(&self, expected: impl Into<String>, found: impl Into<String>) -> BadInput {
        BadInput::new(self.place(), expected, found)
    }

    /// The end of the file instead of what was expected.
    pub(super) fn ends(&self, expected: &str) -> BadInput {
        self.bad(expected, "the end of the file").hint("the file is cut short: write or copy it again")
    }

    /// The number of items a count promises, never more than the remaining bytes can hold.
    pub(super) fn capacity(&self, count: u64) -> usize {
        usize::try_from(count).unwrap_or(usize::MAX).min(self.rest().len())
    }

    pub(super) fn skip_blank(&mut self) {
        while self.rest().first().is_some_and(u8::is_ascii_whitespace) {
            self.at += 1;
        }
    }

    /// Moves behind the mark that some editors put before UTF-8 text.
    ///
    /// # Errors
    /// `BadInput` for text in UTF-16.
    pub(super) fn skip_byte_order_mark(&mut self) -> Result<(), BadInput> {
        match self.rest() {
            [0xef, 0xbb, 0xbf, ..] => self.at += 3,
            [0xff, 0xfe, ..] | [0xfe, 0xff, ..] => {
                return Err(self
                    .bad("a Gmsh mesh", "text in UTF-16")
                    .hint("save the file as UTF-8 or ASCII"));
            }
            _ => {}
        }
        Ok(())
    }

    /// True where the next bytes are these.
    pub(super) fn is_at(&self, mark: &str) -> bool {
        self.rest().starts_with(mark.as_bytes())
    }

    pub(super) fn at_end(&self) -> bool {
        self.rest().is_empty()
    }

    /// The next line without its end, and moves behind it.
    pub(super) fn line(&mut self) -> &'a [u8] {
        let rest = self.rest();
        let (line, used) = match rest.iter().position(|&b| b == b'\n') {
            Some(n) => (&rest[..n], n + 1),
            None => (rest, rest.len()),
        };
        self.at += used;
        line.strip_suffix(b"\r").unwrap_or(line)
    }

    /// Whether the rest of the line is blank.
    pub(super) fn is_line_read(&self) -> bool {
        let blanks = self.rest().iter().find(|b| **b == b'\n' || !b.is_ascii_whitespace());
        blanks.is_none_or(|b| *b == b'\n')
    }

    /// Moves behind the next occurrence of `mark` at the start of a line.
    pub(super) fn skip_behind(&mut self, mark: &str) -> Result<(), BadInput> {
        let found = self.rest().windows(mark.len()).position(|w| w == mark.as_bytes());
        match found {
            Some(n) => {
                self.at += n + mark.len();
                Ok(())
            }
            None => Err(self.ends(mark)),
        }
    }

    /// The next word of a text section.
    pub(super) fn word(&mut self, what: &str) -> Result<&'a str, BadInput> {
        self.skip_blank();
        let rest = self.rest();
        let n = rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len());
        if n == 0 {
            return Err(self.ends(what));
        }
        let word = std::str::from_utf8(&rest[..n]).map_err(|_| self.bad(what, printable(&rest[..n])))?;
        self.at += n;
        Ok(word)
    }

    /// The closing line of a section.
    pub(super) fn end_of(&mut self, expected: &str) -> Result<(), BadInput> {
        self.skip_blank();
        if self.at_end() {
            return Err(self.ends(expected));
        }
        let rest = self.rest();
        if !rest.starts_with(expected.as_bytes()) {
            let n = rest.iter().position(|&b| b == b'\n').unwrap_or(rest.len());
            return Err(self
                .bad(expected, printable(&rest[..n]))
                .hint("the counts of the section do not match its contents"));
        }
        self.at += expected.len();
        Ok(())
    }

    fn take<const N: usize>(&mut self, what: &str) -> Result<[u8; N], BadInput> {
        let Some(bytes) = self.rest().first_chunk::<N>() else {
            return Err(self.ends(what));
        };
        self.at += N;
        Ok(*bytes)
    }

    /// The four bytes that give the byte order of a binary file.
    pub(super) fn byte_order(&mut self) -> Result<bool, BadInput> {
        let bytes = self.take::<4>("the number 1 that marks the byte order")?;
        match bytes {
            [1, 0, 0, 0] => Ok(false),
            [0, 0, 0, 1] => Ok(true),
            _ => Err(self.bad("the number 1 that marks the byte order", format!("bytes {bytes:?}"))),
        }
    }

    fn parsed<T: std::str::FromStr>(&mut self, what: &str) -> Result<T, BadInput> {
        let word = self.word(what)?;
        word.parse().map_err(|_| {
            self.bad(what, format!("`{}`", printable(word.as_bytes())))
                .hint("check the counts at the head of the section")
        })
    }

    /// A signed number: dimension, entity or physical tag, element type.
    pub(super) fn int(&mut self, what: &str) -> Result<i64, BadInput> {
        let Some(binary) = self.binary else {
            return self.parsed(what);
        };
        let bytes = self.take::<4>(what)?;
        let value = if binary.big_endian { i32::from_be_bytes(bytes) } else { i32::from_le_bytes(bytes) };
        Ok(value.into())
    }

    /// A count, node tag or element tag.
    pub(super) fn size(&mut self, what: &str) -> Result<u64, BadInput> {
        let Some(binary) = self.binary else {
            return self.parsed(what);
        };
        if binary.size_bytes == 4 {
            let bytes = self.take::<4>(what)?;
            let value = if binary.big_endian { u32::from_be_bytes(bytes) } else { u32::from_le_bytes(bytes) };
            return Ok(value.into());
        }
        let bytes = self.take::<8>(what)?;
        Ok(if binary.big_endian { u64::from_be_bytes(bytes) } else { u64::from_le_bytes(bytes) })
    }

    /// A count or tag of four bytes in any binary file.
    pub(super) fn positive(&mut self, what: &str) -> Result<u64, BadInput> {
        let value = self.int(what)?;
        u64::try_from(value).map_err(|_| self.bad(what, value.to_string()))
    }

    /// The three coordinates of node `tag`, in the unit of the file.
    pub(super) fn coordinates(&mut self, tag: u64) -> Result<[f64; 3], BadInput> {
        let mut x = [0.0; 3];
        for value in &mut x {
            *value = self.float("a coordinate")?;
            if !value.is_finite() {
                return Err(self
                    .bad(format!("finite coordinates of node {tag}"), value.to_string())
                    .hint("mesh the part again"));
            }
        }
        Ok(x)
    }

    /// A coordinate or bound, possibly not finite.
    pub(super) fn float(&mut self, what: &str) -> Result<f64, BadInput> {
        let Some(binary) = self.binary else {
            return self.parsed(what);
        };
        let bytes = self.take::<8>(what)?;
        Ok(if binary.big_endian { f64::from_be_bytes(bytes) } else { f64::from_le_bytes(bytes) })
    }
}

/// The first characters of something read, fit for a message.
pub(super) fn printable(bytes: &[u8]) -> String {
    const LONGEST: usize = 40;
    let text = String::from_utf8_lossy(bytes);
    let mut shown: String =
        text.chars().take(LONGEST).map(|c| if c.is_control() { '\u{fffd}' } else { c }).collect();
    if text.chars().nth(LONGEST).is_some() {
        shown.push('…');
    }
    shown
}
