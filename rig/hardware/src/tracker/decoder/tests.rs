#![allow(clippy::unwrap_used)] // a test may stop where it stands

use super::super::message::{MessageContent, MessageFormat, ToolPose};
use super::*;
use crate::tracker::Validity;

fn message(device: &str, x: f64) -> Message {
    let pose =
        ToolPose { position: [x, 0.0, 0.0], orientation: [1.0, 0.0, 0.0, 0.0], validity: Validity::Valid };
    Message { device: device.into(), time: Some(1.5), content: MessageContent::Transform(pose) }
}

fn decode(decoder: &mut MessageDecoder, bytes: &[u8]) -> Vec<DecodedMessage> {
    let mut all = Vec::new();
    decoder.decode(bytes, |decoded| all.push(decoded));
    all
}

fn x_of(decoded: &DecodedMessage) -> Option<f64> {
    match decoded {
        DecodedMessage::Message(Message { content: MessageContent::Transform(pose), .. }) => {
            Some(pose.position[0])
        }
        _ => None,
    }
}

/// Ten messages one after the other, at 0, 1, … 9 m.
fn ten(protocol: MessageFormat) -> Vec<Vec<u8>> {
    (0..10).map(|k| message("Tip", f64::from(k)).to_bytes(protocol)).collect()
}

#[test]
fn cuts_anywhere_change_nothing() {
    for protocol in [MessageFormat::Plain, MessageFormat::WithStatus] {
        let bytes = ten(protocol).concat();
        let whole = decode(&mut MessageDecoder::new(), &bytes);
        assert_eq!(whole.iter().filter_map(x_of).collect::<Vec<_>>().len(), 10);
        for size in 1..150 {
            let mut decoder = MessageDecoder::new();
            let decoded: Vec<DecodedMessage> =
                bytes.chunks(size).flat_map(|c| decode(&mut decoder, c)).collect();
            assert_eq!(decoded, whole);
            assert_eq!(decoder.n_buffered(), 0);
        }
    }
}

#[test]
fn garbage_costs_no_message_behind_it_and_is_reported_once() {
    let mut messages = ten(MessageFormat::Plain);
    messages.insert(3, b"\0\x01What is this?\0\0\xFF".repeat(20));
    let all = decode(&mut MessageDecoder::new(), &messages.concat());
    assert_eq!(all.iter().filter_map(x_of).count(), 10);
    assert_eq!(all.iter().filter(|d| matches!(d, DecodedMessage::Damaged(_))).count(), 1);
}

#[test]
fn any_flipped_byte_of_a_size_or_body_costs_that_message_alone() {
    for protocol in [MessageFormat::Plain, MessageFormat::WithStatus] {
        let messages = ten(protocol);
        for at in (42..messages[4].len()).chain([0]) {
            let mut messages = messages.clone();
            messages[4][at] ^= 0x55;
            // A size that became larger is only found out when that much has come.
            messages.extend((10..1300).map(|k| message("Tip", f64::from(k)).to_bytes(protocol)));
            let all = decode(&mut MessageDecoder::new(), &messages.concat());
            let found: Vec<f64> = all.iter().filter_map(x_of).collect();
            assert_eq!(found, (0..1300).filter(|&k| k != 4).map(f64::from).collect::<Vec<_>>(), "byte {at}");
            let n_damaged = all.iter().filter(|d| matches!(d, DecodedMessage::Damaged(_))).count();
            assert_eq!(n_damaged, 1, "byte {at}");
        }
    }
}

#[test]
fn missing_bytes_cost_one_message_or_two() {
    let messages = ten(MessageFormat::Plain);
    for cut in 1..messages[4].len() {
        let mut messages = messages.clone();
        messages[4].truncate(cut);
        let all = decode(&mut MessageDecoder::new(), &messages.concat());
        let found: Vec<f64> = all.iter().filter_map(x_of).collect();
        assert!(found.len() >= 8 && found.contains(&9.0), "{cut}: {found:?}");
        assert!(all.iter().any(|d| matches!(d, DecodedMessage::Damaged(_))), "{cut}");
    }
}

#[test]
fn unknown_types_are_skipped_without_being_kept() {
    let mut image = message("Camera", 0.0).to_bytes(MessageFormat::Plain);
    image.truncate(HEADER);
    image[2..14].copy_from_slice(b"IMAGE\0\0\0\0\0\0\0");
    let body = vec![7; 3_000_000];
    image[42..50].copy_from_slice(&(body.len() as u64).to_be_bytes());
    image[50..58].copy_from_slice(&crc64(0, &body).to_be_bytes());
    image.extend(body);
    let mut decoder = MessageDecoder::new();
    let mut all = Vec::new();
    for chunk in image.chunks(1000) {
        all.extend(decode(&mut decoder, chunk));
        assert!(decoder.n_buffered() < HEADER);
    }
    all.extend(decode(&mut decoder, &message("Tip", 2.0).to_bytes(MessageFormat::Plain)));
    assert_eq!(all[0], DecodedMessage::Skipped { kind: "IMAGE".into(), device: "Camera".into() });
    assert_eq!(x_of(&all[1]), Some(2.0));

    *image.last_mut().unwrap() = 8;
    let all = decode(&mut decoder, &image);
    assert_eq!(all, [DecodedMessage::Damaged("IMAGE of Camera: the checksum is wrong".into())]);
}

#[test]
fn absurd_sizes_are_damage_at_once() {
    for (kind, size) in
        [(b"TRANSFORM\0\0\0", 49_u64), (b"STATUS\0\0\0\0\0\0", 1 << 20), (b"IMAGE\0\0\0\0\0\0\0", 1 << 40)]
    {
        let mut bytes = message("Tip", 0.0).to_bytes(MessageFormat::Plain);
        bytes[2..14].copy_from_slice(kind);
        bytes[42..50].copy_from_slice(&size.to_be_bytes());
        bytes.extend(message("Tip", 3.0).to_bytes(MessageFormat::Plain));
        let all = decode(&mut MessageDecoder::new(), &bytes);
        assert!(matches!(all[0], DecodedMessage::Damaged(_)), "{kind:?}");
        assert_eq!(all.iter().find_map(x_of), Some(3.0));
    }
}

/// Description of the first damage in a stream.
fn first_damage(bytes: &[u8]) -> String {
    let all = decode(&mut MessageDecoder::new(), bytes);
    let damage = all.into_iter().find_map(|decoded| match decoded {
        DecodedMessage::Damaged(what) => Some(what),
        _ => None,
    });
    damage.unwrap_or_else(|| panic!("no damage"))
}

#[test]
fn a_stream_that_was_taken_for_text_or_is_text_is_named() {
    // 10 mm is 41 20 00 00; a time of 10 s has a 0A in the header, a place of 8.5 mm one in the body.
    let in_header = Message { time: Some(10.0), ..message("Tip", 1e-3) }.to_bytes(MessageFormat::Plain);
    let in_body = (1..2000)
        .map(|k| message("Tip", 1e-5 * f64::from(k)).to_bytes(MessageFormat::Plain))
        .find(|bytes| bytes[HEADER..].contains(&b'\n') && !bytes[..HEADER].contains(&b'\n'))
        .unwrap();
    for sound in [in_header, in_body] {
        let widened: Vec<u8> = sound
            .iter()
            .flat_map(|byte| if *byte == b'\n' { vec![b'\r', b'\n'] } else { vec![*byte] })
            .collect();
        assert!(widened.len() > sound.len());
        assert!(first_damage(&widened.repeat(3)).contains("0D 0A"), "{}", first_damage(&widened.repeat(3)));
        let replaced = String::from_utf8_lossy(&sound.repeat(3)).into_owned().into_bytes();
        assert!(replaced.len() > 3 * sound.len());
        assert!(first_damage(&replaced).contains("EF BF BD"), "{}", first_damage(&replaced));
    }
    let page = b"HTTP/1.1 400 Bad Request\r\nContent-Length: 0\r\nConnection: close\r\n\r\n";
    let damage = first_damage(page);
    assert!(damage.contains("HTTP/1.1 400") && damage.contains("another program"), "{damage}");
    assert!(first_damage(&[0; 200]).contains("zeros alone"));
    let mut swapped = message("Tip", 1.0).to_bytes(MessageFormat::Plain);
    swapped[..2].reverse();
    assert!(first_damage(&swapped).contains("big-endian"), "{}", first_damage(&swapped));
    // A flipped bit is a wrong checksum, and nothing is guessed about it.
    let mut flipped = message("Tip", 1.0).to_bytes(MessageFormat::Plain);
    flipped[HEADER + 1] ^= 1;
    assert_eq!(first_damage(&flipped), "TRANSFORM of Tip: the checksum is wrong");
}

#[test]
fn each_field_of_a_header_that_cannot_be_is_named() {
    for (at, byte, part) in [(0, 9, "version"), (3, b'?', "type"), (15, 7, "name")] {
        let mut bytes = message("Tip", 1.0).to_bytes(MessageFormat::Plain);
        bytes[at] = byte;
        assert!(first_damage(&bytes).contains(part), "{}", first_damage(&bytes));
    }
}
