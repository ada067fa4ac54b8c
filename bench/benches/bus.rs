//! A cycle on the servo bus, through a pseudo-terminal to four emulated servos that keep the times of the wire at
//! 1 Mbaud without return delay: a goal to each servo, and load, speed and position from each.
//!
//! `driver` is ours. The baselines are the crate `dynamixel2` alone: the same two instructions, and one write and one
//! read per servo.
#![allow(missing_docs)] // criterion's macros make undocumented functions
#![allow(clippy::unwrap_used, clippy::print_stdout)] // a benchmark may stop where it stands, and prints its proof

use std::path::Path;
use std::time::{Duration, Instant};

use criterion::{Criterion, criterion_group, criterion_main};
use dynamixel2::Bus;
use hysteron_rig::bus::ServoBus;
use hysteron_rig::config::RigConfig;
use hysteron_virtual_rig::emulator::{Options, ServoEmulator};
use hysteron_virtual_rig::virtual_rig::{VirtualRobot, World, rig_file};

const BAUD: u32 = 1_000_000;
const SERVOS: [u8; 4] = [1, 2, 3, 4];
const PATIENCE: Duration = Duration::from_millis(50);
/// Goal position, and what lies from load to position.
const GOAL: [u8; 4] = [116, 0, 4, 0];
const PRESENT: [u8; 4] = [126, 0, 10, 0];

fn emulator(folder: &Path) -> ServoEmulator {
    let options = Options { return_delay: 0.0, ..Options::new(folder.join("servos")) };
    ServoEmulator::start(World::idle(SERVOS.len()), options).unwrap()
}

/// Time of so many bytes on the wire, for people.
fn wire(what: &str, n_bytes: usize) {
    println!("    {what}: {n_bytes} bytes, {:.3} ms on the wire", 1e4 * n_bytes as f64 / f64::from(BAUD));
}

fn driver(criterion: &mut Criterion) {
    let folder = tempfile::tempdir().unwrap();
    let emulator = emulator(folder.path());
    let robot = VirtualRobot::preset("typical").unwrap();
    let rig = RigConfig::from_toml(&rig_file(&robot), folder.path()).unwrap();
    let mut bus = ServoBus::open(&rig.servos, &rig.ids(), Instant::now()).unwrap();
    bus.configure().unwrap();
    let mut samples = [None; 4];
    criterion.bench_function("bus/driver/sync write, sync read", |bencher| {
        bencher.iter(|| {
            bus.write_goals(&[2048; 4]).unwrap();
            bus.read_servos(&mut samples).unwrap();
        });
    });
    assert!(samples.iter().all(Option::is_some));
    println!("    {:.3} ms on the wire; {:?}", 1e3 * bus.cycle_wire_time(), bus.counts());
    drop(emulator);
}

/// Waits for an answer; whether it came whole.
fn hear(bus: &mut Bus<Vec<u8>, Vec<u8>>, length: usize) -> bool {
    let answer = bus.read_status_response_deadline(Instant::now() + PATIENCE);
    answer.is_ok_and(|answer| answer.parameters().len() == length)
}

fn say(bus: &mut Bus<Vec<u8>, Vec<u8>>, id: u8, instruction: u8, parameters: &[u8]) {
    bus.write_instruction(id, instruction, parameters.len(), |to| to.copy_from_slice(parameters)).unwrap();
}

fn crate_alone(criterion: &mut Criterion) {
    let folder = tempfile::tempdir().unwrap();
    let emulator = emulator(folder.path());
    let mut bus = Bus::open(emulator.servo_port(), BAUD).unwrap();
    let (mut n_lost, position) = (0, 2048_u32.to_le_bytes());
    let goals = [&GOAL[..], &SERVOS.map(|id| [&[id], &position[..]].concat()).concat()].concat();
    let asked = [&PRESENT[..], &SERVOS[..]].concat();
    criterion.bench_function("bus/dynamixel2/sync write, sync read", |bencher| {
        bencher.iter(|| {
            say(&mut bus, 0xfe, 0x83, &goals);
            say(&mut bus, 0xfe, 0x82, &asked);
            n_lost += SERVOS.iter().filter(|_| !hear(&mut bus, 10)).count();
        });
    });
    wire("the same", 34 + 18 + 4 * 21);
    let goal = [&GOAL[..2], &position[..]].concat();
    criterion.bench_function("bus/dynamixel2/write and read of each", |bencher| {
        bencher.iter(|| {
            for id in SERVOS {
                say(&mut bus, id, 3, &goal);
                n_lost += usize::from(!hear(&mut bus, 0));
                say(&mut bus, id, 2, &PRESENT);
                n_lost += usize::from(!hear(&mut bus, 10));
            }
        });
    });
    wire("the same", 4 * (16 + 11 + 14 + 21));
    println!("    {n_lost} answers lost; {:?}", emulator.counts());
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(50).measurement_time(Duration::from_secs(4));
    targets = driver, crate_alone
}
criterion_main!(benches);
