//! `ArmWorld`: the arm in time.
//!
//! Each joint is a rotor behind a gear: the rotor drives its link through teeth that are elastic and have backlash. One step of h
//! is implicit in all speeds:
//! ```text
//! J (ω⁺ − ω)/h = τ_m(ω⁺) − τ_c − F_m         τ_c = k (θ + h ω⁺ − q − h q̇⁺ ∓ δ/2) + d (ω⁺ − q̇⁺) where teeth touch
//! M (q̇⁺ − q̇)/h = τ_c − C q̇ − g + Jᵀ f − F_l
//! ```
//! with dry friction F_m of the gear, which depends on its load, and F_l of the bearing; see [`super::stiction`].

use nalgebra::Vector3;

use super::chain::{ArmBody, BodyChain, Configuration, N_JOINTS};
use super::fault::JointFault;
use super::robot::VirtualArm;
use super::servo::{MotorLine, ServoState, VirtualServo};
use super::stiction::{N_SPEEDS, Statuses, StictionProblem};

/// Servos: joints, then the gripper.
pub const N_SERVOS: usize = N_JOINTS + 1;
/// Steps in a control period of the servos.
const STEPS_OF_CONTROL: u64 = 2;
/// Distance from the tip to an object within which the jaws close on it [m].
const REACH: f64 = 0.04;
/// Of the table under an object [N/m], [N s/m].
const TABLE: [f64; 2] = [4000.0, 20.0];

/// Of the ends of a joint's range [N m/rad], [N m s/rad].
const STOP: [f64; 2] = [500.0, 1.0];

/// Something to pick up: a cube on a table.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Object {
    /// [kg].
    pub mass: f64,
    /// Of its sides [m].
    pub width: f64,
    /// Its centre, in the frame of the base [m].
    pub position: Vector3<f64>,
}

/// Where an object is.
#[derive(Debug, Clone)]
struct ObjectState {
    /// The arm with the object.
    chain: BodyChain,
    /// Height of its centre at which the table no longer carries it [m].
    lifted: f64,
}

/// Mean torques and forces on the arm over a step.
#[derive(Debug, Clone, Copy, Default)]
pub struct AppliedTorques {
    /// Torques of the motors at the joints [N m].
    pub motor: [f64; N_JOINTS],
    /// All friction of the joints, positive against positive motion [N m].
    pub friction: [f64; N_JOINTS],
    /// Force of everything outside on the tip, an object's inertia left out [N].
    pub force: Vector3<f64>,
}

/// An arm with its state.
#[derive(Debug, Clone)]
pub struct ArmWorld {
    arm: VirtualArm,
    faults: Vec<JointFault>,
    steps: u64,
    /// Angles of the joints [rad].
    pub q: [f64; N_JOINTS],
    /// Their speeds [rad/s].
    pub dq: [f64; N_JOINTS],
    /// Servos, that of the gripper last.
    pub servos: [ServoState; N_SERVOS],
    /// Where each servo is asked to go [rad]; `None`: its torque is off.
    pub goals: [Option<f64>; N_SERVOS],
    /// Additional torques on the joints [N m].
    pub disturbances: [f64; N_JOINTS],
    /// Force on the tip in addition to that of an object [N].
    pub push: Vector3<f64>,
    /// Voltage of the bus [V].
    pub bus: f64,
    teeth: [f64; N_JOINTS],
    statuses: Statuses,
    object: Option<Object>,
    held: Option<ObjectState>,
    /// Mean torques and forces in the last step.
    pub acted: AppliedTorques,
    /// Power that friction, damping and motors took in the last step [W].
    pub lost: [f64; N_JOINTS],
    configuration: Configuration,
}

impl ArmWorld {
    /// At rest at `q` [rad] with the jaws `aperture` [m] open; each servo as warm as `temperatures` [°C].
    pub fn new(arm: &VirtualArm, q: [f64; N_JOINTS], aperture: f64, temperatures: [f64; N_SERVOS]) -> Self {
        let jaws = arm.gripper.angle(aperture);
        let angle = |k: usize| q.get(k).copied().unwrap_or(jaws);
        Self {
            faults: Vec::new(),
            steps: 0,
            q,
            dq: [0.0; N_JOINTS],
            servos: std::array::from_fn(|k| VirtualServo::resting(angle(k), temperatures[k])),
            goals: [None; N_SERVOS],
            disturbances: [0.0; N_JOINTS],
            push: Vector3::zeros(),
            bus: arm.supply.voltage,
            teeth: [0.0; N_JOINTS],
            statuses: [0.0; N_SPEEDS],
            object: None,
            held: None,
            acted: AppliedTorques::default(),
            lost: [0.0; N_JOINTS],
            configuration: arm.chain.at(&q, &[0.0; N_JOINTS]),
            arm: arm.clone(),
        }
    }

    /// With something wrong.
    pub fn with_faults(mut self, faults: &[JointFault]) -> Self {
        self.faults = faults.to_vec();
        self
    }

    /// With something to pick up.
    pub fn with_object(mut self, object: Object) -> Self {
        self.object = Some(object);
        self
    }

    /// With a body at the tip that never leaves it.
    pub fn with_payload(mut self, mass: f64, side: f64) -> Self {
        let body = ArmBody::cube(mass, side, self.arm.chain.tip);
        self.held =
            Some(ObjectState { chain: self.arm.chain.with_payload(&body), lifted: f64::NEG_INFINITY });
        self.object = Some(Object { mass, width: side, position: self.configuration.tip });
        self.configuration = self.chain().at(&self.q, &self.dq);
        self
    }

    /// Time since the beginning [s].
    pub fn time(&self) -> f64 {
        self.steps as f64 * self.arm.step
    }

    /// The arm.
    pub fn arm(&self) -> &VirtualArm {
        &self.arm
    }

    /// Servo `k`, that of the gripper last.
    pub fn spec(&self, k: usize) -> &VirtualServo {
        self.arm.servos.get(k).unwrap_or(&self.arm.gripper.servo)
    }

    /// Sets the registers P and D of servo `k`.
    pub fn set_gains(&mut self, k: usize, gains: [f64; 2]) {
        self.arm.servos.get_mut(k).unwrap_or(&mut self.arm.gripper.servo).gains = gains;
    }

    /// Sets the voltage of the supply without load [V].
    pub fn set_supply(&mut self, volts: f64) {
        self.arm.supply.voltage = volts;
    }

    /// Where the encoder of servo `k` is: on the output of a joint, on the motor of the gripper [rad].
    pub fn encoder(&self, k: usize) -> f64 {
        self.q.get(k).copied().unwrap_or(self.servos[k].angle)
    }

    /// How fast it turns [rad/s].
    pub fn encoder_speed(&self, k: usize) -> f64 {
        self.dq.get(k).copied().unwrap_or(self.servos[k].speed)
    }

    /// Equations of motion at the beginning of the last step.
    pub fn configuration(&self) -> &Configuration {
        &self.configuration
    }

    /// Mass that the jaws hold, if the table carries none of it [kg].
    pub fn lifted(&self) -> Option<f64> {
        let (object, held) = (self.object.as_ref()?, self.held.as_ref()?);
        (self.configuration.tip.z >= held.lifted).then_some(object.mass)
    }

    /// Mass that the jaws hold, also where the table carries part of it [kg].
    pub fn grasped(&self) -> Option<f64> {
        self.held.as_ref().and(self.object.as_ref()).map(|object| object.mass)
    }

    /// Kinetic and potential energy of bodies and rotors, and elastic energy of the teeth [J].
    pub fn energies(&self) -> [f64; 3] {
        let [kinetic, potential] = self.chain().at(&self.q, &self.dq).energy;
        let (mut rotors, mut elastic) = (0.0, 0.0);
        for (k, servo) in self.arm.servos.iter().enumerate() {
            rotors += 0.5 * servo.armature * self.servos[k].speed * self.servos[k].speed;
            let [beyond, _] = self.flank(k);
            elastic += 0.5 * servo.stiffness * beyond * beyond;
        }
        [kinetic + rotors, potential, elastic]
    }

    fn chain(&self) -> &BodyChain {
        self.held.as_ref().map_or(&self.arm.chain, |held| &held.chain)
    }

    /// How far the flanks of joint `k` are pressed into each other, and half its backlash [rad].
    fn flank(&self, k: usize) -> [f64; 2] {
        let own = self.arm.servos[k].backlash;
        let more: f64 = self.faults.iter().map(|fault| fault.more_backlash(k, self.q[k], own)).sum();
        let (half, gap) = (0.5 * (own + more), self.servos[k].angle - self.q[k]);
        [gap - gap.clamp(-half, half), half]
    }

    /// Lets a step pass.
    pub fn step(&mut self) {
        let h = self.arm.step;
        if self.steps.is_multiple_of(STEPS_OF_CONTROL) {
            self.control();
        }
        self.steps += 1;
        self.configuration = self.chain().at(&self.q, &self.dq);
        let outside = self.push + self.table();
        let line = |servo: &VirtualServo, k: usize| match self.goals[k] {
            Some(_) => servo.motor(&self.servos[k], self.bus),
            None => MotorLine::OPEN,
        };
        let jaws = line(&self.arm.gripper.servo, N_JOINTS);
        let lines: [MotorLine; N_JOINTS] = std::array::from_fn(|k| line(&self.arm.servos[k], k));
        self.solve(&lines, &outside, h);
        self.move_jaws(&jaws, h);
        let supply = self.arm.supply;
        let drawn: f64 = self.servos.iter().map(|servo| servo.duty * servo.current).sum();
        self.bus = supply.voltage - supply.resistance * drawn;
        let specs = self.arm.servos.iter().chain([&self.arm.gripper.servo]);
        for (servo, state) in specs.zip(&mut self.servos) {
            servo.warm(state, supply.air, h);
        }
    }

    fn control(&mut self) {
        let servos = self.arm.servos.iter().chain([&self.arm.gripper.servo]);
        for (k, (servo, state)) in servos.zip(&mut self.servos).enumerate() {
            let angle = self.q.get(k).copied().unwrap_or(state.angle);
            match self.goals[k] {
                Some(goal) => servo.control(state, goal, angle),
                None => state.duty = 0.0,
            }
        }
    }

    /// Force of the table on what the jaws hold [N].
    fn table(&self) -> Vector3<f64> {
        let Some(held) = &self.held else { return Vector3::zeros() };
        let below = held.lifted - self.configuration.tip.z;
        if below <= 0.0 {
            return Vector3::zeros();
        }
        let speed = self.configuration.tip_velocity(&self.dq).z;
        Vector3::z() * (TABLE[0] * below - TABLE[1] * speed).max(0.0)
    }

    /// Speeds at the end of the step, and what made them.
    fn solve(&mut self, lines: &[MotorLine; N_JOINTS], outside: &Vector3<f64>, h: f64) {
        let force = self.configuration.torques_of(outside);
        let mut dry = [0.0; N_SPEEDS];
        let mut free = [0.0; N_SPEEDS];
        for (k, servo) in self.arm.servos.iter().enumerate() {
            let state = &self.servos[k];
            let (motor, _) = lines[k].at(state.speed);
            let factor: f64 = self.faults.iter().map(|fault| fault.friction_factor(k)).product();
            dry[k] = factor * servo.friction.dry(state.speed, motor, -self.teeth[k]);
            dry[N_JOINTS + k] = servo.bearing;
            free[k] = servo.armature / h * state.speed + lines[k].at_rest;
            let inertial: f64 = (0..N_JOINTS).map(|j| self.configuration.mass[k][j] * self.dq[j]).sum();
            let band: f64 = self.faults.iter().map(|fault| fault.torque(k, self.q[k])).sum();
            free[N_JOINTS + k] =
                inertial / h - self.configuration.bias[k] + force[k] + band + self.disturbances[k];
        }
        // Teeth touch where they would be pressed into each other at the speeds so far; those that would pull do not.
        let mut sides: [f64; N_JOINTS] = std::array::from_fn(|k| {
            let [_, half] = self.flank(k);
            let gap = self.servos[k].angle - self.q[k] + h * (self.servos[k].speed - self.dq[k]);
            if gap.abs() > half { gap.signum() } else { 0.0 }
        });
        let mut found = self.balance(lines, &free, &dry, &sides, h);
        for _ in 0..N_JOINTS {
            let pulls = |k: usize| sides[k] != 0.0 && sides[k] * found.1[k] < 0.0;
            let pulling: [bool; N_JOINTS] = std::array::from_fn(pulls);
            if !pulling.contains(&true) {
                break;
            }
            for k in (0..N_JOINTS).filter(|k| pulling[*k]) {
                sides[k] = 0.0;
            }
            found = self.balance(lines, &free, &dry, &sides, h);
        }
        let (speeds, teeth, rubbed) = found;
        self.teeth = teeth;
        self.acted.force = *outside;
        for k in 0..N_JOINTS {
            let (motor, current) = lines[k].at(speeds[k]);
            let viscous = self.arm.servos[k].friction.viscous * speeds[k];
            let [link, slip] = [speeds[N_JOINTS + k], speeds[k] - speeds[N_JOINTS + k]];
            let damped = if teeth[k] == 0.0 { 0.0 } else { self.arm.servos[k].damping * slip * slip };
            self.lost[k] = (rubbed[k] + viscous - motor) * speeds[k] + rubbed[N_JOINTS + k] * link + damped;
            self.acted.motor[k] = motor;
            self.acted.friction[k] = rubbed[k] + rubbed[N_JOINTS + k] + viscous;
            let state = &mut self.servos[k];
            (state.speed, state.current) = (speeds[k], current);
            state.angle += h * speeds[k];
            self.dq[k] = speeds[N_JOINTS + k];
            self.q[k] += h * self.dq[k];
        }
    }

    /// Speeds, torques of the teeth on the links, and dry friction, if the teeth touch on these sides.
    fn balance(
        &mut self,
        lines: &[MotorLine; N_JOINTS],
        free: &[f64; N_SPEEDS],
        dry: &[f64; N_SPEEDS],
        sides: &[f64; N_JOINTS],
        h: f64,
    ) -> ([f64; N_SPEEDS], [f64; N_JOINTS], [f64; N_SPEEDS]) {
        let mut balance = StictionProblem {
            rotors: [0.0; N_JOINTS],
            coupling: [0.0; N_JOINTS],
            links: self.configuration.mass.map(|row| row.map(|m| m / h)),
            push: *free,
            dry: *dry,
        };
        let mut pressed = [0.0; N_JOINTS];
        for (k, servo) in self.arm.servos.iter().enumerate() {
            balance.rotors[k] = servo.armature / h + lines[k].slope + servo.friction.viscous;
            let [least, greatest] = self.arm.chain.links[k].range;
            let beyond = self.q[k] - self.q[k].clamp(least, greatest);
            if beyond != 0.0 {
                balance.links[k][k] += STOP[0] * h + STOP[1];
                balance.push[N_JOINTS + k] -= STOP[0] * beyond;
            }
            if sides[k] != 0.0 {
                let [_, half] = self.flank(k);
                let stiff = servo.stiffness * h + servo.damping;
                pressed[k] = servo.stiffness * (self.servos[k].angle - self.q[k] - sides[k] * half);
                balance.coupling[k] = stiff;
                balance.rotors[k] += stiff;
                balance.links[k][k] += stiff;
                balance.push[k] -= pressed[k];
                balance.push[N_JOINTS + k] += pressed[k];
            }
        }
        let speeds = balance.solve(&mut self.statuses);
        let teeth =
            std::array::from_fn(|k| pressed[k] + balance.coupling[k] * (speeds[k] - speeds[N_JOINTS + k]));
        let rubbed = std::array::from_fn(|i| balance.friction(i, &speeds));
        (speeds, teeth, rubbed)
    }

    /// Moves the jaws, which take hold of an object or let it go.
    fn move_jaws(&mut self, line: &MotorLine, h: f64) {
        let gripper = self.arm.gripper;
        let tip = self.configuration.tip;
        let within = |object: &&mut Object| (object.position - tip).norm() < REACH;
        let weight = self.arm.chain.gravity.norm();
        let Some(object) = self.object.as_mut().filter(|object| self.held.is_some() || within(object)) else {
            return gripper.step(&mut self.servos[N_JOINTS], line, 0.0, h);
        };
        gripper.step(&mut self.servos[N_JOINTS], line, object.width, h);
        if self.held.as_ref().is_some_and(|held| held.lifted == f64::NEG_INFINITY) {
            object.position = tip;
            return;
        }
        let force = gripper.force(self.servos[N_JOINTS].angle, object.width);
        let holds = gripper.holds(force, object.mass * weight);
        match (&self.held, holds) {
            (None, true) => {
                // The table carries all of it, and less as it is lifted.
                let body = ArmBody::cube(object.mass, object.width, self.arm.chain.tip);
                let lifted = tip.z + object.mass * weight / TABLE[0];
                self.held = Some(ObjectState { chain: self.arm.chain.with_payload(&body), lifted });
            }
            (Some(held), false) => {
                object.position.z = held.lifted - object.mass * weight / TABLE[0];
                self.held = None;
            }
            _ => {}
        }
        if self.held.is_some() {
            object.position = tip;
        }
    }
}
