//! Facts about training, files and rollouts, through the public interface.
#![allow(clippy::unwrap_used)] // a test may stop where it stands

#[path = "it/checkpoints.rs"]
mod checkpoints;
#[path = "it/epochs.rs"]
mod epochs;
#[path = "it/rollouts.rs"]
mod rollouts;
#[path = "it/threads.rs"]
mod threads;
#[path = "it/training.rs"]
mod training;

use hysteron_base::rng;
use hysteron_learn::{Architecture, HeadActivation};
use rand::RngExt;

fn architecture(hidden: usize, layers: usize, dropout: f64) -> Architecture {
    Architecture { inputs: 3, hidden, layers, outputs: 2, head: HeadActivation::Tanh, dropout }
}

/// Random numbers in [-1, 1).
fn uniform(name: &str, n: usize) -> Vec<f32> {
    let mut stream = rng(1, name);
    (0..n).map(|_| stream.random_range(-1.0..1.0)).collect()
}

/// Mean square of what `targets` differ from the outputs, and its gradient.
fn mean_square<'a>(targets: &'a [f32]) -> impl FnOnce(&[f32], &mut [f32]) -> f64 + 'a {
    move |outputs, d_outputs| {
        let n = outputs.len() as f32;
        let mut sum = 0.0;
        for ((d, output), target) in d_outputs.iter_mut().zip(outputs).zip(targets) {
            *d = 2.0 * (output - target) / n;
            sum += f64::from(output - target).powi(2);
        }
        sum / f64::from(n)
    }
}
