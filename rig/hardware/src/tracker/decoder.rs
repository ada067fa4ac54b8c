//! Messages out of a stream of bytes that may be cut anywhere and damaged anywhere.
//!
//! OpenIGTLink has no mark at which a message begins. After damage the decoder therefore advances byte by byte until
//! something can be a header again: version, type, name and size are all plausible. A damaged size of a known type
//! is caught at once or by the checksum, and the bytes are searched again from behind that header, so no message
//! behind the damage is lost. Bodies of unknown types are counted off, not kept.

use super::crc::crc64;
use super::damage::diagnose;
use super::message::{HEADER, Message, MessageHeader, read_body};

/// Largest body of a known type [bytes]: 900 tools.
const MAX_BODY: usize = 64 * 1024;
/// Largest body of an unknown type [bytes]: a volume of images. A larger one is damage.
const MAX_SKIPPED: u64 = 1 << 30;
/// Bytes taken in at once; with one message, all that the decoder keeps.
const CHUNK: usize = 4096;
/// Capacity of the decoder's buffer [bytes].
pub const MAX_BUFFERED: usize = HEADER + MAX_BODY + CHUNK;

/// Item that the decoder found in the stream.
#[derive(Debug, Clone, PartialEq)]
pub enum DecodedMessage {
    /// A whole message.
    Message(Message),
    /// A message of a type that is not read here.
    Skipped {
        /// Its type.
        kind: String,
        /// Its device name.
        device: String,
    },
    /// Damage: a message with a wrong checksum or content, or bytes that are none, once up to the next header.
    Damaged(String),
}

/// State of the decoder.
#[derive(Debug, Clone, PartialEq)]
enum Mode {
    /// A message, or its beginning.
    Message,
    /// Anything, until a header comes.
    Search,
    /// The rest of an unknown body.
    Skip { header: MessageHeader, left: u64, crc: u64 },
}

/// Decoder of one connection.
#[derive(Debug, Clone)]
pub struct MessageDecoder {
    buffer: Vec<u8>,
    mode: Mode,
}

impl Default for MessageDecoder {
    fn default() -> Self {
        Self::new()
    }
}

impl MessageDecoder {
    /// A decoder at the beginning of a stream.
    pub fn new() -> Self {
        Self { buffer: Vec::new(), mode: Mode::Message }
    }

    /// Bytes of an unfinished message that are kept, at most [`MAX_BUFFERED`].
    pub fn n_buffered(&self) -> usize {
        self.buffer.len()
    }

    /// Takes the next bytes of the stream and hands on what they complete.
    pub fn decode(&mut self, bytes: &[u8], mut each: impl FnMut(DecodedMessage)) {
        for chunk in bytes.chunks(CHUNK) {
            self.buffer.extend_from_slice(chunk);
            let mut used = 0;
            while let Some(n) = self.step(used, &mut each) {
                used += n;
            }
            self.buffer.drain(..used);
        }
    }

    /// Reads one message, header or skipped part of a message at `begin`; returns how many bytes are done with, or `None` if
    /// more must come first.
    fn step(&mut self, begin: usize, each: &mut impl FnMut(DecodedMessage)) -> Option<usize> {
        let bytes = &self.buffer[begin..];
        if let Mode::Skip { header, left, crc } = &mut self.mode {
            let n = bytes.len().min(usize::try_from(*left).unwrap_or(usize::MAX));
            *crc = crc64(*crc, &bytes[..n]);
            *left -= n as u64;
            if *left > 0 {
                return (n > 0).then_some(n);
            }
            let MessageHeader { kind, device, crc: expected, .. } = header.clone();
            let intact = *crc == expected;
            self.mode = Mode::Message;
            each(if intact {
                DecodedMessage::Skipped { kind, device }
            } else {
                DecodedMessage::Damaged(format!("{kind} of {device}: the checksum is wrong"))
            });
            return Some(n);
        }
        let header = match MessageHeader::read(bytes.first_chunk()?) {
            Err(what) => return Some(self.damaged(begin, what, each)),
            Ok(header) => header,
        };
        let largest = if header.is_known() { MAX_BODY as u64 } else { MAX_SKIPPED };
        if header.body > largest || !header.size_fits() {
            let what = format!("{} with a body of {} bytes", header.kind, header.body);
            return Some(self.damaged(begin, &what, each));
        }
        if !header.is_known() {
            self.mode = Mode::Skip { left: header.body, crc: 0, header };
            return Some(HEADER);
        }
        let end = HEADER + header.body as usize;
        let body = bytes.get(HEADER..end)?;
        if crc64(0, body) != header.crc {
            // A message of its own, even if what came before it was damaged, too.
            self.mode = Mode::Message;
            let what = format!("{} of {}: the checksum is wrong", header.kind, header.device);
            return Some(self.damaged(begin, &what, each));
        }
        // A message with a valid checksum is undamaged: it ends at its declared length.
        let message = read_body(&header, body);
        self.mode = Mode::Message;
        each(message.map_or_else(DecodedMessage::Damaged, DecodedMessage::Message));
        Some(end)
    }

    /// Reports damage unless that has been done, and goes on one byte further.
    fn damaged(&mut self, begin: usize, what: &str, each: &mut impl FnMut(DecodedMessage)) -> usize {
        if self.mode != Mode::Search {
            each(DecodedMessage::Damaged(diagnose(&self.buffer[begin..], what)));
        }
        self.mode = Mode::Search;
        1
    }
}

#[cfg(test)]
mod tests;
