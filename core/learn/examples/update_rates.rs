//! Times of an update of a training: on all cores by the fused passes, or, built with `--features cuda`, on the first card.
#![allow(clippy::print_stdout)] // an example prints

use std::time::Instant;

use hysteron_learn::{
    Adam, Architecture, Backprop, DeviceCard, HeadActivation, HeadOutputs, Memory, Network, Result,
    SequenceBatch, TapePool, TemporalForm, Training, Transformer, TransformerShape, mean_squared_error,
};
use rayon::prelude::*;

/// Updates that are timed together, after as many that are not.
const UPDATES: usize = 5;
/// Sequences that a thread takes together.
const GROUP: usize = 8;

fn wave(n: usize) -> Vec<f32> {
    (0..n).map(|i| (0.37 * i as f32).sin()).collect()
}

/// Seconds of an update.
fn timed(mut update: impl FnMut() -> Result<f64>) -> Result<(f64, f64)> {
    let mut last = 0.0;
    for _ in 0..UPDATES {
        last = update()?;
    }
    let start = Instant::now();
    for _ in 0..UPDATES {
        last = update()?;
    }
    Ok((start.elapsed().as_secs_f64() / UPDATES as f64, last))
}

fn lstm(hidden: usize, rows: usize, steps: usize) -> Result<()> {
    let architecture =
        Architecture { inputs: 2, hidden, layers: 2, outputs: 4, head: HeadActivation::Linear, dropout: 0.0 };
    let passes = Backprop::new(&architecture, 1)?;
    let mut training = Training::new(Network::new(&architecture, 1)?, Adam::default(), Some(0.01))?;
    let (inputs, targets) = (wave(steps * rows * 2), wave(steps * rows * 4));
    let mut updates = passes.updates(&mut training)?;
    let (seconds, loss) = timed(|| {
        let batch = SequenceBatch { inputs: &inputs, steps, rows, outputs: HeadOutputs::All };
        let mut memory = Memory::zeros(&architecture, rows);
        updates.step(&batch, &mut memory, |found, by| mean_squared_error(found, &targets, by))
    })?;
    updates.finish()?;
    println!(
        "LSTM 2 x {hidden}, {rows} x {steps} samples: {:.1} ms an update, loss {loss:.5}",
        1e3 * seconds
    );
    Ok(())
}

/// One update by the fused passes, groups of sequences, each with its inputs and targets, on all threads.
fn by_fused_passes(
    training: &mut Training<Transformer<f32>>,
    tapes: &TapePool<f32>,
    steps: usize,
    groups: &[[Vec<f32>; 2]],
) -> Result<f64> {
    let network = training.model();
    let found: Vec<(f64, Vec<Vec<f32>>)> = groups
        .par_iter()
        .map(|[inputs, targets]| {
            let mut gradient = network.zeros();
            let loss = tapes.with(network.shape(), (steps, GROUP), |tape| {
                let outputs = tape.forward(network, 0..steps, inputs);
                let mut by = vec![0.0; outputs.len()];
                let loss = mean_squared_error(outputs, targets, &mut by);
                tape.clear_gradients();
                tape.backward(network, 0..steps, &by, &mut gradient);
                tape.weight_gradients(network, steps, &mut gradient);
                loss
            });
            (loss, gradient)
        })
        .collect();
    let part = 1.0 / groups.len() as f32;
    let mut mean = network.zeros();
    for (_, gradient) in &found {
        mean.iter_mut().flatten().zip(gradient.iter().flatten()).for_each(|(mean, own)| *mean += part * own);
    }
    let loss = f64::from(part) * found.iter().map(|(loss, _)| loss).sum::<f64>();
    training.update(loss, &mean)?;
    Ok(loss)
}

/// Those of a few sequences, of arrays ([step][sequence][channel]) for all of them.
fn group(all: &[f32], rows: usize, channels: usize, which: usize) -> Vec<f32> {
    let of_step = |step: &[f32]| step[which * GROUP * channels..][..GROUP * channels].to_vec();
    all.chunks(rows * channels).flat_map(of_step).collect()
}

fn transformer(shape: &TransformerShape, rows: usize, steps: usize) -> Result<()> {
    let mut training = Training::new(Transformer::new(shape, 1)?, Adam::default(), Some(0.01))?;
    let results = if shape.form == TemporalForm::Window { 1 } else { steps };
    let (inputs, targets) = (wave(steps * rows * shape.inputs), wave(results * rows * shape.outputs()));
    let (seconds, loss) = if let Some(card) = DeviceCard::first()? {
        let mut updates = card.updates(&training)?;
        timed(|| {
            let outputs = updates.forward(&inputs, rows)?;
            let mut by = vec![0.0; outputs.len()];
            let loss = mean_squared_error(&outputs, &targets, &mut by);
            updates.update(&training, loss, &by)?;
            Ok(loss)
        })?
    } else {
        let tapes = TapePool::default();
        let own = |k| [group(&inputs, rows, shape.inputs, k), group(&targets, rows, shape.outputs(), k)];
        let groups: Vec<_> = (0..rows / GROUP).map(own).collect();
        timed(|| by_fused_passes(&mut training, &tapes, steps, &groups))?
    };
    println!(
        "Transformer {} x {} wide, {:?}, {rows} x {steps} samples: {:.2} ms an update, loss {loss:.5}",
        shape.layers,
        shape.width,
        shape.form,
        1e3 * seconds
    );
    Ok(())
}

fn main() -> Result<()> {
    let place = DeviceCard::first()?.map_or_else(|| "the processor".to_owned(), |_| "the card".to_owned());
    println!("on {place}, {} threads", rayon::current_num_threads());
    lstm(128, 64, 100)?;
    lstm(512, 64, 200)?;
    let heads = [5, 3, 1, 5];
    let small = |width: usize, layers: usize, tokens: usize| TransformerShape {
        width,
        layers,
        feed_forward: 2 * width,
        latent: width,
        tokens,
        ..TransformerShape::published(36, &heads, TemporalForm::Streaming)
    };
    transformer(&small(32, 2, 33), 32, 64)?;
    transformer(&small(128, 2, 33), 32, 64)?;
    transformer(&TransformerShape::published(36, &heads, TemporalForm::Streaming), 64, 40)?;
    let window = TransformerShape::published(36, &heads, TemporalForm::Window);
    transformer(&window, 64, window.tokens)
}
