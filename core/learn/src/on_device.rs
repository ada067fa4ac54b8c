//! A training whose weights, moments and moving average stay on candle's device from one update to the next: what goes between host
//! and device in an update are inputs, outputs and the norm of the gradient.

use candle_core::backprop::GradStore;
use candle_core::{DType, Device, Tensor, Var, WithDType};

use crate::engine::{AdamFactors, Moments, Updated};
use crate::{Result, TrainableModel, Training};

/// The first NVIDIA card, or the processor: without the feature `cuda`, or where CUDA shows no card.
///
/// # Errors
/// A card is there and refuses.
pub(crate) fn best_device() -> candle_core::Result<Device> {
    match Device::cuda_if_available(0) {
        Err(error) if error.to_string().contains("CUDA_ERROR_NO_DEVICE") => Ok(Device::Cpu),
        found => found,
    }
}

/// The vectors of a model's parameters on a device.
#[derive(Debug)]
pub(crate) struct DeviceWeights(Vec<Var>);

/// Derivatives by each vector of parameters, on the device.
pub(crate) struct DeviceGradients(Vec<Tensor>);

impl DeviceWeights {
    /// Takes them there.
    ///
    /// # Errors
    /// The device refuses.
    pub fn new<T: WithDType>(device: &Device, parameters: &[Vec<T>]) -> candle_core::Result<Self> {
        let place = |values: &Vec<T>| Var::from_slice(values, values.len(), device);
        Ok(Self(parameters.iter().map(place).collect::<candle_core::Result<_>>()?))
    }

    /// One for each vector of parameters.
    pub fn vectors(&self) -> &[Var] {
        &self.0
    }

    /// The derivatives by these vectors in `found`; zeros where there is none.
    ///
    /// # Errors
    /// The device refuses.
    pub fn gradients(&self, found: &GradStore) -> candle_core::Result<DeviceGradients> {
        Ok(DeviceGradients(
            self.0.iter().map(|own| derivative(found, own)).collect::<candle_core::Result<_>>()?,
        ))
    }
}

/// The derivative by a variable in `found`, of its shape; zeros where there is none.
///
/// # Errors
/// The device refuses.
pub(crate) fn derivative(found: &GradStore, by: &Var) -> candle_core::Result<Tensor> {
    found.get(by).map_or_else(|| by.zeros_like(), |own| Ok(own.clone()))
}

impl DeviceGradients {
    /// By each vector.
    pub fn new(gradients: Vec<Tensor>) -> Self {
        Self(gradients)
    }

    /// On the host.
    ///
    /// # Errors
    /// The device refuses.
    pub fn to_vecs<T: WithDType>(&self) -> candle_core::Result<Vec<Vec<T>>> {
        self.0.iter().map(Tensor::to_vec1).collect()
    }
}

/// The arrays of a training, for each vector of parameters.
#[derive(Debug)]
pub(crate) struct OnDevice {
    weights: DeviceWeights,
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
    pub fn new<M: TrainableModel<Value = f32>>(device: &Device, training: &Training<M>) -> Result<Self> {
        let (_, moments) = training.optimiser();
        let average = training.average().map(|(average, _)| placed(device, average.parameters().iter()));
        Ok(Self {
            weights: DeviceWeights::new(device, training.model().parameters())?,
            mean: placed(device, moments.iter().map(|moments| &moments.mean))?,
            square: placed(device, moments.iter().map(|moments| &moments.square))?,
            average: average.transpose()?,
            steps: training.steps(),
        })
    }

    /// The weights as they are now.
    pub fn weights(&self) -> &DeviceWeights {
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
    pub fn update<M: TrainableModel<Value = f32>>(
        &mut self,
        training: &Training<M>,
        loss: f64,
        gradients: &DeviceGradients,
    ) -> Result<()> {
        let square = |gradient: &Tensor| gradient.to_dtype(DType::F64)?.sqr()?.sum_all();
        let squares = gradients.0.iter().map(square).collect::<candle_core::Result<Vec<_>>>()?;
        let norm = Tensor::stack(&squares, 0)?.sum_all()?.sqrt()?.to_scalar::<f64>()?;
        let (adam, _) = training.optimiser();
        let scale = adam.checked_scale(self.steps, loss, norm)?;
        self.steps += 1;
        let factors = adam.factors(self.steps, scale);
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
    pub fn finish<M: TrainableModel<Value = f32>>(self, training: &mut Training<M>) -> Result<()> {
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

fn placed<'a>(
    device: &Device,
    arrays: impl Iterator<Item = &'a Vec<f32>>,
) -> candle_core::Result<Vec<Tensor>> {
    arrays.map(|values| Tensor::from_slice(values, values.len(), device)).collect()
}

/// [`AdamFactors`] on a vector of weights and its moments.
fn adam_step(
    factors: &AdamFactors,
    gradient: &Tensor,
    weights: &Var,
    (mean, square): (&mut Tensor, &mut Tensor),
) -> candle_core::Result<()> {
    let AdamFactors { scale, decay, kept, rate, per_root, epsilon, .. } = *factors;
    let before = weights.as_detached_tensor();
    let g = (gradient.detach().affine(scale, 0.0)? + before.affine(decay, 0.0)?)?;
    let weighted =
        |of: [f64; 2], old: &Tensor, new: &Tensor| old.affine(of[0], 0.0)? + new.affine(of[1], 0.0)?;
    *mean = weighted(factors.mean, mean, &g)?;
    *square = weighted(factors.square, square, &g.sqr()?)?;
    let step = (mean.affine(rate, 0.0)? / square.sqrt()?.affine(per_root, epsilon)?)?;
    weights.set(&(before.affine(kept, 0.0)? - step)?)
}
