//! The tracker: poses of the tip in a frame of its own, late, noisy, drifting, and sometimes missing.

use super::draw::gaussian;
use super::linear::{V3, add, quaternion_of, quaternion_product, turn};
use super::robot::TrackerParameters;
use hysteron_base::rng;
use hysteron_rig::{Pose, Quality};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use std::collections::VecDeque;

/// Poses kept for someone who does not take them; older ones are lost.
const MAX_WAITING: usize = 4096;

/// A pose on its way from the tracker to the client.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrackedPose {
    /// Measured pose, with the time of the measurement on the world's clock [s].
    pub pose: Pose,
    /// When it leaves the tracker, on the world's clock [s].
    pub sent_at: f64,
}

/// The tracker and what it has not sent yet.
#[derive(Debug, Clone)]
pub(super) struct VirtualTracker {
    parameters: TrackerParameters,
    /// Rotation from the robot's axes to the tracker's.
    rotation: [f64; 4],
    /// When it measures next [s].
    next: f64,
    /// Slowly changing error [m].
    bias: V3,
    pub(super) is_connected: bool,
    /// In the order in which they are sent.
    queue: VecDeque<TrackedPose>,
    noise: ChaCha8Rng,
    drift: ChaCha8Rng,
    timing: ChaCha8Rng,
}

impl VirtualTracker {
    pub(super) fn new(parameters: TrackerParameters, seed: u64) -> Self {
        let mut timing = rng(seed, "virtual-rig/tracker/timing");
        let mut drift = rng(seed, "virtual-rig/tracker/drift");
        let bias = std::array::from_fn(|_| parameters.bias * gaussian(&mut drift));
        Self {
            rotation: quaternion_of(parameters.robot_rotation),
            next: timing.random_range(0.0..1.0) / parameters.rate,
            bias,
            is_connected: true,
            queue: VecDeque::with_capacity(64),
            noise: rng(seed, "virtual-rig/tracker/noise"),
            drift,
            timing,
            parameters,
        }
    }

    /// Takes other noise from now on: that of another day.
    pub(super) fn reseed(&mut self, seed: u64, day: &str) {
        let stream = |what: &str| rng(seed, &format!("virtual-rig/tracker/{what}/{day}"));
        (self.noise, self.drift, self.timing) = (stream("noise"), stream("drift"), stream("timing"));
    }

    /// Measures all samples due between two true poses in the robot's frame, the second one `step` [s] after the first.
    pub(super) fn measure(&mut self, from: &Pose, to: &Pose) {
        let step = to.time - from.time;
        while self.next <= to.time {
            let share = if step > 0.0 { ((self.next - from.time) / step).clamp(0.0, 1.0) } else { 1.0 };
            let between = |a: f64, b: f64| a + share * (b - a);
            let position = std::array::from_fn(|i| between(from.position[i], to.position[i]));
            // The step's rotation is small: the chord will do, made a unit again.
            let mut q = std::array::from_fn(|i| between(from.orientation[i], to.orientation[i]));
            let norm = q.iter().map(|x| x * x).sum::<f64>().sqrt();
            q.iter_mut().for_each(|x| *x /= norm);
            self.sample(position, q);
            self.next += 1.0 / self.parameters.rate;
        }
    }

    fn sample(&mut self, position: V3, orientation: [f64; 4]) {
        let p = self.parameters;
        // Ornstein and Uhlenbeck, exactly over one period.
        let keep = (-1.0 / (p.rate * p.bias_time)).exp();
        let fresh = p.bias * (1.0 - keep * keep).sqrt();
        self.bias = self.bias.map(|b| keep * b + fresh * gaussian(&mut self.drift));
        let noise: V3 = std::array::from_fn(|_| p.position_noise * gaussian(&mut self.noise));
        let turned: V3 = std::array::from_fn(|_| p.orientation_noise * gaussian(&mut self.noise));
        let jitter = (p.latency_jitter * gaussian(&mut self.timing)).abs();
        let is_lost = self.timing.random_range(0.0..1.0) < p.dropout;
        if is_lost || !self.is_connected {
            return;
        }
        let in_tracker = add(p.robot_position, turn(self.rotation, position));
        let measured =
            quaternion_product(quaternion_of(turned), quaternion_product(self.rotation, orientation));
        let sent_at =
            (self.next + p.latency + jitter).max(self.queue.back().map_or(0.0, |last| last.sent_at));
        if self.queue.len() == MAX_WAITING {
            self.queue.pop_front();
        }
        self.queue.push_back(TrackedPose {
            pose: Pose {
                time: self.next,
                position: add(in_tracker, add(self.bias, noise)),
                orientation: measured,
                quality: Quality::Good,
            },
            sent_at,
        });
    }

    /// Appends what has been sent by `time` [s].
    pub(super) fn take(&mut self, time: f64, poses: &mut Vec<TrackedPose>) {
        while self.queue.front().is_some_and(|pose| pose.sent_at <= time) {
            poses.extend(self.queue.pop_front());
        }
    }

    /// Forgets what has not been sent: the connection is gone.
    pub(super) fn disconnect(&mut self) {
        self.is_connected = false;
        self.queue.clear();
    }
}
