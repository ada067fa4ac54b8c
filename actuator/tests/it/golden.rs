//! A virtual servo does to the last bit what it did before it became a preset of the drive that others are.

use hysteron_actuator::{DriveLoad, Gains, ServoCommand, ServoSimulation, ServoSpec, Stribeck};
use hysteron_base::file;

/// SHA-256 over angle, speed, reference, PWM, current and temperature of every step, little endian. Made by this test at
/// commit de9b3df, before the change.
const BEFORE: &str = "0d93b616b3bc6fa536e836a2905d6abdb9e652b1799eb801cee50bfc3e3671fc";

#[test]
fn virtual_servo_keeps_its_bytes() {
    let spec = ServoSpec {
        stall_torque: 1.4,
        no_load_speed: 5.97,
        stall_current: 1.3,
        inertia: 0.004,
        friction: Stribeck::new(0.05, 0.08, 0.1, 0.01).unwrap(),
        dead_band: 1.0,
        heat_capacity: 20.0,
        thermal_resistance: 8.0,
        ambient_temperature: 23.0,
    };
    let mut servo = ServoSimulation::new(spec.checked().unwrap().drive(), 0.2);
    let mut bytes = Vec::new();
    for k in 0..6000 {
        let command = ServoCommand {
            torque_on: !(2500..2800).contains(&k),
            goal: if k < 1500 { 700 } else { -300 },
            profile_velocity: if k < 3000 { 2.0 } else { 0.0 },
            profile_acceleration: if k < 1500 { 6.0 } else { 0.0 },
            gains: Gains { p: 640, i: if k > 4000 { 300 } else { 0 }, d: 4000 },
            pwm_limit: if k > 5000 { 0.3 } else { 1.0 },
        };
        servo.step(&command, DriveLoad::torque(-0.2 * (0.01 * f64::from(k)).sin()), 1e-3);
        let (state, reference) = (&servo.state, servo.position_loop.reference);
        let temperature = state.winding_temperature;
        for x in [state.angle, state.velocity, reference, servo.duty, state.current, temperature] {
            bytes.extend_from_slice(&x.to_le_bytes());
        }
    }
    assert_eq!(file::sha256_hex(&bytes), BEFORE);
}
