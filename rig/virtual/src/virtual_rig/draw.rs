//! Members of a population of virtual robots.

use super::linear::{V3, dot, scale};
use super::population::{Population, PopulationSpread, Ranges};
use super::robot::VirtualRobot;
use hysteron_actuator::FrictionLaw;
use hysteron_base::rng;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use std::f64::consts::{PI, TAU};

/// Draws further out than this many deviations are drawn in.
const FURTHEST: f64 = 2.5;

impl VirtualRobot {
    /// A member of the population around this robot. The same seed gives the same member.
    pub fn draw(&self, seed: u64) -> Self {
        match &self.population {
            Population::Around(spread) => spread.draw(self, seed),
            Population::Wide(ranges) => ranges.draw(self, seed),
        }
    }
}

impl PopulationSpread {
    fn draw(&self, middle: &VirtualRobot, seed: u64) -> VirtualRobot {
        let mut robot = middle.clone();
        let mut rng = rng(seed, "virtual-rig/population");
        let mut normal = |deviation: f64| deviation * gaussian(&mut rng).clamp(-FURTHEST, FURTHEST);
        stiffen(&mut robot, normal(self.stiffness).exp(), normal(0.5 * self.anisotropy).exp());
        let body = &mut robot.body;
        body.axes_angle += normal(self.axes_angle);
        body.natural_curvature = body.natural_curvature.map(|k| k + normal(self.natural_curvature));
        let creep = normal(self.creep).exp();
        body.prony.weights.iter_mut().for_each(|weight| *weight *= creep);
        let tendons = &mut robot.tendons;
        let friction = normal(self.friction).exp();
        tendons.friction *= friction;
        tendons.friction_force *= friction;
        tendons.axial_stiffness *= normal(self.tendon_stiffness).exp();
        tendons.slack.iter_mut().for_each(|slack| *slack += normal(self.slack));
        tendons.play *= normal(self.play).exp();
        grease(&mut robot, normal(self.servo_friction).exp());
        robot
    }
}

impl Ranges {
    fn draw(&self, middle: &VirtualRobot, seed: u64) -> VirtualRobot {
        let mut robot = middle.clone();
        // A stream for every part: what is drawn of one does not depend on how many numbers another takes.
        let stream = |part: &str| rng(seed, &format!("virtual-rig/population/wide/{part}"));
        self.draw_body(&mut robot, &mut stream("body"));
        self.draw_tendons(&mut robot, &mut stream("tendons"));
        self.draw_servos(&mut robot, &mut stream("servos"));
        self.draw_mounting(&mut robot, &mut stream("mounting"));
        robot
    }

    fn draw_body(&self, robot: &mut VirtualRobot, rng: &mut ChaCha8Rng) {
        let [b1, b2] = robot.body.bending_stiffness;
        // The ratio becomes the drawn one; their product stays.
        let ratio = factor(rng, self.bending_ratio) * b2 / b1;
        stiffen(robot, factor(rng, self.stiffness), ratio.sqrt());
        let body = &mut robot.body;
        body.axes_angle = rng.random_range(0.0..PI);
        body.section_factors.iter_mut().for_each(|section| *section = factor(rng, self.section));
        body.natural_curvature = [(); 2].map(|()| even(rng, self.natural_curvature));
        let creep = factor(rng, self.creep);
        body.prony.weights.iter_mut().for_each(|weight| *weight *= creep);
    }

    fn draw_tendons(&self, robot: &mut VirtualRobot, rng: &mut ChaCha8Rng) {
        let tendons = &mut robot.tendons;
        tendons.angles.iter_mut().for_each(|angle| *angle += even(rng, self.guide_angle));
        tendons.offsets.iter_mut().flatten().for_each(|offset| *offset = even(rng, self.guide_offset));
        tendons.axial_stiffness *= factor(rng, self.tendon_stiffness);
        let friction = factor(rng, self.friction);
        tendons.friction *= friction;
        tendons.friction_force *= friction;
        let length = factor(rng, self.presliding);
        let is_dahls = rng.random_range(0.0..1.0) < 0.5;
        tendons.law = if is_dahls { FrictionLaw::Dahl(length) } else { FrictionLaw::Prandtl(length) };
        tendons.play = even(rng, self.play);
        tendons.zero_errors.iter_mut().for_each(|zero| *zero = even(rng, self.zero_error));
        let slack = rng.random_range(0..tendons.zero_errors.len());
        tendons.zero_errors[slack] = -even(rng, self.slack_tendon);
    }

    fn draw_servos(&self, robot: &mut VirtualRobot, rng: &mut ChaCha8Rng) {
        let nominal = robot.servos.pulley_radius;
        robot.servos.true_radii.iter_mut().for_each(|radius| *radius = nominal * factor(rng, self.pulley));
        grease(robot, factor(rng, self.servo_friction));
    }

    fn draw_mounting(&self, robot: &mut VirtualRobot, rng: &mut ChaCha8Rng) {
        let down: V3 = direction(rng);
        robot.body.gravity = scale(dot(robot.body.gravity, robot.body.gravity).sqrt(), down);
        // A rotation drawn evenly from all: a direction in four dimensions is its quaternion.
        let [w, x, y, z]: [f64; 4] = direction(rng);
        let sine = (x * x + y * y + z * z).sqrt();
        robot.tracker.robot_rotation = scale(2.0 * sine.atan2(w) / sine, [x, y, z]);
        robot.tracker.robot_position = [(); 3].map(|()| even(rng, self.tracker_position));
    }
}

/// Multiplies all stiffnesses of the body by `all`, the first of bending by `ratio` and the second by its inverse.
fn stiffen(robot: &mut VirtualRobot, all: f64, ratio: f64) {
    let body = &mut robot.body;
    body.bending_stiffness[0] *= all * ratio;
    body.bending_stiffness[1] *= all / ratio;
    body.torsional_stiffness *= all;
    body.axial_stiffness *= all;
}

/// Multiplies the servos' friction.
fn grease(robot: &mut VirtualRobot, by: f64) {
    let friction = &mut robot.servos.spec.friction;
    friction.coulomb *= by;
    friction.breakaway *= by;
}

fn even(rng: &mut ChaCha8Rng, [min, max]: [f64; 2]) -> f64 {
    rng.random_range(min..=max)
}

fn factor(rng: &mut ChaCha8Rng, range: [f64; 2]) -> f64 {
    even(rng, range.map(f64::ln)).exp()
}

/// A unit vector, evenly from all directions.
fn direction<const N: usize>(rng: &mut ChaCha8Rng) -> [f64; N] {
    let drawn: [f64; N] = std::array::from_fn(|_| gaussian(rng));
    let length = drawn.iter().map(|x| x * x).sum::<f64>().sqrt();
    drawn.map(|x| x / length)
}

/// A normal number of deviation 1: Box and Muller (1958).
pub(crate) fn gaussian(rng: &mut ChaCha8Rng) -> f64 {
    let (u, v): (f64, f64) = (rng.random_range(f64::MIN_POSITIVE..1.0), rng.random_range(0.0..1.0));
    (-2.0 * u.ln()).sqrt() * (TAU * v).cos()
}
