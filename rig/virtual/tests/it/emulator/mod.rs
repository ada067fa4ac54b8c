//! The emulated servos, asked by the crate `dynamixel2` through the port.

mod faults;
mod instructions;
mod motion;
mod port;

use dynamixel2::{Bus, ReadError};
use hysteron_rig::bus::xl430::{self, ControlRegister};
use hysteron_virtual_rig::emulator::{Options, ServoEmulator, Timing};
use hysteron_virtual_rig::virtual_rig::World;
use std::time::{Duration, Instant};

/// Longest wait for an answer; a machine with other work to do is late now and then.
const PATIENCE: Duration = Duration::from_secs(2);
/// Longest wait for an answer that should not come.
const SILENCE: Duration = Duration::from_millis(60);

/// Four emulated servos and a host.
pub struct Bench {
    pub host: Bus<Vec<u8>, Vec<u8>>,
    pub emulator: ServoEmulator,
    folder: tempfile::TempDir,
}

/// Answer of a servo: alert bit and parameters, or an error number.
type Answer = Result<(bool, Vec<u8>), u8>;

impl Bench {
    pub fn new() -> Self {
        Self::with(|_| {})
    }

    pub fn with(change: impl FnOnce(&mut Options)) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let mut options = Options::new(folder.path().join("servos"));
        options.return_delay = 0.0;
        options.timing = Timing::Relaxed;
        options.logs = Some(folder.path().to_owned());
        change(&mut options);
        let emulator = ServoEmulator::start(World::idle(4), options).unwrap();
        let host = Self::open(&emulator, 1_000_000);
        Self { host, emulator, folder }
    }

    pub fn open(emulator: &ServoEmulator, baud: u32) -> Bus<Vec<u8>, Vec<u8>> {
        Bus::open_with_buffers(emulator.servo_port(), baud, vec![0; 1024], vec![0; 1024]).unwrap()
    }

    pub fn text(&self, name: &str) -> String {
        std::fs::read_to_string(self.folder.path().join(name)).unwrap()
    }

    pub fn say(&mut self, id: u8, instruction: u8, parameters: &[u8]) {
        self.host
            .write_instruction(id, instruction, parameters.len(), |to| to.copy_from_slice(parameters))
            .unwrap();
    }

    /// The next answer: its servo and its data, or the error number.
    pub fn hear(&mut self) -> (u8, Answer) {
        match self.host.read_status_response_deadline(Instant::now() + PATIENCE) {
            Ok(packet) => (packet.packet_id(), Ok((packet.alert(), packet.parameters().to_vec()))),
            Err(ReadError::MotorError(error)) => (0, Err(error.raw)),
            Err(error) => panic!("{error}"),
        }
    }

    pub fn is_silent(&mut self) -> bool {
        match self.host.read_status_response_deadline(Instant::now() + SILENCE) {
            Err(ReadError::Io(error)) => error.kind() == std::io::ErrorKind::TimedOut,
            _ => false,
        }
    }

    pub fn ask(&mut self, id: u8, instruction: u8, parameters: &[u8]) -> Answer {
        self.say(id, instruction, parameters);
        self.hear().1
    }

    pub fn write(&mut self, id: u8, register: ControlRegister, value: i64) -> Result<bool, u8> {
        let data = &value.to_le_bytes()[..usize::from(register.size)];
        let parameters = [&register.address.to_le_bytes(), data].concat();
        self.ask(id, 3, &parameters).map(|(alert, _)| alert)
    }

    pub fn read(&mut self, id: u8, register: ControlRegister) -> i64 {
        let [low, high] = register.address.to_le_bytes();
        let (_, bytes) = self.ask(id, 2, &[low, high, register.size, 0]).unwrap();
        assert_eq!(bytes.len(), usize::from(register.size));
        let mut value = [if bytes[bytes.len() - 1] >= 0x80 && register.size == 4 { 0xff } else { 0 }; 8];
        value[..bytes.len()].copy_from_slice(&bytes);
        i64::from_le_bytes(value)
    }

    /// Waits until something holds.
    pub fn wait_for(&mut self, what: &str, mut holds: impl FnMut(&mut Self) -> bool) {
        let start = Instant::now();
        while !holds(self) {
            assert!(start.elapsed() < Duration::from_secs(10), "{what} never came");
            std::thread::sleep(Duration::from_millis(5));
        }
    }

    /// Waits until a servo answers again.
    pub fn wait_awake(&mut self, id: u8) {
        self.wait_for("an answer", |bench| {
            bench.say(id, 1, &[]);
            !bench.is_silent()
        });
    }

    pub fn torque(&mut self, on: bool) {
        for id in 1..=4 {
            self.write(id, xl430::TORQUE_ENABLE, i64::from(on)).unwrap();
        }
    }
}
