//! How long a cycle on the emulated bus takes, beside the time that its bytes take on the wire.
//!
//! A cycle is a sync write of four goals and a sync read of 12 bytes from four servos, at 1 Mbaud without return delay.
//! Prints `median`, `p99` and the wire time [µs]: `cargo run --release -p hysteron-rig --example bus_cycle`.

use std::io::Write;
use std::time::{Duration, Instant};

use dynamixel2::Bus;
use hysteron_rig::virtual_rig::World;
use hysteron_rig::virtual_rig::emulator::{Emulator, Options, Timing};

/// Bytes of the sync write, the sync read and the four answers.
const N_BYTES: u32 = 34 + 18 + 4 * 23;
const N_CYCLES: usize = 2000;
const BAUD: u32 = 1_000_000;
const SERVOS: [u8; 4] = [1, 2, 3, 4];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let wire = 1e6 * f64::from(N_BYTES) * 10.0 / f64::from(BAUD);
    writeln!(std::io::stdout(), "wire time {wire:.0} us")?;
    for timing in [Timing::Wire, Timing::Relaxed] {
        let folder = tempfile::tempdir()?;
        let options = Options { timing, return_delay: 0.0, ..Options::new(folder.path().join("servos")) };
        let emulator = Emulator::start(World::idle(SERVOS.len()), options)?;
        let mut bus = Bus::open(emulator.servo_port(), BAUD)?;
        let mut goals = vec![116, 0, 4, 0];
        for id in SERVOS {
            goals.push(id);
            goals.extend(2048u32.to_le_bytes());
        }
        let read = [&[126, 0, 12, 0], &SERVOS[..]].concat();
        let mut times = Vec::with_capacity(N_CYCLES);
        let mut n_lost = 0;
        for _ in 0..N_CYCLES {
            let start = Instant::now();
            bus.write_instruction(0xfe, 0x83, goals.len(), |to| to.copy_from_slice(&goals))?;
            bus.write_instruction(0xfe, 0x82, read.len(), |to| to.copy_from_slice(&read))?;
            for _ in SERVOS {
                let answer = bus.read_status_response_deadline(start + Duration::from_millis(50));
                n_lost += u32::from(!answer.is_ok_and(|packet| packet.parameters().len() == 12));
            }
            times.push(1e6 * start.elapsed().as_secs_f64());
        }
        times.sort_by(f64::total_cmp);
        let (median, p99) = (times[N_CYCLES / 2], times[N_CYCLES * 99 / 100]);
        writeln!(
            std::io::stdout(),
            "{timing:?}: median {median:.0} us ({:.2} x wire), p99 {p99:.0} us, {n_lost} answers lost, {:?}",
            median / wire,
            emulator.counts()
        )?;
    }
    Ok(())
}
