//! The simulated arm that a network drives: rigid bodies with implicit damping, and the gripper's motor as an axis of its own.

use hysteron_actuator::number::Dual;
use hysteron_actuator::{CatalogueDrive, Drive};
use hysteron_base::BadInput;
use hysteron_base::lanes::Isa;
use serde::{Deserialize, Serialize};

use super::drive_model::DriveModel;
use super::features::FeatureLayout;
use super::motors::Motors;
use super::servo::RolloutServo;
use hysteron_arm_dynamics::{ArmRollouts, EndStops, Integrator, JointKind, Model, RolloutInputs};
use hysteron_arm_estimation::servo_force::TIP;

/// Step, damping and limits of the simulation in training.
///
/// The substitutes for armature and damping of the gears take their part of the torque: torques so learned are those of this
/// simulation, and no physical ones.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SimulationOptions {
    /// Length of a step [s].
    pub period: f64,
    /// Its equal parts.
    pub substeps: usize,
    /// Of every motor, at the output [kg m²].
    pub armature: f64,
    /// Of every motor [N m s/rad].
    pub damping: f64,
    /// Largest torque of a joint, and of the gripper's motor [N m].
    pub torque_limits: [f64; 2],
    /// A position servo in the loop, to whose torque the network's is added; none as published.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub servo: Option<RolloutServo>,
    /// In place of that servo a drive, the same in every motor.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub drive: Option<CatalogueDrive>,
    /// Payload of the tip at all times [kg].
    #[serde(default, skip_serializing_if = "is_nothing")]
    pub payload: f64,
}

fn is_nothing(mass: &f64) -> bool {
    *mass == 0.0
}

/// Second moments of a payload's mass: a cube with sides of 24 mm [m²].
const PAYLOAD_SHAPE: f64 = 0.024 * 0.024 / 12.0;
/// Parts of a step for which the servo's torque is held.
const SERVO_PARTS: usize = 4;

impl SimulationOptions {
    /// Those of NeuralActuator's release for the OpenManipulator-X: 17 ms in four parts.
    pub const PUBLISHED: Self = Self {
        period: 0.017,
        substeps: 4,
        armature: 0.1,
        damping: 1.0,
        torque_limits: [5.0, 1.5],
        servo: None,
        drive: None,
        payload: 0.0,
    };

    /// With these motors and no servo in the loop.
    pub fn without_servo(motors: &Motors, period: f64) -> Self {
        let Self { armature, damping, torque_limits: [limit, gripper], .. } = Self::PUBLISHED;
        Self {
            period,
            armature: motors.armature.unwrap_or(armature),
            damping: motors.damping.unwrap_or(damping),
            torque_limits: [motors.torque_limit.unwrap_or(limit), gripper],
            ..Self::PUBLISHED
        }
    }

    /// With this servo in the loop, and its damping and motors.
    pub fn with_servo(servo: &RolloutServo, period: f64) -> Self {
        Self {
            substeps: SERVO_PARTS,
            armature: servo.motors.servo_armature(),
            damping: servo.damping,
            servo: Some(servo.clone()),
            ..Self::without_servo(&servo.motors, period)
        }
    }

    /// With this drive in the loop of every motor, and its armature, damping and stall torque where these motors do not set them.
    pub fn with_drive(drive: &CatalogueDrive, motors: &Motors, period: f64) -> Self {
        let Drive { motor, supply, gear, .. } = &drive.drive;
        let stall = motor.stall_torque * supply.voltage / motor.rated_voltage;
        let limit = motors.torque_limit.unwrap_or(stall);
        Self {
            substeps: SERVO_PARTS,
            armature: motors.armature.unwrap_or(gear.armature),
            damping: motors.damping.unwrap_or_else(|| drive.drive.viscous()),
            torque_limits: [limit; 2],
            drive: Some(drive.clone()),
            ..Self::without_servo(motors, period)
        }
    }

    /// Model that drives the motors next to the network.
    pub(super) fn drive_model(&self) -> Option<DriveModel<'_>> {
        let drive = self.drive.as_ref().map(|one| DriveModel::Drive(&one.drive));
        self.servo.as_ref().map(DriveModel::Servo).or(drive)
    }

    /// Reference that gains of the position loops are relative to; none where it is not known.
    pub(super) fn position_gain(&self) -> Option<f64> {
        match self.drive_model()? {
            DriveModel::Servo(servo) => servo.position_gain,
            DriveModel::Drive(_) => Some(1.0),
        }
    }

    /// # Errors
    /// `BadInput` where a drive in the loop is not given the gain of its position loop by what `place` names.
    pub(super) fn check_gain(&self, place: &str, gain: Option<f64>) -> Result<(), BadInput> {
        if self.drive.is_none() || gain.is_some() {
            return Ok(());
        }
        let expected = "the gain of the position loop, as its register has it, for the drive in the loop";
        let bad = BadInput::new(format!("{place}: position_gain"), expected, "none");
        Err(bad.hint("a servo in the loop needs no gain: --prior servo"))
    }

    /// # Errors
    /// `BadInput` naming what is out of range, or not for these motors.
    pub fn check(&self, features: &FeatureLayout) -> Result<(), BadInput> {
        let Self { period, substeps, armature, damping, torque_limits, servo, drive, payload } = self;
        let ranges =
            [("period", *period), ("torque_limits", torque_limits[0]), ("torque_limits", torque_limits[1])];
        for (name, value) in ranges {
            if !(value > 0.0 && value.is_finite()) {
                return Err(BadInput::new(name, "a finite number above zero", value.to_string()));
            }
        }
        for (name, value) in [("armature", *armature), ("damping", *damping), ("payload", *payload)] {
            if !(value >= 0.0 && value.is_finite()) {
                return Err(BadInput::new(name, "a finite number, zero or more", value.to_string()));
            }
        }
        if *substeps == 0 || *substeps > 1000 {
            return Err(BadInput::new("substeps", "1 to 1000", substeps.to_string()));
        }
        if let (Some(_), Some(drive)) = (servo, drive) {
            return Err(BadInput::new(
                "drive",
                "a servo or a drive in the loop",
                format!("both, {}", drive.name),
            ));
        }
        let checked = drive.as_ref().map_or(Ok(()), |one| one.drive.check_load_friction());
        checked.map_err(|bad| bad.within("drive"))?;
        servo.as_ref().map_or(Ok(()), |servo| servo.check(features))
    }
}

/// Motor commands of a step, for arms side by side.
#[derive(Debug, Clone, Copy)]
pub struct MotorCommand<'a> {
    /// Where the servo or drive in the loop goes (trajectories × m) [rad]; of no meaning without one.
    pub goals: &'a [f64],
    /// Gains of the servo's position loops over the gain that its stiffness holds for; of drives as their registers have them (trajectories).
    pub gains: &'a [f64],
    /// Temperatures of the drives' windings (trajectories × m) [°C]; of no meaning without drives.
    pub windings: &'a [f64],
    /// The network's torques (trajectories × m) [N m].
    pub torques: &'a [f64],
}

/// An arm in simulation; motors that are no joints move on their own.
#[derive(Debug, Clone)]
pub struct ArmSimulation {
    model: Model,
    features: FeatureLayout,
    options: SimulationOptions,
}

impl ArmSimulation {
    /// The first joints of `model` are those of `features`; all others are locked at zero.
    ///
    /// # Errors
    /// `BadInput` where the model has fewer joints, a joint that slides, or the options are out of range.
    pub fn new(
        model: &Model,
        features: &FeatureLayout,
        options: &SimulationOptions,
    ) -> Result<Self, BadInput> {
        let n = features.joints;
        options.check(features)?;
        if model.n_joints() < n {
            return Err(BadInput::new("robot", format!("{n} joints or more"), model.n_joints().to_string()));
        }
        let locked: Vec<(&str, f64)> =
            model.joints()[n..].iter().map(|joint| (joint.name.as_str(), 0.0)).collect();
        let model = if locked.is_empty() { model.clone() } else { model.with_locked(&locked)? };
        for joint in model.joints() {
            if joint.kind == JointKind::Prismatic || joint.follows.is_some() {
                return Err(BadInput::new(
                    format!("joint {}", joint.name),
                    "a joint that turns by itself",
                    "another",
                )
                .hint("name fewer joints"));
            }
        }
        let mut model = model.with_bodies_and_drives(|k, _, drive| {
            (drive.armature, drive.damping) = (options.armature, options.damping);
            drive.dry_friction =
                options.drive_model().map_or(0.0, |drive_model| drive_model.friction(k, 0.0)[0].value);
        });
        if options.payload > 0.0 {
            // Second moments of the mass, as xx, xy, yy, xz, yz, zz.
            let second = [1.0, 0.0, 1.0, 0.0, 0.0, 1.0].map(|share| share * options.payload * PAYLOAD_SHAPE);
            model = model.with_payload(TIP, options.payload, [0.0; 3], second)?;
        }
        Ok(Self { model, features: *features, options: options.clone() })
    }

    /// The arm, with the armature and damping of the options.
    pub fn model(&self) -> &Model {
        &self.model
    }

    /// Layout of the state and of the network's inputs.
    pub fn features(&self) -> &FeatureLayout {
        &self.features
    }

    /// Step, damping and limits.
    pub fn options(&self) -> &SimulationOptions {
        &self.options
    }

    /// Largest torque of a motor [N m].
    pub fn limit(&self, motor: usize) -> f64 {
        self.options.torque_limits[usize::from(motor >= self.features.joints)]
    }

    /// For how long torques are held [s], and the parts of that: a whole step, or one part of it with a servo or drive in the loop.
    fn hold_interval(&self) -> (f64, usize) {
        let SimulationOptions { period, substeps, .. } = self.options;
        match self.options.drive_model() {
            None => (period, substeps),
            Some(_) => (period / substeps as f64, 1),
        }
    }

    fn rollouts(&self) -> ArmRollouts<'_> {
        let creeps =
            |drive_model: DriveModel<'_>| matches!(drive_model, DriveModel::Servo(servo) if !servo.holds);
        let integrator = match self.options.drive_model() {
            Some(drive_model) if !creeps(drive_model) => Integrator::WithFriction(EndStops::None),
            _ => Integrator::SemiImplicitEuler,
        };
        ArmRollouts {
            model: &self.model,
            integrator,
            period: self.hold_interval(),
            n_steps: 1,
            frames: Vec::new(),
            isa: Isa::detect(),
        }
    }

    /// Friction of motor `k` at a speed, as [`DriveModel::friction`] has it.
    fn friction(&self, k: usize, speed: f64) -> [Dual; 2] {
        self.options.drive_model().map_or([Dual::from(0.0); 2], |drive_model| drive_model.friction(k, speed))
    }

    /// Friction of the arm's joints in these states (trajectories × 2n), where it is not the model's.
    fn friction_of_arm(&self, states: &[f64]) -> Vec<f64> {
        if !self.options.drive_model().is_some_and(|drive_model| drive_model.friction_varies()) {
            return Vec::new();
        }
        let (m, n) = (self.features.motors(), self.features.joints);
        let mut all = vec![0.0; states.len() / m * n];
        for (row, state) in all.chunks_exact_mut(2 * n).zip(states.chunks_exact(2 * m)) {
            for k in 0..n {
                [row[k], row[n + k]] = self.friction(k, state[m + k]).map(|one| one.value);
            }
        }
        all
    }

    /// Parts that belong to the arm, of rows of `width` numbers for each motor.
    fn of_arm(&self, rows: &[f64], per_motor: usize) -> Vec<f64> {
        let (m, n) = (self.features.motors(), self.features.joints);
        rows.chunks_exact(m * per_motor)
            .flat_map(|row| row.chunks_exact(m).flat_map(|part| &part[..n]))
            .copied()
            .collect()
    }

    /// States after a step from `states` (trajectories × 2m) under the commanded torques; with a servo in the loop, under its torque
    /// towards the goals too.
    pub fn step(&self, states: &[f64], command: MotorCommand<'_>, next: &mut [f64]) {
        let Some(drive_model) = self.options.drive_model() else {
            return self.hold(states, command.torques, next);
        };
        let mut now = states.to_vec();
        for _ in 0..self.options.substeps {
            let driven = self.driven(drive_model, &now, command);
            self.hold(&now, &driven, next);
            now.copy_from_slice(next);
        }
    }

    /// Gradients by states and torques of a step from those by the states after it, `weights`.
    pub fn step_back(&self, states: &[f64], command: MotorCommand<'_>, weights: &[f64]) -> [Vec<f64>; 2] {
        let torques = command.torques;
        let Some(drive_model) = self.options.drive_model() else {
            return self.friction_backward(states, torques, weights);
        };
        let mut path = vec![states.to_vec()];
        for part in 1..self.options.substeps {
            let driven = self.driven(drive_model, &path[part - 1], command);
            let mut next = vec![0.0; states.len()];
            self.hold(&path[part - 1], &driven, &mut next);
            path.push(next);
        }
        let m = self.features.motors();
        let (mut by_state, mut by_torque) = (weights.to_vec(), vec![0.0; torques.len()]);
        for states in path.iter().rev() {
            let driven = self.driven(drive_model, states, command);
            let [mut by_before, by_driven] = self.friction_backward(states, &driven, &by_state);
            for (at, (by_driven, torque)) in by_driven.iter().zip(torques).enumerate() {
                let (row, k) = (at / m, at % m);
                let (free, [by_angle, by_speed]) = own_torque(drive_model, states, command, (at, m));
                if (free + torque).abs() < self.limit(k) {
                    by_torque[at] += by_driven;
                    by_before[row * 2 * m + k] += by_angle * by_driven;
                    by_before[row * 2 * m + m + k] += by_speed * by_driven;
                }
            }
            by_state = by_before;
        }
        [by_state, by_torque]
    }

    /// Torques of servo or drive and the network's together, as far as the motors' limits (trajectories × m) [N m].
    fn driven(&self, drive_model: DriveModel<'_>, states: &[f64], command: MotorCommand<'_>) -> Vec<f64> {
        let m = self.features.motors();
        let one = |(at, torque): (usize, &f64)| {
            let (free, _) = own_torque(drive_model, states, command, (at, m));
            (free + torque).clamp(-self.limit(at % m), self.limit(at % m))
        };
        command.torques.iter().enumerate().map(one).collect()
    }

    /// States after `torques` were held.
    fn hold(&self, states: &[f64], torques: &[f64], next: &mut [f64]) {
        let (m, n) = (self.features.motors(), self.features.joints);
        let (initial, tau) = (self.of_arm(states, 2), self.of_arm(torques, 1));
        let mut found = vec![0.0; initial.len()];
        let friction = self.friction_of_arm(states);
        let inputs = RolloutInputs { initial: &initial, tau: &tau, forces: &[], friction: &friction };
        self.rollouts().run(&inputs, &mut found);
        for (next, found) in next.chunks_exact_mut(2 * m).zip(found.chunks_exact(2 * n)) {
            next[..n].copy_from_slice(&found[..n]);
            next[m..m + n].copy_from_slice(&found[n..]);
        }
        let (interval, substeps) = self.hold_interval();
        let h = interval / substeps as f64;
        let SimulationOptions { armature, damping, .. } = self.options;
        for motor in n..m {
            let rows =
                next.chunks_exact_mut(2 * m).zip(states.chunks_exact(2 * m)).zip(torques.chunks_exact(m));
            for ((next, state), torque) in rows {
                let (mut angle, mut speed) = (state[motor], state[m + motor]);
                let [friction, share] = self.friction(motor, speed);
                let dry = h * (friction.value + share.value * torque[motor].abs());
                for _ in 0..substeps {
                    let push = armature * speed + h * torque[motor];
                    speed = push.signum() * (push.abs() - dry).max(0.0) / (armature + h * damping);
                    angle += h * speed;
                }
                (next[motor], next[m + motor]) = (angle, speed);
            }
        }
    }

    /// The gradient of [`Self::hold`].
    fn friction_backward(&self, states: &[f64], torques: &[f64], weights: &[f64]) -> [Vec<f64>; 2] {
        let (m, n) = (self.features.motors(), self.features.joints);
        let (initial, tau) = (self.of_arm(states, 2), self.of_arm(torques, 1));
        let mut after = vec![0.0; initial.len()];
        let friction = self.friction_of_arm(states);
        let inputs = RolloutInputs { initial: &initial, tau: &tau, forces: &[], friction: &friction };
        let rollouts = self.rollouts();
        rollouts.run(&inputs, &mut after);
        let found = rollouts.pull_back(&inputs, &after, &self.of_arm(weights, 2));
        let [mut by_state, mut by_torque] = [vec![0.0; states.len()], vec![0.0; torques.len()]];
        let rows = by_state.chunks_exact_mut(2 * m).zip(by_torque.chunks_exact_mut(m));
        let arms = found.initial.chunks_exact(2 * n).zip(found.tau.chunks_exact(n));
        for ((by_state, by_torque), (initial, tau)) in rows.zip(arms) {
            by_state[..n].copy_from_slice(&initial[..n]);
            by_state[m..m + n].copy_from_slice(&initial[n..]);
            by_torque[..n].copy_from_slice(tau);
        }
        for (row, by_friction) in found.friction.chunks_exact(2 * n).enumerate() {
            for k in 0..n {
                let at = row * 2 * m + m + k;
                let [friction, share] = self.friction(k, states[at]);
                by_state[at] += friction.slope * by_friction[k] + share.slope * by_friction[n + k];
            }
        }
        let (interval, substeps) = self.hold_interval();
        let h = interval / substeps as f64;
        let SimulationOptions { armature, damping, .. } = self.options;
        for motor in n..m {
            // Where there is friction that holds, torques are held for one part only.
            let rows = by_state.chunks_exact_mut(2 * m).zip(by_torque.chunks_exact_mut(m)).enumerate();
            for ((row, (by_state, by_torque)), weights) in rows.zip(weights.chunks_exact(2 * m)) {
                let (by_angle, mut by_speed) = (weights[motor], weights[m + motor]);
                let (torque, before) = (torques[m * row + motor], states[2 * m * row + m + motor]);
                let [friction, share] = self.friction(motor, before);
                let push = armature * before + h * torque;
                let dry = h * (friction.value + share.value * torque.abs());
                let sliding = if dry == 0.0 || push.abs() > dry { 1.0 } else { 0.0 };
                // What more torque and more speed move, less what they rub.
                let moved = 1.0 - share.value * torque.signum() * push.signum();
                let kept = armature - push.signum() * h * (friction.slope + share.slope * torque.abs());
                for _ in 0..substeps {
                    by_speed = sliding * (by_speed + h * by_angle);
                    by_torque[motor] += moved * by_speed * h / (armature + h * damping);
                    by_speed *= kept / (armature + h * damping);
                }
                (by_state[motor], by_state[m + motor]) = (by_angle, by_speed);
            }
        }
        [by_state, by_torque]
    }
}

/// Torque and its derivatives, as [`DriveModel::torque`] has them, of motor `at` of all m in every row.
fn own_torque(
    drive_model: DriveModel<'_>,
    states: &[f64],
    command: MotorCommand<'_>,
    (at, m): (usize, usize),
) -> (f64, [f64; 2]) {
    let (row, k) = (at / m, at % m);
    let state = &states[row * 2 * m..][..2 * m];
    let winding = command.windings.get(at).copied().unwrap_or_default();
    drive_model.torque(k, (command.goals[at], command.gains[row]), [state[k], state[m + k]], winding)
}
