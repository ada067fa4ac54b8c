//! Torques, force, contact and condition of a motor along a recording.

use std::path::Path;

use hysteron_arm_learning::neural::{LiveEstimator, NeuralActuator, Unlabelled, trajectory_of};
use hysteron_base::{BadInput, Channel, Recording};

use super::Options;
use super::channels::{names, values};
use super::outcome::RecordingEstimates;
use crate::{Context, arm};

/// Estimates along a recording.
///
/// # Errors
/// Bad input; files that cannot be written.
pub(super) fn run(
    (options, path): (&Options, &Path),
    actuator: &NeuralActuator,
    estimator: LiveEstimator<'_>,
    context: &Context,
) -> anyhow::Result<RecordingEstimates> {
    let (features, period) = (&actuator.features, actuator.simulation.period);
    let within = |bad: BadInput| bad.within(path.display());
    let recording = crate::shared::memory::recording(path)?;
    let trajectory = trajectory_of(&recording, features, period, Unlabelled::Unknown).map_err(within)?;
    let voltage = trajectory.motor_voltage().map_err(within)?;
    let mut estimator = estimator.with_position_gain(trajectory.position_gain).map_err(within)?;
    let (n, names) = (features.joints, names(features.motors()));
    let mut columns = vec![Vec::with_capacity(trajectory.len()); names.len()];
    let (mut contacts, mut healthy) = (0, f64::NAN);
    for row in 0..trajectory.len() {
        let [inputs, state] = [trajectory.inputs_at(row as isize), trajectory.state_at(row)];
        let now = estimator.update_inputs([inputs, state, &voltage[row * n..][..n]]);
        let all = values(estimator.torque(), &now);
        columns.iter_mut().zip(all).for_each(|(column, value)| column.push(value));
        contacts += usize::from(now.gate >= 0.5);
        healthy = now.condition;
    }
    let channels = names.into_iter().zip(columns).map(|(name, column)| Channel::new(name, column)).collect();
    let begin = recording.time().first().copied().unwrap_or(0.0);
    let time = (0..trajectory.len()).map(|row| begin + period * row as f64).collect();
    let meta = arm::meta(context, "torques, force, contact and condition from telemetry");
    Recording::new(time, channels, trajectory.gap.clone(), meta)?.write(&options.out)?;
    let share = contacts as f64 / trajectory.len() as f64;
    context.print(format_args!(
        "{} rows, contact in {:.1} % of them, condition at the end {healthy:.3}: {}",
        trajectory.len(),
        100.0 * share,
        options.out.display()
    ));
    Ok(RecordingEstimates {
        rows: trajectory.len(),
        contact: share,
        healthy_at_end: healthy,
        out: options.out.clone(),
        held_joints: Vec::new(),
    })
}
