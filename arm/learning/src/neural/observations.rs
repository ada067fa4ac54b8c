//! Inputs of the network of labels from a sample: the telemetry, and results of momentum observers on the
//! identified drive.
//!
//! Everything is causal and comes sample by sample. Its inputs are recorded positions: it estimates what acts on the real arm, and has no
//! part in a simulation.

use hysteron_base::BadInput;
use serde::{Deserialize, Serialize};

use super::base_frame::BaseFrame;
use super::data::Trajectory;
use super::features::FeatureLayout;
use super::health::{ALIKE, HealthModel, HealthSample, JointHealth};
use super::loss::{Heads, watched_motor};
use hysteron_arm_dynamics::Model;
use hysteron_arm_estimation::observer::{ForceFilter, TipForceEstimator};
use hysteron_arm_estimation::servo_force::{
    DriveObserver, GAIN, STANDSTILL_SPEED, ServoDrive, ServoForceTelemetry, tip_force,
};

/// Gains of observers in addition to that whose force is added to [1/s]: what comes and goes within a second
/// is seen sooner, with more noise.
const FASTER: [f64; 2] = [30.0, 60.0];
/// Time constants of forces while joints are at rest [s], and their deviation [N].
const MEMORY: [f64; 2] = [0.3, 2.0];
const DEVIATION: f64 = 5.0;
/// As [`ALIKE`] of a joint at rest, whose friction may stay for a second.
const ALIKE_AT_REST: f64 = 60.0;
/// Time over which the force's slow part is taken, and torques of a motor's condition [s].
const SLOW: [f64; 2] = [1.0, 0.5];
/// Speed over which friction turns its sign [rad/s].
const WIDTH: f64 = 0.05;
/// Spreads below these are not plausible: 0.1 N, 0.02 N m, a twentieth, one.
const FLOORS: [f64; 4] = [0.1, 0.02, 0.05, 1.0];
/// A standard deviation that leaves a joint out [N m].
const UNKNOWN: f64 = 1e3;

/// Identified drives and healthy scatter of an arm for the network of labels.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct IdentifiedArm {
    /// The drives, for the observers.
    pub drive: ServoDrive,
    /// How the watched joint scatters while it is healthy.
    pub health: HealthModel,
}

/// Numbers of a sample.
pub(super) fn channels(features: &FeatureLayout) -> usize {
    parts(features).into_iter().map(|(n, _)| n).sum::<usize>() + features.len()
}

/// Channels in addition to the telemetry, and their least spreads.
fn parts(features: &FeatureLayout) -> [(usize, f64); 4] {
    let n = features.joints;
    let forces = 3 * (2 + FASTER.len() + MEMORY.len());
    [(forces, FLOORS[0]), (4 * n, FLOORS[1]), (n, FLOORS[2]), (JointHealth::CHANNELS, FLOORS[3])]
}

/// Least spreads of all channels.
pub(super) fn floors(features: &FeatureLayout) -> Vec<f64> {
    let more = parts(features).into_iter().flat_map(|(n, floor)| std::iter::repeat_n(floor, n));
    features.floors().into_iter().chain(more).collect()
}

/// The estimators of one arm that need nothing but its drives, sample by sample.
#[derive(Debug, Clone)]
struct ArmObservers<'m> {
    joints: usize,
    motors: usize,
    watched: usize,
    observer: DriveObserver<'m>,
    faster: [DriveObserver<'m>; FASTER.len()],
    /// Force by all joints but the watched one.
    others: TipForceEstimator<'m>,
    /// Forces that are remembered.
    filters: [ForceFilter; MEMORY.len()],
    period: f64,
    drive: ServoDrive,
    /// Forces of the faster observers.
    forces: [[f64; 3]; FASTER.len()],
}

impl<'m> ArmObservers<'m> {
    fn new(
        model: &'m Model,
        (features, drive, period): (&FeatureLayout, &ServoDrive, f64),
    ) -> Result<Self, BadInput> {
        // The gripper's motor has no torque on the arm.
        let watched = watched_motor(features).min(features.joints - 1);
        let mut noise = drive.noise.clone();
        noise[watched] = UNKNOWN;
        let of = |gain: f64| DriveObserver::new(model, drive, (period, gain));
        Ok(Self {
            joints: features.joints,
            motors: features.motors(),
            watched,
            observer: of(GAIN)?,
            faster: [of(FASTER[0])?, of(FASTER[1])?],
            others: tip_force(model, &noise)?,
            filters: MEMORY.map(|time| ForceFilter::new(time, DEVIATION)),
            period,
            drive: drive.clone(),
            forces: [[0.0; 3]; FASTER.len()],
        })
    }

    /// Takes a sample's state and voltages; gives the force [N], and what the watched joint shows.
    fn next(&mut self, state: &[f64], voltage: &[f64]) -> ([f64; 3], HealthSample) {
        let (n, m) = (self.joints, self.motors);
        let [position, velocity, voltage] = [&state[..n], &state[m..m + n], &voltage[..n]];
        let force = self.observer.update(position, velocity, voltage);
        for (force, observer) in self.forces.iter_mut().zip(&mut self.faster) {
            *force = observer.update(position, velocity, voltage);
        }
        self.update_filters(velocity);
        self.others.update(position, &self.observer.external);
        let [of_force, variance] = self.others.torque(self.watched);
        let k = self.watched;
        let torque = self.observer.external[k] - of_force;
        let motor = self.observer.motor(k);
        (force, HealthSample { position: position[k], velocity: velocity[k], motor, torque, variance })
    }

    /// Updates the force filters with the joints' external torques: at rest friction may be anything up to what breaks it loose.
    fn update_filters(&mut self, velocity: &[f64]) {
        let observer = &self.faster[0];
        self.filters.iter_mut().for_each(|filter| filter.advance(self.period));
        for (k, velocity) in velocity.iter().enumerate() {
            let noise = self.drive.noise[k] * self.drive.noise[k];
            let variance = if velocity.abs() > STANDSTILL_SPEED {
                noise * ALIKE
            } else {
                let dry = self.drive.dry_friction(k, observer.motor(k));
                (noise + dry * dry / 3.0) * ALIKE_AT_REST
            };
            let lever = observer.lever(k);
            self.filters.iter_mut().for_each(|one| one.update(lever, observer.external[k], variance));
        }
    }
}

/// The estimators of one arm, sample by sample.
#[derive(Debug, Clone)]
pub(super) struct Observations<'m> {
    features: FeatureLayout,
    base_frame: BaseFrame,
    observers: ArmObservers<'m>,
    health: JointHealth,
    /// Part of the way to a new value in a sample, for force and torques.
    shares: [f64; 2],
    /// Force; external torque, torque against the motion, and motion of every joint: their slow parts.
    slow: Vec<f64>,
}

impl<'m> Observations<'m> {
    /// For samples every `period` [s] of `model`, an arm as `observed_arm` gives it.
    ///
    /// # Errors
    /// `BadInput` where the model has no tip.
    pub fn new(
        model: &'m Model,
        (features, known, period): (&FeatureLayout, &IdentifiedArm, f64),
    ) -> Result<Self, BadInput> {
        Ok(Self {
            features: *features,
            base_frame: BaseFrame::of(model),
            observers: ArmObservers::new(model, (features, &known.drive, period))?,
            health: JointHealth::new(&known.health, (period, GAIN)),
            shares: SLOW.map(|time| period / (time + period)),
            slow: vec![0.0; 3 + 3 * features.joints],
        })
    }

    /// Evidence for a healthy watched joint, up to the last sample.
    pub fn evidence(&self) -> f64 {
        self.health.evidence()
    }

    /// Axes that turn with the arm.
    pub fn base_frame(&self) -> BaseFrame {
        self.base_frame
    }

    /// Takes a sample's inputs, state and voltages on the motors; writes its channels and gives the observer's force [N].
    pub fn next(&mut self, [inputs, state, voltage]: [&[f64]; 3], to: &mut [f64]) -> [f64; 3] {
        let (m, n) = (self.features.motors(), self.features.joints);
        let speeds = &state[m..m + n];
        let (force, sample) = self.observers.next(state, voltage);
        self.health.update(&sample);
        let external = &self.observers.observer.external;
        let now = force
            .into_iter()
            .chain(external.iter().copied())
            .chain(external.iter().zip(speeds).map(|(torque, dq)| -torque * (dq / WIDTH).tanh()))
            .chain(speeds.iter().map(|dq| (dq / WIDTH).tanh().abs()));
        for (k, (slow, now)) in self.slow.iter_mut().zip(now).enumerate() {
            *slow += self.shares[usize::from(k >= 3)] * (now - *slow);
        }
        let slow = [self.slow[0], self.slow[1], self.slow[2]];
        let all = [force, slow]
            .into_iter()
            .chain(self.observers.forces)
            .chain(self.observers.filters.iter().map(|one| one.force));
        let forces = all.flat_map(|f| self.base_frame.to_arm(state[0], f));
        let (slow_torque, slow_friction) = self.slow[3..].split_at(n);
        let friction = (0..n).map(|k| self.observers.observer.friction(k));
        let torques = external.iter().chain(slow_torque).copied().chain(friction);
        let more = forces.chain(torques).chain(slow_friction.iter().copied()).chain(self.health.channels());
        to.iter_mut().zip(inputs.iter().copied().chain(more)).for_each(|(to, from)| *to = from);
        self.base_frame.remove_azimuth(&self.features, to);
        force
    }
}

impl IdentifiedArm {
    /// With these drives, and the scatter of all trajectories that are not known to have a fault; `model` is an arm as `observed_arm` gives it.
    ///
    /// # Errors
    /// `BadInput` where a recording has no PWM, or the watched joint never moves.
    pub fn identify(
        model: &Model,
        (features, drive, period): (&FeatureLayout, &ServoDrive, f64),
        training: &[Trajectory],
    ) -> Result<Self, BadInput> {
        let samples = |one: &Trajectory| -> Result<Vec<HealthSample>, BadInput> {
            let mut observers = ArmObservers::new(model, (features, drive, period))?;
            let rows = one.motor_voltage()?.chunks_exact(features.joints).enumerate();
            Ok(rows.map(|(row, voltage)| observers.next(one.state_at(row), voltage).1).collect())
        };
        let healthy = training.iter().filter(|one| one.is_healthy != Some(false));
        let all = healthy.map(samples).collect::<Result<Vec<_>, _>>()?;
        Ok(Self { drive: drive.clone(), health: HealthModel::fit(&all, (period, GAIN))? })
    }

    /// # Errors
    /// `BadInput` naming what is not for `n` joints or out of range.
    pub(super) fn check(&self, n: usize) -> Result<(), BadInput> {
        self.drive.check(n).map_err(|bad| bad.within("drive"))?;
        self.health.check().map_err(|bad| bad.within("health"))
    }
}

/// A trajectory as the network of labels sees it.
#[derive(Debug, Clone)]
pub struct ObservedTrajectory<'a> {
    /// Its labels.
    pub trajectory: &'a Trajectory,
    /// Channels of every row (rows × channels), SI.
    pub(super) rows: Vec<f64>,
    /// The observer's force at every row [N].
    pub force: Vec<[f64; 3]>,
    /// Logarithm of the likelihood of all rows so far if the watched joint is healthy, over that if it is not.
    pub evidence: Vec<f64>,
    /// Which output is what.
    pub(super) heads: Heads,
    /// Axes that turn with the arm: those of the network's forces.
    base_frame: BaseFrame,
}

impl<'a> ObservedTrajectory<'a> {
    /// # Errors
    /// `BadInput` where the recording has no PWM.
    pub fn new(
        model: &Model,
        about: (&FeatureLayout, &IdentifiedArm, f64),
        trajectory: &'a Trajectory,
    ) -> Result<Self, BadInput> {
        let mut observations = Observations::new(model, about)?;
        let (features, width) = (about.0, channels(about.0));
        let n = features.joints;
        let voltage = trajectory.motor_voltage()?;
        let mut rows = vec![0.0; trajectory.len() * width];
        let (mut force, mut evidence) = (Vec::new(), Vec::new());
        for (row, to) in rows.chunks_exact_mut(width).enumerate() {
            let [inputs, state] = [trajectory.inputs_at(row as isize), trajectory.state_at(row)];
            force.push(observations.next([inputs, state, &voltage[row * n..][..n]], to));
            evidence.push(observations.evidence());
        }
        let base_frame = observations.base_frame();
        Ok(Self { trajectory, rows, force, evidence, heads: Heads::new(features), base_frame })
    }

    /// Makes of the network's raw force at a row that of base's axes, the observer's added.
    pub(super) fn complete(&self, row: usize, outputs: &mut [f64]) {
        let angle = self.trajectory.state_at(row)[0];
        self.base_frame.add_force(&self.heads, (angle, &self.force[row]), outputs);
    }

    /// Makes of the gradient by that force the one by the network's.
    pub(super) fn turn_gradient(&self, row: usize, by_outputs: &mut [f64]) {
        let angle = self.trajectory.state_at(row)[0];
        self.heads.map_force(by_outputs, |g| self.base_frame.to_arm(angle, g));
    }

    /// Channels of a row; before the first, those of the first.
    pub(super) fn row(&self, row: isize) -> &[f64] {
        let width = self.rows.len() / self.trajectory.len();
        &self.rows[row.max(0) as usize * width..][..width]
    }
}

/// A trajectory as identification takes it.
///
/// # Errors
/// `BadInput` where the recording has no PWM.
pub fn telemetry(
    features: &FeatureLayout,
    period: f64,
    trajectory: &Trajectory,
) -> Result<ServoForceTelemetry, BadInput> {
    let (m, n, rows) = (features.motors(), features.joints, trajectory.len());
    let states = |first: usize| {
        trajectory.states.chunks_exact(2 * m).flat_map(move |state| &state[first..first + n]).copied()
    };
    let currents = trajectory
        .inputs
        .chunks_exact(features.len())
        .flat_map(|row| &row[features.currents()..features.currents() + n]);
    Ok(ServoForceTelemetry {
        n_joints: n,
        time: (0..rows).map(|row| period * row as f64).collect(),
        periods: vec![period; rows],
        position: states(0).collect(),
        velocity: states(m).collect(),
        current: currents.copied().collect(),
        voltage: trajectory.motor_voltage()?.to_vec(),
        force: trajectory.force.iter().map(|force| force.unwrap_or_default()).collect(),
        is_labelled: trajectory.force.iter().map(Option::is_some).collect(),
    })
}
