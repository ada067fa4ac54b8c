//! What the network of labels sees of a sample: the telemetry, and what a momentum observer on the identified drive makes of it.
//!
//! Everything is causal and comes sample by sample. It sees recorded positions: it says what acts on the arm that is there, and takes no
//! part in a simulation.

use hysteron_base::BadInput;

use super::data::Trajectory;
use super::features::Features;
use super::loss::Heads;
use crate::Model;
use crate::servo_force::{DriveObserver, ServoDrive, Telemetry};

/// Time over which the force's slow part is taken, and torques of a motor's condition [s].
const SLOW: [f64; 2] = [1.0, 0.5];
/// Speed over which friction turns its sign [rad/s].
const WIDTH: f64 = 0.05;
/// Spreads below these are not believed: 0.1 N, 0.02 N m, a twentieth.
const FLOORS: [f64; 3] = [0.1, 0.02, 0.05];

/// Numbers of a sample.
pub(super) fn channels(features: &Features) -> usize {
    features.len() + 6 + 4 * features.joints
}

/// Least spreads of all channels.
pub(super) fn floors(features: &Features) -> Vec<f64> {
    let n = features.joints;
    let parts = [(6, FLOORS[0]), (3 * n, FLOORS[1]), (n, FLOORS[2])];
    let more = parts.into_iter().flat_map(|(n, floor)| std::iter::repeat_n(floor, n));
    features.floors().into_iter().chain(more).collect()
}

/// The estimators of one arm, sample by sample.
#[derive(Debug, Clone)]
pub(super) struct Observations<'m> {
    features: Features,
    observer: DriveObserver<'m>,
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
        (features, drive, period): (&Features, &ServoDrive, f64),
    ) -> Result<Self, BadInput> {
        Ok(Self {
            features: *features,
            observer: DriveObserver::new(model, drive, period)?,
            shares: SLOW.map(|time| period / (time + period)),
            slow: vec![0.0; 3 + 3 * features.joints],
        })
    }

    /// Takes a sample's inputs, state and voltages on the motors; writes its channels and gives the observer's force [N].
    pub fn next(&mut self, [inputs, state, voltage]: [&[f64]; 3], to: &mut [f64]) -> [f64; 3] {
        let (m, n) = (self.features.motors(), self.features.joints);
        let speeds = &state[m..m + n];
        let force = self.observer.update(&state[..n], speeds, &voltage[..n]);
        let external = &self.observer.external;
        let now = force
            .into_iter()
            .chain(external.iter().copied())
            .chain(external.iter().zip(speeds).map(|(torque, dq)| -torque * (dq / WIDTH).tanh()))
            .chain(speeds.iter().map(|dq| (dq / WIDTH).tanh().abs()));
        for (k, (slow, now)) in self.slow.iter_mut().zip(now).enumerate() {
            *slow += self.shares[usize::from(k >= 3)] * (now - *slow);
        }
        let more = force.iter().chain(&self.slow[..3]).chain(external).chain(&self.slow[3..]);
        to.iter_mut().zip(inputs.iter().chain(more)).for_each(|(to, from)| *to = *from);
        force
    }
}

/// A trajectory as the network of labels sees it.
#[derive(Debug, Clone)]
pub struct Observed<'a> {
    /// Its labels.
    pub trajectory: &'a Trajectory,
    /// Channels of every row (rows × channels), SI.
    pub(super) rows: Vec<f64>,
    /// The observer's force at every row [N].
    pub force: Vec<[f64; 3]>,
    /// Which output is what.
    pub(super) heads: Heads,
}

impl<'a> Observed<'a> {
    /// # Errors
    /// `BadInput` where the recording has no PWM.
    pub fn new(
        model: &Model,
        about: (&Features, &ServoDrive, f64),
        trajectory: &'a Trajectory,
    ) -> Result<Self, BadInput> {
        let mut observations = Observations::new(model, about)?;
        let (features, width) = (about.0, channels(about.0));
        let n = features.joints;
        let voltage = trajectory.motor_voltage()?;
        let mut rows = vec![0.0; trajectory.len() * width];
        let force = rows
            .chunks_exact_mut(width)
            .enumerate()
            .map(|(row, to)| {
                let [inputs, state] = [trajectory.inputs_at(row as isize), trajectory.state_at(row)];
                observations.next([inputs, state, &voltage[row * n..][..n]], to)
            })
            .collect();
        Ok(Self { trajectory, rows, force, heads: Heads::new(features) })
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
pub fn telemetry(features: &Features, period: f64, trajectory: &Trajectory) -> Result<Telemetry, BadInput> {
    let (m, n, rows) = (features.motors(), features.joints, trajectory.len());
    let states = |first: usize| {
        trajectory.states.chunks_exact(2 * m).flat_map(move |state| &state[first..first + n]).copied()
    };
    let currents = trajectory
        .inputs
        .chunks_exact(features.len())
        .flat_map(|row| &row[features.currents()..features.currents() + n]);
    Ok(Telemetry {
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
