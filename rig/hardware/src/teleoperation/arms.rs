//! Both arms on their ports.

use super::config::{ArmsConfig, JointConfig, ServoMount};
use crate::bus::{ArmServoSample, RegisterBaseline, ServoBounds, ServoBus, ServoStatus};
use crate::{Event, EventKind, Result};
use std::time::{Duration, Instant};

/// Two arms on their ports.
#[derive(Debug)]
pub struct ArmPair {
    pub(super) config: ArmsConfig,
    leader: ServoBus,
    follower: ServoBus,
    clock: Instant,
}

impl ArmPair {
    /// Opens both ports. Nothing moves.
    ///
    /// # Errors
    /// `Bus` if one does not open.
    pub fn open(config: &ArmsConfig) -> Result<Self> {
        let clock = Instant::now();
        let ids = |follower: bool| -> Vec<u8> {
            let mounts =
                config.joints.iter().map(|joint| if follower { &joint.follower } else { &joint.leader });
            mounts.map(|mount| mount.id).collect()
        };
        let leader = ServoBus::open(&config.leader, &ids(false), clock)?;
        let follower = ServoBus::open(&config.follower, &ids(true), clock)?;
        Ok(Self { config: config.clone(), leader, follower, clock })
    }

    /// Checks every servo of both arms, their registers among it, and makes them ready, without torque.
    ///
    /// # Errors
    /// `Bus` with everything that is wrong.
    pub fn prepare(&mut self) -> Result<()> {
        for (_, baseline, bus) in self.examine()? {
            bus.accept_registers(&baseline)?;
        }
        self.leader.configure_passive()?;
        self.follower.configure()
    }

    /// Checks every servo of both arms and reads its registers: each arm's name, what these are compared with, and its
    /// bus.
    ///
    /// # Errors
    /// `Bus` with everything else that is wrong.
    pub fn examine(&mut self) -> Result<[(&'static str, RegisterBaseline, &mut ServoBus); 2]> {
        let joints = &self.config.joints;
        let led: Vec<_> =
            joints.iter().map(|joint| (joint.leader.model, ServoBounds::of(joint.leader.model))).collect();
        let following: Vec<_> =
            joints.iter().map(|joint| (joint.follower.model, self.config.limits.servos)).collect();
        let known = |mount: fn(&JointConfig) -> &ServoMount| RegisterBaseline::Known {
            of: "as the file of the arms and the factory say".into(),
            servos: joints.iter().map(|joint| mount(joint).registers.clone()).collect(),
        };
        let baselines = [known(|joint| &joint.leader), known(|joint| &joint.follower)];
        self.leader.self_check(&led)?;
        self.follower.self_check(&following)?;
        let [of_leader, of_follower] = baselines;
        Ok([("leader", of_leader, &mut self.leader), ("follower", of_follower, &mut self.follower)])
    }

    /// The buses of leader and follower.
    pub fn buses(&mut self) -> [&mut ServoBus; 2] {
        [&mut self.leader, &mut self.follower]
    }

    /// Number of joints, with the gripper.
    pub fn n_joints(&self) -> usize {
        self.config.joints.len()
    }

    /// Time since the ports were opened [s].
    pub(super) fn now(&self) -> f64 {
        self.clock.elapsed().as_secs_f64()
    }

    /// Waits until that time [s]; returns at once if it is past.
    pub(super) fn wait_until(&self, time: f64) {
        let left = time - self.now();
        if left > 0.0 {
            std::thread::sleep(Duration::from_secs_f64(left));
        }
    }

    /// Where the leader is; a joint that did not answer keeps its angle [rad]. Returns whether all answered.
    pub(super) fn read_leader(&mut self, angles: &mut [f64]) -> Result<bool> {
        let mut positions = vec![None; self.n_joints()];
        self.leader.read_positions(&mut positions)?;
        for ((angle, joint), position) in angles.iter_mut().zip(&self.config.joints).zip(&positions) {
            if let Some(position) = position {
                *angle = joint.leader.angle(*position);
            }
        }
        Ok(positions.iter().all(Option::is_some))
    }

    /// Reads the measurements of the follower's servos.
    pub(super) fn read_follower(&mut self, samples: &mut [Option<ArmServoSample>]) -> Result<()> {
        self.follower.read_measured(samples)
    }

    /// Whether the follower's servos still hold.
    pub(super) fn read_status(&mut self, status: &mut [Option<ServoStatus>]) -> Result<()> {
        self.follower.read_status(status)
    }

    /// Sends the follower to these angles [rad].
    pub(super) fn write_goals(&mut self, angles: &[f64]) -> Result<()> {
        let joints = &self.config.joints;
        let goals: Vec<i32> =
            joints.iter().zip(angles).map(|(joint, angle)| joint.follower.ticks(*angle)).collect();
        self.follower.write_goals(&goals)
    }

    /// Switches the follower's torque on.
    pub(super) fn enable_torque(&mut self) -> Result<()> {
        self.follower.enable_torque()
    }

    /// Switches the follower's torque off, of all servos at once, and makes sure that it is.
    ///
    /// # Errors
    /// `Bus` naming the servos that did not confirm.
    pub fn disable_torque(&mut self) -> Result<()> {
        self.follower.disable_torque()
    }

    /// Appends what went wrong on either bus since the last call.
    pub(super) fn take_events(&mut self, events: &mut Vec<Event>) {
        for (arm, bus) in [("leader", &mut self.leader), ("follower", &mut self.follower)] {
            let first = events.len();
            bus.take_events(events);
            for event in &mut events[first..] {
                event.message = format!("{arm}: {}", event.message);
            }
        }
    }

    /// An event of now.
    pub(super) fn event(&self, kind: EventKind, servo: Option<u8>, message: impl Into<String>) -> Event {
        Event { time_s: self.now(), kind, servo, message: message.into() }
    }
}
