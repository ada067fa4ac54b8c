//! Networks: a step of training compared with candle's own cells, and a step of a rollout.

use std::hint::black_box;
use std::time::Instant;

use anyhow::Result;
use hysteron_learn::{
    Adam, Architecture, HeadActivation, HeadOutputs, Memory, Network, NetworkRunner, SequenceBatch,
    TemporalForm, Trainer, Transformer, TransformerGraph, TransformerRunner, TransformerShape,
    TransformerTape, WeightFormat,
};

use crate::measure::{shortest, shortest_of_both};
use crate::table::{FigureTarget, TableRow};

/// Sequences in a batch.
const ROWS: usize = 64;

/// A network that learns to follow a sum of two waves.
#[derive(Debug)]
pub struct WaveTraining {
    trainer: Trainer,
    inputs: Vec<f32>,
    steps: usize,
    outputs: HeadOutputs,
}

impl WaveTraining {
    /// 2 × 512 units, 2 inputs, 4 outputs: the controller's network; batches of 64 sequences of `steps` samples.
    fn architecture() -> Architecture {
        Architecture {
            inputs: 2,
            hidden: 512,
            layers: 2,
            outputs: 4,
            head: HeadActivation::Linear,
            dropout: 0.0,
        }
    }

    /// With fused layers; the loss is of these outputs.
    ///
    /// # Errors
    /// A device refuses.
    pub fn fused(steps: usize, outputs: HeadOutputs) -> Result<Self> {
        let network = Network::new(&Self::architecture(), 1)?;
        Ok(Self::with(Trainer::new(network, Adam::default(), 1)?, steps, outputs))
    }

    /// With candle's own cells; the loss is of all outputs.
    ///
    /// # Errors
    /// As [`WaveTraining::fused`].
    pub fn unrolled(steps: usize) -> Result<Self> {
        let network = Network::new(&Self::architecture(), 1)?;
        Ok(Self::with(Trainer::unrolled(network, Adam::default(), 1)?, steps, HeadOutputs::All))
    }

    fn with(trainer: Trainer, steps: usize, outputs: HeadOutputs) -> Self {
        let wave = |k: usize| (0.1 * (k / (2 * ROWS)) as f32 + 0.37 * (k % (2 * ROWS)) as f32).sin();
        Self { trainer, inputs: (0..steps * ROWS * 2).map(wave).collect(), steps, outputs }
    }

    /// One step of training: the loss before it.
    ///
    /// # Errors
    /// Training diverged.
    pub fn step(&mut self) -> Result<f64> {
        let batch =
            SequenceBatch { inputs: &self.inputs, steps: self.steps, rows: ROWS, outputs: self.outputs };
        let mut memory = Memory::zeros(self.trainer.network().architecture(), ROWS);
        let loss = |outputs: &[f32], d_outputs: &mut [f32]| {
            let mut sum = 0.0;
            let per_value = 1.0 / outputs.len() as f32;
            let last = &self.inputs[self.inputs.len() - outputs.len() / 2..];
            for (k, (output, d)) in outputs.iter().zip(d_outputs).enumerate() {
                let sample = k / 4;
                let off = output - 0.5 * (last[2 * sample] + last[2 * sample + 1]);
                *d = 2.0 * off * per_value;
                sum += f64::from(off * off * per_value);
            }
            sum
        };
        Ok(self.trainer.step(&batch, &mut memory, loss)?)
    }

    /// One step: the loss before it, and how long it took [s].
    ///
    /// # Errors
    /// Training diverged.
    pub fn timed(&mut self) -> Result<(f64, f64)> {
        let start = Instant::now();
        let loss = self.step()?;
        Ok((loss, start.elapsed().as_secs_f64()))
    }
}

/// Network that is stepped one sample at a time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stepped {
    /// A network of the size of the residual: 2 × 128 units, 7 inputs, 36 outputs.
    Residual,
    /// The controller's network: 2 × 512 units, 2 inputs, 4 outputs.
    Controller,
}

/// A network with nothing remembered.
///
/// # Errors
/// None: the sizes are legal.
pub fn runner(stepped: Stepped) -> Result<NetworkRunner> {
    let architecture = match stepped {
        Stepped::Residual => Architecture {
            inputs: 7,
            hidden: 128,
            layers: 2,
            outputs: 36,
            head: HeadActivation::Linear,
            dropout: 0.0,
        },
        Stepped::Controller => WaveTraining::architecture(),
    };
    Ok(NetworkRunner::new(&Network::new(&architecture, 1)?))
}

/// NeuralActuator's published sizes: 36 inputs, and heads for torques, force, contact and condition.
fn published(form: TemporalForm) -> Result<Transformer<f32>> {
    Ok(Transformer::new(&TransformerShape::published(36, &[5, 3, 1, 5], form), 1)?)
}

/// The same with nothing remembered.
///
/// # Errors
/// None: the sizes are legal.
pub fn transformer(form: TemporalForm, format: WeightFormat) -> Result<TransformerRunner> {
    Ok(TransformerRunner::new(&published(form)?, format))
}

/// Time of one sample of a Transformer on one core [ms].
fn transformer_ms(form: TemporalForm, format: WeightFormat) -> Result<f64> {
    let mut runner = transformer(form, format)?;
    let hundred = || {
        (0..100).for_each(|_| {
            black_box(runner.step(&[0.1; 36]));
        });
    };
    Ok(1e3 * shortest(100, hundred) / 100.0)
}

/// A pass of NeuralActuator's Transformer over windows side by side and back, fused and by candle's operations.
pub struct TransformerPasses {
    network: Transformer<f32>,
    tape: TransformerTape<f32>,
    graph: TransformerGraph,
    gradient: Vec<Vec<f32>>,
    inputs: Vec<f32>,
    weights: Vec<f32>,
}

impl TransformerPasses {
    /// Of `rows` windows.
    ///
    /// # Errors
    /// None: the sizes are legal.
    pub fn new(form: TemporalForm, rows: usize) -> Result<Self> {
        let network = published(form)?;
        let shape = network.shape();
        let tape = TransformerTape::new(shape, shape.tokens, rows);
        let graph = TransformerGraph::new(&network, rows)?;
        let numbers = |n: usize| (0..n).map(|i| (0.37 * i as f32).sin()).collect::<Vec<_>>();
        let n_results = if form == TemporalForm::Window { 1 } else { shape.tokens };
        let (inputs, weights) =
            (numbers(shape.tokens * rows * shape.inputs), numbers(n_results * rows * shape.outputs()));
        Ok(Self { gradient: network.zeros(), network, tape, graph, inputs, weights })
    }

    /// Outputs of the fused pass.
    pub fn fused(&mut self) -> &[f32] {
        let steps = 0..self.network.shape().tokens;
        self.tape.forward(&self.network, steps, &self.inputs)
    }

    /// The fused pass and back: the derivatives by the parameters.
    pub fn fused_and_back(&mut self) -> &[Vec<f32>] {
        let n = self.network.shape().tokens;
        self.gradient.iter_mut().for_each(|values| values.fill(0.0));
        self.fused();
        self.tape.clear_gradients();
        self.tape.backward(&self.network, 0..n, &self.weights, &mut self.gradient);
        self.tape.weight_gradients(&self.network, n, &mut self.gradient);
        &self.gradient
    }

    /// Outputs by candle's operations.
    ///
    /// # Errors
    /// candle refuses.
    pub fn by_candle(&mut self) -> Result<Vec<f32>> {
        Ok(self.graph.forward(&self.inputs)?)
    }

    /// The same and back: the derivatives by the parameters, then those by the inputs.
    ///
    /// # Errors
    /// candle refuses.
    pub fn by_candle_and_back(&mut self) -> Result<Vec<Vec<f32>>> {
        self.by_candle()?;
        Ok(self.graph.backward(&self.weights)?)
    }

    /// How far the derivatives of both are apart, over the largest: the proof of equal work.
    ///
    /// # Errors
    /// candle refuses.
    pub fn apart(&mut self) -> Result<f64> {
        let theirs = self.by_candle_and_back()?;
        let ours = self.fused_and_back();
        let (mut apart, mut largest) = (0.0f32, 0.0f32);
        for (ours, theirs) in ours.iter().flatten().zip(theirs.iter().flatten()) {
            (apart, largest) = (apart.max((ours - theirs).abs()), largest.max(theirs.abs()));
        }
        Ok(f64::from(apart / largest))
    }
}

/// Times of windows of NeuralActuator's Transformer compared with candle's operations.
fn transformer_rows() -> Result<Vec<TableRow>> {
    const THEIRS: &str = "candle's own operations on the same window";
    let by_candle = |form| -> Result<f64> {
        let mut passes = TransformerPasses::new(form, 1)?;
        passes.by_candle()?;
        Ok(1e3 * shortest(30, || drop(black_box(passes.by_candle()))))
    };
    let (window, streamed) = (by_candle(TemporalForm::Window)?, by_candle(TemporalForm::Streaming)?);
    let mut passes = TransformerPasses::new(TemporalForm::Window, ROWS)?;
    let apart = passes.apart()?;
    let [fast, slow] = shortest_of_both(10, |_| -> Result<[f64; 2]> {
        let start = Instant::now();
        black_box(passes.fused_and_back());
        let fast = start.elapsed().as_secs_f64();
        let start = Instant::now();
        black_box(passes.by_candle_and_back()?);
        Ok([fast, start.elapsed().as_secs_f64()])
    })?;
    let name = "NeuralActuator's Transformer";
    Ok(vec![
        TableRow::new(
            format!(
                "{name}, published form: one sample (the authors' release, as its notes print it: 2.6 ms)"
            ),
            transformer_ms(TemporalForm::Window, WeightFormat::Float32)?,
            "ms",
        )
        .against(window, THEIRS)
        .goal(FigureTarget::AtMost(0.5)),
        TableRow::new(
            format!("{name}, streaming form: one sample"),
            transformer_ms(TemporalForm::Streaming, WeightFormat::Float32)?,
            "ms",
        )
        .against(streamed, THEIRS),
        TableRow::new(
            format!("{name}, streaming form, 16-bit weights: one sample"),
            transformer_ms(TemporalForm::Streaming, WeightFormat::Int16)?,
            "ms",
        )
        .against(streamed, THEIRS)
        .goal(FigureTarget::AtMost(0.06)),
        TableRow::new(format!("{name}: {ROWS} windows and back"), 1e3 * fast, "ms")
            .against(1e3 * slow, THEIRS),
        // Rounding of sums over all windows and tokens.
        TableRow::new(format!("{name}: derivatives of both apart"), apart, "-")
            .goal(FigureTarget::AtMost(1e-4)),
    ])
}

/// Time of one sample on one core [s].
fn sample_seconds(stepped: Stepped) -> Result<f64> {
    let mut runner = runner(stepped)?;
    let inputs = match stepped {
        Stepped::Residual => &[0.1; 7][..],
        Stepped::Controller => &[0.1; 2],
    };
    let hundred = || {
        (0..100).for_each(|_| {
            black_box(runner.step(inputs));
        });
    };
    Ok(shortest(100, hundred) / 100.0)
}

/// Training on sequences of `steps` samples, alternating with candle's cells; one sample of a rollout and of a
/// controller.
///
/// # Errors
/// Training diverged.
pub fn rows(repetitions: usize, steps: usize) -> Result<Vec<TableRow>> {
    let (mut fused, mut unrolled) =
        (WaveTraining::fused(steps, HeadOutputs::All)?, WaveTraining::unrolled(steps)?);
    let mut apart = 0.0f64;
    let [fast, slow] = shortest_of_both(repetitions.max(2), |k| -> Result<[f64; 2]> {
        let ((here, fast), (there, slow)) = (fused.timed()?, unrolled.timed()?);
        // The second step shows that the first moved the weights alike; from step to step rounding grows.
        if k < 2 {
            apart = apart.max((here / there - 1.0).abs());
        }
        Ok([fast, slow])
    })?;
    let name = format!("LSTM 2 × 512, batch of {ROWS} × {steps}");
    let mut rows = vec![
        TableRow::new(format!("{name}: step of training"), fast, "s")
            .against(slow, "candle's own cells, unrolled")
            .goal(FigureTarget::AtMost(3.0)),
        TableRow::new(format!("{name}: candle's time over ours"), slow / fast, "-")
            .goal(FigureTarget::AtLeast(5.0)),
        // Proof that both did the same work: rounding of sums over the batch.
        TableRow::new(format!("{name}: losses of both apart"), apart, "-").goal(FigureTarget::AtMost(1e-4)),
        TableRow::new("LSTM 2 × 128: one sample", 1e6 * sample_seconds(Stepped::Residual)?, "µs")
            .goal(FigureTarget::AtMost(30.0)),
        TableRow::new("LSTM 2 × 512: one sample", 1e3 * sample_seconds(Stepped::Controller)?, "ms")
            .goal(FigureTarget::AtMost(0.3)),
    ];
    rows.extend(transformer_rows()?);
    Ok(rows)
}
