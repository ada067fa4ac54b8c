//! Diagnosis of bytes that are no message: text where there should be bytes, or bytes taken for text.

use super::crc::crc64;
use super::message::{HEADER, MessageHeader};

/// Bytes that are looked at.
const LOOKED_AT: usize = 1024;
/// Printable bytes in a row that are text and no header: type and name of a message are shorter, and padded.
const TEXT: usize = 24;
/// Replacement character of a UTF-8 decoder for an invalid byte.
const REPLACEMENT: [u8; 3] = [0xef, 0xbf, 0xbd];

/// A fault, with what explains it and what to do.
pub(super) fn diagnose(bytes: &[u8], fault: &str) -> String {
    let bytes = &bytes[..bytes.len().min(LOOKED_AT)];
    let n_printable = bytes.iter().take_while(|byte| is_printable(**byte)).count();
    if n_printable >= TEXT {
        let text: String = bytes.iter().take(TEXT).map(|byte| char::from(*byte)).collect();
        return format!("{fault}: text, {text:?} (hint: is that the port of another program?)");
    }
    if bytes.windows(REPLACEMENT.len()).any(|window| window == REPLACEMENT) {
        return format!(
            "{fault}: bytes were replaced by EF BF BD (hint: something on the way takes the stream for text in UTF-8; pass it on \
             as bytes)"
        );
    }
    if has_widened_newlines(bytes) {
        return format!(
            "{fault}: every 0A came as 0D 0A (hint: a relay treats the stream as lines of text; forward it as \
             bytes)"
        );
    }
    if let [0, 0, ..] = bytes
        && bytes.iter().take(HEADER).all(|byte| *byte == 0)
    {
        return format!(
            "{fault}: zeros alone (hint: the sender pads its messages, or its buffer was never filled)"
        );
    }
    if let [1..=3, 0, rest @ ..] = bytes
        && rest.iter().take(4).all(u8::is_ascii_uppercase)
    {
        return format!("{fault}: its numbers are little-endian (hint: OpenIGTLink is big-endian)");
    }
    fault.to_owned()
}

fn is_printable(byte: u8) -> bool {
    byte.is_ascii_graphic() || [b' ', b'\t', b'\r', b'\n'].contains(&byte)
}

/// Whether a whole message appears once 0D 0A is read as 0A: its checksum proves it.
fn has_widened_newlines(bytes: &[u8]) -> bool {
    let mut narrowed = Vec::with_capacity(bytes.len());
    for (i, byte) in bytes.iter().enumerate() {
        if !(*byte == b'\r' && bytes.get(i + 1) == Some(&b'\n')) {
            narrowed.push(*byte);
        }
    }
    if narrowed.len() == bytes.len() {
        return false;
    }
    let Some(Ok(header)) = narrowed.first_chunk::<HEADER>().map(MessageHeader::read) else { return false };
    let end = usize::try_from(header.body).ok().and_then(|body| HEADER.checked_add(body));
    end.and_then(|end| narrowed.get(HEADER..end)).is_some_and(|body| crc64(0, body) == header.crc)
}
