#![allow(clippy::unwrap_used)] // a test may stop where it stands

use super::super::message::{Content, Protocol, ToolPose};
use super::*;

fn message(device: &str, x: f64) -> Message {
    let pose = ToolPose { position: [x, 0.0, 0.0], orientation: [1.0, 0.0, 0.0, 0.0], valid: true };
    Message { device: device.into(), time: Some(1.5), content: Content::Transform(pose) }
}

fn decode(decoder: &mut Decoder, bytes: &[u8]) -> Vec<Decoded> {
    let mut all = Vec::new();
    decoder.decode(bytes, |decoded| all.push(decoded));
    all
}

fn x_of(decoded: &Decoded) -> Option<f64> {
    match decoded {
        Decoded::Message(Message { content: Content::Transform(pose), .. }) => Some(pose.position[0]),
        _ => None,
    }
}

/// Ten messages one after the other, at 0, 1, … 9 m.
fn ten(protocol: Protocol) -> Vec<Vec<u8>> {
    (0..10).map(|k| message("Tip", f64::from(k)).to_bytes(protocol)).collect()
}

#[test]
fn cuts_anywhere_change_nothing() {
    for protocol in [Protocol::Plain, Protocol::WithStatus] {
        let bytes = ten(protocol).concat();
        let whole = decode(&mut Decoder::new(), &bytes);
        assert_eq!(whole.iter().filter_map(x_of).collect::<Vec<_>>().len(), 10);
        for size in 1..150 {
            let mut decoder = Decoder::new();
            let pieces: Vec<Decoded> = bytes.chunks(size).flat_map(|c| decode(&mut decoder, c)).collect();
            assert_eq!(pieces, whole);
            assert_eq!(decoder.n_buffered(), 0);
        }
    }
}

#[test]
fn garbage_costs_no_message_behind_it_and_is_reported_once() {
    let mut messages = ten(Protocol::Plain);
    messages.insert(3, b"\0\x01What is this?\0\0\xFF".repeat(20));
    let all = decode(&mut Decoder::new(), &messages.concat());
    assert_eq!(all.iter().filter_map(x_of).count(), 10);
    assert_eq!(all.iter().filter(|d| matches!(d, Decoded::Damaged(_))).count(), 1);
}

#[test]
fn any_flipped_byte_of_a_size_or_body_costs_that_message_alone() {
    for protocol in [Protocol::Plain, Protocol::WithStatus] {
        let messages = ten(protocol);
        for at in (42..messages[4].len()).chain([0]) {
            let mut messages = messages.clone();
            messages[4][at] ^= 0x55;
            // A size that became larger is only found out when that much has come.
            messages.extend((10..1300).map(|k| message("Tip", f64::from(k)).to_bytes(protocol)));
            let all = decode(&mut Decoder::new(), &messages.concat());
            let found: Vec<f64> = all.iter().filter_map(x_of).collect();
            assert_eq!(found, (0..1300).filter(|&k| k != 4).map(f64::from).collect::<Vec<_>>(), "byte {at}");
            let n_damaged = all.iter().filter(|d| matches!(d, Decoded::Damaged(_))).count();
            assert_eq!(n_damaged, 1, "byte {at}");
        }
    }
}

#[test]
fn missing_bytes_cost_one_message_or_two() {
    let messages = ten(Protocol::Plain);
    for cut in 1..messages[4].len() {
        let mut messages = messages.clone();
        messages[4].truncate(cut);
        let all = decode(&mut Decoder::new(), &messages.concat());
        let found: Vec<f64> = all.iter().filter_map(x_of).collect();
        assert!(found.len() >= 8 && found.contains(&9.0), "{cut}: {found:?}");
        assert!(all.iter().any(|d| matches!(d, Decoded::Damaged(_))), "{cut}");
    }
}

#[test]
fn unknown_types_are_skipped_without_being_kept() {
    let mut image = message("Camera", 0.0).to_bytes(Protocol::Plain);
    image.truncate(HEADER);
    image[2..14].copy_from_slice(b"IMAGE\0\0\0\0\0\0\0");
    let body = vec![7; 3_000_000];
    image[42..50].copy_from_slice(&(body.len() as u64).to_be_bytes());
    image[50..58].copy_from_slice(&crc64(0, &body).to_be_bytes());
    image.extend(body);
    let mut decoder = Decoder::new();
    let mut all = Vec::new();
    for chunk in image.chunks(1000) {
        all.extend(decode(&mut decoder, chunk));
        assert!(decoder.n_buffered() < HEADER);
    }
    all.extend(decode(&mut decoder, &message("Tip", 2.0).to_bytes(Protocol::Plain)));
    assert_eq!(all[0], Decoded::Skipped { kind: "IMAGE".into(), device: "Camera".into() });
    assert_eq!(x_of(&all[1]), Some(2.0));

    *image.last_mut().unwrap() = 8;
    let all = decode(&mut decoder, &image);
    assert_eq!(all, [Decoded::Damaged("IMAGE of Camera: the checksum is wrong".into())]);
}

#[test]
fn absurd_sizes_are_damage_at_once() {
    for (kind, size) in
        [(b"TRANSFORM\0\0\0", 49_u64), (b"STATUS\0\0\0\0\0\0", 1 << 20), (b"IMAGE\0\0\0\0\0\0\0", 1 << 40)]
    {
        let mut bytes = message("Tip", 0.0).to_bytes(Protocol::Plain);
        bytes[2..14].copy_from_slice(kind);
        bytes[42..50].copy_from_slice(&size.to_be_bytes());
        bytes.extend(message("Tip", 3.0).to_bytes(Protocol::Plain));
        let all = decode(&mut Decoder::new(), &bytes);
        assert!(matches!(all[0], Decoded::Damaged(_)), "{kind:?}");
        assert_eq!(all.iter().find_map(x_of), Some(3.0));
    }
}
