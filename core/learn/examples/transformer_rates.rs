//! Times of the Transformer on one core: a step in use, a token in training.
#![allow(clippy::print_stdout)] // an example prints

use std::hint::black_box;
use std::time::Instant;

use hysteron_base::BadInput;
use hysteron_learn::{
    TemporalForm, Transformer, TransformerRunner, TransformerShape, TransformerTape, WeightFormat,
};

/// The shortest of some runs [s].
fn shortest(runs: usize, mut work: impl FnMut()) -> f64 {
    let time = |_| {
        let start = Instant::now();
        work();
        start.elapsed().as_secs_f64()
    };
    (0..runs).map(time).fold(f64::INFINITY, f64::min)
}

fn main() -> Result<(), BadInput> {
    let runs = std::env::args().nth(1).and_then(|n| n.parse().ok()).unwrap_or(30);
    for form in [TemporalForm::Window, TemporalForm::Streaming] {
        let shape = TransformerShape::published(36, &[5, 3, 1, 5], form);
        let network = Transformer::<f32>::new(&shape, 1)?;
        for format in [WeightFormat::Float32, WeightFormat::Int16] {
            let mut runner = TransformerRunner::new(&network, format);
            let x: Vec<f32> = (0..36).map(|k| (k as f32).sin()).collect();
            let seconds = shortest(runs, || {
                (0..100).for_each(|_| {
                    black_box(runner.step(&x));
                });
            }) / 100.0;
            println!(
                "{form:?}, {format:?}: {:.1} µs a step, output {:.5}",
                1e6 * seconds,
                runner.step(&x)[0]
            );
        }
        // Eight sequences; a window of each, or one step after the other.
        let (rows, steps) = (8, if form == TemporalForm::Window { shape.tokens } else { 32 });
        let mut tape = TransformerTape::new(&shape, steps, rows);
        let inputs = vec![0.1; steps * rows * shape.inputs];
        let mut gradient = network.zeros();
        let mut seconds = [f64::INFINITY; 3];
        for _ in 0..runs {
            let results = if form == TemporalForm::Window { 1 } else { steps };
            let start = Instant::now();
            let pass = if form == TemporalForm::Window { steps } else { 1 };
            for s in (0..steps).step_by(pass) {
                tape.forward(
                    &network,
                    s..s + pass,
                    &inputs[s * rows * shape.inputs..][..pass * rows * shape.inputs],
                );
            }
            let forward = start.elapsed().as_secs_f64();
            tape.clear_gradients();
            let weights = vec![0.1; rows * shape.outputs()];
            for s in (0..steps).step_by(pass).rev() {
                tape.backward(&network, s..s + pass, &weights, &mut gradient);
            }
            let backward = start.elapsed().as_secs_f64();
            tape.weight_gradients(&network, steps, &mut gradient);
            let all = start.elapsed().as_secs_f64();
            let found = [forward, backward - forward, all - backward];
            for (best, found) in seconds.iter_mut().zip(found) {
                *best = best.min(found / (results * rows) as f64);
            }
        }
        let [forward, backward, weights] = seconds.map(|s| 1e6 * s);
        println!(
            "{form:?}, {rows} sequences: forward {forward:.0}, backward {backward:.0}, weights {weights:.0} µs a sample"
        );
    }
    Ok(())
}
