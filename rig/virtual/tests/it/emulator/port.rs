//! The port itself: its name, its baud, garbage on it, and how long things take.

use super::Bench;
use hysteron_rig::bus::xl430::*;
use hysteron_virtual_rig::emulator::{Options, ServoEmulator, Timing};
use hysteron_virtual_rig::virtual_rig::World;
use std::time::Instant;

#[test]
fn the_name_goes_with_the_emulator() {
    let bench = Bench::new();
    let link = bench.emulator.servo_port().to_owned();
    assert!(link.is_symlink() && link.exists());
    let Bench { host, emulator, folder } = bench;
    drop(emulator);
    assert!(!link.is_symlink());
    drop((host, folder));
}

#[test]
fn a_file_in_the_way_is_kept() {
    let folder = tempfile::tempdir().unwrap();
    let link = folder.path().join("servos");
    std::fs::write(&link, "precious").unwrap();
    let error = ServoEmulator::start(World::idle(1), Options::new(&link)).unwrap_err();
    assert!(error.bad_input().is_some(), "{error}");
    assert_eq!(std::fs::read_to_string(&link).unwrap(), "precious");
}

#[test]
fn impossible_options_are_bad_input() {
    let folder = tempfile::tempdir().unwrap();
    let start = |change: &dyn Fn(&mut Options)| {
        let mut options = Options::new(folder.path().join("servos"));
        change(&mut options);
        ServoEmulator::start(World::idle(1), options).unwrap_err()
    };
    assert_eq!(start(&|options| options.baud = 1).bad_input().unwrap().place, "baud");
    for delay in [-1e-6, 1e-3, f64::NAN] {
        let error = start(&|options| options.return_delay = delay);
        assert_eq!(error.bad_input().unwrap().place, "return delay");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn servos_hear_only_their_baud() {
    let mut bench = Bench::new();
    bench.host.set_baud_rate(57_600).unwrap();
    bench.say(1, 1, &[]);
    assert!(bench.is_silent());
    bench.host.set_baud_rate(1_000_000).unwrap();
    bench.write(1, BAUD, 1).unwrap();
    bench.say(1, 1, &[]);
    assert!(bench.is_silent());
    bench.host.set_baud_rate(57_600).unwrap();
    bench.ask(1, 1, &[]).unwrap();
}

#[test]
fn garbage_and_broken_packets_do_not_deafen() {
    let mut bench = Bench::new();
    for garbage in [&[0xff, 0xff, 0xfd, 0, 1, 200, 3, 2][..], &[0xff; 40], &[0x55, 0xff, 0xff, 0xfd]] {
        bench.host.serial_port().write_all(garbage).unwrap();
        assert_eq!(bench.read(1, ID), 1);
    }
}

#[test]
fn a_host_that_never_reads_stops_nothing() {
    let mut bench = Bench::new();
    for _ in 0..200 {
        // Past the crate, which throws unread answers away.
        bench.host.serial_port().write_all(&[0xff, 0xff, 0xfd, 0, 1, 7, 0, 2, 0, 0, 100, 0, 0, 0]).unwrap();
        bench.host.serial_port().write_all(&[0xff, 0xff, 0xfd, 0, 1, 3, 0, 1, 0x19, 0x4e]).unwrap();
    }
    bench.wait_for("all instructions", |bench| bench.emulator.counts().instructions == 200);
    assert_eq!(bench.read(1, ID), 1);
}

#[test]
fn an_answer_takes_its_time_on_the_wire() {
    let mut bench = Bench::with(|options| {
        options.timing = Timing::Wire;
        options.return_delay = 500e-6;
        options.baud = 57_600;
    });
    bench.host.set_baud_rate(57_600).unwrap();
    // Ping 10 bytes, answer 14: no answer may come sooner.
    let least = 24.0 * 10.0 / 57_600.0 + 500e-6;
    let mut fastest = f64::INFINITY;
    for _ in 0..20 {
        let start = Instant::now();
        bench.ask(1, 1, &[]).unwrap();
        let took = start.elapsed().as_secs_f64();
        assert!(took >= least, "{took} s");
        fastest = fastest.min(took);
    }
    assert!(fastest < 1.5 * least, "{fastest} s for {least} s");
}
