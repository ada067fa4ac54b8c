//! Series of an arm's recording, joint by joint: the one reading for everything that fits, tests or draws.

use hysteron_base::{BadInput, Recording};

use crate::recorded::JointQuantityKind;
use hysteron_arm_dynamics::{JointKind, MAX_JOINTS};

/// Kind and series of one joint in a recording; every series has one value per row (n_samples).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RecordedJoint<'a> {
    /// About or along its axis: from the unit of its coordinate.
    pub kind: JointKind,
    /// Coordinate q [rad or m].
    pub position: Option<&'a [f64]>,
    /// Its rate [rad/s or m/s].
    pub velocity: Option<&'a [f64]>,
    /// The rate of that [rad/s² or m/s²].
    pub acceleration: Option<&'a [f64]>,
    /// Torque or force of the drive on the joint [N m or N].
    pub torque: Option<&'a [f64]>,
    /// Coordinate that the drive was asked for [rad or m].
    pub goal: Option<&'a [f64]>,
    /// Motor current [A].
    pub current: Option<&'a [f64]>,
    /// Supply voltage at the motor's drive [V].
    pub voltage: Option<&'a [f64]>,
    /// Temperature of the motor [deg C].
    pub temperature: Option<&'a [f64]>,
    /// Duty cycle with sign, 1 at full voltage [-].
    pub pwm: Option<&'a [f64]>,
}

impl<'a> RecordedJoint<'a> {
    /// The series of a quantity.
    pub fn of(&self, quantity: JointQuantityKind) -> Option<&'a [f64]> {
        match quantity {
            JointQuantityKind::Position => self.position,
            JointQuantityKind::Velocity => self.velocity,
            JointQuantityKind::Acceleration => self.acceleration,
            JointQuantityKind::Torque => self.torque,
            JointQuantityKind::Goal => self.goal,
            JointQuantityKind::Current => self.current,
            JointQuantityKind::Voltage => self.voltage,
            JointQuantityKind::Temperature => self.temperature,
            JointQuantityKind::Pwm => self.pwm,
        }
    }

    /// Name of the channel of a quantity, of joint number `joint` (from 0).
    pub fn name_of(&self, quantity: JointQuantityKind, joint: usize) -> String {
        quantity.channel(self.kind, joint)
    }
}

/// A component of a force from outside, of which not every row has a label.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ForceSeries<'a> {
    /// Force (n_samples) [N]; zero where there is no label.
    pub values: &'a [f64],
    /// 1 where there is a label, else 0 (n_samples); `None` where every row has one.
    pub labelled: Option<&'a [f64]>,
}

/// A recording of an arm.
#[derive(Debug, Clone, PartialEq)]
pub struct ArmRecording<'a> {
    /// Times (n_samples) [s].
    pub time: &'a [f64],
    /// True where a sample was missing and has been filled in (n_samples).
    pub gap: &'a [bool],
    /// One for each joint, in the order of their numbers.
    pub joints: Vec<RecordedJoint<'a>>,
    /// Names of the joints from the metadata; empty if these have none.
    pub joint_names: Vec<String>,
    /// Force on the tip along x, y and z.
    pub force: [Option<ForceSeries<'a>>; 3],
}

impl<'a> ArmRecording<'a> {
    /// Reads the channels `q_k_rad` (or `q_k_m`), `dq_k_rad_s`, `ddq_k_rad_s2`, `tau_k_n_m`, `goal_k_rad`, `current_k_a`, `voltage_k_v`,
    /// `temperature_k_degc`, `pwm_k_ratio` of the joints k = 1, 2, … and `force_x_n`, ….
    ///
    /// # Errors
    /// `BadInput` where there is no joint, where a quantity is there for some joints only, or where the names of joints are not
    /// as many.
    pub fn of(recording: &'a Recording) -> Result<Self, BadInput> {
        let series = |quantity: JointQuantityKind, joint: usize| {
            let kinds = [JointKind::Revolute, JointKind::Prismatic];
            kinds.into_iter().find_map(|kind| recording.channel(&quantity.channel(kind, joint)))
        };
        let has_any =
            |joint: &usize| JointQuantityKind::ALL.iter().any(|quantity| series(*quantity, *joint).is_some());
        let Some(n) = (0..MAX_JOINTS).rev().find(has_any).map(|last| last + 1) else {
            let names: Vec<&str> = recording.channels().iter().map(|channel| channel.name.as_str()).collect();
            return Err(BadInput::new("recording", "channels of joints, as q_1_rad", names.join(", ")));
        };
        for quantity in JointQuantityKind::ALL {
            let of_quantity: Vec<bool> = (0..n).map(|joint| series(quantity, joint).is_some()).collect();
            if let (true, Some(lacking)) =
                (of_quantity.contains(&true), of_quantity.iter().position(|has| !has))
            {
                let name = quantity.channel(JointKind::Revolute, lacking);
                let has = of_quantity.iter().filter(|has| **has).count();
                return Err(BadInput::new(
                    name,
                    format!("this channel of all {n} joints"),
                    format!("of {has}"),
                )
                .hint("every quantity is there for all joints or for none"));
            }
        }
        let joint = |joint: usize| {
            let is_prismatic = recording
                .channel(&JointQuantityKind::Position.channel(JointKind::Prismatic, joint))
                .is_some();
            RecordedJoint {
                kind: if is_prismatic { JointKind::Prismatic } else { JointKind::Revolute },
                position: series(JointQuantityKind::Position, joint),
                velocity: series(JointQuantityKind::Velocity, joint),
                acceleration: series(JointQuantityKind::Acceleration, joint),
                torque: series(JointQuantityKind::Torque, joint),
                goal: series(JointQuantityKind::Goal, joint),
                current: series(JointQuantityKind::Current, joint),
                voltage: series(JointQuantityKind::Voltage, joint),
                temperature: series(JointQuantityKind::Temperature, joint),
                pwm: series(JointQuantityKind::Pwm, joint),
            }
        };
        let names = recording.meta().extra.get("joint_names").map_or("", String::as_str);
        let joint_names: Vec<String> =
            names.split(',').map(|name| name.trim().to_owned()).filter(|name| !name.is_empty()).collect();
        let force = ["x", "y", "z"].map(|axis| {
            let values = recording.channel(&format!("force_{axis}_n"))?;
            Some(ForceSeries { values, labelled: recording.channel(&format!("force_{axis}_labelled_ratio")) })
        });
        let joints = (0..n).map(joint).collect();
        Ok(Self { time: recording.time(), gap: recording.gap(), joints, joint_names, force })
    }

    /// The series of a quantity of all joints, in order.
    ///
    /// # Errors
    /// `BadInput` naming the channel that is missing.
    pub fn require(&self, quantity: JointQuantityKind) -> Result<Vec<&'a [f64]>, BadInput> {
        let of = |(k, joint): (usize, &RecordedJoint<'a>)| {
            joint
                .of(quantity)
                .ok_or_else(|| BadInput::new(joint.name_of(quantity, k), "this channel", "none"))
        };
        self.joints.iter().enumerate().map(of).collect()
    }
}
