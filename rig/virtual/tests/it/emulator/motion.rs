//! Goals, limits, and everything that takes the torque away.

use super::Bench;
use hysteron_rig::bus::xl430::*;
use hysteron_virtual_rig::emulator::{BusFault, FaultKind};
use std::time::Duration;

#[test]
fn a_servo_goes_to_its_goal() {
    let mut bench = Bench::new();
    assert_eq!(bench.read(1, PRESENT_POSITION), 2048);
    bench.torque(true);
    assert_eq!(bench.read(1, GOAL_POSITION), 2048);
    bench.write(1, GOAL_POSITION, 2300).unwrap();
    bench.wait_for("the goal", |bench| bench.read(1, PRESENT_POSITION) == 2300);
    assert_eq!(bench.read(1, MOVING_STATUS) & 1, 1);
    assert_eq!(bench.read(2, PRESENT_POSITION), 2048);
}

#[test]
fn without_torque_nothing_moves_and_torque_holds_where_it_is() {
    let mut bench = Bench::new();
    bench.write(1, GOAL_POSITION, 3000).unwrap();
    std::thread::sleep(Duration::from_millis(50));
    assert_eq!(bench.read(1, PRESENT_POSITION), 2048);
    bench.torque(true);
    std::thread::sleep(Duration::from_millis(50));
    assert_eq!(bench.read(1, PRESENT_POSITION), 2048);
}

#[test]
fn turns_count_in_extended_mode_until_a_restart() {
    let mut bench = Bench::new();
    bench.write(1, OPERATING_MODE, i64::from(mode::EXTENDED_POSITION)).unwrap();
    bench.torque(true);
    bench.write(1, GOAL_POSITION, -100).unwrap();
    bench.wait_for("the goal", |bench| bench.read(1, PRESENT_POSITION) == -100);
    bench.wait_for("standstill", |bench| bench.read(1, MOVING) == 0);
    bench.ask(1, 0x10, &[0x01, 0x44, 0x58, 0x4c, 0x22]).unwrap();
    assert_eq!(bench.read(1, PRESENT_POSITION), 3996);
    // It stays where it is, and goals count from the new zero.
    std::thread::sleep(Duration::from_millis(50));
    assert_eq!(bench.read(1, PRESENT_POSITION), 3996);
    bench.write(1, GOAL_POSITION, 4200).unwrap();
    bench.wait_for("the goal", |bench| bench.read(1, PRESENT_POSITION) == 4200);
    bench.ask(1, 8, &[]).unwrap();
    bench.wait_awake(1);
    assert_eq!(bench.read(1, PRESENT_POSITION), 4200 - 4096);
}

#[test]
fn direction_and_offset_change_what_is_read_not_where_it_stands() {
    let mut bench = Bench::new();
    bench.write(1, HOMING_OFFSET, 100).unwrap();
    assert_eq!(bench.read(1, PRESENT_POSITION), 2148);
    bench.torque(true);
    std::thread::sleep(Duration::from_millis(30));
    assert_eq!(bench.read(1, PRESENT_POSITION), 2148);
    bench.torque(false);
    bench.write(1, OPERATING_MODE, i64::from(mode::EXTENDED_POSITION)).unwrap();
    bench.write(1, DRIVE_MODE, 1).unwrap();
    assert_eq!(bench.read(1, PRESENT_POSITION), -2048 + 100);
    let angle = bench.emulator.world().lock().unwrap().servo(0).state.angle;
    bench.torque(true);
    let goal = bench.read(1, GOAL_POSITION);
    bench.write(1, GOAL_POSITION, goal + 50).unwrap();
    bench.wait_for("the goal", |bench| bench.read(1, PRESENT_POSITION) == goal + 50);
    assert!(bench.emulator.world().lock().unwrap().servo(0).state.angle < angle);
}

#[test]
fn the_watchdog_trips_in_silence_and_refuses_goals_until_cleared() {
    let mut bench = Bench::new();
    bench.torque(true);
    // 2 s, so that no hiccup of the machine trips it early.
    bench.write(1, PROFILE_VELOCITY, 1).unwrap();
    bench.write(1, BUS_WATCHDOG, 100).unwrap();
    bench.write(1, GOAL_POSITION, 4000).unwrap();
    assert_eq!(bench.read(1, BUS_WATCHDOG), 100);
    std::thread::sleep(Duration::from_millis(2400));
    assert_eq!(bench.read(1, BUS_WATCHDOG), 0xff);
    assert_eq!(bench.write(1, GOAL_POSITION, 2048), Err(4));
    let here = bench.read(1, PRESENT_POSITION);
    std::thread::sleep(Duration::from_millis(50));
    assert_eq!(bench.read(1, PRESENT_POSITION), here);
    bench.write(1, BUS_WATCHDOG, 0).unwrap();
    bench.write(1, GOAL_POSITION, 2048).unwrap();
}

#[test]
fn an_overload_takes_the_torque_until_a_reboot() {
    let mut bench = Bench::new();
    bench.torque(true);
    bench.emulator.inject(BusFault::new(0.0, FaultKind::Overload).of_servo(2)).unwrap();
    bench.wait_for("the shutdown", |bench| bench.emulator.torque_on() == [true, false, true, true]);
    assert_eq!(bench.read(2, HARDWARE_ERROR), i64::from(error_bit::OVERLOAD));
    assert!(bench.ask(2, 1, &[]).unwrap().0, "no alert");
    assert_eq!(bench.write(2, TORQUE_ENABLE, 1), Err(0x81));
    bench.ask(2, 8, &[]).unwrap();
    bench.wait_awake(2);
    assert_eq!(bench.write(2, TORQUE_ENABLE, 1), Ok(false));
}

#[test]
fn heat_switches_torque_off_only_with_the_shutdown_mask() {
    let mut bench = Bench::new();
    bench.write(1, SHUTDOWN, 0).unwrap();
    bench.torque(true);
    for id in [1, 2] {
        bench.emulator.inject(BusFault::new(0.0, FaultKind::Overheat).of_servo(id).lasting(0.3)).unwrap();
    }
    bench.wait_for("the shutdown", |bench| bench.emulator.torque_on() == [true, false, true, true]);
    assert!(bench.read(2, PRESENT_TEMPERATURE) > 72 || bench.read(2, HARDWARE_ERROR) != 0);
    bench.wait_for("the end of the alert", |bench| !bench.ask(1, 1, &[]).unwrap().0);
    assert!(bench.ask(2, 1, &[]).unwrap().0);
}
