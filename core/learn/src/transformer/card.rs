//! Trainings of Transformers on a card, by candle's operations.

use candle_core::{Device, Tensor};

use super::graph::{Leaves, Operations, SharedTensors};
use super::{Transformer, TransformerShape};
use crate::on_device::{OnDevice, best_device};
use crate::{Error, Result, Training};

/// Where candle computes what is not computed by the fused passes.
#[derive(Debug, Clone)]
pub struct DeviceCard(Device);

impl DeviceCard {
    /// The first NVIDIA card; none without the feature `cuda`, or where CUDA shows no card.
    ///
    /// # Errors
    /// `Tensors` if the card refuses.
    pub fn first() -> Result<Option<Self>> {
        let device = best_device()?;
        Ok((!device.is_cpu()).then_some(Self(device)))
    }

    /// The processor in its place: for tests without one.
    pub fn emulated() -> Self {
        Self(Device::Cpu)
    }

    /// For many updates of a training, whose weights, moments and moving average stay on the card until [`CardUpdates::finish`].
    ///
    /// # Errors
    /// `Tensors` if the card refuses.
    pub fn updates(&self, training: &Training<Transformer<f32>>) -> Result<CardUpdates> {
        let shape = training.model().shape().clone();
        let state = OnDevice::new(&self.0, training)?;
        Ok(CardUpdates { card: self.0.clone(), shape, state, times: None, pass: None })
    }
}

/// Updates of a training on a card, one after the other: the training's once they are finished, and lost otherwise.
pub struct CardUpdates {
    card: Device,
    shape: TransformerShape,
    state: OnDevice,
    times: Option<SharedTensors>,
    /// The parameters of the last pass as variables, and its outputs.
    pass: Option<(Leaves, Tensor)>,
}

impl CardUpdates {
    /// Outputs ([result][row][output]) of the network as it is now for `inputs` ([step][row][input]).
    ///
    /// # Errors
    /// `Tensors` if the card refuses.
    pub fn forward(&mut self, inputs: &[f32], rows: usize) -> Result<Vec<f32>> {
        let n = inputs.len() / (rows * self.shape.inputs);
        let inputs = Tensor::from_slice(inputs, (n, rows, self.shape.inputs), &self.card)?;
        let (shape, weights) = (&self.shape, self.state.weights());
        let times = SharedTensors::again(self.times.take(), shape, n, &inputs)?;
        let leaves = Leaves::new(shape, weights)?;
        let outputs = Operations { shape, leaves: &leaves, times: &times }.run(&inputs)?;
        let values = outputs.flatten_all()?.to_vec1()?;
        (self.times, self.pass) = (Some(times), Some((leaves, outputs)));
        Ok(values)
    }

    /// As [`Training::update`] with the settings of `training`: by the loss of the last pass and its derivatives by the outputs.
    ///
    /// # Errors
    /// As there; `Tensors` without a pass before, or if the card refuses.
    pub fn update(
        &mut self,
        training: &Training<Transformer<f32>>,
        loss: f64,
        by_outputs: &[f32],
    ) -> Result<()> {
        let Some((leaves, outputs)) = self.pass.take() else {
            return Err(Error::Tensors("no pass to go back through".to_owned()));
        };
        let by_outputs = Tensor::from_slice(by_outputs, outputs.shape(), &self.card)?;
        let found = (outputs * by_outputs)?.sum_all()?.backward()?;
        self.state.update(training, loss, &leaves.gradients(&found)?)
    }

    /// Hands what the updates have come to over to the training.
    ///
    /// # Errors
    /// `Tensors` if the card refuses.
    pub fn finish(self, training: &mut Training<Transformer<f32>>) -> Result<()> {
        self.state.finish(training)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)] // a test may stop where it stands

    use hysteron_base::rng;
    use rand::RngExt;

    use super::super::tests::shape;
    use super::super::{BlockKind, TemporalForm, TransformerTape};
    use super::*;
    use crate::{Adam, Penalty, TrainableModel, mean_squared_error};

    const ROWS: usize = 5;
    const UPDATES: u64 = 10;
    /// A derivative is a sum over up to 13 steps of 5 rows of what went through sums of up to 40 products, in two layers: √(65 · 40 · 2) ≈ 72
    /// rounding errors of 2⁻²⁴ and four times that, relative to the largest; with ε = 1 an update passes on no more than its step size
    /// times that, and there are ten of them.
    const ACC: f64 = 10.0 * RATE * 4.0 * 72.0 * 0.5 * f32::EPSILON as f64;
    const RATE: f64 = 0.05;

    fn uniform(name: &str, n: usize) -> Vec<f32> {
        let mut stream = rng(1, name);
        (0..n).map(|_| stream.random_range(-1.0..1.0)).collect()
    }

    fn training(block: BlockKind, form: TemporalForm) -> Training<Transformer<f32>> {
        let adam = Adam {
            learning_rate: RATE,
            epsilon: 1.0,
            weight_decay: 0.1,
            penalty: Penalty::Decoupled,
            clip_norm: Some(0.5),
            ..Adam::default()
        };
        Training::new(Transformer::new(&shape(block, form), 5).unwrap(), adam, Some(0.3)).unwrap()
    }

    /// Inputs of an update, and its targets.
    fn batch(shape: &TransformerShape, update: u64) -> (usize, Vec<f32>, Vec<f32>) {
        let (n, results) = if shape.form == TemporalForm::Window { (shape.tokens, 1) } else { (13, 13) };
        let inputs = uniform(&format!("inputs {update}"), n * ROWS * shape.inputs);
        (n, inputs, uniform(&format!("targets {update}"), results * ROWS * shape.outputs()))
    }

    fn on_host(training: &mut Training<Transformer<f32>>) -> Vec<f64> {
        let update = |update| {
            let network = training.model();
            let (n, inputs, targets) = batch(network.shape(), update);
            let mut tape = TransformerTape::new(network.shape(), n, ROWS);
            let outputs = tape.forward(network, 0..n, &inputs).to_vec();
            let mut by_outputs = vec![0.0; outputs.len()];
            let loss = mean_squared_error(&outputs, &targets, &mut by_outputs);
            let mut gradient = network.zeros();
            tape.clear_gradients();
            tape.backward(network, 0..n, &by_outputs, &mut gradient);
            tape.weight_gradients(network, n, &mut gradient);
            training.update(loss, &gradient).unwrap();
            loss
        };
        (0..UPDATES).map(update).collect()
    }

    fn on_card(card: &DeviceCard, training: &mut Training<Transformer<f32>>) -> Vec<f64> {
        let mut updates = card.updates(training).unwrap();
        let update = |update| {
            let (_, inputs, targets) = batch(training.model().shape(), update);
            let outputs = updates.forward(&inputs, ROWS).unwrap();
            let mut by_outputs = vec![0.0; outputs.len()];
            let loss = mean_squared_error(&outputs, &targets, &mut by_outputs);
            updates.update(training, loss, &by_outputs).unwrap();
            loss
        };
        let losses = (0..UPDATES).map(update).collect();
        updates.finish(training).unwrap();
        losses
    }

    #[track_caller]
    fn assert_near(what: &str, found: &[Vec<f32>], expected: &[Vec<f32>]) {
        let pairs = found.iter().flatten().zip(expected.iter().flatten());
        let off = pairs.map(|(a, b)| f64::from((a - b).abs())).fold(0.0, f64::max);
        assert!(off <= ACC, "{what}: {off}");
    }

    /// On a card where the program is built for one and there is one, and else on the processor.
    #[test]
    fn a_training_on_the_card_is_that_by_the_fused_passes() {
        let card = DeviceCard::first().unwrap().unwrap_or_else(DeviceCard::emulated);
        let (pre, post) = (BlockKind::GatedPreNorm, BlockKind::ScaledPostNorm);
        for (block, form) in
            [(pre, TemporalForm::Streaming), (pre, TemporalForm::Window), (post, TemporalForm::Window)]
        {
            let [mut host, mut device] = [(); 2].map(|()| training(block, form));
            let first = host.model().parameters().to_vec();
            let losses = [on_host(&mut host), on_card(&card, &mut device)];
            for (host, device) in losses[0].iter().zip(&losses[1]) {
                assert!((host - device).abs() <= ACC * host, "{block:?} {form:?}: {losses:?}");
            }
            assert_eq!(device.steps(), UPDATES);
            assert_near("weights", device.model().parameters(), host.model().parameters());
            assert_near("average", device.evaluated().parameters(), host.evaluated().parameters());
            let moved = device.model().parameters().iter().flatten().zip(first.iter().flatten());
            let moved = moved.map(|(now, then)| f64::from((now - then).abs())).fold(0.0, f64::max);
            assert!(moved > 100.0 * ACC, "{moved}: nothing to compare");
        }
    }
}
