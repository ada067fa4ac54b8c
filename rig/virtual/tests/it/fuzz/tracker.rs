//! Messages of a tracker whose checksums are right and whose contents are not.

use super::{MEMORY_MAX, corpus, drive};
use hysteron_rig::tracker::{DecodedMessage, MAX_BUFFERED, MessageContent, MessageDecoder, ToolPose};
use proptest::prelude::*;

/// CRC-64 of OpenIGTLink: ECMA-182, highest bit first.
fn crc64(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0, |crc: u64, byte| {
        (0..8).fold(crc ^ (u64::from(*byte) << 56), |crc, _| {
            if crc >> 63 == 0 { crc << 1 } else { (crc << 1) ^ 0x42F0_E1EB_A9EA_3693 }
        })
    })
}

/// A message with this header and a body that its checksum vouches for.
fn message(version: u16, kind: &[u8], device: &[u8], stamp: u64, body: &[u8]) -> Vec<u8> {
    let mut bytes = version.to_be_bytes().to_vec();
    for (text, size) in [(kind, 12), (device, 20)] {
        bytes.extend(text.iter().copied().chain(std::iter::repeat(0)).take(size));
    }
    bytes.extend(stamp.to_be_bytes());
    bytes.extend((body.len() as u64).to_be_bytes());
    bytes.extend(crc64(body).to_be_bytes());
    bytes.extend(body);
    bytes
}

/// Bodies with any extended header, invalid numbers, names that are no text.
fn body() -> impl Strategy<Value = Vec<u8>> {
    let word = prop_oneof![
        Just(12_u16.to_be_bytes().to_vec()),
        any::<u16>().prop_map(|x| x.to_be_bytes().to_vec()),
        prop_oneof![Just(0_u32), Just(10), Just(u32::MAX), Just(1 << 31)]
            .prop_map(|x| x.to_be_bytes().to_vec()),
        prop_oneof![Just(f32::NAN), Just(f32::INFINITY), Just(f32::MAX), Just(-0.0), Just(1e-40), Just(1.0)]
            .prop_map(|x| x.to_be_bytes().to_vec()),
        Just(b"TipTransformStatus".to_vec()),
        Just(vec![0; 28]),
        prop::collection::vec(any::<u8>(), 0..40),
    ];
    let chunks = prop::collection::vec(word, 0..20).prop_map(|chunks| chunks.concat());
    // Most types have a size of their own.
    (chunks, prop::option::of(prop::sample::select(vec![12_usize, 24, 28, 48, 50, 60, 70, 100, 140])))
        .prop_map(|(mut body, size)| {
            if let Some(size) = size {
                body.resize(size, 0);
            }
            body
        })
}

fn any_message() -> impl Strategy<Value = Vec<u8>> {
    let kind = prop_oneof![
        Just(b"TRANSFORM".to_vec()),
        Just(b"POSITION".to_vec()),
        Just(b"QTRANS".to_vec()),
        Just(b"TDATA".to_vec()),
        Just(b"QTDATA".to_vec()),
        Just(b"STATUS".to_vec()),
        Just(b"IMAGE".to_vec()),
        prop::collection::vec(any::<u8>(), 0..12),
    ];
    let device = prop_oneof![Just(b"Tip".to_vec()), prop::collection::vec(any::<u8>(), 0..20)];
    (prop_oneof![1_u16..4, any::<u16>()], kind, device, any::<u64>(), body())
        .prop_map(|(version, kind, device, stamp, body)| message(version, &kind, &device, stamp, &body))
}

/// Damage to a stream on its way.
#[derive(Debug, Clone)]
enum Mangling {
    Lines,
    Text,
    Swapped(usize),
    Cut(usize),
    Flipped(usize, u8),
    Doubled(usize),
}

impl Mangling {
    fn apply(&self, bytes: &[u8]) -> Vec<u8> {
        let at = |place: usize| place % bytes.len().max(1);
        let mut mangled = bytes.to_vec();
        match self {
            Self::Lines => {
                return bytes
                    .iter()
                    .flat_map(|byte| if *byte == b'\n' { vec![b'\r', b'\n'] } else { vec![*byte] })
                    .collect();
            }
            Self::Text => return String::from_utf8_lossy(bytes).into_owned().into_bytes(),
            Self::Swapped(place) => mangled[at(*place)..].chunks_exact_mut(4).for_each(<[u8]>::reverse),
            Self::Cut(place) => drop(mangled.drain(at(*place)..(at(*place) + 9).min(bytes.len()))),
            Self::Flipped(place, bit) => mangled[at(*place)] ^= 1 << (bit % 8),
            Self::Doubled(place) => mangled.extend_from_slice(&bytes[at(*place)..]),
        }
        mangled
    }
}

fn mangling() -> impl Strategy<Value = Mangling> {
    prop_oneof![
        Just(Mangling::Lines),
        Just(Mangling::Text),
        any::<usize>().prop_map(Mangling::Swapped),
        any::<usize>().prop_map(Mangling::Cut),
        (any::<usize>(), any::<u8>()).prop_map(|(place, bit)| Mangling::Flipped(place, bit)),
        any::<usize>().prop_map(Mangling::Doubled),
    ]
}

fn assert_sound(pose: &ToolPose) {
    assert!(pose.position.iter().all(|x| x.is_finite()), "{pose:?}");
    let norm: f64 = pose.orientation.iter().map(|x| x * x).sum();
    assert!((norm - 1.0).abs() < 1e-9, "{pose:?}");
}

/// Decodes all; what is a pose is one. Returns the number of messages.
fn decode(bytes: &[u8]) -> usize {
    let (mut decoder, mut n) = (MessageDecoder::new(), 0);
    for chunk in bytes.chunks(777) {
        decoder.decode(chunk, |decoded| {
            if let DecodedMessage::Message(message) = decoded {
                n += 1;
                assert!(message.time.is_none_or(f64::is_finite));
                assert!(message.device.len() <= 20);
                match message.content {
                    MessageContent::Transform(pose) | MessageContent::Position(pose) => assert_sound(&pose),
                    MessageContent::Tools(tools) => tools.iter().for_each(|(_, pose)| assert_sound(pose)),
                    MessageContent::Status { .. } => {}
                }
            }
        });
        assert!(decoder.n_buffered() <= MAX_BUFFERED);
    }
    n
}

#[test]
fn corpus_of_messages_is_survived_and_the_next_one_found() {
    let sound = message(1, b"STATUS", b"Tip", 0, &[&[0, 1][..], &[0; 28], b"ok\0"].concat());
    assert_eq!(decode(&sound), 1);
    for (name, bytes) in corpus("tracker") {
        // Some declare bodies; these are skipped.
        let n = decode(&[bytes, vec![b'-'; 70_000], sound.repeat(2)].concat());
        assert!(n >= 2 || name.contains("swallows"), "{name}: {n}");
    }
}

#[test]
fn no_message_that_was_mangled_on_its_way_does_harm() {
    let case = (prop::collection::vec(any_message(), 1..5), prop::collection::vec(mangling(), 0..3));
    drive("igtl, mangled", 500, MEMORY_MAX, case, |(messages, manglings)| {
        let bytes = manglings.iter().fold(messages.concat(), |bytes, mangling| mangling.apply(&bytes));
        decode(&bytes);
    });
}

#[test]
fn no_content_of_a_message_does_harm() {
    let messages = prop::collection::vec(any_message(), 1..6);
    drive("igtl, contents", 2000, MEMORY_MAX, messages, |messages| {
        decode(&messages.concat());
    });
}
