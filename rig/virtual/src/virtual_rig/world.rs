//! Servos, tendons, body and tracker of the virtual rig, advanced together.
//!
//! Time goes in ticks of one millisecond, however it is asked for: the servos move at every tick, the body finds its
//! balance at every tenth. Between two balances each servo feels the tension of the last one.

use super::body::FactorReuse;
use super::body::{BodySpec, TendonBody};
use super::equilibrium::StepReport;
use super::robot::VirtualRobot;
use super::sensor::{TrackedPose, VirtualTracker};
use hysteron_actuator::{
    DriveLoad, Gains, Play, ServoCommand, ServoSimulation, ServoSpec, Stribeck, TendonModel, TendonSpec,
};
use hysteron_base::rng;
use hysteron_rig::{Pose, Quality};
use rand::RngExt;
use std::f64::consts::{PI, TAU};

/// Time between two steps of the servos [s].
const TICK: f64 = 1e-3;
/// Ticks between two balances of the body.
const TICKS_PER_BALANCE: u64 = 10;

/// Energy of body and tendons.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct RigEnergy {
    /// Held by rod, Maxwell elements, tendons and weight [J].
    pub stored: f64,
    /// Turned into heat by the guides since power-on [J].
    pub friction_heat: f64,
    /// Turned into heat by creep since power-on [J].
    pub creep_heat: f64,
}

/// How the body's balances went.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct BalanceCounts {
    /// Balances asked for.
    pub steps: u64,
    /// Residuals evaluated for them.
    pub evaluations: u64,
    /// Tangents factorised.
    pub factorisations: u64,
    /// Substeps without balance; the body then stayed where it was.
    pub failures: u64,
}

/// The virtual rig at one moment.
#[derive(Debug, Clone)]
pub struct World {
    ticks: u64,
    /// Part of a tick that has been asked for and not gone yet [s].
    rest: f64,
    commands: Vec<ServoCommand>,
    servos: Vec<ServoSimulation>,
    /// External torque on a pulley (n_servos) [N m].
    disturbances: Vec<f64>,
    robot: Option<RigRobot>,
}

/// Robot on the pulleys.
#[derive(Debug, Clone)]
struct RigRobot {
    body: TendonBody,
    tracker: VirtualTracker,
    /// Pulley radius with the sign of the winding direction (n_servos) [m].
    arms: Vec<f64>,
    /// Angles at power-on (n_servos) [rad].
    zeros: Vec<f64>,
    /// Between pulley and tendon (n_servos) [m].
    plays: Vec<Play>,
    /// Slack at the angles of power-on (n_servos) [m].
    slack: Vec<f64>,
    /// By how much more each tendon is pulled from the next day on (n_servos) [m].
    zero_errors: Vec<f64>,
    /// Scratch (n_servos) [m].
    pulled: Vec<f64>,
    /// Truth at the last balance.
    tip: Pose,
    counts: BalanceCounts,
}

impl World {
    /// A robot at rest, just switched on: its servos are anywhere within a turn, without torque.
    ///
    /// The seed decides these angles and everything that the tracker adds.
    pub fn new(robot: &VirtualRobot, seed: u64) -> Self {
        let mut angles = rng(seed, "virtual-rig/servos");
        let n = robot.n_tendons();
        let zeros: Vec<f64> = (0..n).map(|_| angles.random_range(0.0..TAU)).collect();
        let mut drive = robot.servos.spec.drive();
        drive.supply.voltage = robot.servos.supply;
        let servos = zeros.iter().map(|&angle| ServoSimulation::new(drive.clone(), angle)).collect();
        Self { robot: Some(RigRobot::new(robot, zeros, seed)), ..Self::of(servos) }
    }

    /// Servos with nothing on their pulleys.
    fn of(servos: Vec<ServoSimulation>) -> Self {
        Self {
            ticks: 0,
            rest: 0.0,
            commands: commands(&servos),
            disturbances: vec![0.0; servos.len()],
            servos,
            robot: None,
        }
    }

    /// `n` light servos with hardly any friction at rest, at half a turn, with nothing on their pulleys.
    pub fn idle(n: usize) -> Self {
        let spec = ServoSpec {
            stall_torque: 1.4,
            no_load_speed: 57.0 / 60.0 * TAU,
            stall_current: 1.3,
            // They reach every tick and stop where the torque leaves them.
            inertia: 1e-4,
            friction: Stribeck { coulomb: 2e-3, breakaway: 2e-3, stribeck_velocity: 1.0, viscous: 1e-2 },
            dead_band: 0.0,
            heat_capacity: 40.0,
            thermal_resistance: 8.0,
            ambient_temperature: 30.0,
        };
        let mut drive = spec.drive();
        drive.supply.voltage = 12.0;
        Self::of(vec![ServoSimulation::new(drive, PI); n])
    }

    /// Seconds since power-on [s].
    pub fn time(&self) -> f64 {
        self.ticks as f64 * TICK + self.rest
    }

    /// Number of servos, one per tendon.
    pub fn n_servos(&self) -> usize {
        self.servos.len()
    }

    /// Command of servo `k`; stays until it is changed.
    pub fn command_mut(&mut self, k: usize) -> &mut ServoCommand {
        &mut self.commands[k]
    }

    /// State of servo `k`.
    pub fn servo(&self, k: usize) -> &ServoSimulation {
        &self.servos[k]
    }

    /// Lets `dt` [s] pass.
    pub fn advance(&mut self, dt: f64) {
        self.rest += dt.max(0.0);
        // A hair early, so that ten times 0.01 s are a hundred ticks.
        while self.rest > TICK * (1.0 - 1e-6) {
            self.rest = (self.rest - TICK).max(0.0);
            self.ticks += 1;
            self.tick();
        }
    }

    fn tick(&mut self) {
        for (k, servo) in self.servos.iter_mut().enumerate() {
            let pull = self.robot.as_ref().map_or(0.0, |robot| robot.torque(k));
            servo.step(&self.commands[k], DriveLoad::torque(pull + self.disturbances[k]), TICK);
        }
        let time = self.ticks as f64 * TICK;
        if let Some(robot) = &mut self.robot
            && self.ticks.is_multiple_of(TICKS_PER_BALANCE)
        {
            robot.balance(&self.servos, time);
        }
    }

    /// Load that servo `k` senses, -1 to 1 of its stall torque, positive towards positive ticks [-].
    pub fn load(&self, k: usize) -> f64 {
        self.servos[k].load()
    }

    /// Appends the poses that the tracker has sent since the last call.
    pub fn take_poses(&mut self, poses: &mut Vec<TrackedPose>) {
        let time = self.time();
        if let Some(robot) = &mut self.robot {
            robot.tracker.take(time, poses);
        }
    }

    /// Switches servo `k` off and on again: it forgets its command; its output stays where it was.
    pub fn power_cycle(&mut self, k: usize) {
        self.commands[k] = ServoCommand { goal: self.servos[k].ticks(), ..ServoCommand::POWER_ON };
    }

    /// Sets the supply voltage [V].
    pub fn set_supply(&mut self, volts: f64) {
        self.servos.iter_mut().for_each(|servo| servo.drive.supply.voltage = volts);
    }

    /// Adds a torque against servo `k`, as if something held its pulley: positive towards positive angles [N m].
    pub fn set_disturbance(&mut self, k: usize, torque: f64) {
        self.disturbances[k] = torque;
    }

    /// Sets the force that the surroundings exert on the tip, in the robot's frame [N], from the next balance on.
    pub fn set_tip_force(&mut self, force: [f64; 3]) {
        if let Some(robot) = &mut self.robot {
            robot.body.set_tip_load(force);
        }
    }

    /// Force on the tip, in the robot's frame [N].
    pub fn tip_force(&self) -> [f64; 3] {
        self.robot.as_ref().map_or([0.0; 3], |robot| robot.body.spec.tip_load)
    }

    /// The same robot on another day: what the tracker adds is another, and what the calibration took for zero has
    /// given by the robot's zero errors, once.
    pub fn reseed(&mut self, seed: u64, day: &str) {
        if let Some(robot) = &mut self.robot {
            robot.tracker.reseed(seed, day);
            for (slack, error) in robot.slack.iter_mut().zip(&mut robot.zero_errors) {
                *slack -= std::mem::take(error);
            }
        }
    }

    /// Connects the tracker or takes it away: what it measures meanwhile is lost.
    pub fn set_tracker_connected(&mut self, connected: bool) {
        if let Some(robot) = &mut self.robot {
            if connected {
                robot.tracker.is_connected = true;
            } else {
                robot.tracker.disconnect();
            }
        }
    }

    /// Where the tip truly was at the last balance, in the robot's frame; at the origin if there is no robot.
    pub fn tip(&self) -> Pose {
        self.robot.as_ref().map_or(
            Pose {
                time: self.time(),
                position: [0.0; 3],
                orientation: [1.0, 0.0, 0.0, 0.0],
                quality: Quality::Good,
            },
            |robot| robot.tip,
        )
    }

    /// Tension of tendon `k` at its pulley [N].
    pub fn tension(&self, k: usize) -> f64 {
        self.robot.as_ref().map_or(0.0, |robot| robot.body.tendons[k].tensions[0])
    }

    /// Stroke of tendon `k` since power-on [m].
    pub fn stroke(&self, k: usize) -> f64 {
        self.robot.as_ref().map_or(0.0, |robot| robot.plays[k].output)
    }

    /// Energy in body and tendons.
    pub fn energy(&self) -> RigEnergy {
        self.robot.as_ref().map_or(RigEnergy::default(), |robot| RigEnergy {
            stored: robot.body.stored_energy(),
            friction_heat: robot.body.tendons.iter().map(|tendon| tendon.dissipated).sum(),
            creep_heat: robot.body.creep_heat,
        })
    }

    /// From now on factorises the tangent in every iteration, as plain Newton's method does: for comparisons.
    pub fn always_factorise(&mut self) {
        if let Some(robot) = &mut self.robot {
            robot.body.use_of_factor = FactorReuse::AlwaysNew;
        }
    }

    /// How the body's balances went so far.
    pub fn balance_counts(&self) -> BalanceCounts {
        self.robot.as_ref().map_or(BalanceCounts::default(), |robot| robot.counts)
    }
}

/// As after power-on.
fn commands(servos: &[ServoSimulation]) -> Vec<ServoCommand> {
    let command = |servo: &ServoSimulation| ServoCommand {
        goal: servo.ticks(),
        gains: Gains::XL430,
        ..ServoCommand::POWER_ON
    };
    servos.iter().map(command).collect()
}

impl RigRobot {
    fn new(robot: &VirtualRobot, zeros: Vec<f64>, seed: u64) -> Self {
        let (body, tendons) = (&robot.body, &robot.tendons);
        let section = body.length / body.n_sections as f64;
        let mut rest_lengths = vec![section; body.n_sections + 1];
        rest_lengths[0] = tendons.transmission_length;
        let spec = TendonSpec {
            rest_lengths,
            axial_stiffness: tendons.axial_stiffness,
            friction: tendons.friction,
            friction_force: tendons.friction_force,
            law: tendons.law,
        };
        let guides = tendons.angles.iter().zip(&tendons.offsets);
        let guides = guides.map(|(a, [x, y])| [tendons.radius * a.cos() + x, tendons.radius * a.sin() + y]);
        let spec_of_body = BodySpec {
            length: body.length,
            n_sections: body.n_sections,
            stiffness: [
                body.bending_stiffness[0],
                body.bending_stiffness[1],
                body.torsional_stiffness,
                body.axial_stiffness,
            ],
            section_factors: body.section_factors.clone(),
            axes_angle: body.axes_angle,
            natural_curvature: body.natural_curvature,
            prony: body.prony.clone(),
            mass: body.mass,
            gravity: body.gravity,
            tip_load: body.tip_load,
            guides: guides.collect(),
            base_wrap: tendons.base_wrap,
        };
        let all = tendons.angles.iter().map(|_| TendonModel::of_valid(spec.clone())).collect();
        let mut body = TendonBody::new(spec_of_body, all);
        let mut counts = BalanceCounts::default();
        let pulled: Vec<f64> = tendons.slack.iter().map(|slack| -slack).collect();
        // So long ago that all creep from gravity and pretension is over.
        counts.add(body.step(&pulled, 1e6));
        let (orientation, position) = body.tip();
        Self {
            body,
            tracker: VirtualTracker::new(robot.tracker, seed),
            arms: robot
                .servos
                .directions
                .iter()
                .zip(&robot.servos.true_radii)
                .map(|(sign, r)| sign * r)
                .collect(),
            zeros,
            plays: vec![Play::new(tendons.play, 0.0); tendons.slack.len()],
            slack: tendons.slack.clone(),
            zero_errors: tendons.zero_errors.clone(),
            pulled,
            tip: Pose { time: 0.0, position, orientation, quality: Quality::Good },
            counts,
        }
    }

    /// Torque of tendon `k` on its pulley, positive towards positive angles [N m].
    fn torque(&self, k: usize) -> f64 {
        -self.arms[k] * self.body.tendons[k].tensions[0]
    }

    /// Balances the body at the servos' present angles.
    fn balance(&mut self, servos: &[ServoSimulation], time: f64) {
        for (k, servo) in servos.iter().enumerate() {
            let turned = self.arms[k] * (servo.state.angle - self.zeros[k]);
            self.pulled[k] = self.plays[k].follow(turned) - self.slack[k];
        }
        let step = time - self.tip.time;
        let report = self.body.step(&self.pulled, step);
        self.counts.add(report);
        let (orientation, position) = self.body.tip();
        let before = self.tip;
        self.tip = Pose { time, position, orientation, quality: Quality::Good };
        self.tracker.measure(&before, &self.tip);
    }
}

impl BalanceCounts {
    fn add(&mut self, report: StepReport) {
        self.steps += 1;
        self.evaluations += report.evaluations as u64;
        self.factorisations += report.factorisations as u64;
        self.failures += report.failures as u64;
    }
}
