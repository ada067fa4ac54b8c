//! Times training steps of 2 × 512 units for the peers: `lstm_training_step STEPS REPETITIONS all|last` prints one
//! JSON line with the shortest step [s] and the losses, of all outputs or of the last. RAYON_NUM_THREADS sets on how
//! many threads.
#![allow(clippy::print_stdout)] // a peer reads it

use anyhow::{Context, Result, bail};
use hysteron_base::json;
use hysteron_bench::learn::WaveTraining;
use hysteron_learn::HeadOutputs;

const USAGE: &str = "usage: lstm_training_step STEPS REPETITIONS all|last";

fn main() -> Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [steps, repetitions, outputs] = &arguments[..] else { bail!(USAGE) };
    let outputs = match outputs.as_str() {
        "all" => HeadOutputs::All,
        "last" => HeadOutputs::Last,
        _ => bail!(USAGE),
    };
    let number = |text: &String| -> Result<usize> { text.parse().context(USAGE) };
    let (steps, repetitions) = (number(steps)?, number(repetitions)?);
    let mut training = WaveTraining::fused(steps, outputs)?;
    let timed = (0..repetitions).map(|_| training.timed()).collect::<Result<Vec<_>>>()?;
    let shortest = timed.iter().map(|(_, seconds)| *seconds).fold(f64::INFINITY, f64::min);
    let losses: Vec<f64> = timed.iter().map(|(loss, _)| *loss).collect();
    println!("{}", json!({ "seconds": shortest, "losses": losses }));
    Ok(())
}
