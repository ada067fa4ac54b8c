//! The motions of NAD: what the leader does in each task, with what in the jaws and what pushing.
//!
//! # Reference
//! Dou et al. (NeuralActuator), section III, and the folders of their data set.

use std::f64::consts::PI;

use nalgebra::Vector3;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::chain::N_JOINTS;
use super::fault::JointFault;
use super::leader::{Posture, VirtualLeader};
use super::robot::VirtualArm;
use super::world::Object;

/// Side of every object [m].
const OBJECT_WIDTH: f64 = 0.024;
/// Aperture before and after grasping [m].
const OPEN: f64 = 0.04;
/// Asked for while an object is held: the jaws press by what is missing [m].
const CLOSED: f64 = 0.0225;
/// Where the arm rests between motions [rad], [m].
const HOME: Posture = [0.0, -0.9, 0.5, 0.9, 0.012];
/// Height of an object's centre above the base frame [m].
const TABLE_HEIGHT: f64 = 0.03;

/// A motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ArmTask {
    /// The tip goes far out and back near.
    BackwardForward,
    /// It goes around, clockwise as seen from the arm.
    CircularClockwise,
    /// It goes around the other way.
    CircularCounterclockwise,
    /// It goes up and stays, perhaps with an object.
    GoUpAndStay,
    /// One joint, from 0, or the gripper sweeps its range.
    Sweep(usize),
    /// An object, or none, is picked up, put down elsewhere, and brought back.
    PickPlace,
    /// The tip goes slowly to and fro, perhaps pushed along an axis.
    Push,
}

/// A direction of pushing: axis from 0, and sign.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PushDirection {
    /// 0 to 2.
    pub axis: usize,
    /// 1 or -1.
    pub sign: f64,
}

/// Definition of one trajectory.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ArmTrial {
    /// Task of the leader.
    pub task: ArmTask,
    /// Payload in the jaws [kg]; 0 for nothing.
    pub payload: f64,
    /// From where it is pushed.
    pub push: Option<PushDirection>,
    /// Whether a joint is degraded; how is drawn.
    pub degraded: Degraded,
    /// Labelled part of the force.
    pub labels: Labels,
}

/// Condition of the arm. Faults are at joint 3; how large they are is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Degraded {
    /// Healthy.
    No,
    /// A rubber band around the joint, as in NAD.
    Band,
    /// More dry friction.
    Friction,
    /// A tooth is lost.
    LostTooth,
}

/// Force labels at the tip in the data set.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Labels {
    /// Nothing.
    None,
    /// The weight of an object while it is lifted.
    Weight,
    /// The readings of the sensor at all times.
    Sensor,
}

/// A push that grows, stays and goes.
#[derive(Debug, Clone, Copy)]
pub struct PushProfile {
    from: f64,
    until: f64,
    force: Vector3<f64>,
}

/// Everything drawn for a trajectory.
#[derive(Debug, Clone)]
pub struct ArmCourse {
    /// The hand.
    pub leader: VirtualLeader,
    /// Object on the table, if there is one.
    pub object: Option<Object>,
    /// Pushes.
    pub presses: Vec<PushProfile>,
    /// Faults of the arm.
    pub faults: Vec<JointFault>,
}

impl PushProfile {
    fn at(&self, time: f64) -> Vector3<f64> {
        let share = (time - self.from) / (self.until - self.from);
        if !(0.0..1.0).contains(&share) {
            return Vector3::zeros();
        }
        let edge = (share.min(1.0 - share) / 0.25).min(1.0);
        self.force * (0.5 - 0.5 * (PI * edge).cos())
    }
}

impl ArmCourse {
    /// Force of all pushes at `time` [N].
    pub fn push_at(&self, time: f64) -> Vector3<f64> {
        self.presses.iter().map(|press| press.at(time)).sum()
    }
}

impl ArmTrial {
    /// Draws the trajectory's own way of doing it.
    pub fn course(&self, arm: &VirtualArm, stream: &mut ChaCha8Rng) -> ArmCourse {
        let mut leader = VirtualLeader::new(&arm.chain, stream);
        let mut object = None;
        let home = near(stream, &HOME, 0.03);
        leader.then(0.0, home);
        leader.stays(stream.random_range(0.4..0.7));
        match self.task {
            ArmTask::BackwardForward => backward_forward(&mut leader, stream),
            ArmTask::CircularClockwise => circular(&mut leader, stream, -1.0),
            ArmTask::CircularCounterclockwise => circular(&mut leader, stream, 1.0),
            ArmTask::Sweep(joint) => sweep(&mut leader, stream, joint),
            ArmTask::GoUpAndStay => object = go_up_and_stay(&mut leader, stream, self.payload),
            ArmTask::PickPlace => object = pick_place(&mut leader, stream, self.payload),
            ArmTask::Push => to_and_fro(&mut leader, stream, self.push),
        }
        if self.task != ArmTask::Push {
            leader.then(stream.random_range(1.6..2.0), home);
            leader.stays(0.4);
        }
        let presses = self.push.map_or_else(Vec::new, |push| presses(push, leader.end(), stream));
        let faults = fault(self.degraded, stream).into_iter().collect();
        ArmCourse { leader, object, presses, faults }
    }
}

fn near(stream: &mut ChaCha8Rng, posture: &Posture, by: f64) -> Posture {
    std::array::from_fn(|k| {
        if k < N_JOINTS { posture[k] + by * stream.random_range(-1.0..1.0) } else { posture[k] }
    })
}

fn about(stream: &mut ChaCha8Rng, tip: [f64; 3], by: f64) -> Vector3<f64> {
    Vector3::from_fn(|k, _| tip[k] + by * stream.random_range(-1.0..1.0))
}

fn backward_forward(leader: &mut VirtualLeader, stream: &mut ChaCha8Rng) {
    let rounds = 4;
    for _ in 0..rounds {
        let pitch = stream.random_range(0.1..0.35);
        let far = about(stream, [0.30, 0.0, 0.14], 0.012);
        leader.reaches(stream.random_range(1.8..2.4), far, pitch, HOME[N_JOINTS]);
        let close = about(stream, [0.15, 0.0, 0.17], 0.012);
        leader.reaches(stream.random_range(1.8..2.4), close, pitch, HOME[N_JOINTS]);
    }
}

fn circular(leader: &mut VirtualLeader, stream: &mut ChaCha8Rng, sense: f64) {
    let pitch = stream.random_range(0.15..0.3);
    let top = about(stream, [0.235, 0.0, 0.215], 0.008);
    leader.reaches(stream.random_range(1.8..2.2), top, pitch, HOME[N_JOINTS]);
    let radius = stream.random_range(0.045..0.06);
    let turns = f64::from(stream.random_range(5_u8..=7));
    leader.circles(stream.random_range(14.0..16.0), top, pitch, radius, sense * turns);
}

/// Least and greatest angle of a sweep, the others at home [rad], and aperture [m].
const SWEEPS: [[f64; 2]; 5] = [[-1.4, 1.4], [-1.3, 0.5], [-1.2, 1.0], [-1.3, 1.6], [0.004, 0.040]];

fn sweep(leader: &mut VirtualLeader, stream: &mut ChaCha8Rng, joint: usize) {
    let [least, greatest] = SWEEPS[joint];
    let posture = near(stream, &HOME, 0.08);
    for round in 0..6 {
        let mut end = posture;
        let share = stream.random_range(0.92..1.0);
        let middle = 0.5 * (least + greatest);
        let goal = if round % 2 == 0 { greatest } else { least };
        end[joint] = middle + share * (goal - middle);
        leader.then(stream.random_range(2.3..3.2), end);
    }
}

/// Goes to an object on the table and closes the jaws on it, or on nothing; gives the object.
fn grasp(leader: &mut VirtualLeader, stream: &mut ChaCha8Rng, place: Vector3<f64>, pitch: f64) {
    let above = place + Vector3::z() * 0.06;
    leader.reaches(stream.random_range(1.3..1.7), above, pitch, OPEN);
    leader.reaches(stream.random_range(0.8..1.1), place, pitch, OPEN);
    leader.stays(0.2);
    leader.reaches(stream.random_range(0.5..0.7), place, pitch, CLOSED);
    leader.stays(0.25);
}

fn release(leader: &mut VirtualLeader, stream: &mut ChaCha8Rng, place: Vector3<f64>, pitch: f64) {
    let above = place + Vector3::z() * stream.random_range(0.05..0.07);
    leader.reaches(stream.random_range(1.3..1.7), above, pitch, CLOSED);
    // Down until the table has it.
    leader.reaches(stream.random_range(0.8..1.1), place - Vector3::z() * 0.004, pitch, CLOSED);
    leader.stays(0.2);
    leader.reaches(stream.random_range(0.4..0.6), place, pitch, OPEN);
    leader.reaches(stream.random_range(0.7..0.9), above, pitch, OPEN);
}

fn object(mass: f64, position: Vector3<f64>) -> Option<Object> {
    (mass > 0.0).then_some(Object { mass, width: OBJECT_WIDTH, position })
}

fn go_up_and_stay(leader: &mut VirtualLeader, stream: &mut ChaCha8Rng, payload: f64) -> Option<Object> {
    let pitch = stream.random_range(0.35..0.55);
    let place = about(stream, [0.22, 0.0, TABLE_HEIGHT], 0.01);
    grasp(leader, stream, place, pitch);
    let high = about(stream, [0.23, 0.0, 0.20], 0.02);
    leader.reaches(stream.random_range(1.8..2.4), high, pitch, CLOSED);
    leader.stays(stream.random_range(8.0..9.0));
    release(leader, stream, place, pitch);
    object(payload, place)
}

fn pick_place(leader: &mut VirtualLeader, stream: &mut ChaCha8Rng, payload: f64) -> Option<Object> {
    let pitch = stream.random_range(0.5..0.7);
    let [right, left] = [-0.09, 0.09].map(|y| about(stream, [0.20, y, TABLE_HEIGHT], 0.01));
    let left = Vector3::new(left.x, left.y, right.z);
    for (from, to) in [(right, left), (left, right)] {
        grasp(leader, stream, from, pitch);
        let between = 0.5 * (from + to) + Vector3::z() * stream.random_range(0.09..0.12);
        leader.reaches(stream.random_range(1.0..1.4), between, pitch, CLOSED);
        release(leader, stream, to, pitch);
    }
    object(payload, right)
}

/// The same motion with and without a push.
fn to_and_fro(leader: &mut VirtualLeader, stream: &mut ChaCha8Rng, push: Option<PushDirection>) {
    let axis = push.map_or_else(|| stream.random_range(0..3), |push| push.axis);
    let along = Vector3::from_fn(|k, _| if k == axis { 0.03 } else { 0.0 });
    let pitch = stream.random_range(0.1..0.25);
    let middle = about(stream, [0.23, 0.0, 0.15], 0.01);
    for round in 0..4 {
        let side = if round % 2 == 0 { 1.0 } else { -1.0 };
        let tip = middle + along * (side * stream.random_range(0.6..1.0));
        leader.reaches(stream.random_range(1.8..2.3), tip, pitch, HOME[N_JOINTS]);
        leader.stays(0.5);
    }
}

/// Three pushes with rests between.
fn presses(push: PushDirection, end: f64, stream: &mut ChaCha8Rng) -> Vec<PushProfile> {
    let each = (end - 1.0) / 3.0;
    let press = |k: usize| {
        let from = 1.0 + each * k as f64 + stream.random_range(0.1..0.4);
        let until = 1.0 + each * (k + 1) as f64 - stream.random_range(0.2..0.6);
        let peak = stream.random_range(2.5..9.0);
        let force = Vector3::from_fn(|axis, _| {
            if axis == push.axis { push.sign * peak } else { 0.08 * peak * stream.random_range(-1.0..1.0) }
        });
        PushProfile { from, until, force }
    };
    (0..3).map(press).collect()
}

/// Fault of joint 3, if it is degraded.
fn fault(degraded: Degraded, stream: &mut ChaCha8Rng) -> Option<JointFault> {
    let joint = 2;
    match degraded {
        Degraded::No => None,
        Degraded::Friction => Some(JointFault::Friction { joint, factor: stream.random_range(1.3..2.0) }),
        Degraded::Band => Some(JointFault::Band {
            joint,
            stiffness: stream.random_range(0.3..0.9),
            from: stream.random_range(-0.3..0.3),
        }),
        Degraded::LostTooth => Some(JointFault::LostTooth {
            joint,
            at: stream.random_range(0.2..0.9),
            width: stream.random_range(0.12..0.2),
            backlash: stream.random_range(0.02..0.05),
        }),
    }
}
