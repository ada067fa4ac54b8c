//! Training of an actuator through the simulated arm at the published sizes: simulated steps a second, forward and back, as one
//! JSON object. `bench/peers/neural_training_peer.py` runs it next to MJX with the same network.
//!
//!     cargo run --release -p hysteron-arm-learning --example neural_rates
//!
//! Torques come from the network alone, as published. Processor time, the best of several rounds; with RAYON_NUM_THREADS=1 that of one
//! core. `-- streaming` or `-- published` asks for one form alone, for a profiler.

use std::time::Duration;

use hysteron_arm_dynamics::Model;
use hysteron_arm_learning::neural::{
    ArmSimulation, FeatureLayout, GripperAxis, Heads, InputScale, LossWeights, Segment, SimulationOptions,
    Trajectory, horizon_gradient,
};
use hysteron_learn::{TapePool, TemporalForm, TrainableModel as _, Transformer, TransformerShape};
use rustix::time::{ClockId, clock_gettime};

/// Arms side by side, and the steps that each of them goes.
const ROLLOUTS: usize = 64;
const HORIZON: usize = 64;
const ROUNDS: usize = 7;

/// Processor time of this program [s].
fn now() -> f64 {
    let time = clock_gettime(ClockId::ProcessCPUTime);
    Duration::new(time.tv_sec as u64, time.tv_nsec as u32).as_secs_f64()
}

/// A smooth motion without labels.
fn trajectory(features: &FeatureLayout, period: f64) -> Trajectory {
    let (rows, m) = (HORIZON + 1, features.motors());
    let (mut inputs, mut states) = (Vec::new(), Vec::new());
    for row in 0..rows {
        let t = period * row as f64;
        let angle = |k: usize| 0.3 * (2.0 * t + k as f64).sin();
        let state: Vec<f64> =
            (0..m).map(angle).chain((0..m).map(|k| 0.6 * (2.0 * t + k as f64).cos())).collect();
        let goals: Vec<f64> = (0..m).map(|k| angle(k) + 0.02).collect();
        let constant = |value: f64| vec![value; m];
        let mut sample = vec![0.0; features.len()];
        let [currents, voltages, temperatures] = [0.2, 12.0, 40.0].map(constant);
        features.gather([&goals, &state, &currents, &voltages, &temperatures], goals[m - 1], &mut sample);
        inputs.extend(sample);
        states.extend(state);
    }
    Trajectory {
        name: "smooth".to_owned(),
        inputs,
        states,
        voltage: None,
        force: vec![None; rows],
        is_healthy: None,
        position_gain: None,
        gap: vec![false; rows],
    }
}

#[allow(clippy::print_stdout)] // what it is for
fn main() -> Result<(), Box<dyn std::error::Error>> {
    let gripper = Some(GripperAxis { slope: 0.0228, offset: 0.0 });
    let features = FeatureLayout { joints: 4, gripper };
    let options = SimulationOptions::PUBLISHED;
    let simulation = ArmSimulation::new(&Model::builtin("open-manipulator-x")?, &features, &options)?;
    let trajectory = trajectory(&features, options.period);
    let scale = InputScale::of(&features, trajectory.inputs.chunks_exact(features.len()))?;
    let segments = vec![Segment::recorded(&trajectory, 0); ROLLOUTS];
    let initial = trajectory.state_at(0).repeat(ROLLOUTS);
    let rate = |form| -> Result<f64, Box<dyn std::error::Error>> {
        let shape = TransformerShape::published(features.len(), &Heads::sizes(&features), form);
        let (mut network, tapes) = (Transformer::<f32>::new(&shape, 1)?, TapePool::default());
        let mut best = f64::INFINITY;
        for _ in 0..ROUNDS {
            let start = now();
            // As after every update: values derived from the parameters are recomputed.
            network.parameters_mut();
            let setting = (&simulation, &scale);
            let about = (&initial[..], HORIZON);
            let loss = &LossWeights::PUBLISHED;
            let (_, gradient) = horizon_gradient(setting, (&network, &tapes), &segments, about, loss);
            tapes.give_back(gradient);
            best = best.min(now() - start);
        }
        Ok((ROLLOUTS * HORIZON) as f64 / best)
    };
    let asked = std::env::args().nth(1);
    let mut rates = hysteron_base::json!({ "inputs": features.len() });
    for (name, form) in [("streaming", TemporalForm::Streaming), ("published", TemporalForm::Window)] {
        if asked.as_ref().is_none_or(|asked| asked == name) {
            rates[name] = rate(form)?.into();
        }
    }
    println!("{rates}");
    Ok(())
}
