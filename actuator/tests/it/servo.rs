//! A servo on its own: profile, droop, stall, standstill, heat.

use hysteron_actuator::{
    Drive, DriveLoad, Gains, NOMINAL_VOLTAGE, ServoCommand, ServoSimulation, ServoSpec, Stribeck,
    TICKS_PER_TURN,
};
use std::f64::consts::TAU;

const H: f64 = 1e-3;
const NO_LOAD_SPEED: f64 = 57.0 * TAU / 60.0;

fn spec(coulomb: f64, breakaway: f64) -> ServoSpec {
    ServoSpec {
        stall_torque: 1.4,
        no_load_speed: NO_LOAD_SPEED,
        stall_current: 1.3,
        inertia: 3e-3,
        friction: Stribeck::new(coulomb, breakaway, 0.1, 0.01).unwrap(),
        dead_band: 0.0,
        heat_capacity: 40.0,
        thermal_resistance: 8.0,
        ambient_temperature: 25.0,
    }
    .checked()
    .unwrap()
}

fn servo_with(coulomb: f64, breakaway: f64) -> ServoSimulation {
    ServoSimulation::new(spec(coulomb, breakaway).drive(), 0.0)
}

fn on(goal: i32) -> ServoCommand {
    ServoCommand { torque_on: true, goal, ..ServoCommand::POWER_ON }
}

fn run(servo: &mut ServoSimulation, command: &ServoCommand, load: f64, seconds: f64) {
    for _ in 0..(seconds / H).round() as usize {
        servo.step(command, DriveLoad::torque(load), H);
    }
}

#[test]
fn droop_is_load_over_stiffness() {
    let mut servo = servo_with(0.0, 0.0);
    let load = -0.4;
    run(&mut servo, &on(1000), load, 5.0);
    let droop = 1000.0 / TICKS_PER_TURN * TAU - servo.state.angle;
    let expected = 0.4 / servo.drive.stiffness(Gains::XL430.p);
    // The encoder rounds: it hunts within a tick.
    assert!((droop - expected).abs() < 1.0 / TICKS_PER_TURN * TAU, "{droop} {expected}");
}

#[test]
fn profile_is_a_trapezoid() {
    let mut servo = servo_with(0.06, 0.08);
    let command = ServoCommand { profile_velocity: 2.0, profile_acceleration: 10.0, ..on(2048) };
    // Half a turn: 0.2 s up, 0.2 s down, the rest at full speed.
    let duration = std::f64::consts::PI / 2.0 + 0.2;
    let mut fastest = 0.0f64;
    let mut arrival = f64::NAN;
    for k in 0..3000 {
        let before = servo.position_loop.reference;
        servo.step(&command, DriveLoad::torque(0.0), H);
        fastest = fastest.max((servo.position_loop.reference - before) / H);
        if arrival.is_nan() && (servo.position_loop.reference - std::f64::consts::PI).abs() < 1e-12 {
            arrival = (k + 1) as f64 * H;
        }
    }
    assert!((fastest - 2.0).abs() < 1e-9, "{fastest}");
    assert!((arrival - duration).abs() < 0.02, "{arrival} {duration}");
    // Settled within the friction.
    let most = 0.08 / servo.drive.stiffness(Gains::XL430.p) + TAU / TICKS_PER_TURN;
    assert!((servo.state.angle - std::f64::consts::PI).abs() < most);
}

/// Where a reference from rest at 0 is at `time`, on its way of `way` > 0 at most as fast as `speed`.
fn trapezoid(time: f64, way: f64, speed: f64, acceleration: f64) -> f64 {
    let speed = speed.min((way * acceleration).sqrt());
    let (ramp, duration) = (speed / acceleration, way / speed + speed / acceleration);
    match time {
        t if t < ramp => 0.5 * acceleration * t * t,
        t if t < duration - ramp => speed * (t - 0.5 * ramp),
        t if t < duration => way - 0.5 * acceleration * (duration - t).powi(2),
        _ => way,
    }
}

#[test]
fn profile_is_the_closed_form_all_the_way() {
    // Full speed is reached, is just reached, is never reached; to either side.
    for goal in [2048, 261, 60, -1500, -9] {
        let mut servo = servo_with(0.06, 0.08);
        let (speed, acceleration) = (2.0, 10.0);
        let command =
            ServoCommand { profile_velocity: speed, profile_acceleration: acceleration, ..on(goal) };
        let way = f64::from(goal) / TICKS_PER_TURN * TAU;
        let (mut before, mut fastest) = (0.0, 0.0f64);
        for k in 1..=3000 {
            let at = servo.position_loop.reference;
            servo.step(&command, DriveLoad::torque(0.0), H);
            let now = (servo.position_loop.reference - at) / H;
            let exact = trapezoid(H * f64::from(k), way.abs(), speed, acceleration).copysign(way);
            // Whole steps at every change of the acceleration: half a step each at the start and on the way down, and the last one.
            let room = 2.0 * H * speed.min((way.abs() * acceleration).sqrt());
            let off = (servo.position_loop.reference - exact).abs();
            assert!(off <= room, "{goal}, step {k}: {off} of {room} rad");
            // The last step, onto the goal, may be half as hard again.
            assert!(
                (now - before).abs() <= 1.5 * acceleration * H + 1e-9,
                "{goal}, step {k}: {before} {now}"
            );
            (before, fastest) = (now, fastest.max(now.abs()));
        }
        assert!(fastest <= speed + 1e-9 && servo.position_loop.reference == way, "{goal}: {fastest}");
    }
}

#[test]
fn errors_within_the_dead_band_move_nothing() {
    let drive = |dead_band: f64| ServoSpec { dead_band, ..spec(0.0, 0.0) }.drive();
    let turned = |drive: Drive| {
        let mut servo = ServoSimulation::new(drive, 0.0);
        run(&mut servo, &on(4), 0.0, 1.0);
        servo.ticks()
    };
    assert_eq!([turned(drive(4.0)), turned(drive(3.0))], [0, 1]);
}

#[test]
fn profile_without_acceleration_has_its_speed_at_once() {
    let mut servo = servo_with(0.06, 0.08);
    let command = ServoCommand { profile_velocity: 1.0, ..on(-652) };
    servo.step(&command, DriveLoad::torque(0.0), H);
    assert!((servo.position_loop.reference + H).abs() < 1e-12);
    run(&mut servo, &command, 0.0, 1.1);
    assert_eq!(servo.position_loop.reference, -652.0 / TICKS_PER_TURN * TAU);
}

#[test]
fn free_output_reaches_the_catalogue_speed_and_stall_gives_the_catalogue_torque() {
    let mut servo = servo_with(0.06, 0.08);
    run(&mut servo, &on(40_000), 0.0, 2.0);
    assert!((servo.state.velocity - NO_LOAD_SPEED).abs() < 1e-3, "{}", servo.state.velocity);
    // A little less than the stall torque is still moved, a little more is not.
    for (load, moves) in [(-1.37, true), (-1.45, false)] {
        let mut servo = servo_with(0.06, 0.08);
        run(&mut servo, &on(4000), load, 0.5);
        assert_eq!(servo.state.velocity > 0.0, moves, "{load}: {}", servo.state.velocity);
        assert!(moves || servo.load() > 0.99);
    }
}

#[test]
fn half_the_voltage_gives_half_the_speed() {
    let mut servo = servo_with(0.0, 0.0);
    servo.drive.supply.voltage = 0.5 * NOMINAL_VOLTAGE;
    run(&mut servo, &on(40_000), 0.0, 2.0);
    assert!((servo.state.velocity / NO_LOAD_SPEED - 0.5).abs() < 0.01);
}

#[test]
fn output_without_torque_holds_until_friction_is_overcome() {
    let mut servo = ServoSimulation::new(spec(0.06, 0.08).drive(), 1.0);
    run(&mut servo, &ServoCommand::POWER_ON, 0.079, 1.0);
    assert_eq!(servo.state.angle, 1.0);
    run(&mut servo, &ServoCommand::POWER_ON, 0.085, 0.1);
    assert!(servo.state.angle > 1.0);
}

#[test]
fn integral_removes_the_droop() {
    let mut servo = servo_with(0.0, 0.0);
    let command = ServoCommand { gains: Gains { p: 800, i: 500, d: 0 }, ..on(500) };
    run(&mut servo, &command, -0.4, 10.0);
    assert!((servo.state.angle / TAU * TICKS_PER_TURN - 500.0).abs() < 1.5, "{}", servo.ticks());
}

#[test]
fn stalled_motor_warms_by_its_losses() {
    let mut servo = servo_with(0.06, 0.08);
    let command = on(4000);
    run(&mut servo, &command, -2.0 * 0.7, 0.0);
    let seconds = 20.0;
    // Held from outside: the load follows the torque.
    for _ in 0..(seconds / H) as usize {
        servo.step(&command, DriveLoad::torque(-1.42), H);
    }
    let power = NOMINAL_VOLTAGE * 1.3;
    let (c, r) = (40.0, 8.0);
    let expected = 25.0 + power * r * (1.0 - f64::exp(-seconds / (r * c)));
    assert!(
        (servo.state.winding_temperature - expected).abs() < 0.2,
        "{} {expected}",
        servo.state.winding_temperature
    );
}

#[test]
fn spec_rejects_what_cannot_be() {
    let reject = |change: fn(&mut ServoSpec)| {
        let mut spec = spec(0.06, 0.08);
        change(&mut spec);
        spec.checked().unwrap_err().place
    };
    assert_eq!(reject(|spec| spec.inertia = 0.0), "inertia");
    assert_eq!(reject(|spec| spec.dead_band = -1.0), "dead_band");
    assert_eq!(reject(|spec| spec.friction.viscous = 1.0), "friction");
    assert_eq!(reject(|spec| spec.friction.viscous = f64::NAN), "friction");
    assert_eq!(reject(|spec| spec.friction.stribeck_velocity = f64::INFINITY), "friction");
    assert_eq!(reject(|spec| spec.ambient_temperature = f64::NAN), "ambient_temperature");
}
