//! A training whose weights, moments and moving average stay on candle's device from one update to the next: what goes between host
//! and device in an update are inputs, outputs and the norm of the gradient.

use candle_core::{DType, Tensor, Var};

use super::graph::{Gradients, Graph, Weights};
use crate::engine::{Factors, Moments, Updated};
use crate::{Model, Network, Result, Training};

/// The arrays of a training, for each vector of parameters.
#[derive(Debug)]
pub(crate) struct OnDevice {
    weights: Weights,
    mean: Vec<Tensor>,
    square: Vec<Tensor>,
    average: Option<Vec<Tensor>>,
    /// Updates done.
    steps: u64,
}

impl OnDevice {
    /// Takes the arrays to the device.
    ///
    /// # Errors
    /// `Tensors` if it refuses.
    pub fn new(graph: &Graph, training: &Training<Network>) -> Result<Self> {
        let (_, moments) = training.optimiser();
        let average = training.average().map(|(average, _)| placed(graph, average.parameters().iter()));
        Ok(Self {
            weights: graph.weights(training.model())?,
            mean: placed(graph, moments.iter().map(|moments| &moments.mean))?,
            square: placed(graph, moments.iter().map(|moments| &moments.square))?,
            average: average.transpose()?,
            steps: training.steps(),
        })
    }

    /// The weights as they are now.
    pub fn weights(&self) -> &Weights {
        &self.weights
    }

    /// Updates done.
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// As [`Training::update`], with the settings of `training`.
    ///
    /// # Errors
    /// As there; `Tensors` if the device refuses.
    pub fn update(&mut self, training: &Training<Network>, loss: f64, gradients: &Gradients) -> Result<()> {
        let mut squares = 0.0;
        for gradient in &gradients.0 {
            squares += gradient.to_dtype(DType::F64)?.sqr()?.sum_all()?.to_scalar::<f64>()?;
        }
        let scale = training.scale(self.steps, loss, squares.sqrt())?;
        self.steps += 1;
        let factors = training.optimiser().0.factors(self.steps, scale);
        let moments = self.mean.iter_mut().zip(&mut self.square);
        for ((weights, gradient), moments) in self.weights.0.iter().zip(&gradients.0).zip(moments) {
            adam_step(&factors, gradient, weights, moments)?;
        }
        if let (Some(average), Some((_, part))) = (&mut self.average, training.average()) {
            for (average, weights) in average.iter_mut().zip(&self.weights.0) {
                let off = (weights.as_detached_tensor() - &*average)?;
                *average = (&*average + off.affine(f64::from(part), 0.0)?)?;
            }
        }
        Ok(())
    }

    /// Hands everything back.
    ///
    /// # Errors
    /// `Tensors` if the device refuses.
    pub fn finish(self, training: &mut Training<Network>) -> Result<()> {
        let vecs = |tensors: &[Tensor]| -> candle_core::Result<Vec<Vec<f32>>> {
            tensors.iter().map(Tensor::to_vec1).collect()
        };
        let moments = vecs(&self.mean)?.into_iter().zip(vecs(&self.square)?);
        training.take_over(Updated {
            steps: self.steps,
            parameters: self.weights.0.iter().map(|own| own.to_vec1()).collect::<candle_core::Result<_>>()?,
            moments: moments.map(|(mean, square)| Moments { mean, square }).collect(),
            average: self.average.as_deref().map(vecs).transpose()?,
        });
        Ok(())
    }
}

fn placed<'a>(graph: &Graph, arrays: impl Iterator<Item = &'a Vec<f32>>) -> candle_core::Result<Vec<Tensor>> {
    arrays.map(|values| graph.place(values)).collect()
}

/// [`Factors`] on a vector of weights and its moments.
fn adam_step(
    factors: &Factors,
    gradient: &Tensor,
    weights: &Var,
    (mean, square): (&mut Tensor, &mut Tensor),
) -> candle_core::Result<()> {
    let Factors { scale, decay, kept, rate, per_root, epsilon, .. } = *factors;
    let before = weights.as_detached_tensor();
    let g = (gradient.detach().affine(scale, 0.0)? + before.affine(decay, 0.0)?)?;
    let weighted =
        |of: [f64; 2], old: &Tensor, new: &Tensor| old.affine(of[0], 0.0)? + new.affine(of[1], 0.0)?;
    *mean = weighted(factors.mean, mean, &g)?;
    *square = weighted(factors.square, square, &g.sqr()?)?;
    let step = (mean.affine(rate, 0.0)? / square.sqrt()?.affine(per_root, epsilon)?)?;
    weights.set(&(before.affine(kept, 0.0)? - step)?)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)] // a test may stop where it stands

    use hysteron_base::rng;
    use rand::RngExt;

    use crate::{Adam, Architecture, Backprop, Batch, Head, Memory, Network, Outputs, Penalty, Training};

    const STEPS: usize = 12;
    const ROWS: usize = 5;
    const UPDATES: u64 = 10;
    /// A gradient differs by at most √(STEPS² ROWS) ≈ 27 rounding errors of 2⁻²⁴ and four times that, relative to the largest; with
    /// ε = 1 an update passes on no more, and there are ten of them.
    const ACC: f64 = 10.0 * 4.0 * 27.0 * 0.5 * f32::EPSILON as f64;

    fn uniform(name: &str, n: usize) -> Vec<f32> {
        let mut stream = rng(1, name);
        (0..n).map(|_| stream.random_range(-1.0..1.0)).collect()
    }

    fn training(penalty: Penalty) -> Training<Network> {
        let architecture =
            Architecture { inputs: 3, hidden: 6, layers: 2, outputs: 2, head: Head::Linear, dropout: 0.2 };
        let clip_norm = (penalty == Penalty::Coupled).then_some(0.5);
        let adam = Adam {
            learning_rate: 0.05,
            epsilon: 1.0,
            weight_decay: 0.1,
            penalty,
            clip_norm,
            ..Adam::default()
        };
        Training::new(Network::new(&architecture, 5).unwrap(), adam, Some(0.3)).unwrap()
    }

    /// The losses of some updates, with what is called before and after each of them.
    fn losses(
        passes: &Backprop,
        training: &mut Training<Network>,
        mut watch: impl FnMut(&super::super::backprop::Updates<'_>),
    ) -> Vec<f64> {
        let mut updates = passes.updates(training).unwrap();
        let mut losses = Vec::new();
        for step in 0..UPDATES {
            let inputs = uniform(&format!("inputs {step}"), STEPS * ROWS * 3);
            let targets = uniform(&format!("targets {step}"), STEPS * ROWS * 2);
            let batch = Batch { inputs: &inputs, steps: STEPS, rows: ROWS, outputs: Outputs::All };
            let mut memory = Memory::zeros(updates.training().model().architecture(), ROWS);
            let loss = |found: &[f32], d: &mut [f32]| crate::mean_squared_error(found, &targets, d);
            losses.push(updates.step(&batch, &mut memory, loss).unwrap());
            watch(&updates);
        }
        updates.finish().unwrap();
        losses
    }

    #[track_caller]
    fn assert_near(what: &str, found: &[Vec<f32>], expected: &[Vec<f32>]) {
        let mut n = 0;
        for (found, expected) in found.iter().flatten().zip(expected.iter().flatten()) {
            let off = f64::from((found - expected).abs());
            assert!(off <= ACC, "{what}: {found} {expected}");
            n += 1;
        }
        assert!(n > 0, "{what}: nothing to compare");
    }

    #[test]
    fn a_training_on_the_device_is_that_on_the_host() {
        use crate::Model;
        for penalty in [Penalty::Coupled, Penalty::Decoupled] {
            let (mut host, mut device) = (training(penalty), training(penalty));
            let architecture = host.model().architecture().clone();
            let on_host = losses(&Backprop::new(&architecture, 7).unwrap(), &mut host, |_| ());
            let on_device = losses(&Backprop::unrolled_on_device(&architecture, 7), &mut device, |_| ());
            for (host, device) in on_host.iter().zip(&on_device) {
                assert!((host - device).abs() <= ACC * host, "{penalty:?}: {on_host:?} {on_device:?}");
            }
            assert_eq!((host.steps(), device.steps()), (UPDATES, UPDATES));
            assert_near("weights", device.model().parameters(), host.model().parameters());
            assert_near("average", device.evaluated().parameters(), host.evaluated().parameters());
            let moments = |training: &Training<Network>| -> Vec<Vec<f32>> {
                training.optimiser().1.iter().flat_map(|own| [own.mean.clone(), own.square.clone()]).collect()
            };
            assert_near("moments", &moments(&device), &moments(&host));
        }
    }

    #[test]
    fn weights_do_not_leave_the_device_between_updates() {
        let [mut training, before] = [Penalty::Coupled; 2].map(training);
        let passes = Backprop::unrolled_on_device(training.model().architecture(), 7);
        let mut variables = Vec::new();
        losses(&passes, &mut training, |updates| {
            let own = updates.on_device().unwrap();
            variables.push(own.weights.0.iter().map(|weights| weights.id()).collect::<Vec<_>>());
            // Host arrays that updates had been copied to would have changed.
            let host = updates.training();
            assert_eq!((host.model(), host.steps()), (before.model(), 0));
            assert_eq!(host.optimiser().1, before.optimiser().1);
        });
        assert!(variables.iter().all(|ids| *ids == variables[0]), "weights were taken to the device again");
        assert_ne!(training.model(), before.model());
    }
}
