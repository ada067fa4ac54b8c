//! Parameters of a virtual robot.

use super::population::Population;
use hysteron_actuator::{FrictionLaw, Prony, ServoSpec};

/// A virtual robot. Every number is valid and SI.
#[derive(Debug, Clone, PartialEq)]
pub struct VirtualRobot {
    /// Its name.
    pub name: String,
    /// Its body.
    pub body: BodyParameters,
    /// Its tendons.
    pub tendons: TendonParameters,
    /// Its servos and pulleys.
    pub servos: ServoParameters,
    /// Its tracker.
    pub tracker: TrackerParameters,
    /// How members of its population differ.
    pub population: Population,
}

/// The body: a rod along z, base at the origin.
#[derive(Debug, Clone, PartialEq)]
pub struct BodyParameters {
    /// Length at rest [m].
    pub length: f64,
    /// Sections of constant strain.
    pub n_sections: usize,
    /// Relaxed bending stiffness about the two principal axes [N m²].
    pub bending_stiffness: [f64; 2],
    /// Stiffness of each section, base first, over that of the body (n_sections) [-].
    pub section_factors: Vec<f64>,
    /// Turn of the principal axes about z [rad].
    pub axes_angle: f64,
    /// Torsional stiffness [N m²].
    pub torsional_stiffness: f64,
    /// Axial stiffness [N].
    pub axial_stiffness: f64,
    /// Curvature without load about x and y [1/m].
    pub natural_curvature: [f64; 2],
    /// Creep.
    pub prony: Prony,
    /// Mass [kg].
    pub mass: f64,
    /// Acceleration of gravity in the robot's frame [m/s²].
    pub gravity: [f64; 3],
    /// Force on the tip [N].
    pub tip_load: [f64; 3],
}

/// The tendons: through the whole body, fixed at its tip.
#[derive(Debug, Clone, PartialEq)]
pub struct TendonParameters {
    /// Distance from the axis [m].
    pub radius: f64,
    /// Angle of each about z (n_tendons) [rad].
    pub angles: Vec<f64>,
    /// Offset of each from the position by radius and angle, in x and y (n_tendons) [m].
    pub offsets: Vec<[f64; 2]>,
    /// Axial stiffness E A [N].
    pub axial_stiffness: f64,
    /// Length between pulley and body [m].
    pub transmission_length: f64,
    /// Coefficient of friction at the guides [-].
    pub friction: f64,
    /// Friction of each guide without tension [N].
    pub friction_force: f64,
    /// How that friction approaches its bound.
    pub law: FrictionLaw,
    /// Turn of each tendon between pulley and body [rad].
    pub base_wrap: f64,
    /// Slack at power-on, negative for pretension (n_tendons) [m].
    pub slack: Vec<f64>,
    /// Lost motion between pulley and tendon [m].
    pub play: f64,
    /// How much more each is pulled at stroke zero than calibration left it, as when a knot has given since:
    /// negative is slack (n_tendons) [m].
    pub zero_errors: Vec<f64>,
}

/// The servos and their pulleys.
#[derive(Debug, Clone, PartialEq)]
pub struct ServoParameters {
    /// Parameters of each servo.
    pub spec: ServoSpec,
    /// Radius of the pulleys, as in the rig file [m].
    pub pulley_radius: f64,
    /// Radius at which each tendon truly lies (n_tendons) [m].
    pub true_radii: Vec<f64>,
    /// 1 where positive ticks wind the tendon, -1 where negative ones do (n_tendons).
    pub directions: Vec<f64>,
    /// Supply voltage [V].
    pub supply: f64,
}

/// The tracker at the tip.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrackerParameters {
    /// Poses per second [Hz].
    pub rate: f64,
    /// Deviation of each coordinate [m] and of each component of the rotation [rad].
    pub position_noise: f64,
    /// See `position_noise`.
    pub orientation_noise: f64,
    /// Deviation of the slowly changing error of each coordinate [m].
    pub bias: f64,
    /// Time over which that error changes [s].
    pub bias_time: f64,
    /// Shortest time from measurement to sending [s].
    pub latency: f64,
    /// Deviation of what comes on top [s].
    pub latency_jitter: f64,
    /// Share of poses that never come [-].
    pub dropout: f64,
    /// Origin of the robot in the tracker's frame [m].
    pub robot_position: [f64; 3],
    /// Rotation vector from the robot's axes to the tracker's [rad].
    pub robot_rotation: [f64; 3],
}

impl VirtualRobot {
    /// Number of tendons.
    pub fn n_tendons(&self) -> usize {
        self.tendons.angles.len()
    }
}
