//! Telemetry of the arm: sampling times, filters and resolution of the readings, and the effects that they
//! leave out.

use std::f64::consts::TAU;

use hysteron_base::{BadInput, Channel, Metadata, Recording, rng};
use nalgebra::Vector3;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::chain::N_JOINTS;
use super::robot::VirtualArm;
use super::servo::{FULL_PWM, TICKS_PER_TURN};
use super::task::Labels;
use super::world::{ArmWorld, N_SERVOS};
use crate::virtual_rig::gaussian;

/// Reads the arm row by row.
#[derive(Debug)]
pub struct TelemetryRecorder {
    labels: Labels,
    timing: ChaCha8Rng,
    noise: ChaCha8Rng,
    offset: Vector3<f64>,
    /// When the next row is read [s].
    next: f64,
    /// Number of rows whose time is drawn.
    drawn: u32,
    /// Speeds as the servos report them [rad/s].
    speeds: [f64; N_SERVOS],
    /// Sums since the last row.
    sums: RowSums,
    last_velocity: Vector3<f64>,
    rows: Vec<TelemetryRow>,
}

/// Sums over the steps of a row.
#[derive(Debug, Clone, Copy, Default)]
struct RowSums {
    steps: f64,
    motor: [f64; N_JOINTS],
    friction: [f64; N_JOINTS],
    force: Vector3<f64>,
    carried: f64,
}

/// Simultaneous reading of all servos, the gripper's last.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reading {
    /// When [s].
    pub time: f64,
    /// [rad].
    pub position: [f64; N_SERVOS],
    /// Where they were sent [rad].
    pub goal: [f64; N_SERVOS],
    /// [rad/s].
    pub velocity: [f64; N_SERVOS],
    /// [A].
    pub current: [f64; N_SERVOS],
    /// [V].
    pub voltage: [f64; N_SERVOS],
    /// [°C].
    pub temperature: [f64; N_SERVOS],
    /// Part of the supply on the motor [-].
    pub pwm: [f64; N_SERVOS],
    /// Where the jaws were sent [m].
    pub goal_aperture: f64,
}

#[derive(Debug, Clone)]
struct TelemetryRow {
    time: f64,
    position: [f64; N_SERVOS],
    goal: [f64; N_SERVOS],
    speed: [f64; N_SERVOS],
    current: [f64; N_SERVOS],
    voltage: [f64; N_SERVOS],
    temperature: [f64; N_SERVOS],
    pwm: [f64; N_SERVOS],
    aperture: [f64; 2],
    /// As labelled; `None` where it is not.
    force: [Option<f64>; 3],
    true_force: [f64; 3],
    true_external: [f64; N_JOINTS],
    true_friction: [f64; N_JOINTS],
    true_motor: [f64; N_JOINTS],
    true_position: [f64; N_JOINTS],
    true_speed: [f64; N_JOINTS],
}

/// Lets the servos' own filters of their speeds [rad/s] see a step.
pub(super) fn filter_speeds(speeds: &mut [f64; N_SERVOS], world: &ArmWorld) {
    let arm = world.arm();
    let share = arm.step / (arm.telemetry.speed_filter + arm.step);
    for (k, speed) in speeds.iter_mut().enumerate() {
        *speed += share * (world.encoder_speed(k) - *speed);
    }
}

fn rounded(x: f64, step: f64) -> f64 {
    (x / step).round() * step
}

impl TelemetryRecorder {
    /// Begins at time zero; `seed` and `name` draw its noise.
    pub fn new(arm: &VirtualArm, labels: Labels, seed: u64, name: &str) -> Self {
        let stream = |what: &str| rng(seed, &format!("virtual-arm/{name}/{what}"));
        let mut noise = stream("noise");
        let offset = Vector3::from_fn(|_, _| arm.sensor.offset * gaussian(&mut noise));
        Self {
            labels,
            timing: stream("timing"),
            noise,
            offset,
            next: 0.0,
            drawn: 0,
            speeds: [0.0; N_SERVOS],
            sums: RowSums::default(),
            last_velocity: Vector3::zeros(),
            rows: Vec::new(),
        }
    }

    /// Whether a row is due at `time` [s].
    pub fn is_due(&self, time: f64) -> bool {
        time >= self.next
    }

    /// Looks at the arm after a step.
    pub fn watch(&mut self, world: &ArmWorld) {
        filter_speeds(&mut self.speeds, world);
        let sums = &mut self.sums;
        sums.steps += 1.0;
        sums.force += world.acted.force;
        sums.carried += world.grasped().unwrap_or(0.0);
        for k in 0..N_JOINTS {
            sums.motor[k] += world.acted.motor[k];
            sums.friction[k] += world.acted.friction[k];
        }
    }

    /// Reads a row at `time` [s]; `goals` are what the servos have been sent last [rad].
    pub fn read(&mut self, world: &ArmWorld, time: f64, goals: &[f64; N_SERVOS]) {
        let arm = world.arm();
        let telemetry = &arm.telemetry;
        let tick = TAU / TICKS_PER_TURN;
        let noise = &mut self.noise;
        let steps = self.sums.steps.max(1.0);
        let configuration = arm.chain.at(&world.q, &world.dq);
        let velocity = configuration.tip_velocity(&world.dq);
        let since = self.rows.last().map_or(f64::INFINITY, |row: &TelemetryRow| time - row.time);
        let carried = self.sums.carried / steps;
        let inertial = (velocity - self.last_velocity) / since;
        let force = self.sums.force / steps + (arm.chain.gravity - inertial) * carried;
        self.last_velocity = velocity;
        let every = |value: &mut dyn FnMut(usize) -> f64| std::array::from_fn(value);
        let labelled = match (self.labels, world.lifted()) {
            (Labels::Weight, Some(mass)) => [None, None, Some(mass * arm.chain.gravity.z)],
            (Labels::Sensor, _) => [0, 1, 2]
                .map(|axis| Some(force[axis] + self.offset[axis] + arm.sensor.noise * gaussian(noise))),
            _ => [None; 3],
        };
        let means = |sums: [f64; N_JOINTS]| sums.map(|sum| sum / steps);
        self.rows.push(TelemetryRow {
            time,
            position: every(&mut |k| rounded(world.encoder(k), tick)),
            goal: every(&mut |k| rounded(goals[k], tick)),
            speed: every(&mut |k| rounded(self.speeds[k], telemetry.speed_step)),
            current: every(&mut |k| {
                rounded(
                    world.servos[k].current + telemetry.current[1] * gaussian(noise),
                    telemetry.current[0],
                )
            }),
            voltage: every(&mut |_| {
                rounded(world.bus + telemetry.voltage[1] * gaussian(noise), telemetry.voltage[0])
            }),
            temperature: every(&mut |k| world.servos[k].case.round()),
            pwm: every(&mut |k| (world.servos[k].duty * FULL_PWM).round() / FULL_PWM),
            aperture: [world.servos[N_JOINTS].angle, goals[N_JOINTS]]
                .map(|angle| arm.gripper.aperture(angle)),
            force: labelled,
            true_force: force.into(),
            true_external: configuration.torques_of(&force),
            true_friction: means(self.sums.friction),
            true_motor: means(self.sums.motor),
            true_position: world.q,
            true_speed: world.dq,
        });
        self.sums = RowSums::default();
        self.schedule(telemetry);
    }

    /// The last row, and the force on the tip since the one before, which only a simulation knows [N].
    pub fn last(&self) -> Option<(Reading, [f64; 3])> {
        self.rows.last().map(|row| {
            let reading = Reading {
                time: row.time,
                position: row.position,
                goal: row.goal,
                velocity: row.speed,
                current: row.current,
                voltage: row.voltage,
                temperature: row.temperature,
                pwm: row.pwm,
                goal_aperture: row.aperture[1],
            };
            (reading, row.true_force)
        })
    }

    /// When the next row is read: rows keep to a clock, around which they scatter, and a few come late.
    fn schedule(&mut self, telemetry: &super::TelemetryNoise) {
        self.drawn += 1;
        let [share, by] = telemetry.late;
        let scatter = telemetry.jitter * gaussian(&mut self.timing).clamp(-3.0, 3.0);
        let late = if self.timing.random_range(0.0..1.0) < share {
            -by * (1.0 - self.timing.random_range(0.0..1.0_f64)).ln()
        } else {
            0.0
        };
        self.next = f64::from(self.drawn) * telemetry.period + scatter + late;
    }

    /// The rows as a recording with the channels of NAD, and what only a simulation knows as `truth_…`.
    ///
    /// # Errors
    /// `BadInput` naming what is not finite.
    pub fn finish(self, meta: Metadata) -> Result<Recording, BadInput> {
        let rows = &self.rows;
        let mut channels = Vec::new();
        let mut add = |name: String, of: &dyn Fn(&TelemetryRow) -> f64| {
            channels.push(Channel::new(name, rows.iter().map(of).collect()));
        };
        type RowValues = fn(&TelemetryRow, usize) -> f64;
        let telemetry: [(&str, &str, RowValues); 7] = [
            ("q", "rad", |row, k| row.position[k]),
            ("goal", "rad", |row, k| row.goal[k]),
            ("dq", "rad_s", |row, k| row.speed[k]),
            ("current", "a", |row, k| row.current[k]),
            ("voltage", "v", |row, k| row.voltage[k]),
            ("temperature", "degc", |row, k| row.temperature[k]),
            ("pwm", "ratio", |row, k| row.pwm[k]),
        ];
        for (stem, unit, value) in telemetry {
            for k in 0..N_SERVOS {
                add(format!("{stem}_{}_{unit}", k + 1), &|row| value(row, k));
            }
        }
        add("aperture_m".to_owned(), &|row| row.aperture[0]);
        add("goal_aperture_m".to_owned(), &|row| row.aperture[1]);
        for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
            // Where no row has a label there is no channel: no label is not no force.
            if rows.iter().any(|row| row.force[axis].is_some()) {
                add(format!("force_{name}_n"), &|row| row.force[axis].unwrap_or(0.0));
                add(format!("force_{name}_labelled_ratio"), &|row| {
                    f64::from(u8::from(row.force[axis].is_some()))
                });
            }
        }
        for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
            add(format!("truth_force_{name}_n"), &|row| row.true_force[axis]);
        }
        let truth: [(&str, &str, RowValues); 5] = [
            ("truth_q", "rad", |row, k| row.true_position[k]),
            ("truth_dq", "rad_s", |row, k| row.true_speed[k]),
            ("truth_motor", "n_m", |row, k| row.true_motor[k]),
            ("truth_friction", "n_m", |row, k| row.true_friction[k]),
            ("truth_external", "n_m", |row, k| row.true_external[k]),
        ];
        for (stem, unit, value) in truth {
            for k in 0..N_JOINTS {
                add(format!("{stem}_{}_{unit}", k + 1), &|row| value(row, k));
            }
        }
        let time = rows.iter().map(|row| row.time).collect();
        Recording::new(time, channels, Vec::new(), meta)
    }
}
