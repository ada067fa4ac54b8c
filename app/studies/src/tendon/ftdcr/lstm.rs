//! An LSTM from strokes to the tip, without a model of the robot: what history alone can do.
//!
//! Patterns run side by side from their first rows, shorter ones with weight zero after their end. Every fourth
//! training pattern chooses when to stop.

use anyhow::Result;
use hysteron_learn::{
    Adam, Architecture, Backprop, ChannelRange, HeadActivation, HeadOutputs, Memory, Network, Normaliser,
    SequenceBatch, Trainer,
};

use super::recording::{N_TENDONS, Pattern};

const HIDDEN: usize = 48;
const EPOCHS: usize = 600;
/// Epochs between two looks at the patterns that choose.
const LOOK_EVERY: usize = 10;
const LEARNING_RATE: f64 = 5e-3;
/// Strokes and their change since the row before.
const INPUTS: usize = 2 * N_TENDONS;

/// Patterns side by side: inputs and tips [step][row][channel], weights [step][row].
struct PatternRows {
    inputs: Vec<f32>,
    tips: Vec<f32>,
    weights: Vec<f32>,
    steps: usize,
    rows: usize,
}

impl PatternRows {
    fn new(patterns: &[&Pattern], inputs: &Normaliser, tips: &Normaliser) -> Self {
        let steps = patterns.iter().map(|pattern| pattern.rows.len()).max().unwrap_or(0);
        let rows = patterns.len();
        let n = steps * rows;
        let mut all = Self {
            inputs: vec![0.0; n * INPUTS],
            tips: vec![0.0; n * 3],
            weights: vec![0.0; n],
            steps,
            rows,
        };
        for (row, pattern) in patterns.iter().enumerate() {
            for (step, (input, tip)) in channels(pattern).iter().zip(&pattern.rows).enumerate() {
                let k = step * rows + row;
                inputs.normalise_into(input, &mut all.inputs[k * INPUTS..(k + 1) * INPUTS]);
                tips.normalise_into(&tip.tip, &mut all.tips[3 * k..3 * (k + 1)]);
                all.weights[k] = 1.0;
            }
        }
        all
    }

    fn batch(&self) -> SequenceBatch<'_> {
        SequenceBatch { inputs: &self.inputs, steps: self.steps, rows: self.rows, outputs: HeadOutputs::All }
    }

    /// Mean squared error and, where asked for, its gradient by the outputs.
    fn error(&self, outputs: &[f32], gradient: Option<&mut [f32]>) -> f64 {
        let n = 3.0 * self.weights.iter().sum::<f32>();
        let off = |k: usize| self.weights[k / 3] * (outputs[k] - self.tips[k]);
        if let Some(gradient) = gradient {
            gradient.iter_mut().enumerate().for_each(|(k, g)| *g = 2.0 * off(k) / n);
        }
        (0..outputs.len()).map(|k| f64::from(off(k).powi(2))).sum::<f64>() / f64::from(n)
    }
}

/// Strokes [m] and their changes in every row.
fn channels(pattern: &Pattern) -> Vec<Vec<f64>> {
    let row = |k: usize| {
        let (now, before) = (&pattern.rows[k].strokes, &pattern.rows[k.saturating_sub(1)].strokes);
        now.iter().copied().chain((0..N_TENDONS).map(|j| now[j] - before[j])).collect()
    };
    (0..pattern.rows.len()).map(row).collect()
}

/// Tips of the rows of `held` [mm], after training on `training`.
///
/// # Errors
/// Training that leaves finite numbers.
pub fn predict(training: &[Pattern], held: &[Pattern]) -> Result<Vec<[f64; 3]>> {
    let samples: Vec<Vec<f64>> = training.iter().flat_map(channels).collect();
    let inputs = ranges(&samples, INPUTS)?;
    let samples: Vec<Vec<f64>> = training.iter().flat_map(|p| &p.rows).map(|row| row.tip.to_vec()).collect();
    let tips = ranges(&samples, 3)?;
    let part = |is_validation: bool| -> Vec<&Pattern> {
        training.iter().enumerate().filter(|(k, _)| (k % 4 == 3) == is_validation).map(|(_, p)| p).collect()
    };
    let [fitted, validation] =
        [part(false), part(true)].map(|patterns| PatternRows::new(&patterns, &inputs, &tips));
    let network = trained(&fitted, &validation)?;

    let held_patterns: Vec<&Pattern> = held.iter().collect();
    let new = PatternRows::new(&held_patterns, &inputs, &tips);
    let outputs = run(&network, &new)?;
    let mut found = Vec::new();
    for (row, pattern) in held.iter().enumerate() {
        for step in 0..pattern.rows.len() {
            let k = 3 * (step * new.rows + row);
            let mut tip = [0.0; 3];
            tips.restore_into(&outputs[k..k + 3], &mut tip);
            found.push(tip.map(|c| 1e3 * c));
        }
    }
    Ok(found)
}

fn ranges(samples: &[Vec<f64>], n: usize) -> Result<Normaliser> {
    let least = |k: usize| samples.iter().map(|s| s[k]).fold(f64::INFINITY, f64::min);
    let most = |k: usize| samples.iter().map(|s| s[k]).fold(f64::NEG_INFINITY, f64::max);
    let range = |k: usize| ChannelRange { name: format!("channel {k}"), min: least(k), max: most(k) };
    Ok(Normaliser::new((0..n).map(range).collect())?)
}

/// The network with the least error on `validation`.
fn trained(training: &PatternRows, validation: &PatternRows) -> Result<Network> {
    let architecture = Architecture {
        inputs: INPUTS,
        hidden: HIDDEN,
        layers: 1,
        outputs: 3,
        head: HeadActivation::Linear,
        dropout: 0.0,
    };
    let adam = Adam { learning_rate: LEARNING_RATE, clip_norm: Some(1.0), ..Adam::default() };
    let mut trainer = Trainer::new(Network::new(&architecture, 1)?, adam, 1)?;
    let mut best = (f64::INFINITY, trainer.network().clone());
    for epoch in 0..EPOCHS {
        let part = epoch as f64 / EPOCHS as f64;
        trainer
            .set_learning_rate(LEARNING_RATE * (0.01 + 0.495 * (1.0 + (std::f64::consts::PI * part).cos())));
        let mut memory = Memory::zeros(&architecture, training.rows);
        trainer.step(&training.batch(), &mut memory, |outputs, gradient| {
            training.error(outputs, Some(gradient))
        })?;
        if (epoch + 1) % LOOK_EVERY == 0 {
            let error = validation.error(&run(trainer.network(), validation)?, None);
            if error < best.0 {
                best = (error, trainer.network().clone());
            }
        }
    }
    Ok(best.1)
}

fn run(network: &Network, rows: &PatternRows) -> Result<Vec<f32>> {
    let mut memory = Memory::zeros(network.architecture(), rows.rows);
    Ok(Backprop::new(network.architecture(), 0)?.predict(network, &rows.batch(), &mut memory)?)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)] // a test may stop where it stands
    use super::super::recording::Row;
    use super::*;

    #[test]
    fn a_tip_that_follows_the_row_before_is_learned() {
        let mut stream = hysteron_base::rng(1, "lstm");
        let mut pattern = |_| {
            let strokes: Vec<[f64; N_TENDONS]> = (0..12)
                .map(|_| std::array::from_fn(|_| rand::RngExt::random_range(&mut stream, -5e-3..5e-3)))
                .collect();
            let tip = |k: usize| [10.0 * strokes[k][0], 10.0 * strokes[k.saturating_sub(1)][1], 0.1];
            let rows = (0..12).map(|k| Row::new(strokes[k], tip(k))).collect();
            Pattern { label: String::new(), rows }
        };
        let patterns: Vec<Pattern> = (0..60).map(&mut pattern).collect();
        let (training, held) = patterns.split_at(50);
        let found = predict(training, held).unwrap();
        let measured: Vec<[f64; 3]> =
            held.iter().flat_map(|p| &p.rows).map(|row| row.tip.map(|c| 1e3 * c)).collect();
        let off = found.iter().zip(&measured).map(|(a, b)| crate::tendon::numbers::distance(*a, *b));
        // The mean alone would miss by 41 mm, no memory by 29 mm.
        let error = crate::tendon::numbers::rms(off);
        assert!(error < 12.0, "{error} mm");
    }
}
