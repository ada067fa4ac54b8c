//! A session: the follower under torque, from its first goal to torque off, which always follows.

use super::arms::ArmPair;
use crate::bus::{ArmServoSample, ServoStatus, xl430};
use crate::{Error, Event, EventKind, Result};

/// Cycles without an answer after which a servo, or the leader, counts as lost.
const LOST_AFTER: u32 = 5;
/// How long to retry torque off for servos that do not answer [s].
const RELEASE_PATIENCE: f64 = 3.0;
/// Pause between these tries [s].
const RELEASE_PAUSE: f64 = 0.05;

/// Why a motion did not come to its end.
#[derive(Debug)]
pub(super) enum StopReason {
    /// The follower must not be driven any more; its torque is off.
    Unsafe(Error),
    /// The leader is lost, or the disk; the follower is sound.
    Failed(Error),
    /// Somebody asked to stop.
    Asked,
}

impl From<StopReason> for Option<Error> {
    fn from(reason: StopReason) -> Self {
        match reason {
            StopReason::Unsafe(error) | StopReason::Failed(error) => Some(error),
            StopReason::Asked => None,
        }
    }
}

/// The follower under torque. Dropped, its torque is off.
pub(super) struct TeleoperationSession<'a> {
    pub arms: &'a mut ArmPair,
    /// When the next cycle begins [s].
    next: f64,
    /// Where the leader is (n) [rad].
    pub leader: Vec<f64>,
    /// Where the follower was sent last (n) [rad].
    pub goals: Vec<f64>,
    /// Measurements of its servos in the last cycle (n).
    pub samples: Vec<Option<ArmServoSample>>,
    /// When that was read [s].
    pub read_at: f64,
    status: Vec<Option<ServoStatus>>,
    /// Cycles since each servo answered, and the leader last (n + 1).
    silent: Vec<u32>,
    torque_on: bool,
    /// Why the torque is not known to be off, servo by servo.
    pub torque_trouble: Option<String>,
    /// Events since they were last taken.
    pub events: Vec<Event>,
}

impl<'a> TeleoperationSession<'a> {
    /// Switches the torque of the follower on at its present position.
    pub fn start(arms: &'a mut ArmPair) -> Result<Self> {
        let n = arms.n_joints();
        let mut samples = vec![None; n];
        arms.read_follower(&mut samples)?;
        let mut goals = Vec::with_capacity(n);
        for (joint, sample) in arms.config.joints.iter().zip(&samples) {
            let id = joint.follower.id;
            let sample: &ArmServoSample =
                sample.as_ref().ok_or_else(|| Error::Bus(format!("follower: servo {id} does not answer")))?;
            goals.push(joint.follower.angle(sample.position));
        }
        let mut leader = vec![f64::NAN; n];
        if !arms.read_leader(&mut leader)? || leader.iter().any(|angle| angle.is_nan()) {
            return Err(Error::Bus("leader: not all servos answer".into()));
        }
        // A goal from an earlier session must not make a servo jump.
        arms.write_goals(&goals)?;
        let next = arms.now();
        let mut session = Self {
            arms,
            next,
            leader,
            goals,
            samples,
            read_at: next,
            status: vec![None; n],
            silent: vec![0; n + 1],
            torque_on: true,
            torque_trouble: None,
            events: Vec::new(),
        };
        // If only some confirm, dropping the session switches all torques off.
        session.arms.enable_torque()?;
        session.say("torque on");
        session.next = session.arms.now();
        Ok(session)
    }

    /// Goes to where the leader is, which may move meanwhile.
    pub fn approach(&mut self, stop_requested: &dyn Fn() -> bool) -> std::result::Result<(), StopReason> {
        self.say("going to the leader");
        let near = self.arms.config.limits.speed_max * self.arms.config.period;
        loop {
            self.follow(self.arms.config.approach)?;
            let limited = self.limited();
            if self.goals.iter().zip(&limited).all(|(goal, target)| (goal - target).abs() < near) {
                return Ok(());
            }
            if stop_requested() {
                return Err(StopReason::Asked);
            }
        }
    }

    /// One cycle that sends the follower towards the leader, no faster than `speed` [rad/s].
    pub fn follow(&mut self, speed: f64) -> std::result::Result<(), StopReason> {
        self.wait();
        let answered = self.arms.read_leader(&mut self.leader);
        let n = self.goals.len();
        self.silent[n] = if matches!(answered, Ok(true)) { 0 } else { self.silent[n] + 1 };
        if self.silent[n] == LOST_AFTER {
            let why = answered.err().map_or_else(|| "not all of its servos answer".into(), Error::reason);
            let message = format!("the leader is lost: {why}");
            self.note(EventKind::ServoLost, message.clone());
            return Err(StopReason::Failed(Error::Bus(message)));
        }
        let targets = self.limited();
        self.command(&targets, speed)
    }

    /// Goes to rest, if nothing forbids that.
    pub fn go_to_rest(&mut self) -> std::result::Result<(), StopReason> {
        self.say("going to rest");
        let rest: Vec<f64> = self.arms.config.joints.iter().map(|joint| joint.rest).collect();
        while self.goals != rest {
            self.wait();
            self.command(&rest, self.arms.config.approach)?;
        }
        Ok(())
    }

    /// Where the leader is, within the follower's range (n) [rad].
    fn limited(&self) -> Vec<f64> {
        let joints = &self.arms.config.joints;
        let angles = self.leader.iter().zip(joints);
        angles.map(|(angle, joint)| angle.clamp(joint.range[0], joint.range[1])).collect()
    }

    /// Waits for the next cycle; what was missed is not made up for in a rush.
    fn wait(&mut self) {
        self.arms.wait_until(self.next);
        let (period, late) = (self.arms.config.period, self.arms.now() - self.next);
        if late > period {
            self.note(EventKind::Late, format!("a cycle began {:.1} ms late", 1e3 * late));
            self.next += (late / period).floor() * period;
        }
        self.next += period;
    }

    /// Moves the goals towards `targets` (n) [rad] by one period, sends them, reads and checks.
    fn command(&mut self, targets: &[f64], speed: f64) -> std::result::Result<(), StopReason> {
        let most = speed * self.arms.config.period;
        for (goal, target) in self.goals.iter_mut().zip(targets) {
            let step = target - *goal;
            *goal = if step.abs() <= most { *target } else { *goal + most.copysign(step) };
        }
        let done = self.exchange();
        self.arms.take_events(&mut self.events);
        done.and_then(|()| self.check()).map_err(|error| {
            self.note(EventKind::Limit, error.to_string());
            self.release();
            StopReason::Unsafe(error)
        })
    }

    fn exchange(&mut self) -> Result<()> {
        self.arms.write_goals(&self.goals)?;
        self.read_at = self.arms.now();
        self.arms.read_follower(&mut self.samples)?;
        self.arms.read_status(&mut self.status)
    }

    /// All conditions that end the session.
    fn check(&mut self) -> Result<()> {
        let (joints, limits) = (&self.arms.config.joints, &self.arms.config.limits);
        for (k, joint) in joints.iter().enumerate() {
            let violated = |what: String| Err(Error::Limit(format!("{}: {what}", joint.name)));
            let (Some(sample), Some(status)) = (self.samples[k], self.status[k]) else {
                self.silent[k] += 1;
                if self.silent[k] == LOST_AFTER {
                    let id = joint.follower.id;
                    return Err(Error::Bus(format!(
                        "follower: servo {id} has not answered for {LOST_AFTER} cycles"
                    )));
                }
                continue;
            };
            self.silent[k] = 0;
            if status.hardware_error != 0 {
                let errors = xl430::describe_errors(status.hardware_error);
                return violated(format!("the servo reports {errors}"));
            }
            if !status.torque_on {
                return violated("the servo's torque is off; it lost its supply or tripped".into());
            }
            let lag = (self.goals[k] - joint.follower.angle(sample.position)).abs();
            if lag > limits.lag_max {
                let (most, found) = (limits.lag_max.to_degrees(), lag.to_degrees());
                return violated(format!("lag: expected at most {most:.1} degrees, got {found:.1}"));
            }
            let current = sample.current(joint.follower.model).unwrap_or(0.0).abs();
            if current > limits.current_max {
                let most = limits.current_max;
                return violated(format!("current: expected at most {most:.2} A, got {current:.2} A"));
            }
            if let Some(found) = limits.servos.violation(sample.voltage, sample.temperature) {
                return violated(found);
            }
        }
        Ok(())
    }

    /// Switches the torque off, with patience; returns whether it is known to be off.
    pub fn release(&mut self) -> bool {
        if !self.torque_on {
            return true;
        }
        let end = self.arms.now() + RELEASE_PATIENCE;
        loop {
            let done = self.arms.disable_torque();
            self.arms.take_events(&mut self.events);
            match done {
                Ok(()) => {
                    self.torque_on = false;
                    self.say("torque off");
                    return true;
                }
                Err(error) if self.arms.now() > end => {
                    let message = format!("torque could not be switched off: {}", error.reason());
                    self.note(EventKind::Run, message.clone());
                    self.torque_trouble = Some(message);
                    return false;
                }
                Err(_) => self.arms.wait_until(self.arms.now() + RELEASE_PAUSE),
            }
        }
    }

    /// Time since the ports were opened [s].
    pub fn now(&self) -> f64 {
        self.arms.now()
    }

    /// Notes what the run does.
    pub fn say(&mut self, message: impl Into<String>) {
        self.note(EventKind::Run, message);
    }

    fn note(&mut self, kind: EventKind, message: impl Into<String>) {
        self.events.push(self.arms.event(kind, None, message));
    }
}

impl Drop for TeleoperationSession<'_> {
    fn drop(&mut self) {
        self.release();
    }
}
