//! Table II: gradients of the loss by horizon.

use hysteron_learn::TapePool;

use super::comparison::HorizonGradient;
use hysteron_arm_dynamics::Model;
use hysteron_arm_learning::neural::{LossWeights, NeuralActuator, Segment, Trajectory, horizon_gradient};

/// Steps of table II.
const HORIZONS: [usize; 5] = [64, 128, 256, 320, 500];
/// Rollouts side by side.
const ROLLOUTS: usize = 16;

/// Mean size of the gradient by a step's torque, size of that by the weights, and its cosine with that of 128 steps; `None` without a
/// trajectory of more than 500 samples.
///
/// # Errors
/// `BadInput` for another arm.
pub(super) fn by_horizon(
    actuator: &NeuralActuator,
    model: &Model,
    trajectories: &[&Trajectory],
) -> Result<Option<Vec<HorizonGradient>>, hysteron_base::BadInput> {
    let simulation = actuator.simulation(model)?;
    let long: Vec<&Trajectory> = trajectories.iter().filter(|one| one.len() > HORIZONS[4]).copied().collect();
    if long.is_empty() {
        return Ok(None);
    }
    let segments: Vec<Segment<'_>> =
        (0..ROLLOUTS).map(|k| Segment::recorded(long[k % long.len()], 0)).collect();
    let initial: Vec<f64> = segments.iter().flat_map(|one| one.trajectory.state_at(0)).copied().collect();
    let tapes = TapePool::default();
    let found = HORIZONS.map(|horizon| {
        let (setting, network) = ((&simulation, &actuator.scale), (&actuator.network, &tapes));
        let about = (&initial[..], horizon);
        let (loss, gradient) = horizon_gradient(setting, network, &segments, about, &LossWeights::PUBLISHED);
        let flat: Vec<f64> = gradient.iter().flatten().map(|x| f64::from(*x)).collect();
        (loss.torque, flat)
    });
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let reference = &found[1].1;
    let row = |(steps, (by_torque, own)): (usize, &(f64, Vec<f64>))| {
        let [by_weights, other] = [own, reference].map(|g| dot(g, g).sqrt());
        let cosine = dot(own, reference) / (by_weights * other);
        HorizonGradient { steps, by_torque: *by_torque, by_weights, cosine }
    };
    Ok(Some(HORIZONS.into_iter().zip(&found).map(row).collect()))
}
