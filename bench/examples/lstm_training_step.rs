//! Times training steps of 2 × 512 units for the peers: `lstm_training_step STEPS REPETITIONS` prints one JSON line with the
//! shortest step [s] and the losses. RAYON_NUM_THREADS says on how many threads.
#![allow(clippy::print_stdout)] // a peer reads it

use anyhow::{Context, Result};
use hysteron_bench::learn::Training;
use serde_json::json;

fn main() -> Result<()> {
    let mut arguments = std::env::args().skip(1);
    let mut number = || -> Result<usize> {
        arguments
            .next()
            .context("usage: lstm_training_step STEPS REPETITIONS")?
            .parse()
            .context("a whole number")
    };
    let (steps, repetitions) = (number()?, number()?);
    let mut training = Training::fused(steps)?;
    let timed = (0..repetitions).map(|_| training.timed()).collect::<Result<Vec<_>>>()?;
    let shortest = timed.iter().map(|(_, seconds)| *seconds).fold(f64::INFINITY, f64::min);
    let losses: Vec<f64> = timed.iter().map(|(loss, _)| *loss).collect();
    println!("{}", json!({ "seconds": shortest, "losses": losses }));
    Ok(())
}
