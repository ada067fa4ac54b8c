//! Gradients of a trained actuator by horizon (table II of NeuralActuator).
//!
//!     cargo run --release -p hysteron-arm-learning --example neural_gradients -- ACTUATOR REC...
#![allow(clippy::print_stdout)] // an example prints

use std::path::PathBuf;

use hysteron_arm_dynamics::Model;
use hysteron_arm_learning::neural::{
    LossWeights, NeuralActuator, Segment, Trajectory, Unlabelled, horizon_gradient, trajectory_of,
};
use hysteron_base::Recording;
use hysteron_learn::TapePool;

/// Horizons of the table [steps]; directions are compared with that of the second.
const HORIZONS: [usize; 5] = [64, 128, 256, 320, 500];
/// Rollouts at once.
const ROLLOUTS: usize = 16;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1).map(PathBuf::from);
    let actuator = NeuralActuator::read(&arguments.next().ok_or("an actuator, and recordings")?)?;
    let simulation = actuator.simulation(&Model::builtin("open-manipulator-x")?)?;
    let mut trajectories: Vec<Trajectory> = Vec::new();
    for path in arguments {
        let recording = Recording::read(&path)?;
        let period = actuator.simulation.period;
        trajectories.push(trajectory_of(&recording, &actuator.features, period, Unlabelled::Unknown)?);
    }
    trajectories.retain(|one| one.len() > HORIZONS[4]);
    if trajectories.is_empty() {
        return Err("a recording of more than 500 samples".into());
    }
    let segments: Vec<Segment<'_>> =
        (0..ROLLOUTS).map(|k| Segment::recorded(&trajectories[k % trajectories.len()], 0)).collect();
    let initial: Vec<f64> = segments.iter().flat_map(|one| one.trajectory.state_at(0)).copied().collect();
    let tapes = TapePool::default();
    let of = |horizon: usize| {
        let (setting, network) = ((&simulation, &actuator.scale), (&actuator.network, &tapes));
        horizon_gradient(setting, network, &segments, (&initial, horizon), &LossWeights::PUBLISHED)
    };
    let found = HORIZONS.map(of);
    let flat =
        |gradient: &[Vec<f32>]| -> Vec<f64> { gradient.iter().flatten().map(|x| f64::from(*x)).collect() };
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let reference = flat(&found[1].1);
    println!("horizon  |gradient by torque|  |gradient by weights|  cosine with H = 128");
    for (horizon, (about, gradient)) in HORIZONS.into_iter().zip(&found) {
        let own = flat(gradient);
        let [size, other] = [&own, &reference].map(|g| dot(g, g).sqrt());
        let cosine = dot(&own, &reference) / (size * other);
        println!("{horizon:7}  {:20.3e}  {size:21.3}  {cosine:19.3}", about.torque);
    }
    Ok(())
}
