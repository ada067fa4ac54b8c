//! Parameters of a virtual arm, and their spread among individual arms.

use hysteron_base::rng;
use nalgebra::Vector3;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::chain::{BodyChain, N_JOINTS};
use super::gripper::VirtualGripper;
use super::servo::VirtualServo;
use crate::virtual_rig::gaussian;

/// A virtual arm with its gripper, supply and telemetry. Every number is valid and SI.
#[derive(Debug, Clone, PartialEq)]
pub struct VirtualArm {
    /// Its name.
    pub name: String,
    /// Its bodies.
    pub chain: BodyChain,
    /// The servos of its joints.
    pub servos: [VirtualServo; N_JOINTS],
    /// Its gripper.
    pub gripper: VirtualGripper,
    /// Power supply of all servos.
    pub supply: Supply,
    /// Telemetry of the arm.
    pub telemetry: TelemetryNoise,
    /// The force sensor at its tip.
    pub sensor: VirtualForceSensor,
    /// How individual arms differ.
    pub spread: ArmVariation,
    /// Step of the simulation [s]; the servos control in every second one.
    pub step: f64,
    /// SHA-256 of the file that it comes from.
    pub hash: String,
}

/// A voltage behind a resistance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Supply {
    /// Without current [V].
    pub voltage: f64,
    /// Of source and cables [Ω].
    pub resistance: f64,
    /// Temperature of the air [°C].
    pub air: f64,
    /// Most that a servo is warmer than the air when a trajectory starts [K].
    pub warm_start: f64,
}

impl Supply {
    /// Draws how warm N servos are when a trajectory starts [°C].
    pub(super) fn temperatures<const N: usize>(&self, random: &mut ChaCha8Rng) -> [f64; N] {
        std::array::from_fn(|_| self.air + self.warm_start * random.random_range(0.2..=1.0))
    }
}

/// How the servos are read.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TelemetryNoise {
    /// Mean time between rows [s].
    pub period: f64,
    /// Deviation of that time [s].
    pub jitter: f64,
    /// Share of rows that come late [-], and mean time by which they do [s].
    pub late: [f64; 2],
    /// Time constant of the speed that a servo reports [s].
    pub speed_filter: f64,
    /// Step of reported currents [A], and their noise [A].
    pub current: [f64; 2],
    /// Step of reported speeds [rad/s].
    pub speed_step: f64,
    /// Step of reported voltages [V], and their noise [V].
    pub voltage: [f64; 2],
}

/// A sensor of force at the tip.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VirtualForceSensor {
    /// Deviation of each component [N].
    pub noise: f64,
    /// Deviation of the offset of each component, which stays over a trajectory [N].
    pub offset: f64,
}

/// How far individual arms are from the file, as relative deviations unless a unit is given.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ArmVariation {
    /// Of every mass.
    pub mass: f64,
    /// Of every component of a centre [m].
    pub centre: f64,
    /// Of all moments of a body.
    pub inertia: f64,
    /// Of torque constants and resistances.
    pub motor: f64,
    /// Of all friction of a servo.
    pub friction: f64,
    /// Of backlash.
    pub backlash: f64,
}

impl VirtualArm {
    /// One arm of those that the file describes: bodies and servos that differ from it by [`Self::spread`].
    pub fn individual(&self, seed: u64) -> Self {
        let mut stream = rng(seed, "virtual-arm/individual");
        let (mut one, spread) = (self.clone(), self.spread);
        for link in &mut one.chain.links {
            let body = &mut link.body;
            body.mass *= factor(&mut stream, spread.mass);
            body.centre += Vector3::from_fn(|_, _| spread.centre * gaussian(&mut stream));
            body.inertia *= factor(&mut stream, spread.inertia);
        }
        for servo in one.servos.iter_mut().chain([&mut one.gripper.servo]) {
            servo.torque_constant *= factor(&mut stream, spread.motor);
            servo.resistance *= factor(&mut stream, spread.motor);
            let friction = factor(&mut stream, spread.friction);
            servo.bearing *= friction;
            servo.friction = servo.friction.scaled(friction);
            servo.backlash *= factor(&mut stream, spread.backlash);
        }
        one
    }
}

/// 1 with that relative deviation, as a logarithm.
fn factor(stream: &mut ChaCha8Rng, relative: f64) -> f64 {
    (relative * gaussian(stream)).exp()
}
