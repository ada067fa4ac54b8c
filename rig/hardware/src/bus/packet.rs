//! Packets of protocol 2.0: the driver takes answers out of the bytes of the port with it, the emulated servos take
//! instructions, and write their answers.
//!
//! Written from the e-Manual. `dynamixel2`, which writes the driver's instructions and is the host in the emulator's
//! tests, and ROBOTIS's own SDK (`tests/peers`) check it. A packet is `FF FF FD 00`, id, length (2 bytes),
//! instruction, parameters, CRC-16. After `FF FF FD` inside the instruction and its parameters another `FD` is
//! stuffed, so the header appears nowhere else.

/// Header of a packet.
const HEADER: [u8; 4] = [0xff, 0xff, 0xfd, 0x00];
/// Bytes before those that the length counts: header, id, length.
const PREFIX: usize = 7;
/// Largest plausible length; the longest answer is a read of the whole control table.
const MAX_LENGTH: usize = 2048;
/// Id that addresses all servos.
pub const BROADCAST: u8 = 0xfe;
/// Instruction number of answers.
pub const STATUS: u8 = 0x55;

/// Item that the decoder found.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum DecodedPacket {
    /// A whole packet.
    Packet {
        /// Whom it addresses.
        id: u8,
        /// Instruction number and parameters, without stuffing; never empty.
        body: Vec<u8>,
        /// Bytes that it took on the wire.
        wire_len: usize,
    },
    /// A packet whose checksum is wrong, with its id.
    BadChecksum {
        /// Whom it seemed to address.
        id: u8,
        /// Bytes that it took on the wire.
        wire_len: usize,
    },
}

/// Finds packets in a stream of bytes, with any segmentation and any bytes between them.
#[derive(Debug, Default)]
pub struct PacketDecoder {
    bytes: Vec<u8>,
}

impl PacketDecoder {
    /// Takes bytes as they came.
    pub fn push(&mut self, bytes: &[u8]) {
        self.bytes.extend_from_slice(bytes);
    }

    /// Whether bytes wait for the rest of their packet.
    pub fn is_waiting(&self) -> bool {
        !self.bytes.is_empty()
    }

    /// Forgets a packet that never became whole.
    pub fn clear(&mut self) {
        self.bytes.clear();
    }

    /// The next packet, if one is whole. Call until `None`; then at most one unfinished packet is kept.
    pub fn next_packet(&mut self) -> Option<DecodedPacket> {
        loop {
            let start = find_header(&self.bytes);
            self.bytes.drain(..start);
            if self.bytes.len() < PREFIX {
                return None;
            }
            let length = usize::from(u16::from_le_bytes([self.bytes[5], self.bytes[6]]));
            if !(3..=MAX_LENGTH).contains(&length) {
                self.bytes.drain(..HEADER.len());
                continue;
            }
            let end = PREFIX + length;
            // A header inside a body: the packet broke off and another began.
            let inside = &self.bytes[HEADER.len()..self.bytes.len().min(end - 2)];
            if let Some(at) = inside.windows(HEADER.len()).position(|window| window == HEADER) {
                self.bytes.drain(..HEADER.len() + at);
                continue;
            }
            if self.bytes.len() < end {
                return None;
            }
            let id = self.bytes[4];
            let stated = u16::from_le_bytes([self.bytes[end - 2], self.bytes[end - 1]]);
            if checksum(&self.bytes[..end - 2]) != stated {
                // The length may be what is wrong: look for the next header right behind this one.
                self.bytes.drain(..HEADER.len());
                return Some(DecodedPacket::BadChecksum { id, wire_len: end });
            }
            let body = unstuffed(&self.bytes[PREFIX..end - 2]);
            self.bytes.drain(..end);
            return Some(DecodedPacket::Packet { id, body, wire_len: end });
        }
    }
}

/// First position of a header or of the beginning of one.
fn find_header(bytes: &[u8]) -> usize {
    (0..bytes.len())
        .find(|&at| bytes[at..].iter().zip(&HEADER).all(|(byte, expected)| byte == expected))
        .unwrap_or(bytes.len())
}

fn unstuffed(stuffed: &[u8]) -> Vec<u8> {
    let mut body = Vec::with_capacity(stuffed.len());
    // Bytes FF FF FD just seen, as a count; after all three a stuffed FD follows and goes.
    let mut n_matched = 0;
    for &byte in stuffed {
        if n_matched == 3 {
            n_matched = 0;
            if byte == 0xfd {
                continue;
            }
        }
        n_matched = next_match(n_matched, byte);
        body.push(byte);
    }
    body
}

fn stuffed(body: &[u8]) -> Vec<u8> {
    let mut wire = Vec::with_capacity(body.len() + 2);
    let mut n_matched = 0;
    for &byte in body {
        n_matched = next_match(n_matched, byte);
        wire.push(byte);
        if n_matched == 3 {
            wire.push(0xfd);
            n_matched = 0;
        }
    }
    wire
}

/// How much of FF FF FD has been seen after one more byte.
fn next_match(n_matched: usize, byte: u8) -> usize {
    match (n_matched, byte) {
        (2, 0xfd) => 3,
        (1 | 2, 0xff) => 2,
        (_, 0xff) => 1,
        _ => 0,
    }
}

/// A packet with this body: instruction number and parameters.
pub fn packet(id: u8, body: &[u8]) -> Vec<u8> {
    let body = stuffed(body);
    let mut bytes = opened(id, body.len() + 2);
    bytes.extend_from_slice(&body);
    close(&mut bytes);
    bytes
}

/// The answer of a servo: error byte and parameters.
pub fn status(id: u8, error: u8, parameters: &[u8]) -> Vec<u8> {
    let mut body = vec![STATUS, error];
    body.extend_from_slice(parameters);
    packet(id, &body)
}

/// The one answer to a fast read: of every servo error byte, id, data and the checksum of all so far. Not stuffed.
pub fn fast_status(parts: &[(u8, u8, Vec<u8>)]) -> Vec<u8> {
    let length = 1 + parts.iter().map(|(_, _, data)| data.len() + 4).sum::<usize>();
    let mut bytes = opened(BROADCAST, length);
    bytes.push(STATUS);
    for (error, id, data) in parts {
        bytes.extend_from_slice(&[*error, *id]);
        bytes.extend_from_slice(data);
        close(&mut bytes);
    }
    bytes
}

fn opened(id: u8, length: usize) -> Vec<u8> {
    let [low, high] = u16::try_from(length).unwrap_or(u16::MAX).to_le_bytes();
    let mut bytes = HEADER.to_vec();
    bytes.extend_from_slice(&[id, low, high]);
    bytes
}

fn close(bytes: &mut Vec<u8>) {
    let sum = checksum(bytes);
    bytes.extend_from_slice(&sum.to_le_bytes());
}

/// CRC-16 with the polynomial x¹⁶ + x¹⁵ + x² + 1, from 0, highest bit first.
fn checksum(bytes: &[u8]) -> u16 {
    const TABLE: [u16; 256] = table();
    bytes.iter().fold(0, |sum, &byte| (sum << 8) ^ TABLE[usize::from((sum >> 8) as u8 ^ byte)])
}

const fn table() -> [u16; 256] {
    let mut table = [0; 256];
    let mut i = 0;
    while i < 256 {
        let mut sum = (i as u16) << 8;
        let mut bit = 0;
        while bit < 8 {
            sum = if sum & 0x8000 == 0 { sum << 1 } else { (sum << 1) ^ 0x8005 };
            bit += 1;
        }
        table[i] = sum;
        i += 1;
    }
    table
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)] // a test may stop where it stands
    use super::*;
    use proptest::prelude::*;

    fn decoded(bytes: &[u8]) -> Vec<DecodedPacket> {
        let mut decoder = PacketDecoder::default();
        decoder.push(bytes);
        std::iter::from_fn(|| decoder.next_packet()).collect()
    }

    fn is_packet(found: &DecodedPacket, id: u8, body: &[u8]) -> bool {
        matches!(found, DecodedPacket::Packet { id: i, body: b, .. } if *i == id && b == body)
    }

    /// Bodies rich in what must be stuffed.
    fn body() -> impl Strategy<Value = Vec<u8>> {
        proptest::collection::vec(prop_oneof![Just(0xff), Just(0xfd), Just(0), any::<u8>()], 1..120)
    }

    #[test]
    fn packets_of_the_manual_are_reproduced() {
        // e-Manual, protocol 2.0: ping of servo 1, and read of its present position, with its answer.
        assert_eq!(packet(1, &[1]), [0xff, 0xff, 0xfd, 0, 1, 3, 0, 1, 0x19, 0x4e]);
        let read = [0xff, 0xff, 0xfd, 0, 1, 7, 0, 2, 0x84, 0, 4, 0, 0x1d, 0x15];
        assert_eq!(packet(1, &[2, 0x84, 0, 4, 0]), read);
        let answer = [0xff, 0xff, 0xfd, 0, 1, 8, 0, 0x55, 0, 0xa6, 0, 0, 0, 0x8c, 0xc0];
        assert_eq!(status(1, 0, &[0xa6, 0, 0, 0]), answer);
    }

    #[test]
    fn a_header_in_the_data_is_stuffed() {
        let bytes = packet(1, &[3, 0xff, 0xff, 0xfd, 0x00]);
        assert_eq!(bytes[7..13], [3, 0xff, 0xff, 0xfd, 0xfd, 0x00]);
        assert_eq!(bytes[5], 8);
    }

    #[test]
    fn a_packet_that_broke_off_does_not_hide_the_next() {
        let whole = packet(2, &[2, 132, 0, 4, 0]);
        for kept in 4..whole.len() {
            let bytes = [&whole[..kept], &packet(3, &[1])].concat();
            assert!(is_packet(decoded(&bytes).last().unwrap(), 3, &[1]), "after {kept} bytes");
        }
    }

    #[test]
    fn a_wrong_checksum_is_reported_and_passed() {
        let mut bytes = packet(2, &[2, 132, 0, 4, 0]);
        bytes[9] ^= 1;
        bytes.extend(packet(3, &[1]));
        let found = decoded(&bytes);
        assert_eq!(found[0], DecodedPacket::BadChecksum { id: 2, wire_len: 14 });
        assert!(is_packet(&found[1], 3, &[1]));
    }

    #[test]
    fn memory_is_bounded() {
        let mut decoder = PacketDecoder::default();
        for _ in 0..1000 {
            decoder.push(&[0xff; 1000]);
            assert_eq!(decoder.next_packet(), None);
            assert!(decoder.bytes.len() < 4);
        }
    }

    /// A part of a stream: a whole packet, one with a field that lies, or bytes that are none.
    #[derive(Debug, Clone)]
    enum StreamPart {
        Whole(u8, Vec<u8>),
        Broken(Vec<u8>),
    }

    fn part() -> impl Strategy<Value = StreamPart> {
        let whole = (0u8..=0xfe, body());
        let broken =
            (0u8..=0xfe, body(), 0..6, any::<u16>(), any::<u8>()).prop_map(|(id, body, how, word, byte)| {
                let mut bytes = packet(id, &body);
                let at = usize::from(word) % bytes.len();
                match how {
                    0 => bytes[at] ^= 1 << (byte % 8),
                    1 => bytes.truncate(at),
                    2 => drop(bytes.remove(at)),
                    3 => bytes.insert(at, byte),
                    4 => bytes[5..7].copy_from_slice(&word.to_le_bytes()),
                    // A length that lies, with a checksum that is right where it then ends.
                    _ => {
                        bytes = opened(id, usize::from(word) % (body.len() + 40));
                        bytes.extend(&body);
                        close(&mut bytes);
                    }
                }
                StreamPart::Broken(bytes)
            });
        let noise =
            proptest::collection::vec(prop_oneof![Just(0xff), Just(0xfd), Just(0), any::<u8>()], 0..80);
        prop_oneof![
            2 => whole.prop_map(|(id, body)| StreamPart::Whole(id, body)),
            3 => broken,
            1 => noise.prop_map(StreamPart::Broken),
        ]
    }

    #[test]
    fn no_stream_of_packets_that_lie_stops_the_decoder() {
        const MEMORY_MAX: u64 = 256 << 20;
        let case = (proptest::collection::vec(part(), 0..12), 1usize..300);
        hysteron_fuzz::drive("dynamixel/stream", 500, MEMORY_MAX, case, |(parts, cut)| {
            let mut bytes = Vec::new();
            for part in &parts {
                match part {
                    StreamPart::Whole(id, body) => bytes.extend(packet(*id, body)),
                    StreamPart::Broken(broken) => bytes.extend(broken),
                }
            }
            let (mut decoder, mut found) = (PacketDecoder::default(), Vec::new());
            for chunk in bytes.chunks(cut) {
                decoder.push(chunk);
                found.extend(std::iter::from_fn(|| decoder.next_packet()));
                assert!(decoder.bytes.len() <= PREFIX + MAX_LENGTH);
            }
            // Packets before the first damage are read unchanged.
            for (part, found) in parts.iter().zip(&found) {
                let StreamPart::Whole(id, body) = part else { break };
                assert!(is_packet(found, *id, body));
            }
        });
    }

    proptest! {
        #[test]
        fn what_is_written_is_read(id in 0u8..=0xfe, body in body()) {
            let found = decoded(&packet(id, &body));
            prop_assert_eq!(found.len(), 1);
            prop_assert!(is_packet(&found[0], id, &body));
        }

        #[test]
        fn any_cut_gives_the_same(bodies in proptest::collection::vec(body(), 1..4), cuts in proptest::collection::vec(1usize..30, 1..20)) {
            let bytes: Vec<u8> = bodies.iter().flat_map(|body| packet(7, body)).collect();
            let mut decoder = PacketDecoder::default();
            let mut found = Vec::new();
            let mut rest = &bytes[..];
            for cut in cuts.iter().cycle() {
                let (now, later) = rest.split_at((*cut).min(rest.len()));
                decoder.push(now);
                found.extend(std::iter::from_fn(|| decoder.next_packet()));
                rest = later;
                if rest.is_empty() { break }
            }
            prop_assert_eq!(found.len(), bodies.len());
            for (found, body) in found.iter().zip(&bodies) {
                prop_assert!(is_packet(found, 7, body));
            }
        }

        #[test]
        fn noise_around_a_packet_does_not_hide_it(before in proptest::collection::vec(any::<u8>(), 0..60), body in body(), after in proptest::collection::vec(any::<u8>(), 0..60)) {
            let bytes = [before, packet(9, &body), after].concat();
            prop_assert!(decoded(&bytes).iter().any(|found| is_packet(found, 9, &body)));
        }

        #[test]
        fn any_bytes_are_survived(bytes in proptest::collection::vec(prop_oneof![Just(0xff), Just(0xfd), Just(0), any::<u8>()], 0..3000)) {
            let mut decoder = PacketDecoder::default();
            decoder.push(&bytes);
            while decoder.next_packet().is_some() {}
            prop_assert!(decoder.bytes.len() <= PREFIX + MAX_LENGTH);
        }
    }
}
