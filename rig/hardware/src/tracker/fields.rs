//! Fields of a message, one after the other, big-endian; nothing is read beyond the end.

/// The bytes that have not been read yet.
pub(super) struct Fields<'a>(&'a [u8]);

impl<'a> Fields<'a> {
    /// Begins at the first byte.
    pub fn new(bytes: &'a [u8]) -> Self {
        Self(bytes)
    }

    /// Whether all has been read.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Bytes left.
    pub fn remaining(&self) -> usize {
        self.0.len()
    }

    /// The next `n` bytes.
    pub fn take(&mut self, n: usize) -> Option<&'a [u8]> {
        let (taken, rest) = self.0.split_at_checked(n)?;
        self.0 = rest;
        Some(taken)
    }

    /// All that is left.
    pub fn rest(&mut self) -> &'a [u8] {
        std::mem::take(&mut self.0)
    }

    fn array<const N: usize>(&mut self) -> Option<[u8; N]> {
        self.take(N)?.try_into().ok()
    }

    pub fn u16(&mut self) -> Option<u16> {
        self.array().map(u16::from_be_bytes)
    }

    pub fn u32(&mut self) -> Option<u32> {
        self.array().map(u32::from_be_bytes)
    }

    pub fn u64(&mut self) -> Option<u64> {
        self.array().map(u64::from_be_bytes)
    }

    /// A 32-bit number, wider.
    pub fn f32(&mut self) -> Option<f64> {
        self.array().map(|bytes| f64::from(f32::from_be_bytes(bytes)))
    }

    /// A name of at most `n` bytes, filled up with zeros or spaces; `None` if it is not printable. Some senders leave
    /// old bytes behind the first zero.
    pub fn name(&mut self, n: usize) -> Option<String> {
        let bytes = self.take(n)?;
        let text = bytes.split(|byte| *byte == 0).next().unwrap_or_default();
        let text = std::str::from_utf8(text).ok()?.trim_end();
        (!text.chars().any(char::is_control)).then(|| text.to_owned())
    }

    /// A word of at most `n` letters, digits and `_`, filled up with zeros and nothing else.
    pub fn word(&mut self, n: usize) -> Option<String> {
        let bytes = self.take(n)?;
        let length = bytes.iter().position(|byte| *byte == 0).unwrap_or(n);
        let (word, rest) = bytes.split_at(length);
        let sound = !word.is_empty()
            && word.iter().all(|b| b.is_ascii_alphanumeric() || *b == b'_')
            && rest.iter().all(|b| *b == 0);
        sound.then(|| String::from_utf8_lossy(word).into_owned())
    }
}

/// A name filled up with zeros, cut at a character if it is too long.
pub(super) fn padded<const N: usize>(name: &str) -> [u8; N] {
    let mut end = name.len().min(N);
    while !name.is_char_boundary(end) {
        end -= 1;
    }
    let mut bytes = [0; N];
    bytes[..end].copy_from_slice(&name.as_bytes()[..end]);
    bytes
}
