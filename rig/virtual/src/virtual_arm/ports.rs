//! Both arms as the emulator takes them: a follower with torque of its own, and a leader in a hand.
//!
//! They share nothing but the time since they began: what the follower is asked to do comes over its port.

use hysteron_actuator::ServoCommand;
use hysteron_base::rng;
use rand_chacha::ChaCha8Rng;
use std::f64::consts::TAU;

use super::chain::N_JOINTS;
use super::fault::JointFault;
use super::gripper::VirtualGripper;
use super::leader::VirtualLeader;
use super::robot::VirtualArm;
use super::servo::TICKS_PER_TURN;
use super::task::{ArmCourse, ArmTrial};
use super::telemetry::filter_speeds;
use super::world::{ArmWorld, N_SERVOS};
use crate::emulator::{ServoReadings, ServoWorld};
use crate::virtual_rig::gaussian;
use hysteron_rig::bus::model::{ServoModel, XL330_M288, XM430_W350};

/// Supply of the leader [V], and its temperature [°C].
const LEADER_SUPPLY: f64 = 5.0;
const LEADER_DEGC: f64 = 27.0;
/// Over how long the leader's speed is taken [s].
const SPEED_SPAN: f64 = 8e-3;

/// The follower of a trajectory.
#[derive(Debug)]
pub struct VirtualFollower {
    world: ArmWorld,
    course: ArmCourse,
    /// When the hand begins to move [s].
    begins: f64,
    /// Time that is not yet a step [s].
    rest: f64,
    speeds: [f64; N_SERVOS],
    noise: ChaCha8Rng,
    /// Present errors of the readings of currents [A] and voltages [V].
    scatter: [[f64; N_SERVOS]; 2],
}

/// The leader of a trajectory, which an external force moves, independent of the commands of its servos.
#[derive(Debug)]
pub struct HeldLeader {
    leader: VirtualLeader,
    gripper: VirtualGripper,
    begins: f64,
    time: f64,
    supply: f64,
}

impl VirtualArm {
    /// Both arms of a trajectory at the leader's first posture, without torque; the hand begins to move `begins` [s] later.
    /// Everything that is drawn comes from `seed` and `name`.
    pub fn arms(
        &self,
        trial: &ArmTrial,
        seed: u64,
        name: &str,
        begins: f64,
    ) -> (HeldLeader, VirtualFollower) {
        let stream = |what: &str| rng(seed, &format!("virtual-arm/{name}/{what}"));
        let course = trial.course(self, &mut stream("course"));
        let start = course.leader.at(0.0);
        let temperatures = self.supply.temperatures(&mut stream("heat"));
        let angles = std::array::from_fn(|k| start[k]);
        let world = ArmWorld::new(self, angles, start[N_JOINTS], temperatures).with_faults(&course.faults);
        let world = match course.object {
            Some(object) => world.with_object(object),
            None => world,
        };
        let leader = course.leader.clone();
        let held = HeldLeader { leader, gripper: self.gripper, begins, time: 0.0, supply: LEADER_SUPPLY };
        let scatter = [[0.0; N_SERVOS]; 2];
        let (speeds, noise) = ([0.0; N_SERVOS], stream("noise"));
        (held, VirtualFollower { world, course, begins, rest: 0.0, speeds, noise, scatter })
    }
}

impl VirtualFollower {
    /// The arm.
    pub fn world(&self) -> &ArmWorld {
        &self.world
    }

    /// Fault of a joint; `None` if there is none.
    pub fn fault(&self) -> Option<&JointFault> {
        self.course.faults.first()
    }
}

impl ServoWorld for VirtualFollower {
    fn model(&self) -> &'static ServoModel {
        &XM430_W350
    }

    fn has_full_loop(&self) -> bool {
        false
    }

    fn time(&self) -> f64 {
        self.world.time() + self.rest
    }

    fn advance(&mut self, dt: f64) {
        self.rest += dt.max(0.0);
        let step = self.world.arm().step;
        while self.rest >= step {
            self.rest -= step;
            self.world.push = self.course.push_at(self.world.time() - self.begins);
            self.world.step();
            filter_speeds(&mut self.speeds, &self.world);
        }
        let telemetry = self.world.arm().telemetry;
        for (values, size) in self.scatter.iter_mut().zip([telemetry.current[1], telemetry.voltage[1]]) {
            values.fill_with(|| size * gaussian(&mut self.noise));
        }
    }

    fn n_servos(&self) -> usize {
        N_SERVOS
    }

    fn servo(&self, k: usize) -> ServoReadings {
        let (state, angle) = (&self.world.servos[k], self.world.encoder(k));
        ServoReadings {
            angle,
            velocity: self.speeds[k],
            reference: self.world.goals[k].unwrap_or(angle),
            pwm: state.duty,
            voltage: self.world.bus + self.scatter[1][k],
            temperature: state.case,
        }
    }

    fn load(&self, k: usize) -> f64 {
        let stall_current = self.world.bus / self.world.spec(k).resistance;
        if stall_current > 0.0 { self.world.servos[k].current / stall_current } else { 0.0 }
    }

    fn effort(&self, k: usize) -> f64 {
        self.world.servos[k].current + self.scatter[0][k]
    }

    fn command(&mut self, k: usize, command: &ServoCommand) {
        let goal = f64::from(command.goal) / TICKS_PER_TURN * TAU;
        self.world.goals[k] = command.torque_on.then_some(goal);
        self.world.set_gains(k, [f64::from(command.gains.p), f64::from(command.gains.d)]);
    }

    fn power_cycle(&mut self, k: usize) {
        self.world.goals[k] = None;
    }

    fn set_supply(&mut self, volts: f64) {
        self.world.set_supply(volts);
    }

    fn set_disturbance(&mut self, k: usize, torque: f64) {
        if let Some(disturbance) = self.world.disturbances.get_mut(k) {
            *disturbance = torque;
        }
    }
}

impl HeldLeader {
    /// When the hand is at the end of its motion [s].
    pub fn end(&self) -> f64 {
        self.begins + self.leader.end()
    }

    /// Angles of the servos at `time` [rad].
    pub fn at(&self, time: f64) -> [f64; N_SERVOS] {
        VirtualLeader::goals(&self.leader.at((time - self.begins).max(0.0)), &self.gripper)
    }
}

impl ServoWorld for HeldLeader {
    fn model(&self) -> &'static ServoModel {
        &XL330_M288
    }

    fn has_full_loop(&self) -> bool {
        false
    }

    fn time(&self) -> f64 {
        self.time
    }

    fn advance(&mut self, dt: f64) {
        self.time += dt.max(0.0);
    }

    fn n_servos(&self) -> usize {
        N_SERVOS
    }

    fn servo(&self, k: usize) -> ServoReadings {
        let angle = self.at(self.time)[k];
        let velocity = (angle - self.at(self.time - SPEED_SPAN)[k]) / SPEED_SPAN;
        let (voltage, temperature) = (self.supply, LEADER_DEGC);
        ServoReadings { angle, velocity, reference: angle, pwm: 0.0, voltage, temperature }
    }

    fn load(&self, _: usize) -> f64 {
        0.0
    }

    fn effort(&self, _: usize) -> f64 {
        0.0
    }

    fn command(&mut self, _: usize, _: &ServoCommand) {}

    fn power_cycle(&mut self, _: usize) {}

    fn set_supply(&mut self, volts: f64) {
        self.supply = volts;
    }

    fn set_disturbance(&mut self, _: usize, _: f64) {}
}
