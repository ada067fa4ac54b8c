//! Bytes on the servo bus: to the driver instead of answers, and to the emulated servos instead of instructions.

use super::{assert_memory_is_bounded, cases, corpus};
use hysteron_rig::bus::{ServoBus, xl430};
use hysteron_rig::config::RigConfig;
use hysteron_virtual_rig::emulator::{Options, ServoEmulator, Timing};
use hysteron_virtual_rig::virtual_rig::World;
use proptest::prelude::*;
use serialport::{SerialPort, TTYPort};
use std::io::{Read, Write};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

const RIG: &str = hysteron_rig::config::RIG_FILE;
/// Longest that reading four silent servos may take; a quarter of a second would do on an idle machine.
const PATIENCE: Duration = Duration::from_secs(10);

/// CRC-16 of protocol 2.0.
fn crc16(bytes: &[u8]) -> u16 {
    bytes.iter().fold(0, |crc: u16, byte| {
        (0..8).fold(crc ^ (u16::from(*byte) << 8), |crc, _| {
            if crc >> 15 == 0 { crc << 1 } else { (crc << 1) ^ 0x8005 }
        })
    })
}

/// A packet that states this length, with the checksum over all that is there.
fn packet_of(id: u8, length: u16, body: &[u8]) -> Vec<u8> {
    let mut bytes = vec![0xff, 0xff, 0xfd, 0, id];
    bytes.extend(length.to_le_bytes());
    bytes.extend(body);
    let sum = crc16(&bytes);
    bytes.extend(sum.to_le_bytes());
    bytes
}

/// A packet; its body is not stuffed.
fn packet(id: u8, body: &[u8]) -> Vec<u8> {
    packet_of(id, body.len() as u16 + 2, body)
}

/// The answer of a healthy servo to the read of a cycle.
fn answer(id: u8) -> Vec<u8> {
    packet(id, &[0x55, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 8, 0, 0])
}

/// A driver, and a port that answers every instruction with the same bytes.
struct Stage {
    bus: ServoBus,
    bytes: Arc<Mutex<Vec<u8>>>,
    is_over: Arc<AtomicBool>,
    thread: Option<std::thread::JoinHandle<()>>,
}

impl Stage {
    fn new() -> Self {
        let (mut servos, host) = TTYPort::pair().unwrap();
        servos.set_timeout(Duration::from_millis(20)).unwrap();
        let text = RIG
            .replace("port = \"servos\"", &format!("port = \"{}\"", host.name().unwrap()))
            .replace("reply_timeout_ms = 4.0", "reply_timeout_ms = 1.0")
            .replace("retries = 2", "retries = 0");
        let rig = RigConfig::from_toml(&text, Path::new("")).unwrap();
        let bus = ServoBus::open(&rig.servos, &rig.ids(), Instant::now()).unwrap();
        let bytes = Arc::new(Mutex::new(Vec::new()));
        let is_over = Arc::new(AtomicBool::new(false));
        let (shared, flag) = (Arc::clone(&bytes), Arc::clone(&is_over));
        let thread = std::thread::spawn(move || {
            let _host = host; // kept open
            let mut heard = [0; 1024];
            while !flag.load(Ordering::Relaxed) {
                if servos.read(&mut heard).is_ok_and(|n| n > 0) {
                    let bytes: Vec<u8> = shared.lock().unwrap().clone();
                    // A host that does not read loses the rest.
                    let _ = servos.write_all(&bytes);
                }
            }
        });
        Self { bus, bytes, is_over, thread: Some(thread) }
    }

    /// Everything that the driver reads, answered with these bytes; returns how many servos it heard.
    fn play(&mut self, bytes: &[u8]) -> usize {
        *self.bytes.lock().unwrap() = bytes.to_vec();
        let begin = Instant::now();
        let before = self.bus.counts();
        let mut samples = [None; 4];
        self.bus.read_servos(&mut samples).unwrap();
        let n_heard = samples.iter().flatten().count();
        let (after, mut events) = (self.bus.counts(), Vec::new());
        self.bus.take_events(&mut events);
        let troubles =
            |counts: hysteron_rig::bus::BusCounts| counts.timeouts + counts.corrupt + counts.refused;
        if n_heard < 4 {
            assert_eq!(after.lost - before.lost, 4 - n_heard as u64);
            assert!(after.retries - before.retries >= 4 - n_heard as u64, "asking again is counted");
            assert!(troubles(after) > troubles(before) && !events.is_empty(), "{after:?}");
        }
        assert!(events.len() < 100, "{} events", events.len());
        let mut slow = [None; 4];
        self.bus.read_slow(&mut slow).unwrap();
        for (id, register) in [(1, xl430::PRESENT_POSITION), (2, xl430::TORQUE_ENABLE)] {
            let _ = self.bus.read(id, register);
            let _ = self.bus.write(id, register, 1);
        }
        assert!(begin.elapsed() < PATIENCE, "{:?}", begin.elapsed());
        self.bus.take_events(&mut events);
        n_heard
    }
}

impl Drop for Stage {
    fn drop(&mut self) {
        self.is_over.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            thread.join().unwrap();
        }
    }
}

/// Something that is not a whole answer.
fn damage() -> impl Strategy<Value = Vec<u8>> {
    let length = prop_oneof![0_u16..16, any::<u16>(), Just(u16::MAX), Just(1015), Just(1016), Just(2048)];
    let body = prop::collection::vec(prop_oneof![Just(0xff), Just(0xfd), Just(0x55), any::<u8>()], 0..30);
    prop_oneof![
        // A length that is not that of what follows, its checksum right where it then ends.
        (any::<u8>(), length, prop::collection::vec(any::<u8>(), 0..4))
            .prop_map(|(id, length, body)| packet_of(id, length, &body)),
        // The echo of an instruction.
        (any::<u8>(), 0_u8..0xa0).prop_map(|(id, instruction)| packet(id, &[instruction])),
        // Answers of any content, to another question, of another servo.
        (any::<u8>(), body).prop_map(|(id, body)| packet(id, &[&[0x55][..], &body].concat())),
        // Answers cut off.
        (1_u8..5, 0_usize..23).prop_map(|(id, n)| answer(id)[..n].to_vec()),
        // One bit turned round.
        (1_u8..5, 0_usize..23, 0..8).prop_map(|(id, at, bit)| {
            let mut bytes = answer(id);
            bytes[at] ^= 1_u8 << bit;
            bytes
        }),
        prop::collection::vec(any::<u8>(), 0..300),
    ]
}

#[test]
fn corpus_of_answers_is_passed_over() {
    let whole: Vec<u8> = (1..5).flat_map(answer).collect();
    let mut stage = Stage::new();
    assert!((0..20).any(|_| stage.play(&whole) == 4));
    for (name, bytes) in corpus("answers") {
        stage.play(&bytes);
        // A machine with other work to do is late now and then.
        let all = [&bytes[..], &whole].concat();
        let is_heard = (0..20).any(|_| stage.play(&all) == 4);
        assert!(is_heard || name.contains("swallows"), "{name}: not all servos heard behind it");
        assert!(stage.bus.discover().unwrap().len() < 10);
    }
    assert!((0..20).any(|_| stage.play(&whole) == 4));
    assert_memory_is_bounded();
}

/// Instructions with the right checksum and any content, and bytes that are none.
fn instruction() -> impl Strategy<Value = Vec<u8>> {
    let id = prop_oneof![0_u8..6, Just(0xfe), any::<u8>()];
    let number = prop_oneof![
        4 => prop::sample::select(vec![1_u8, 2, 3, 4, 5, 8, 0x10, 0x20, 0x82, 0x83, 0x8a, 0x92, 0x93, 0x9a]),
        1 => any::<u8>(),
    ];
    let word = prop_oneof![Just(64_u16), Just(116), Just(224), Just(634), 0_u16..700, any::<u16>()];
    let words = prop::collection::vec(word, 0..12)
        .prop_map(|words| words.iter().flat_map(|word| word.to_le_bytes()).collect::<Vec<u8>>());
    let tail = prop::collection::vec(any::<u8>(), 0..12);
    let whole = (id, number, words, tail)
        .prop_map(|(id, number, words, tail)| packet(id, &[&[number][..], &words, &tail].concat()));
    prop_oneof![6 => whole, 1 => damage()]
}

/// Sends all of it to emulated servos; they must live, and answer what comes after it.
fn instruct(packets: &[Vec<u8>]) {
    let folder = tempfile::tempdir().unwrap();
    let mut options = Options::new(folder.path().join("servos"));
    (options.return_delay, options.timing) = (0.0, Timing::Relaxed);
    let emulator = ServoEmulator::start(World::idle(4), options).unwrap();
    let mut host = serialport::new(emulator.servo_port().to_string_lossy(), 1_000_000).open_native().unwrap();
    host.set_timeout(Duration::from_millis(100)).unwrap();
    let begin = Instant::now();
    for packet in packets {
        host.write_all(packet).unwrap();
    }
    // An unfinished packet is discarded after a silence; a header ends it at once. Whoever changed its baud is deaf,
    // but hears that there was something.
    let ping = packet(0xfe, &[1]);
    let before = emulator.counts();
    let mut n_pings = 0;
    loop {
        host.write_all(&ping).unwrap();
        n_pings += 1;
        std::thread::sleep(Duration::from_millis(2));
        let counts = emulator.counts();
        if n_pings > 3 && counts.instructions > before.instructions + 1 {
            break;
        }
        assert!(begin.elapsed() < PATIENCE && emulator.is_running(), "{counts:?}");
    }
    assert!(emulator.is_running());
}

#[test]
fn corpus_of_instructions_stops_no_servo() {
    for (_, bytes) in corpus("instructions") {
        instruct(&[bytes]);
    }
}

proptest! {
    #![proptest_config(cases(100))]

    #[test]
    fn no_answer_stops_the_driver(chunks in prop::collection::vec(prop_oneof![2 => damage(), 1 => (1_u8..5).prop_map(answer)], 0..8)) {
        let mut stage = Stage::new();
        stage.play(&chunks.concat());
        assert_memory_is_bounded();
    }

    #[test]
    fn no_instruction_stops_the_servos(packets in prop::collection::vec(instruction(), 1..12)) {
        instruct(&packets);
        assert_memory_is_bounded();
    }
}
